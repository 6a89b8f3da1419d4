//! The rest of a file that was read: all that a mesh and its attributes do not hold.

use serde::{Deserialize, Serialize};

use super::gltf::GltfDocument;
use super::threemf::ThreeMfDocument;

/// A file that was read, kept so that the same format can be written with all that a mesh does not hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum FileDocument {
    /// A glTF or GLB file.
    Gltf(GltfDocument),
    /// A 3MF package.
    ThreeMf(ThreeMfDocument),
}

impl FileDocument {
    /// The document of a glTF or GLB file.
    pub fn gltf(&self) -> Option<&GltfDocument> {
        match self {
            Self::Gltf(document) => Some(document),
            Self::ThreeMf(_) => None,
        }
    }

    /// The package of a 3MF file.
    pub(crate) fn three_mf(&self) -> Option<&ThreeMfDocument> {
        match self {
            Self::Gltf(_) => None,
            Self::ThreeMf(document) => Some(document),
        }
    }
}
