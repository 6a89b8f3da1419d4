//! A coarse version of a large mesh by vertex clustering: a page shows it before it has the mesh itself.

use glam::DVec3;
use rayon::prelude::*;

use isomend_core::mesh::{Mesh, area_vector};

/// Number of faces, about, of a coarse version: as many as a picture has pixels.
const FACES: f64 = 1e6;
/// Upper bound of the number of faces, relative to [`FACES`].
const MOST: f64 = 1.5;
/// Faces of a coarse version for each cell of its area. A surface touches about 1.5 cells for each square of their size, and each is a
/// vertex with two faces.
const FACES_OF_CELL: f64 = 3.0;
/// Factor by which cells grow if there are too many faces.
const GROWTH: f64 = 1.3;

/// A coarse version of a mesh.
pub struct Clusters {
    /// Its vertices, as vertices of the mesh: in each cell the one nearest to the mean.
    pub vertices: Vec<u32>,
    /// Its faces, with indices into `vertices`.
    pub faces: Vec<[u32; 3]>,
    /// For each of its faces the face of the mesh that became it.
    pub numbers: Vec<u32>,
}

impl Clusters {
    /// A coarse version of a mesh with about a million faces, or fewer if the mesh has fewer.
    pub fn new(mesh: &Mesh) -> Self {
        let area = |face| 0.5 * area_vector(mesh.corners(face)).length();
        let faces = (0..mesh.faces.len() as u32).into_par_iter();
        let area: f64 = faces.map(area).sum();
        let mut cell = (FACES_OF_CELL * area / FACES).sqrt();
        loop {
            let clusters = Self::with_cells(mesh, cell);
            if clusters.faces.len() as f64 <= MOST * FACES || !cell.is_normal() {
                return clusters;
            }
            cell *= GROWTH;
        }
    }

    /// A coarse version with cells of a size, in the mesh's unit.
    fn with_cells(mesh: &Mesh, size: f64) -> Self {
        let [low, _] = mesh.bounds();
        // Sort the vertices by their cells.
        let place = |vertex: u32| {
            let p = mesh.positions[vertex as usize];
            (((p - low) / size).to_array().map(|x| x as u32), vertex)
        };
        let vertices = (0..mesh.positions.len() as u32).into_par_iter();
        let mut placed: Vec<([u32; 3], u32)> = vertices.map(place).collect();
        placed.par_sort_unstable();
        // Of each cell, take the vertex nearest to the mean of its vertices.
        let mut cell_of = vec![0; mesh.positions.len()];
        let mut nearest = Vec::new();
        for cell in placed.chunk_by(|(a, _), (b, _)| a == b) {
            let position = |&(_, vertex): &([u32; 3], u32)| mesh.positions[vertex as usize];
            let mean = cell.iter().map(position).sum::<DVec3>() / cell.len() as f64;
            let far = |one: &_| position(one).distance_squared(mean);
            let best = cell.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
            for &(_, vertex) in cell {
                cell_of[vertex as usize] = nearest.len() as u32;
            }
            nearest.extend(best.map(|(_, vertex)| *vertex));
        }
        // Faces with all corners in different cells remain.
        let moved = mesh.faces.iter().map(|f| f.map(|v| cell_of[v as usize]));
        let (numbers, faces) = (0..)
            .zip(moved)
            .filter(|(_, [a, b, c])| a != b && b != c && c != a)
            .unzip();
        Self {
            vertices: nearest,
            faces,
            numbers,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat square of `side`² pairs of triangles.
    fn square(side: u32) -> Mesh {
        let at = |i: u32| f64::from(i) / f64::from(side);
        let points =
            (0..=side).flat_map(|y| (0..=side).map(move |x| DVec3::new(at(x), at(y), 0.0)));
        let vertex = |x: u32, y: u32| y * (side + 1) + x;
        let faces = (0..side).flat_map(|y| {
            (0..side).flat_map(move |x| {
                let [a, b] = [vertex(x, y), vertex(x + 1, y)];
                let [c, d] = [vertex(x, y + 1), vertex(x + 1, y + 1)];
                [[a, b, c], [b, d, c]]
            })
        });
        Mesh::new(points.collect(), faces.collect())
    }

    #[test]
    fn cells_with_several_vertices_become_one_vertex() {
        let mesh = square(40);
        let clusters = Clusters::with_cells(&mesh, 0.1);
        assert!((100..150).contains(&clusters.vertices.len()));
        assert!((180..250).contains(&clusters.faces.len()));
        assert_eq!(clusters.faces.len(), clusters.numbers.len());
        for (face, number) in clusters.faces.iter().zip(&clusters.numbers) {
            let corners = face.map(|v| mesh.positions[clusters.vertices[v as usize] as usize]);
            for (corner, own) in corners.iter().zip(mesh.corners(*number)) {
                assert!(corner.distance(own) < 0.15, "{corner} stands for {own}");
            }
        }
    }

    #[test]
    fn a_large_mesh_gets_about_as_many_faces_as_a_picture_has_pixels() {
        let clusters = Clusters::new(&square(1500));
        assert!((0.3e6..1.5e6).contains(&(clusters.faces.len() as f64)));
        assert!(
            Clusters::new(&Mesh::new(Vec::new(), Vec::new()))
                .faces
                .is_empty()
        );
    }
}
