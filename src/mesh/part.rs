//! A part of a mesh with its own numbering.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::Mesh;

/// Some faces of a mesh with their vertices. Faces and vertices keep their order, so that what works on the part alone comes
/// to the same result as on the whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// The part on its own.
    pub mesh: Mesh,
    /// The whole's number of each vertex, rising.
    vertices: Vec<u32>,
}

impl Part {
    /// The part with the given faces, in the order given, and the given vertices beside theirs.
    ///
    /// # Panics
    /// When a number is past the end of the faces or of the positions.
    pub fn new(whole: &Mesh, faces: &[u32], vertices: impl Iterator<Item = u32>) -> Self {
        let faces: Vec<[u32; 3]> = faces.iter().map(|&f| whole.faces[f as usize]).collect();
        Self::of_faces(&whole.positions, &faces, vertices)
    }

    /// The same for faces that need not be those of a mesh, between vertices at these positions.
    ///
    /// # Panics
    /// When a number is past the end of the positions.
    pub fn of_faces(
        positions: &[DVec3],
        faces: &[[u32; 3]],
        vertices: impl Iterator<Item = u32>,
    ) -> Self {
        let mut vertices: Vec<u32> = faces.iter().flatten().copied().chain(vertices).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let own = vertices.iter().map(|&v| positions[v as usize]);
        let mut part = Self {
            mesh: Mesh::new(own.collect(), Vec::new()),
            vertices,
        };
        let local = |f: &[u32; 3]| f.map(|v| part.local(v));
        part.mesh.faces = faces.iter().map(local).collect();
        part
    }

    /// For each of its vertices the whole's number, rising.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// The part's number of a vertex of the whole that is in it.
    pub fn local(&self, vertex: u32) -> u32 {
        self.vertices.partition_point(|&v| v < vertex) as u32
    }

    /// The part's number of a vertex that is in it, or of a new one that follows the `count` vertices of the whole and then those of the
    /// part: the inverse of [`Part::original`].
    pub fn local_or_new(&self, vertex: u32, count: usize) -> u32 {
        match vertex.checked_sub(count as u32) {
            Some(new) => self.vertices.len() as u32 + new,
            None => self.local(vertex),
        }
    }

    /// The whole's number of a vertex of the part. Numbers past the part's vertices are those of new ones, which follow the
    /// `count` vertices of the whole.
    pub fn original(&self, vertex: u32, count: usize) -> u32 {
        match self.vertices.get(vertex as usize) {
            Some(&v) => v,
            None => vertex - self.vertices.len() as u32 + count as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::icosphere;

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
