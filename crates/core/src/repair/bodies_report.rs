//! The report on the repair of several bodies: the sum of the reports on each.

use super::RepairReport;
use crate::check::Verdict;

impl RepairReport {
    /// The report on a mesh of several bodies, from the name and the report of each. `components` has the number of
    /// components of each repaired body. The reports of the fills are not joined.
    pub fn of_bodies(objects: Vec<(String, Self)>, components: &[usize]) -> Self {
        let mut all = Self::default();
        let mut first = 0;
        for ((_, own), count) in objects.iter().zip(components) {
            all.steps.add(&own.steps);
            all.lost_faces += own.lost_faces;
            all.lost_vertices += own.lost_vertices;
            all.lost_components = all.lost_components.and(own.lost_components);
            let shells = own.offset_shells.iter().cloned();
            all.offset_shells
                .extend(shells.map(|(n, shell)| (first + n, shell)));
            let thin = own.thin_offset_shells.iter();
            all.thin_offset_shells
                .extend(thin.map(|(n, limit)| (first + n, *limit)));
            first += count;
        }
        let before = objects
            .iter()
            .map(|(name, own)| Some((name.clone(), own.before.clone()?)));
        all.before = before.collect::<Option<Vec<_>>>().map(Verdict::of_bodies);
        all.doubt = objects.iter().find_map(|(_, own)| own.doubt);
        all.objects = objects;
        all
    }

    /// Stores the verdict on each body in the body's report, and their sum. Bodies are found by their names.
    pub(super) fn judge_bodies(&mut self, verdict: Verdict) {
        let mut judged = Vec::new();
        for (k, (name, verdict)) in verdict.objects.into_iter().enumerate() {
            // Usually in the same place.
            let same = self.objects.get(k).is_some_and(|(n, _)| *n == name);
            let place = match same {
                true => Some(k),
                false => self.objects.iter().position(|(n, _)| *n == name),
            };
            let own = place.and_then(|place| self.objects.get_mut(place));
            let after = own.and_then(|(_, report)| {
                report.judge(verdict.clone());
                report.after.clone()
            });
            judged.push((name, after.unwrap_or(verdict)));
        }
        let mut after = Verdict::of_bodies(judged);
        // Also of a body that has no face left.
        after.doubt = after.doubt.or(self.doubt);
        self.after = Some(after);
    }
}
