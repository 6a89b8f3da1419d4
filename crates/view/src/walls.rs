//! Wall thickness of a mesh at all its faces, measured part by part as the page asks for it: the page shows how far it is, and stops asking
//! to cancel.

use isomend_core::check::WallMap;
use isomend_core::mesh::Mesh;

/// Number of faces that are measured for one request: a fraction of a second.
const PART: usize = 100_000;

/// What is needed to measure more faces of one state, with the number of that state: its size is a multiple of the mesh's, so one is kept at a
/// time, and a request for another state replaces it. None before the first face and after the last.
pub type WallSlot = Option<(u32, WallMap)>;

/// The thickness at the first faces of a mesh; see [`WallMap::thickness`].
#[derive(Default)]
pub struct Thickness {
    values: Vec<f32>,
    /// Whether a request has prepared the mesh before.
    was_prepared: bool,
}

impl Thickness {
    /// Whether values from face `known` on require a measurement.
    pub fn is_wanting(&self, known: usize, mesh: &Mesh) -> bool {
        known >= self.values.len() && self.values.len() < mesh.faces.len()
    }

    /// Measures a part of the faces of `mesh`, the mesh of the state with number `id`. The first call measures none: it only prepares the mesh.
    /// Later calls prepare it again if the slot was used for another state, so that each of two that take turns gets on. All calls must be for
    /// the same mesh.
    pub fn measure(&mut self, id: u32, mesh: &Mesh, slot: &mut WallSlot) {
        if slot.as_ref().is_none_or(|(of, _)| *of != id) {
            // Release the map of the other state first.
            *slot = None;
            *slot = Some((id, WallMap::new(mesh)));
            if !std::mem::replace(&mut self.was_prepared, true) {
                return;
            }
        }
        let (done, count) = (self.values.len(), mesh.faces.len());
        let end = count.min(done + PART);
        if let Some((_, map)) = slot {
            self.values.extend(map.thickness(done as u32..end as u32));
        }
        if end == count {
            *slot = None;
        }
    }

    /// The values from face `known` on, as far as they are measured.
    pub fn after(&self, known: usize) -> &[f32] {
        self.values.get(known..).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Plates of 1 × 1 with a thickness of 0.1.
    fn plates(count: usize) -> Mesh {
        let mut mesh = Mesh::new(Vec::new(), Vec::new());
        for i in 0..count as u32 {
            let corner = |k: u32| {
                let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(f64::from);
                DVec3::new(x + 2.0 * f64::from(i), y, 0.1 * z)
            };
            mesh.positions.extend((0..8).map(corner));
            for [a, b, c, d] in [
                [0, 2, 3, 1],
                [4, 5, 7, 6],
                [0, 1, 5, 4],
                [1, 3, 7, 5],
                [3, 2, 6, 7],
                [2, 0, 4, 6],
            ] {
                let faces = [[a, b, c], [a, c, d]];
                mesh.faces.extend(faces.map(|face| face.map(|v| v + 8 * i)));
            }
        }
        mesh
    }

    #[test]
    fn parts_join_to_the_thickness_of_every_face() {
        let mesh = plates(PART / 12 + 7);
        let (mut thickness, mut slot, mut values) = (Thickness::default(), None, Vec::new());
        thickness.measure(3, &mesh, &mut slot);
        assert!(thickness.after(0).is_empty());
        let mut parts = 0;
        while thickness.is_wanting(values.len(), &mesh) {
            thickness.measure(3, &mesh, &mut slot);
            let more = thickness.after(values.len());
            assert!(!more.is_empty() && more.len() <= PART);
            values.extend_from_slice(more);
            parts += 1;
        }
        assert_eq!(parts, 2);
        assert_eq!(values.len(), mesh.faces.len());
        assert!(slot.is_none(), "nothing is kept but the values");
        for (i, value) in values.iter().enumerate() {
            let wanted = if i % 12 < 4 { 0.1 } else { 1.0 };
            assert!((value - wanted).abs() < 1e-6, "face {i}: {value}");
        }
        assert_eq!(thickness.after(values.len() - 3), [1.0; 3]);
        assert!(thickness.after(2 * values.len()).is_empty());
        assert!(!thickness.is_wanting(2 * values.len(), &mesh));
    }

    #[test]
    fn states_that_take_turns_share_one_slot() {
        let meshes = [plates(PART / 12 + 7), plates(5)];
        let mut all = [Thickness::default(), Thickness::default()];
        let mut slot = None;
        // A cancelled measurement leaves its map only until another state is asked for.
        for (id, (own, mesh)) in all.iter_mut().zip(&meshes).enumerate() {
            own.measure(id as u32, mesh, &mut slot);
            assert_eq!(slot.as_ref().map(|(of, _)| *of), Some(id as u32));
        }
        // Neither starts again at its first face whenever the other one took the slot.
        let mut rounds = 0;
        while (0..2).any(|i| all[i].is_wanting(all[i].values.len(), &meshes[i])) {
            for (id, (own, mesh)) in all.iter_mut().zip(&meshes).enumerate() {
                if own.is_wanting(own.values.len(), mesh) {
                    own.measure(id as u32, mesh, &mut slot);
                }
            }
            rounds += 1;
            assert!(rounds <= 2, "a part is measured in each round");
        }
        for (own, mesh) in all.iter().zip(&meshes) {
            assert_eq!(
                own.values,
                WallMap::new(mesh).thickness(0..mesh.faces.len() as u32)
            );
        }
        assert!(slot.is_none());
    }
}
