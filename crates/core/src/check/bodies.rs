//! The verdict on several bodies: the sum of the verdicts on each.

use super::{Defect, DefectKind, ShapeDoubt, Verdict};

impl Verdict {
    /// The same verdict with the face numbers of a larger mesh: `faces` are the numbers there, in order.
    pub fn in_whole(mut self, faces: &[u32]) -> Self {
        for defect in &mut self.defects {
            defect
                .faces
                .iter_mut()
                .for_each(|f| *f = faces[*f as usize]);
        }
        self
    }

    /// The verdict on a mesh of several bodies, from the name and the verdict of each; face numbers are the whole mesh's.
    pub fn of_bodies(objects: Vec<(String, Self)>) -> Self {
        let mut all = objects.iter().map(|(_, v)| v);
        let sum = |count: fn(&Self) -> usize| objects.iter().map(|(_, v)| count(v)).sum::<usize>();
        let welds = objects.iter().filter_map(|(_, v)| v.weld);
        let weld = welds.reduce(|(a, m), (b, n)| (a.max(b), m + n));
        let mut params = all
            .next()
            .map_or_else(Default::default, |v| v.params.clone());
        for verdict in all {
            let limits = [params.min_wall, verdict.params.min_wall].into_iter();
            params.min_wall = limits.flatten().reduce(f64::max);
        }
        let (mut components, mut foils) = (Vec::new(), Vec::new());
        for (_, verdict) in &objects {
            let first = components.len();
            foils.extend(verdict.foils.iter().map(|number| first + number));
            let own = verdict.components.iter().cloned();
            components.extend(own.map(|mut component| {
                component.inside = component.inside.map(|outer| first + outer);
                component
            }));
        }
        Self {
            vertices: sum(|v| v.vertices),
            faces: sum(|v| v.faces),
            unused_vertices: sum(|v| v.unused_vertices),
            duplicate_vertices: sum(|v| v.duplicate_vertices),
            holes: sum(|v| v.holes),
            open_chains: sum(|v| v.open_chains),
            t_junctions: sum(|v| v.t_junctions),
            t_junction_holes: sum(|v| v.t_junction_holes),
            weld,
            weld_by_default: objects
                .iter()
                .all(|(_, v)| v.weld.is_none() || v.weld_by_default)
                && weld.is_some(),
            components,
            defects: defects(&objects),
            foils,
            doubt: largest_doubt(&objects),
            params,
            objects,
        }
    }
}

/// The defects of all bodies, one entry for each kind.
fn defects(objects: &[(String, Verdict)]) -> Vec<Defect> {
    let all = DefectKind::ALL.into_iter().map(|kind| {
        let mut sum = Defect::named(kind, 0);
        let own = objects.iter().flat_map(|(_, v)| &v.defects);
        for defect in own.filter(|d| d.kind == kind) {
            sum.count += defect.count;
            sum.faces.extend(&defect.faces);
            sum.places.extend(&defect.places);
        }
        sum.faces.sort_unstable();
        sum
    });
    all.filter(|d| d.count > 0).collect()
}

/// The doubt about the body that differs most from its input.
fn largest_doubt(objects: &[(String, Verdict)]) -> Option<ShapeDoubt> {
    let doubts = objects.iter().filter_map(|(_, v)| v.doubt);
    let size = |d: &ShapeDoubt| d.lost.max(1.0 - d.agreement);
    doubts.max_by(|a, b| size(a).total_cmp(&size(b)))
}
