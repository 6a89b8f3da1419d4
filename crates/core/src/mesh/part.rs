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
