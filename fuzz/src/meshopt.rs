//! Compressed buffer views of glTF: the bytes become a stream of `EXT_meshopt_compression` in a file that is otherwise right.

use isomend::io::Format;
use serde_json::json;

use crate::files::mesh;

/// Number of vertices, where the stream has the indices.
const VERTICES: usize = 64;

/// Reads a GLB file with one compressed view. The first byte chooses its mode and filter, the second its stride, the third its number
/// of elements; the stream follows.
pub fn meshopt(data: &[u8]) {
    let Some((&[form, stride, count], stream)) = data.split_first_chunk::<3>() else {
        return;
    };
    let mode = ["ATTRIBUTES", "TRIANGLES", "INDICES"][usize::from(form % 3)];
    let filter = ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"][usize::from(form / 3 % 4)];
    let is_points = form % 3 == 0;
    let (stride, count) = match is_points {
        // Four shorts or three floats have room for positions.
        true => (
            [8, 12, 16, 252][usize::from(stride % 4)],
            usize::from(count),
        ),
        false => ([2, 4][usize::from(stride % 2)], 3 * usize::from(count)),
    };
    let plain: Vec<u8> = (0..3 * VERTICES as u32)
        .flat_map(|at| ((at * at % 97) as f32).to_le_bytes())
        .collect();
    let view = json!({ "buffer": 1, "byteLength": stride * count, "extensions": { "EXT_meshopt_compression": {
        "buffer": 0, "byteOffset": plain.len(), "byteLength": stream.len(), "byteStride": stride, "count": count,
        "mode": mode, "filter": filter } } });
    let points = match (is_points, stride) {
        (true, 8) => {
            json!({ "bufferView": 1, "componentType": 5122, "normalized": true, "count": count, "type": "VEC3" })
        }
        (true, _) => {
            json!({ "bufferView": 1, "componentType": 5126, "count": count, "type": "VEC3" })
        }
        (false, _) => {
            json!({ "bufferView": 0, "componentType": 5126, "count": VERTICES, "type": "VEC3" })
        }
    };
    let kind = if stride == 2 { 5123 } else { 5125 };
    let mut primitive = json!({ "attributes": { "POSITION": 0 } });
    let mut accessors = vec![points];
    if !is_points {
        primitive["indices"] = json!(1);
        accessors.push(
            json!({ "bufferView": 1, "componentType": kind, "count": count, "type": "SCALAR" }),
        );
    }
    let file = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "extensionsRequired": ["EXT_meshopt_compression"], "meshes": [{ "primitives": [primitive] }],
        "buffers": [{ "byteLength": plain.len() + stream.len() }, { "byteLength": stride * count }],
        "bufferViews": [{ "buffer": 0, "byteLength": plain.len() }, view], "accessors": accessors,
    });
    mesh(
        &glb(&file.to_string(), &[&plain, stream].concat()),
        Format::Glb,
    );
}

/// A GLB file of a JSON text and a binary chunk.
pub(crate) fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], data: &[u8], filler: u8| {
        let size = data.len().next_multiple_of(4);
        let mut chunk = [&(size as u32).to_le_bytes(), kind, data].concat();
        chunk.resize(8 + size, filler);
        chunk
    };
    let chunks = [
        chunk(b"JSON", json.as_bytes(), b' '),
        chunk(b"BIN\0", binary, 0),
    ]
    .concat();
    let size = (12 + chunks.len() as u32).to_le_bytes();
    [&b"glTF"[..], &2u32.to_le_bytes(), &size, &chunks].concat()
}
