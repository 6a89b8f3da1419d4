//! Parts of a mesh with local numbers.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::Mesh;

/// Some faces of a mesh with their vertices. Faces and vertices keep their order, so that algorithms give the same result on the
/// part as on the whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// The part as a mesh.
    pub mesh: Mesh,
    /// The number in the whole of each vertex, in rising order.
    vertices: Vec<u32>,
}

impl Part {
    /// The part with the given faces, in the given order, and with the given vertices in addition to theirs.
    ///
    /// # Panics
    /// If a face or vertex number is out of range.
    pub fn new(whole: &Mesh, faces: &[u32], vertices: impl Iterator<Item = u32>) -> Self {
        let faces: Vec<[u32; 3]> = faces.iter().map(|&f| whole.faces[f as usize]).collect();
        Self::of_faces(&whole.positions, &faces, vertices)
    }

    /// The same for any faces between vertices with these positions.
    ///
    /// # Panics
    /// If a vertex number is out of range.
    pub fn of_faces(
        positions: &[DVec3],
        faces: &[[u32; 3]],
        vertices: impl Iterator<Item = u32>,
    ) -> Self {
        let mut faces = faces.to_vec();
        let vertices = compacted(&mut faces, vertices.collect());
        let own = vertices.iter().map(|&v| positions[v as usize]);
        Self {
            mesh: Mesh::new(own.collect(), faces),
            vertices,
        }
    }

    /// The number in the whole of each vertex, in rising order.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// The local number of a vertex of the whole; the vertex must be in the part.
    pub fn local(&self, vertex: u32) -> u32 {
        self.vertices.partition_point(|&v| v < vertex) as u32
    }

    /// The local number of a vertex of the part, or of a new vertex: new vertices are numbered after the `count` vertices of the
    /// whole, and locally after the part's. Inverse of [`Part::original`].
    pub fn local_or_new(&self, vertex: u32, count: usize) -> u32 {
        match vertex.checked_sub(count as u32) {
            Some(new) => self.vertices.len() as u32 + new,
            None => self.local(vertex),
        }
    }

    /// The number in the whole of a local vertex. Local numbers past the part's vertices are new vertices, which are numbered
    /// after the `count` vertices of the whole.
    pub fn original(&self, vertex: u32, count: usize) -> u32 {
        match self.vertices.get(vertex as usize) {
            Some(&v) => v,
            None => vertex - self.vertices.len() as u32 + count as u32,
        }
    }
}

/// Numbers the vertices of faces without gaps, in their order; returns the number that each had, with some vertices in addition.
fn compacted(faces: &mut [[u32; 3]], mut vertices: Vec<u32>) -> Vec<u32> {
    let all = || faces.iter().flatten().chain(&vertices).copied();
    let (Some(first), Some(last)) = (all().min(), all().max()) else {
        return Vec::new();
    };
    let words = (last - first) as usize / 64 + 1;
    // Marks of all vertices of the range are faster to make and to count than a sorted list, unless most words are empty.
    if words > 3 * faces.len() {
        vertices.extend(faces.iter().flatten());
        vertices.sort_unstable();
        vertices.dedup();
        let local = |v: u32| vertices.partition_point(|&w| w < v) as u32;
        faces.iter_mut().for_each(|f| *f = f.map(local));
        return vertices;
    }
    let mut marks = vec![0u64; words];
    let place = |v: u32| ((v - first) as usize / 64, (v - first) % 64);
    for (word, bit) in all().map(place) {
        marks[word] |= 1 << bit;
    }
    // The number of marks before each word.
    let mut before = Vec::with_capacity(words);
    let mut used = Vec::new();
    for (&word, start) in marks.iter().zip((first..).step_by(64)) {
        before.push(used.len() as u32);
        let mut rest = word;
        while rest != 0 {
            used.push(start + rest.trailing_zeros());
            rest &= rest - 1;
        }
    }
    let local = |v: u32| {
        let (word, bit) = place(v);
        before[word] + (marks[word] & ((1 << bit) - 1)).count_ones()
    };
    faces.iter_mut().for_each(|f| *f = f.map(local));
    used
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::icosphere;

    #[test]
    fn near_and_far_vertices_are_numbered_alike() {
        let near = vec![[70, 3, 64], [3, 4, 127], [64, 70, 128]];
        let spread = |v: u32| v * 1000 + 5;
        let mut far: Vec<[u32; 3]> = near.iter().map(|f| f.map(spread)).collect();
        let mut local = near.clone();
        let found = compacted(&mut local, vec![66, 3]);
        assert_eq!(found, [3, 4, 64, 66, 70, 127, 128]);
        for (f, g) in local.iter().zip(&near) {
            assert_eq!(f.map(|v| found[v as usize]), *g);
        }
        assert_eq!(
            compacted(&mut far, vec![spread(66), spread(3)]),
            found.iter().map(|v| spread(*v)).collect::<Vec<_>>()
        );
        assert_eq!(far, local);
        assert_eq!(compacted(&mut [], vec![9, 2, 9]), [2, 9]);
        assert!(compacted(&mut [], Vec::new()).is_empty());
    }

    #[test]
    fn numbers_go_there_and_back_and_new_ones_follow_the_whole() {
        let whole = icosphere(2);
        let count = whole.positions.len();
        let part = Part::new(&whole, &[3, 40, 41], std::iter::once(7));
        for (f, g) in [3, 40, 41].into_iter().zip(&part.mesh.faces) {
            assert_eq!(g.map(|v| part.original(v, count)), whole.faces[f]);
        }
        let last = part.mesh.positions.len() as u32;
        assert_eq!(part.original(part.local(7), count), 7);
        assert_eq!(part.original(last + 2, count), count as u32 + 2);
        assert_eq!(part.local_or_new(count as u32 + 2, count), last + 2);
        assert_eq!(part.local_or_new(7, count), part.local(7));
    }
}
