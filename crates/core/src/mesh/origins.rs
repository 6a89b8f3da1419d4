//! Provenance of the vertices and faces of a changed mesh.

use serde::{Deserialize, Serialize};

use super::Mesh;
use super::attributes::NONE;

/// The origin of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaceOrigin {
    /// The old face that it is, or from which it was made; `u32::MAX` for a new face.
    pub face: u32,
    /// For each corner, the corner of the old face that it is; 3 for none.
    pub corners: [u8; 3],
}

impl FaceOrigin {
    /// The origin of a new face.
    pub const NEW: Self = Self {
        face: NONE,
        corners: [3; 3],
    };

    /// The origin of an unchanged face.
    pub fn same(face: u32) -> Self {
        Self {
            face,
            corners: [0, 1, 2],
        }
    }

    /// The origin in an earlier mesh. `earlier` gives for each old face its origin there.
    pub(crate) fn before(self, earlier: &[Self]) -> Self {
        let Some(old) = earlier.get(self.face as usize) else {
            return Self::NEW;
        };
        let corner = |k: u8| old.corners.get(usize::from(k)).copied().unwrap_or(3);
        match old.face {
            NONE => Self::NEW,
            face => Self {
                face,
                corners: self.corners.map(corner),
            },
        }
    }
}

/// The origins of a mesh's vertices and faces.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origins {
    /// For each vertex, the old vertex that it is or copies.
    pub vertices: Vec<u32>,
    /// For each face, its origin.
    pub faces: Vec<FaceOrigin>,
}

impl Origins {
    /// The origins of an unchanged mesh.
    pub fn of(mesh: &Mesh) -> Self {
        Self {
            vertices: (0..mesh.positions.len() as u32).collect(),
            faces: (0..mesh.faces.len() as u32).map(FaceOrigin::same).collect(),
        }
    }

    /// Marks which of `count` old faces are the origin of at least one face.
    pub fn living(&self, count: usize) -> Vec<bool> {
        let mut living = vec![false; count];
        let known = self.faces.iter().filter(|o| o.face != NONE);
        known.for_each(|o| living[o.face as usize] = true);
        living
    }
}
