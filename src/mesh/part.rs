//! A part of a mesh with its own numbering.

use super::Mesh;

/// Some faces of a mesh with their vertices. Faces and vertices keep their order, so that what works on the part alone comes
/// to the same result as on the whole.
#[derive(Clone, Debug, Default)]
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
        let of_faces = faces.iter().flat_map(|&f| whole.faces[f as usize]);
        let mut vertices: Vec<u32> = of_faces.chain(vertices).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let positions = vertices.iter().map(|&v| whole.positions[v as usize]);
        let mut part = Self {
            mesh: Mesh::new(positions.collect(), Vec::new()),
            vertices,
        };
        part.mesh.faces = faces
            .iter()
            .map(|&f| whole.faces[f as usize].map(|v| part.local(v)))
            .collect();
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
    }
}
