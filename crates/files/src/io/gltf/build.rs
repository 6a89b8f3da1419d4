//! Builds a glTF document in JSON with a binary buffer, and packs it as glTF or GLB.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value, json};

use super::super::{Format, IoError, extent};

/// Component types of accessors.
pub(super) const F32: u32 = 5126;
pub(super) const U32: u32 = 5125;
const U8: u32 = 5121;

/// Targets of buffer views.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// A document under construction: JSON, and the bytes of its first buffer.
pub(super) struct Builder {
    pub(super) json: Value,
    pub(super) data: Vec<u8>,
}

impl Builder {
    /// An empty document.
    pub(super) fn new() -> Self {
        Self {
            json: json!({ "asset": { "version": "2.0", "generator": "isomend" } }),
            data: Vec::new(),
        }
    }

    /// A list of the document; created if missing.
    pub(super) fn list(&mut self, key: &str) -> &mut Vec<Value> {
        if !self.json.is_object() {
            self.json = Value::Object(Map::new());
        }
        let entry = &mut self.json[key];
        if !entry.is_array() {
            *entry = Value::Array(Vec::new());
        }
        match entry {
            Value::Array(list) => list,
            _ => unreachable!("it was made an array above"),
        }
    }

    /// Appends an item to a list; returns its index.
    pub(super) fn push(&mut self, key: &str, item: Value) -> usize {
        let list = self.list(key);
        list.push(item);
        list.len() - 1
    }

    /// Appends a buffer view, aligned to four bytes.
    fn view(&mut self, bytes: impl Iterator<Item = u8>, target: u32) -> usize {
        let view = self.plain_view(bytes);
        self.list("bufferViews")[view]["target"] = json!(target);
        view
    }

    /// Appends a buffer view of what is neither vertices nor indices.
    fn plain_view(&mut self, bytes: impl Iterator<Item = u8>) -> usize {
        self.align();
        let start = self.data.len();
        self.data.extend(bytes);
        let length = self.data.len() - start;
        self.push(
            "bufferViews",
            json!({ "buffer": 0, "byteOffset": start, "byteLength": length }),
        )
    }

    /// Appends a texture with an image of its own, which is a path relative to the file's folder, or a PNG image as a data URI, whose
    /// bytes go into the buffer.
    pub(super) fn texture(&mut self, image: &str) -> usize {
        let bytes = image
            .strip_prefix("data:")
            .and_then(super::buffers::decode_data_uri);
        let image = match bytes {
            Some(bytes) => {
                let view = self.plain_view(bytes.into_iter());
                json!({ "bufferView": view, "mimeType": "image/png" })
            }
            None => json!({ "uri": super::buffers::percent_encoded(image) }),
        };
        let image = self.push("images", image);
        self.push("textures", json!({ "source": image }))
    }

    fn align(&mut self) {
        let aligned = self.data.len().next_multiple_of(4);
        self.data.resize(aligned, 0);
    }

    /// Appends an accessor of vertex indices.
    pub(super) fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes = indices.iter().flat_map(|i| i.to_le_bytes());
        let view = self.view(bytes, INDICES);
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": U32, "count": indices.len(), "type": "SCALAR" }),
        )
    }

    /// Appends an accessor of floats with `components` components.
    pub(super) fn floats(&mut self, values: &[f32], components: usize) -> usize {
        let view = self.view(values.iter().flat_map(|v| v.to_le_bytes()), VERTICES);
        let count = values.len() / components.max(1);
        let kind = kind(components);
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": F32, "count": count, "type": kind }),
        )
    }

    /// Appends an accessor of colours with four bytes each.
    pub(super) fn bytes(&mut self, colours: &[[u8; 4]]) -> usize {
        let view = self.view(colours.iter().flatten().copied(), VERTICES);
        self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": U8, "count": colours.len(), "type": "VEC4", "normalized": true
            }),
        )
    }

    /// Appends an accessor of positions, with their minimum and maximum.
    pub(super) fn positions(&mut self, points: &[[f32; 3]]) -> usize {
        let accessor = self.floats(points.as_flattened(), 3);
        let [low, high] = extent(points);
        let accessors = self.list("accessors");
        accessors[accessor]["min"] = json!(low);
        accessors[accessor]["max"] = json!(high);
        accessor
    }

    /// The bytes of the file. `data` becomes the first buffer.
    pub(super) fn finish(mut self, format: Format) -> Result<Vec<u8>, IoError> {
        self.align();
        let mut buffer = json!({ "byteLength": self.data.len() });
        if format == Format::Gltf {
            let head = "data:application/octet-stream;base64,";
            buffer["uri"] = json!(format!("{head}{}", STANDARD.encode(&self.data)));
        }
        let buffers = self.list("buffers");
        match buffers.first_mut() {
            Some(first) => *first = buffer,
            None => buffers.push(buffer),
        }
        let refuse = |what: String| IoError::NotWritable {
            format,
            what,
            advice: "write PLY instead",
        };
        let json = serde_json::to_vec(&self.json).map_err(|error| refuse(error.to_string()))?;
        if format == Format::Gltf {
            return Ok(json);
        }
        pack(json, &self.data).ok_or_else(|| {
            refuse("the mesh is larger than the 4 GB a GLB file can hold".to_string())
        })
    }
}

fn kind(components: usize) -> &'static str {
    ["SCALAR", "VEC2", "VEC3", "VEC4"][components.clamp(1, 4) - 1]
}

/// Packs a JSON chunk and a binary chunk as GLB; `None` above 4 GB.
fn pack(mut json: Vec<u8>, data: &[u8]) -> Option<Vec<u8>> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = u32::try_from(12 + 8 + json.len() + 8 + data.len()).ok()?;
    let mut bytes = Vec::with_capacity(length as usize);
    bytes.extend(b"glTF");
    bytes.extend(2u32.to_le_bytes());
    bytes.extend(length.to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(&json);
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(data);
    Some(bytes)
}
