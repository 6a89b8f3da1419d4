//! Indexed triangle meshes in double precision, their topology, holes and attributes.

mod adjacency;
pub mod attributes;
mod bodies;
mod chains;
pub mod cut;
mod error;
mod fans;
mod hole_id;
pub mod holes;
mod lengths;
pub mod mask;
pub mod measures;
mod model;
mod origins;
mod part;
mod sets;
pub mod shapes;
#[cfg(test)]
mod tests;
pub mod topology;
pub mod triangulate;
mod unit;
mod weld;

use glam::DVec3;
use serde::{Deserialize, Serialize};

pub(crate) use adjacency::VertexNormals;
pub use adjacency::{VertexFaces, face_normal, vertex_normal};
pub use attributes::Attributes;
pub use bodies::Bodies;
pub use chains::{ChainReason, OpenChain};
pub use error::MeshError;
pub use fans::{fans, has_several_fans};
pub use hole_id::HoleId;
pub use holes::{Hole, described, find_holes};
pub use lengths::{at_least, beside, length, length_beside, number, point, significant};
pub use measures::{area_vector, half_cotangents};
pub use model::Model;
pub use origins::{FaceOrigin, Origins};
pub use part::Part;
pub use sets::{DisjointSets, connected};
pub use topology::{Defects, Topology};
pub use unit::Unit;
pub use weld::Welder;
pub(crate) use weld::corner_key;
pub use weld::{weld_map, weld_map_of_bodies, welded};

/// Maximum absolute coordinate: squares of areas, which contain fourth powers of lengths up to three times as large, must not
/// overflow.
pub const LARGEST: f64 = 1e75;
/// Minimum extent: fourth powers of a thousandth of it must not lose precision by underflow.
pub const SMALLEST: f64 = 1e-70;

/// An indexed triangle mesh.
///
/// Faces are counter-clockwise seen from outside. Coordinates are in the units of the file that the mesh comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Three vertex indices per triangle.
    pub faces: Vec<[u32; 3]>,
}

impl Mesh {
    /// A mesh from its positions and faces.
    pub fn new(positions: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Self {
        Self { positions, faces }
    }

    /// A mesh from positions as arrays of 32-bit floats, which doubles hold exactly, and its faces.
    pub fn from_f32(positions: Vec<[f32; 3]>, faces: Vec<[u32; 3]>) -> Self {
        let double = |p: [f32; 3]| DVec3::from(p.map(f64::from));
        Self::new(positions.into_iter().map(double).collect(), faces)
    }

    /// Smallest and largest coordinates of the vertices that faces use; (+∞, −∞) without faces.
    ///
    /// # Panics
    /// If a face uses a vertex that does not exist.
    pub fn bounds(&self) -> [DVec3; 2] {
        let used = self.faces.iter().flatten();
        let (low, high) = bounds(used.map(|&v| self.positions[v as usize]));
        [low, high]
    }

    /// The corners of a face.
    ///
    /// # Panics
    /// If the face or one of its vertices does not exist.
    pub fn corners(&self, face: u32) -> [DVec3; 3] {
        let [a, b, c] = self.faces[face as usize];
        [
            self.positions[a as usize],
            self.positions[b as usize],
            self.positions[c as usize],
        ]
    }
}

/// A mesh from arrays of doubles: positions and faces.
impl From<(Vec<[f64; 3]>, Vec<[u32; 3]>)> for Mesh {
    fn from((positions, faces): (Vec<[f64; 3]>, Vec<[u32; 3]>)) -> Self {
        Self::new(positions.into_iter().map(DVec3::from).collect(), faces)
    }
}

/// Smallest and largest coordinates of points; (+∞, −∞) without points.
pub fn bounds(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points
        .into_iter()
        .fold(start, |(low, high), p| (low.min(p), high.max(p)))
}
