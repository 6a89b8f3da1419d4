//! The coordinates that the format of an output stores.

use glam::DMat4;

use super::output::Output;
use crate::io::{FileDocument, Format, Loaded};

impl Output {
    /// The transform from the file's coordinates to the mesh's, if the file stores 32-bit floats; else `None`.
    pub(super) fn stored(&self, input: &Loaded) -> Option<DMat4> {
        match self.format {
            Format::Gltf | Format::Glb => {
                Some(match input.document.as_ref().and_then(FileDocument::gltf) {
                    Some(document) => document.largest_transform(),
                    None => DMat4::IDENTITY,
                })
            }
            Format::Stl if !self.ascii => Some(DMat4::IDENTITY),
            Format::Usda | Format::Usdz => Some(DMat4::IDENTITY),
            Format::Obj | Format::Off | Format::ThreeMf => None,
            _ => input.f32_exact.then_some(DMat4::IDENTITY),
        }
    }
}
