//! The rest of a glTF file that was read, kept so that patches can be added to the original file.

use std::ops::Range;
use std::sync::Arc;

use glam::DMat4;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::super::{Contents, text};
use super::scene::{Block, PlacedPrimitive};

/// A glTF or GLB file with everything that a mesh does not hold: node tree, materials, textures, animations, extras.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct GltfDocument {
    pub(super) json: Value,
    /// The buffers; `None` for a buffer that could not be loaded, which stays an external file and holds no triangles.
    #[serde(with = "buffers")]
    pub(super) buffers: Vec<Option<Arc<Vec<u8>>>>,
    pub(super) blocks: Vec<Block>,
    pub(super) parts: Vec<PlacedPrimitive>,
}

/// Serialises buffers; a buffer that several documents share is written once per document.
mod buffers {
    use std::sync::Arc;

    use serde::{Deserialize, Deserializer, Serializer};

    type Buffers = Vec<Option<Arc<Vec<u8>>>>;

    pub(super) fn serialize<S: Serializer>(all: &Buffers, to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(all.iter().map(Option::as_deref))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Buffers, D::Error> {
        let all = Vec::<Option<Vec<u8>>>::deserialize(from)?;
        Ok(all.into_iter().map(|bytes| bytes.map(Arc::new)).collect())
    }
}

/// An image of a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Image {
    /// Embedded: the bytes of the image.
    Bytes(Vec<u8>),
    /// A file name relative to the folder of the document.
    File(String),
}

fn number(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|n| usize::try_from(n).ok())
}

impl GltfDocument {
    /// Keeps a file; `None` if its compression extension prevents writing it again.
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

    /// The number of vertices and faces of the scene.
    pub(super) fn counts(&self) -> (usize, usize) {
        let vertices = self.blocks.last().map_or(0, |b| b.start + b.count);
        let faces = self.parts.last().map_or(0, |p| p.faces.0 + p.faces.1);
        (vertices as usize, faces)
    }

    /// The block of a vertex of the file.
    pub(super) fn block_of(&self, vertex: u32) -> usize {
        self.blocks.partition_point(|b| b.start + b.count <= vertex)
    }

    /// The transform to the scene from the node with the most vertices, whose coordinates the file holds as 32-bit
    /// floats.
    pub(crate) fn largest_transform(&self) -> DMat4 {
        let largest = self.blocks.iter().max_by_key(|b| b.count);
        largest.map_or(DMat4::IDENTITY, |b| b.transform)
    }

    /// How many faces of the file the model keeps.
    pub(super) fn kept(&self, model: &Contents<'_>) -> usize {
        match &model.attributes.kept_of_file {
            Some(kept) => kept.iter().filter(|k| **k).count(),
            None => self.counts().1,
        }
    }

    /// Whether a mesh can be an extension of this scene: it has at least its vertices and kept faces, each with the vertices of its
    /// own primitive.
    pub(super) fn fits(&self, model: &Contents<'_>) -> bool {
        let (vertices, faces) = self.counts();
        let marks = model.attributes.kept_of_file.as_ref();
        model.mesh.positions.len() >= vertices
            && model.mesh.faces.len() >= self.kept(model)
            && marks.is_none_or(|kept| kept.len() == faces)
            && self.kept_faces(model).all(|(part, faces)| {
                let block = &self.blocks[part.block];
                let own = block.start..block.start + block.count;
                faces.iter().flatten().all(|v| own.contains(v))
            })
    }

    /// The faces that each placed primitive keeps.
    pub(super) fn kept_faces<'a>(
        &'a self,
        model: &'a Contents<'_>,
    ) -> impl Iterator<Item = (&'a PlacedPrimitive, &'a [[u32; 3]])> {
        let mut next = 0;
        self.parts.iter().map(move |part| {
            let left = match &model.attributes.kept_of_file {
                Some(kept) => {
                    let marks = &kept[part.faces.0..part.faces.0 + part.faces.1];
                    marks.iter().filter(|k| **k).count()
                }
                None => part.faces.1,
            };
            let first = next;
            next += left;
            (part, &model.mesh.faces[first..next])
        })
    }

    /// For each placed primitive, its faces and the index of the image that colours them.
    pub(crate) fn images_of_faces(
        &self,
    ) -> impl Iterator<Item = (Range<usize>, Option<usize>)> + '_ {
        let image = |material: usize| {
            let material = self.json.get("materials")?.get(material)?;
            let texture = material.pointer("/pbrMetallicRoughness/baseColorTexture/index")?;
            let texture = self.json.get("textures")?.get(number(texture)?)?;
            number(texture.get("source")?)
        };
        let parts = self.parts.iter();
        parts.map(move |p| (p.faces.0..p.faces.0 + p.faces.1, p.material.and_then(image)))
    }

    /// The image of an index.
    pub(crate) fn image(&self, index: usize) -> Option<Image> {
        let image = self.json.get("images")?.get(index)?;
        if let Some(uri) = image.get("uri").and_then(Value::as_str) {
            return match uri.strip_prefix("data:") {
                Some(data) => super::buffers::decode_data_uri(data).map(Image::Bytes),
                None => Some(Image::File(super::buffers::percent_decoded(uri))),
            };
        }
        let view = number(image.get("bufferView")?)?;
        let view = self.json.get("bufferViews")?.get(view)?;
        let buffer = self.buffers.get(number(view.get("buffer")?)?)?.as_ref()?;
        let start = view.get("byteOffset").map_or(Some(0), number)?;
        let end = start.checked_add(number(view.get("byteLength")?)?)?;
        Some(Image::Bytes(buffer.get(start..end)?.to_vec()))
    }

    /// The names of external files that the document refers to: images, and buffers that could not be loaded.
    pub(crate) fn side_files(&self) -> Vec<String> {
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
