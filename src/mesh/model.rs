//! A mesh with what it carries.

use super::{Attributes, Mesh};

/// A mesh with what it carries beside its shape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The mesh.
    pub mesh: Mesh,
    /// Colours, texture coordinates, materials, named values and the like.
    pub attributes: Attributes,
    /// Remarks for the user, one sentence each.
    pub notes: Vec<String>,
}

impl From<Mesh> for Model {
    fn from(mesh: Mesh) -> Self {
        Self {
            mesh,
            ..Self::default()
        }
    }
}
