//! Compressed primitives of glTF: the bytes become a stream of `KHR_draco_mesh_compression` in a file that is otherwise right.

use isomend::io::Format;
use serde_json::json;

use crate::files::mesh;
use crate::meshopt::glb;

/// Reads a GLB file with one compressed primitive. The first byte chooses which attributes it has; the stream follows.
pub fn draco(data: &[u8]) {
    let Some((&form, stream)) = data.split_first() else {
        return;
    };
    let (mut named, mut identifiers) = (json!({ "POSITION": 1 }), json!({ "POSITION": 0 }));
    for (bit, name) in ["NORMAL", "TEXCOORD_0", "COLOR_0"].into_iter().enumerate() {
        if form >> bit & 1 == 1 {
            named[name] = json!(bit + 2);
            identifiers[name] = json!(bit + 1);
        }
    }
    let float = |kind: &str| json!({ "componentType": 5126, "count": 0, "type": kind });
    let colour = json!({ "componentType": 5121, "normalized": true, "count": 0, "type": "VEC3" });
    let corners = json!({ "componentType": 5125, "count": 0, "type": "SCALAR" });
    let extension = json!({ "bufferView": 0, "attributes": identifiers });
    let primitive = json!({ "attributes": named, "indices": 0, "extensions": { "KHR_draco_mesh_compression": extension } });
    let file = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "extensionsRequired": ["KHR_draco_mesh_compression"], "meshes": [{ "primitives": [primitive] }],
        "buffers": [{ "byteLength": stream.len() }], "bufferViews": [{ "buffer": 0, "byteLength": stream.len() }],
        "accessors": [corners, float("VEC3"), float("VEC3"), float("VEC2"), colour],
    });
    mesh(&glb(&file.to_string(), stream), Format::Glb);
}
