//! Inside or outside: the side of a surface on which a point is, from its closest point.

use glam::DVec3;

use crate::mesh::{Mesh, face_normal};
use crate::spatial::Closest;

/// A normal does not determine the side of a point if the sine of the angle between its plane and the direction to the point is
/// below this.
const UNCERTAIN: f64 = 1e-3;

/// The mesh element that contains a closest point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Inside its face.
    Face,
    /// On a half-edge.
    Edge(u32),
    /// At a vertex.
    Vertex(u32),
}

/// The mesh element that contains a closest point, from its barycentric coordinates.
pub fn feature(mesh: &Mesh, closest: &Closest) -> Feature {
    let w = closest.barycentric;
    let face = mesh.faces[closest.face as usize];
    match [w[0] == 0.0, w[1] == 0.0, w[2] == 0.0] {
        [false, false, false] => Feature::Face,
        [true, true, _] => Feature::Vertex(face[2]),
        [true, _, true] => Feature::Vertex(face[1]),
        [_, true, true] => Feature::Vertex(face[0]),
        [true, ..] => Feature::Edge(3 * closest.face + 1),
        [_, true, _] => Feature::Edge(3 * closest.face + 2),
        [_, _, true] => Feature::Edge(3 * closest.face),
    }
}

/// −1 inside, 1 outside: by the pseudonormal of the closest feature (Bærentzen and Aanæs, "Signed distance computation using the
/// angle weighted pseudonormal", 2005). Where the pseudonormal does not decide, as at folds and non-manifold edges, the face in
/// `around` decides from whose plane the point is farthest.
pub fn side(
    pseudonormal: DVec3,
    mesh: &Mesh,
    around: impl IntoIterator<Item = u32>,
    closest: &Closest,
    x: DVec3,
) -> f64 {
    let way = x - closest.point;
    let mut along = pseudonormal.dot(way);
    if along.abs() <= UNCERTAIN * closest.distance * pseudonormal.length() {
        for face in around {
            let above = face_normal(mesh, face).dot(way);
            if above.abs() > along.abs() {
                along = above;
            }
        }
    }
    if along < 0.0 { -1.0 } else { 1.0 }
}
