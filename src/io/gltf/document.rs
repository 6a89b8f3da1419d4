//! A glTF file that was read, kept so that it can be written again with more in it.

use std::sync::Arc;

use serde_json::Value;

use super::super::{Contents, text};
use super::scene::{Block, PlacedPrimitive};

/// A glTF or GLB file with all that a mesh does not hold: its node tree, materials, textures, animations and extras.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    pub(super) json: Value,
    /// The buffers; one that could not be loaded, and holds no triangles, stays outside.
    pub(super) buffers: Vec<Option<Arc<Vec<u8>>>>,
    pub(super) blocks: Vec<Block>,
    pub(super) parts: Vec<PlacedPrimitive>,
}

impl Document {
    /// Keeps a file; `None` where it cannot be written again without knowing an extension.
    pub(super) fn new(
        json: &[u8],
        buffers: Vec<Option<Arc<Vec<u8>>>>,
        blocks: Vec<Block>,
        parts: Vec<PlacedPrimitive>,
    ) -> Option<Self> {
        let json: Value = serde_json::from_slice(text::strip_bom(json).trim_ascii_end()).ok()?;
        let used = json.get("extensionsUsed").and_then(Value::as_array);
        let compressed = used.into_iter().flatten().any(|name| {
            let name = name.as_str().unwrap_or("");
            name.contains("draco") || name.contains("meshopt")
        });
        (json.is_object() && !compressed).then_some(Self {
            json,
            buffers,
            blocks,
            parts,
        })
    }

    /// How many vertices and faces the scene has.
    pub(super) fn counts(&self) -> (usize, usize) {
        let vertices = self.blocks.last().map_or(0, |b| b.start + b.count);
        let faces = self.parts.last().map_or(0, |p| p.faces.0 + p.faces.1);
        (vertices as usize, faces)
    }

    /// How many of the faces are kept.
    pub(super) fn kept(&self, model: &Contents<'_>) -> usize {
        match &model.attributes.kept_of_file {
            Some(kept) => kept.iter().filter(|k| **k).count(),
            None => self.counts().1,
        }
    }

    /// Whether a mesh can be one that began as this scene.
    pub(super) fn fits(&self, model: &Contents<'_>) -> bool {
        let (vertices, faces) = self.counts();
        let marks = model.attributes.kept_of_file.as_ref();
        model.mesh.positions.len() >= vertices
            && model.mesh.faces.len() >= self.kept(model)
            && marks.is_none_or(|kept| kept.len() == faces)
    }

    /// Names of files that the document refers to and that stay outside: images, and buffers that could not be loaded.
    pub fn side_files(&self) -> Vec<String> {
        let list = |key: &str| self.json.get(key).and_then(Value::as_array);
        let buffers = list("buffers").into_iter().flatten().enumerate();
        let outside = buffers.filter(|(i, _)| self.buffers.get(*i).is_some_and(Option::is_none));
        let images = list("images").into_iter().flatten();
        images
            .chain(outside.map(|(_, buffer)| buffer))
            .filter_map(|item| item.get("uri")?.as_str())
            .filter(|uri| !uri.starts_with("data:") && !uri.contains("://"))
            .map(super::buffers::percent_decoded)
            .collect()
    }
}
