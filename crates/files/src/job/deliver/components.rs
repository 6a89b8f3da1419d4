//! Splits the patches of a mended mesh into connected components and finds the holes that each component fills.

use std::collections::BTreeMap;

use glam::DVec3;

use isomend_core::mend::FillReport;
use isomend_core::mesh::{HoleId, Mesh, connected};

/// A connected component of the new faces. It fills one hole, or several holes that a bridge joins.
#[derive(Clone, Debug)]
pub(in crate::job) struct Component {
    /// Number of its region, from 1.
    pub(in crate::job) region: usize,
    /// The holes that it fills, in ascending order.
    pub(in crate::job) holes: Vec<HoleId>,
    /// Its faces in the mesh, in ascending order.
    pub(in crate::job) faces: Vec<u32>,
}

impl Component {
    /// The number that files give it: the number of its first hole, or 0 without a hole.
    pub(in crate::job) fn hole(&self) -> usize {
        self.holes.first().map_or(0, |id| id.get())
    }
}

/// The components of the patches of a mesh: region by region, and within a region in the order of their first faces. The first `kept`
/// faces of the mesh are the input's; the new faces of the regions follow, in the order of the report.
pub(in crate::job) fn components(mesh: &Mesh, kept: usize, report: &FillReport) -> Vec<Component> {
    let mut all = Vec::new();
    let mut first = kept;
    for region in &report.regions {
        let last = (first + region.new_faces).min(mesh.faces.len());
        let rims = match &region.holes[..] {
            [_] => BTreeMap::new(),
            holes => rim_places(mesh, holes, report),
        };
        let own: Vec<u32> = (first as u32..last as u32).collect();
        for faces in connected(mesh, &own) {
            let holes = match &region.holes[..] {
                [one] => vec![*one],
                _ => holes_of(mesh, &faces, &rims),
            };
            all.push(Component {
                region: region.id,
                holes,
                faces,
            });
        }
        first = last;
    }
    all
}

/// A position as a map key; 0 and -0 give the same key.
fn key(p: DVec3) -> [u64; 3] {
    p.to_array().map(|x| (x + 0.0).to_bits())
}

/// For each rim vertex of the holes, by its position: the holes whose rims pass through it.
fn rim_places(
    mesh: &Mesh,
    holes: &[HoleId],
    report: &FillReport,
) -> BTreeMap<[u64; 3], Vec<HoleId>> {
    let mut places: BTreeMap<[u64; 3], Vec<HoleId>> = BTreeMap::new();
    let own = report.holes.iter().filter(|h| holes.contains(&h.hole.id));
    for hole in own.map(|h| &h.hole) {
        let positions = hole
            .rim
            .iter()
            .filter_map(|v| mesh.positions.get(*v as usize));
        for position in positions {
            places.entry(key(*position)).or_default().push(hole.id);
        }
    }
    places
}

/// The holes that a component fills: it contains at least two vertices of their rims. A rim that the component only touches in one
/// vertex does not count.
fn holes_of(mesh: &Mesh, faces: &[u32], rims: &BTreeMap<[u64; 3], Vec<HoleId>>) -> Vec<HoleId> {
    let corners = faces.iter().flat_map(|f| mesh.faces[*f as usize]);
    let mut vertices: Vec<u32> = corners.collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut count: BTreeMap<HoleId, usize> = BTreeMap::new();
    for vertex in vertices {
        let at = rims.get(&key(mesh.positions[vertex as usize]));
        for hole in at.into_iter().flatten() {
            *count.entry(*hole).or_default() += 1;
        }
    }
    let real = count.into_iter().filter(|(_, n)| *n > 1);
    real.map(|(hole, _)| hole).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use isomend_core::fill::FillParams;
    use isomend_core::mend::{Control, Inspection};
    use isomend_core::mesh::HoleId;
    use isomend_core::mesh::shapes::{icosphere, punch};

    #[test]
    fn each_hole_has_a_separate_component() {
        let sphere = icosphere(3);
        let open = punch(&sphere, |c| c.z.abs() > 0.9);
        let found = Inspection::new(&open).unwrap();
        let mut params = FillParams::default();
        let filled = found.fill(&params, &Control::new()).unwrap();
        let all = components(&filled.mesh, open.faces.len(), &filled.report);
        let holes: Vec<Vec<HoleId>> = all.iter().map(|c| c.holes.clone()).collect();
        assert_eq!(holes.len(), 2);
        assert!(holes.iter().all(|h| h.len() == 1), "{holes:?}");
        // One region with both holes: every new face belongs to a component, and each component fills a hole.
        params.bridge = vec![vec![1.into(), 2.into()]];
        let filled = found.fill(&params, &Control::new()).unwrap();
        let all = components(&filled.mesh, open.faces.len(), &filled.report);
        let faces: usize = all.iter().map(|c| c.faces.len()).sum();
        assert_eq!(faces, filled.mesh.faces.len() - open.faces.len());
        assert!(all.iter().all(|c| !c.holes.is_empty()));
    }
}
