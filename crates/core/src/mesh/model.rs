//! A mesh together with its attributes.

use super::{Attributes, Mesh};

/// A mesh with attributes and notes for the user.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The mesh.
    pub mesh: Mesh,
    /// Colours, texture coordinates, materials, named values and other attributes.
    pub attributes: Attributes,
    /// Notes for the user, one sentence each.
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
