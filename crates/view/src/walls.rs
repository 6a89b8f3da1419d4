//! Wall thickness of a mesh at all its faces, measured part by part as the page asks for it: the page shows how far it is, and stops asking
//! to cancel.

use isomend_core::check::WallMap;
use isomend_core::mesh::Mesh;

/// Number of faces that are measured for one request: a fraction of a second.
const PART: usize = 100_000;

/// The thickness at the first faces of a mesh; see [`WallMap::thickness`].
#[derive(Default)]
pub struct Thickness {
    values: Vec<f32>,
    /// What is needed to measure more; none before the first face and after the last.
    map: Option<WallMap>,
}

impl Thickness {
    /// Measures a part of the faces of `mesh`, unless more than `known` are measured already, and returns the values from `known` on. The first
    /// part is empty: it only prepares the mesh. All calls must be for the same mesh.
    pub fn after(&mut self, known: usize, mesh: &Mesh) -> &[f32] {
        let (done, count) = (self.values.len(), mesh.faces.len());
        if known >= done && done < count {
            match &self.map {
                None => self.map = Some(WallMap::new(mesh)),
                Some(map) => {
                    let end = count.min(done + PART);
                    self.values.extend(map.thickness(done as u32..end as u32));
                }
            }
            if self.values.len() == count {
                self.map = None;
            }
        }
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
        let (mut thickness, mut values) = (Thickness::default(), Vec::new());
        assert!(thickness.after(0, &mesh).is_empty());
        let mut parts = 0;
        while values.len() < mesh.faces.len() {
            let more = thickness.after(values.len(), &mesh);
            assert!(!more.is_empty() && more.len() <= PART);
            values.extend_from_slice(more);
            parts += 1;
        }
        assert_eq!(parts, 2);
        assert!(thickness.map.is_none(), "nothing is kept but the values");
        for (i, value) in values.iter().enumerate() {
            let wanted = if i % 12 < 4 { 0.1 } else { 1.0 };
            assert!((value - wanted).abs() < 1e-6, "face {i}: {value}");
        }
        assert_eq!(thickness.after(values.len() - 3, &mesh), [1.0; 3]);
        assert!(thickness.after(2 * values.len(), &mesh).is_empty());
    }
}
