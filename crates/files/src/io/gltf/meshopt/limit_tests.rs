//! Tests of the memory limit of compressed files, and of buffers that hold compressed bytes beside others.

use std::collections::BTreeMap;
use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf_json::Root;
use serde_json::json;

use super::super::super::samples::*;
use super::super::super::{Format, read_bytes};
use super::super::buffers::decode_data_uri;
use super::tests::{encoded, file};
use super::*;

/// A file whose compressed bytes are in a side file of `size` bytes, with room for `decoded` decoded bytes; the size is claimed.
fn with_side_file(size: usize, decoded: usize) -> (Vec<u8>, Vec<u8>) {
    let mut side = Vec::new();
    let bytes = file(|_| {});
    let mut json: Value = serde_json::from_slice(&bytes).unwrap();
    let buffer = &mut json["buffers"][0];
    let uri = buffer["uri"].as_str().unwrap().strip_prefix("data:");
    side.extend(uri.and_then(decode_data_uri).unwrap());
    side.resize(size, 0);
    *buffer = json!({ "byteLength": size, "uri": "side.bin" });
    json["buffers"][1]["byteLength"] = json!(decoded);
    (serde_json::to_vec(&json).unwrap(), side)
}

#[test]
fn a_side_file_raises_the_limit_before_its_views_are_decoded() {
    // The limit is 80 MiB and 32 times the size of the files.
    for (size, is_enough) in [(1 << 20, true), (1 << 14, false)] {
        let (json, side) = with_side_file(size, 90 << 20);
        let resolve = |name: &str, _: u64| {
            assert_eq!(name, "side.bin");
            Ok(side.clone())
        };
        let read = read_bytes(&json, Format::Gltf, &resolve);
        match is_enough {
            true => assert_eq!(read.unwrap().mesh.faces.len(), 722),
            false => assert!(read.err().unwrap().to_string().contains("memory")),
        }
    }
}

#[test]
fn views_of_the_same_bytes_are_each_charged() {
    let (count, stride) = (4096, 256);
    let packed = encoded(&vec![0; count * stride], stride);
    let many = |times: usize| {
        file(|json| {
            let uri = format!("data:;base64,{}", STANDARD.encode(&packed));
            let buffer = json!({ "byteLength": packed.len(), "uri": uri });
            let spare = json!({ "byteLength": count * stride });
            let view = json!({ "buffer": 3, "byteLength": count * stride, "extensions": { MESHOPT: {
                "buffer": 2, "byteLength": packed.len(), "byteStride": stride, "mode": "ATTRIBUTES", "count": count } } });
            json["buffers"]
                .as_array_mut()
                .unwrap()
                .extend([buffer, spare]);
            let views = json["bufferViews"].as_array_mut().unwrap();
            views.extend(vec![view; times]);
        })
    };
    assert_eq!(
        read_alone(&many(3), Format::Gltf).unwrap().mesh.faces.len(),
        722
    );
    assert!(refusal(&many(200), Format::Gltf).contains("memory"));
}

#[test]
fn a_decoded_buffer_adds_twelve_times_its_size_to_the_limit() {
    let root = Root::from_slice(br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":1000}]}"#);
    let root = root.unwrap();
    let resolve = |_: &str, _: u64| unreachable!();
    let known = BTreeMap::from([(0, Arc::new(vec![0; 1000]))]);
    let mut buffers = Buffers::new(&root, Format::Gltf, None, 0, &resolve).with(&known);
    buffers.spend((80 << 20) + 12_000).unwrap();
    assert!(buffers.spend(1).is_err());
}

#[test]
fn data_beside_the_compressed_bytes_of_its_own_buffer_are_kept() {
    // The plain data of both views, then their compressed bytes, in one buffer.
    let bytes = file(|json| {
        let whole = read_alone(&file(|_| {}), Format::Gltf).unwrap();
        let document = whole.document.as_ref().and_then(|d| d.gltf()).unwrap();
        let mut data = document.buffers[1].as_ref().unwrap().to_vec();
        let start = data.len();
        let uri = json["buffers"][0]["uri"].as_str().unwrap();
        data.extend(uri.strip_prefix("data:").and_then(decode_data_uri).unwrap());
        let uri = format!("data:;base64,{}", STANDARD.encode(&data));
        json["buffers"] = json!([{ "byteLength": data.len(), "uri": uri }]);
        for view in json["bufferViews"].as_array_mut().unwrap() {
            view["buffer"] = json!(0);
            let packed = &mut view["extensions"][MESHOPT];
            let offset = packed["byteOffset"].as_u64().unwrap_or(0) as usize;
            packed["byteOffset"] = json!(offset + start);
        }
    });
    let loaded = read_alone(&bytes, Format::Gltf).unwrap();
    let decoded = read_alone(&file(|_| {}), Format::Gltf).unwrap();
    assert_eq!(loaded.mesh, decoded.mesh);
}
