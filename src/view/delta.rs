//! What of a mesh is the same in the one that was made of it.

use crate::job::Kept;
use crate::mesh::Mesh;

use super::runs::Runs;

/// Which vertices and faces of a mesh are the first ones of another, in order.
#[derive(Clone, Debug, Default)]
pub struct Delta {
    /// The vertices of the old mesh.
    pub vertices: Runs,
    /// The faces of the old mesh.
    pub faces: Runs,
}

impl Delta {
    /// What of `old` begins `new`, where it is what `kept` says, or all of it; none where that turns out not to be so, as after a
    /// format that has put vertices in another order.
    pub fn new(old: &Mesh, new: &Mesh, kept: Option<&Kept>) -> Option<Self> {
        let all = |count: usize| match count {
            0 => Runs::default(),
            count => Runs(vec![[0, count as u32]]),
        };
        let of_marks = |marks: &[bool]| Runs::of_marks(marks.iter().copied());
        let (vertices, faces) = match kept {
            Some(kept) => (of_marks(&kept.vertices), of_marks(&kept.faces)),
            None => (all(old.positions.len()), all(old.faces.len())),
        };
        let mut number = vec![u32::MAX; old.positions.len()];
        for (i, v) in vertices.numbers().enumerate() {
            let (a, b) = (old.positions.get(v)?, new.positions.get(i)?);
            if a.to_array().map(f64::to_bits) != b.to_array().map(f64::to_bits) {
                return None;
            }
            number[v] = i as u32;
        }
        for (i, f) in faces.numbers().enumerate() {
            let face = old.faces.get(f)?.map(|v| number[v as usize]);
            if new.faces.get(i) != Some(&face) {
                return None;
            }
        }
        Some(Self { vertices, faces })
    }

    /// Whether all of a mesh is kept.
    pub fn keeps_all(&self, mesh: &Mesh) -> bool {
        self.vertices.count() == mesh.positions.len() && self.faces.count() == mesh.faces.len()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn mesh(points: &[[f64; 3]], faces: &[[u32; 3]]) -> Mesh {
        let positions = points.iter().map(|p| DVec3::from_array(*p)).collect();
        Mesh::new(positions, faces.to_vec())
    }

    #[test]
    fn what_is_kept_is_found_and_what_is_not_is_refused() {
        let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]];
        let old = mesh(&points, &[[0, 1, 2], [1, 3, 2]]);
        let delta = Delta::new(&old, &old, None).unwrap();
        assert!(delta.keeps_all(&old));
        let kept = Kept {
            vertices: vec![false, true, true, true],
            faces: vec![false, true],
        };
        let cut = mesh(&points[1..], &[[0, 2, 1], [0, 1, 2]]);
        let delta = Delta::new(&old, &cut, Some(&kept)).unwrap();
        assert_eq!(
            (delta.vertices.0, delta.faces.0),
            (vec![[1, 4]], vec![[1, 2]])
        );
        assert!(Delta::new(&old, &cut, None).is_none());
        let turned = mesh(&points[1..], &[[2, 1, 0]]);
        assert!(Delta::new(&old, &turned, Some(&kept)).is_none());
    }
}
