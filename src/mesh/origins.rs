//! Where the vertices and faces of a mesh come from, after it was changed.

use super::Mesh;
use super::attributes::NONE;

/// Where a face comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct FaceOrigin {
    /// The face that it is, or was made of; `u32::MAX` for a new one.
    pub face: u32,
    /// For each corner the corner of that face which it is; 3 where it is none of them.
    pub corners: [u8; 3],
}

impl FaceOrigin {
    /// That of a new face.
    pub const NEW: Self = Self {
        face: NONE,
        corners: [3; 3],
    };

    /// That of a face as it was.
    pub fn same(face: u32) -> Self {
        Self {
            face,
            corners: [0, 1, 2],
        }
    }
}

/// Where the vertices and faces of a mesh come from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Origins {
    /// For each vertex the one that it is or is a copy of.
    pub vertices: Vec<u32>,
    /// For each face the one that it is.
    pub faces: Vec<FaceOrigin>,
}

impl Origins {
    /// Those of a mesh that was not changed.
    pub fn of(mesh: &Mesh) -> Self {
        Self {
            vertices: (0..mesh.positions.len() as u32).collect(),
            faces: (0..mesh.faces.len() as u32).map(FaceOrigin::same).collect(),
        }
    }

    /// For each of `count` faces whether some face comes from it.
    pub fn living(&self, count: usize) -> Vec<bool> {
        let mut living = vec![false; count];
        let known = self.faces.iter().filter(|o| o.face != NONE);
        known.for_each(|o| living[o.face as usize] = true);
        living
    }
}
