//! The rest of a file that was read: all that a mesh and its attributes do not hold.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::gltf::{GltfDocument, Image};
use super::threemf::ThreeMfDocument;
use super::usd::UsdDocument;
use super::{Contents, Format};

/// A file that was read, kept so that the same format can be written with all that a mesh does not hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileDocument(Kept);

/// What is kept of a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Kept {
    /// A glTF or GLB file.
    Gltf(GltfDocument),
    /// A 3MF package.
    ThreeMf(ThreeMfDocument),
    /// A USD stage.
    Usd(UsdDocument),
}

impl Contents<'_> {
    /// Whether the mesh comes from a glTF or GLB file.
    pub(super) fn is_of_gltf(&self) -> bool {
        self.document.is_some_and(|own| own.gltf().is_some())
    }
}

impl FileDocument {
    /// A glTF or GLB file.
    pub(crate) fn of_gltf(document: GltfDocument) -> Self {
        Self(Kept::Gltf(document))
    }

    /// A 3MF package.
    pub(crate) fn of_three_mf(document: ThreeMfDocument) -> Self {
        Self(Kept::ThreeMf(document))
    }

    /// A USD stage.
    pub(crate) fn of_usd(document: UsdDocument) -> Self {
        Self(Kept::Usd(document))
    }

    /// What a package or a stage holds that a file of another format has no place for, in words.
    pub(super) fn rest_beside(&self, format: Format) -> Vec<String> {
        match &self.0 {
            Kept::ThreeMf(package) if format != Format::ThreeMf => package.rest(),
            Kept::Usd(stage) if !matches!(format, Format::Usda | Format::Usdz) => stage.rest(),
            _ => Vec::new(),
        }
    }

    /// The document of a glTF or GLB file.
    pub(crate) fn gltf(&self) -> Option<&GltfDocument> {
        match &self.0 {
            Kept::Gltf(document) => Some(document),
            Kept::ThreeMf(_) | Kept::Usd(_) => None,
        }
    }

    /// The package of a 3MF file.
    pub(crate) fn three_mf(&self) -> Option<&ThreeMfDocument> {
        match &self.0 {
            Kept::Gltf(_) | Kept::Usd(_) => None,
            Kept::ThreeMf(document) => Some(document),
        }
    }

    /// What a USD stage says besides its meshes.
    pub(crate) fn usd(&self) -> Option<&UsdDocument> {
        match &self.0 {
            Kept::Gltf(_) | Kept::ThreeMf(_) => None,
            Kept::Usd(document) => Some(document),
        }
    }

    /// Whether triangles have paint of a slicer: only in a 3MF file.
    pub fn is_painted(&self) -> bool {
        self.three_mf().is_some_and(ThreeMfDocument::is_painted)
    }

    /// Of a glTF or GLB file: ranges of faces of the mesh, in order, with the index of their texture's image, if they have one. None of
    /// other files.
    pub fn images_of_faces(
        &self,
    ) -> Option<impl Iterator<Item = (Range<usize>, Option<usize>)> + '_> {
        Some(self.gltf()?.images_of_faces())
    }

    /// An image of a glTF or GLB file; none behind the last one.
    pub fn image(&self, index: usize) -> Option<Image> {
        self.gltf()?.image(index)
    }
}
