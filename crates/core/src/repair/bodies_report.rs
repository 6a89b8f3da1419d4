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
            all.add_counts(own);
            all.crack_width = all.crack_width.max(own.crack_width);
            all.skin_thickness = all.skin_thickness.max(own.skin_thickness);
            all.largest_move = all.largest_move.max(own.largest_move);
            all.largest_relaxation = all.largest_relaxation.max(own.largest_relaxation);
            all.add_lost_components(own.lost_components);
            for (k, pass) in own.passes.iter().enumerate() {
                match all.passes.get_mut(k) {
                    None => all.passes.push(*pass),
                    Some(sum) => {
                        sum.intersecting_faces += pass.intersecting_faces;
                        sum.cut_faces += pass.cut_faces;
                        sum.rings = sum.rings.max(pass.rings);
                    }
                }
            }
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

    fn add_counts(&mut self, own: &Self) {
        let add = |sums: [(&mut usize, usize); 19]| sums.into_iter().for_each(|(sum, n)| *sum += n);
        add([
            (&mut self.merged_vertices, own.merged_vertices),
            (&mut self.welded_vertices, own.welded_vertices),
            (&mut self.stitched_junctions, own.stitched_junctions),
            (&mut self.degenerate_faces, own.degenerate_faces),
            (&mut self.flipped_edges, own.flipped_edges),
            (&mut self.duplicate_faces, own.duplicate_faces),
            (&mut self.reoriented_faces, own.reoriented_faces),
            (&mut self.split_vertices, own.split_vertices),
            (&mut self.non_manifold_faces, own.non_manifold_faces),
            (&mut self.united_bodies, own.united_bodies),
            (&mut self.moved_vertices, own.moved_vertices),
            (&mut self.relaxed_vertices, own.relaxed_vertices),
            (&mut self.split_faces, own.split_faces),
            (&mut self.inner_faces, own.inner_faces),
            (&mut self.pinholes, own.pinholes),
            (&mut self.covered_faces, own.covered_faces),
            (&mut self.left_self_intersecting, own.left_self_intersecting),
            (&mut self.lost_faces, own.lost_faces),
            (&mut self.lost_vertices, own.lost_vertices),
        ]);
        for k in 0..2 {
            self.dropped[k] += own.dropped[k];
            self.debris[k] += own.debris[k];
            self.inside[k] += own.inside[k];
            self.inner_skins[k] += own.inner_skins[k];
        }
    }

    fn add_lost_components(&mut self, [count, fewest, most]: [usize; 3]) {
        let [all, least, largest] = self.lost_components;
        let fewest = match [all, count] {
            [0, _] => fewest,
            [_, 0] => least,
            _ => least.min(fewest),
        };
        self.lost_components = [all + count, fewest, most.max(largest)];
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
