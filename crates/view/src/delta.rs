//! Which vertices and faces a step kept, and their numbers before and after it.

use std::collections::HashMap;

use glam::DVec3;

use super::runs::Runs;
use isomend_core::mesh::Mesh;
use isomend_core::spatial::Bvh;
use isomend_files::job::KeptElements;

/// The vertices and faces of an old mesh that a new mesh starts with, in the same order.
#[derive(Clone, Debug, Default)]
pub struct Delta {
    /// Numbers of the kept vertices in the old mesh.
    pub vertices: Runs,
    /// Numbers of the kept faces in the old mesh.
    pub faces: Runs,
}

impl Delta {
    /// Checks that `new` starts with the part of `old` that `kept` names, or with all of `old` if `kept` is none. Returns none if it does
    /// not, for example after a file format that reorders vertices.
    pub fn new(old: &Mesh, new: &Mesh, kept: Option<&KeptElements>) -> Option<Self> {
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

    /// Pairs of an old and a new face: for each face of the new mesh that is not kept, the removed face nearest to its centroid.
    pub fn replaced(&self, old: &Mesh, new: &Mesh) -> Vec<[u32; 2]> {
        let mut is_kept = vec![false; old.faces.len()];
        self.faces.numbers().for_each(|face| is_kept[face] = true);
        let faces = 0..old.faces.len() as u32;
        let bvh = Bvh::new(old, faces.filter(|face| !is_kept[*face as usize]));
        let first = self.faces.count() as u32;
        let pair = |face: u32| {
            let centroid = new.corners(face).iter().sum::<DVec3>() / 3.0;
            let nearest = bvh.closest(centroid, f64::INFINITY)?;
            Some([nearest.face, face])
        };
        (first..new.faces.len() as u32).filter_map(pair).collect()
    }

    /// Whether all of the old mesh is kept.
    pub fn keeps_all(&self, mesh: &Mesh) -> bool {
        self.vertices.count() == mesh.positions.len() && self.faces.count() == mesh.faces.len()
    }
}

/// The numbers of a mesh's vertices and faces in the mesh that a step made from it.
pub struct KeptNumbers {
    /// For each vertex of the old mesh its new number; none if it is gone.
    pub vertices: Vec<Option<u32>>,
    /// For each face of the old mesh its new number; none if it is gone.
    pub faces: Vec<Option<u32>>,
}

impl KeptNumbers {
    /// The new numbers by `delta`, or by position if there is none.
    pub fn new(before: &Mesh, after: &Mesh, delta: Option<&Delta>) -> Self {
        let Some(delta) = delta else {
            return Self::by_position(before, after);
        };
        let numbered = |runs: &Runs, count: usize| {
            let mut number = vec![None; count];
            for (new, old) in (0..).zip(runs.numbers()) {
                number[old] = Some(new);
            }
            number
        };
        Self {
            vertices: numbered(&delta.vertices, before.positions.len()),
            faces: numbered(&delta.faces, before.faces.len()),
        }
    }

    /// The new numbers independent of the order: vertices by exact position, and faces by their vertices in either orientation.
    pub fn by_position(before: &Mesh, after: &Mesh) -> Self {
        let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
        let mut place = HashMap::new();
        for (v, p) in (0u32..).zip(&after.positions) {
            place.entry(bits(p)).or_insert(v);
        }
        let find = |p: &DVec3| place.get(&bits(p)).copied();
        let vertices: Vec<Option<u32>> = before.positions.iter().map(find).collect();
        let sorted = |face: [Option<u32>; 3]| {
            let mut face = [face[0]?, face[1]?, face[2]?];
            face.sort_unstable();
            Some(face)
        };
        let mut numbers = HashMap::new();
        for (f, face) in (0u32..).zip(&after.faces) {
            if let Some(face) = sorted(face.map(|v| find(&after.positions[v as usize]))) {
                numbers.entry(face).or_insert(f);
            }
        }
        let number = |face: &[u32; 3]| {
            let face = sorted(face.map(|v| vertices[v as usize]))?;
            numbers.get(&face).copied()
        };
        let faces = before.faces.iter().map(number).collect();
        Self { vertices, faces }
    }
}

/// The vertex numbers of a rim, rotated to the lexicographically smallest sequence, so that they do not depend on the first vertex.
pub fn rim_key(rim: &[u32]) -> Vec<u32> {
    let least = rim.iter().min();
    let starts = (0..rim.len()).filter(|&i| Some(&rim[i]) == least);
    let from = |start: usize| [&rim[start..], &rim[..start]].concat();
    starts.map(from).min().unwrap_or_default()
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
    fn kept_parts_are_found_and_wrong_ones_refused() {
        let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]];
        let old = mesh(&points, &[[0, 1, 2], [1, 3, 2]]);
        let delta = Delta::new(&old, &old, None).unwrap();
        assert!(delta.keeps_all(&old));
        let kept = KeptElements {
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

    #[test]
    fn vertices_and_faces_are_found_in_another_order() {
        let at = |x: f64| DVec3::new(x, x * x, 0.0);
        let before = Mesh::new(
            (0..4).map(|i| at(f64::from(i))).collect(),
            vec![[0, 1, 2], [1, 3, 2]],
        );
        let after = Mesh::new(
            (1..4).rev().map(|i| at(f64::from(i))).collect(),
            vec![[0, 1, 2]],
        );
        let KeptNumbers { vertices, faces } = KeptNumbers::by_position(&before, &after);
        assert_eq!(vertices, [None, Some(2), Some(1), Some(0)]);
        assert_eq!(faces, [None, Some(0)], "of the same corners, turned over");
    }
}
