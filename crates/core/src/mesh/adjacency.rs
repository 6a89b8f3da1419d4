//! Vertex-face adjacency, face normals and vertex normals.

use std::sync::OnceLock;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::{Mesh, area_vector};
use crate::elementary::angle_between;

/// The faces of each vertex, as one flat list.
pub struct VertexFaces {
    first: Vec<u32>,
    faces: Vec<u32>,
}

impl VertexFaces {
    /// Builds the lists; faces are in rising order.
    pub fn new(mesh: &Mesh) -> Self {
        let mut first = vec![0u32; mesh.positions.len() + 1];
        for v in mesh.faces.iter().flatten() {
            first[*v as usize + 1] += 1;
        }
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut at = first.clone();
        let mut faces = vec![0; 3 * mesh.faces.len()];
        for (f, face) in mesh.faces.iter().enumerate() {
            for &v in face {
                faces[at[v as usize] as usize] = f as u32;
                at[v as usize] += 1;
            }
        }
        Self { first, faces }
    }

    /// The faces of a vertex.
    pub fn of(&self, vertex: u32) -> &[u32] {
        let v = vertex as usize;
        &self.faces[self.first[v] as usize..self.first[v + 1] as usize]
    }
}

/// Unit normal of a face; zero for a face without area.
pub fn face_normal(mesh: &Mesh, face: u32) -> DVec3 {
    area_vector(mesh.corners(face)).normalize_or_zero()
}

/// Angle-weighted unit normal of a vertex (Thürmer and Wüthrich 1998; used in the sign test of Bærentzen and Aanæs 2005).
pub fn vertex_normal(mesh: &Mesh, around: &VertexFaces, vertex: u32) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for &f in around.of(vertex) {
        let normal = face_normal(mesh, f);
        if normal == DVec3::ZERO {
            continue;
        }
        let face = mesh.faces[f as usize];
        let k = face.iter().position(|&v| v == vertex).unwrap_or(0);
        let p = mesh.positions[vertex as usize];
        let a = mesh.positions[face[(k + 1) % 3] as usize] - p;
        let b = mesh.positions[face[(k + 2) % 3] as usize] - p;
        sum += normal * angle_between(a, b);
    }
    sum.normalize_or_zero()
}

/// Faces. The normals of vertices with more are stored, since thousands of points may be nearest to the tip of a fan.
const LARGE_FAN: usize = 100;

/// Normals of vertices, at the tips of large fans computed once.
pub(crate) struct VertexNormals {
    around: VertexFaces,
    of_fans: FxHashMap<u32, OnceLock<DVec3>>,
}

impl VertexNormals {
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let around = VertexFaces::new(mesh);
        let fans = (0..mesh.positions.len() as u32).filter(|v| around.of(*v).len() > LARGE_FAN);
        Self {
            of_fans: fans.map(|v| (v, OnceLock::new())).collect(),
            around,
        }
    }

    /// The faces around each vertex.
    pub(crate) fn around(&self) -> &VertexFaces {
        &self.around
    }

    /// The [`vertex_normal`] of a vertex of the mesh that this was made of.
    pub(crate) fn of(&self, mesh: &Mesh, vertex: u32) -> DVec3 {
        let normal = || vertex_normal(mesh, &self.around, vertex);
        match self.of_fans.get(&vertex) {
            Some(known) => *known.get_or_init(normal),
            None => normal(),
        }
    }
}
