//! Tests of `KHR_draco_mesh_compression` on streams that the encoder of the Draco project (draco3d 1.5.7) wrote, and on damaged ones.

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use glam::DVec3;
use serde_json::json;

use super::super::super::samples::*;
use super::super::super::{Contents, Loaded, WriteOptions, model_to_bytes};
use super::*;
use isomend_core::mesh::attributes::Role;

/// The mesh of [`expected`] with 10 bits for each coordinate, by sequential connectivity (speed 10).
const SEQUENTIAL: &str = "RFJBQ08CAgEAAAAeGQEAAQIAAgMDAgQDBAUFBAYFBgcHBggHCAkBCgsBCwICCwwCDAQGDQ4GDggKDxAKEAsLEBELEQwMERIMEg0NEhMNEw4PFBUPFRAQFRYQFhERFhcRFxISFxgSGBMBAQAJAwAAAgABAQED/wfBEgORAv//D2kDtQH//xvc3Nz//xe1AbUB/4tpA2kDWQ933Nz//yPc//8X3APc3P//D9zctQH/B9wiyIA0gvjbuc1s85Lvc9XlSCsAyPRRRvG7RxDHpckN+1EhcQAAAAD/AwAAAAAAAAAAAAAAAAAAAABwQQo=";
/// The same by Edgebreaker with its standard traversal (speed 5) and by valences (speed 0).
const STANDARD: &str = "RFJBQ08CAgEBAAAAGR4AHgUBHRABCu/TPV2frmlVnyr/AREB/wAAAQAJAwAAAgEBAQEE/wf1IkUEaQP//xO1Ady1Af//D9wDaQMD3P//C5ECB9z/j9y1Af//l9z//yPc//8b3APc3P8DtQEcEhpMK4bbHn7JWsLV7lQC16XFP+HL0I8iNcxvswAAAAD/AwAAAAAAAAAAAAAAAAAAAABwQQo=";
const VALENCE: &str = "RFJBQ08CAgEBAAAAGR4AHgUBHRABCu/TPV2frmlVnyr/AREB/wABAQAJAwAAAgEBAQEH/wf1IkEEaQP//xO1Ady1Af//D9wDkQID3P//C5ECA9zc/4/ctQH//5fc//8j3P//G9wD3Nz/A7UBHSTWVCYNzQdWK7TwfKRU80HzJDd8NvYBY+T04R+BAAAAAP8DAAAAAAAAAAAAAAAAAAAAAHBBCg==";
/// The same with normals of faces (8 bits) and texture coordinates with a seam (10 bits): as vertices of their own (speed 7), and as seams
/// of the attributes (speed 0).
const COPIES: &str = "RFJBQ08CAgEBAAAAVh4AHgAADP/////3///////3A/8C6UEB/wAAAwAJAwAAAQkDAAEDCQIAAgIDAgEBAQED/gcVEn0B//8TPQIBAT0BgP//FwEBAQH//xc9Ab0B/4f5An0CqQotCHeAgIDA//8XAQGA//8XwICAgP//D4DAPQF9Af9Ae/LCWnxrB47lLZi3emZm9qA5pgXNhMxziUBuXdFFfLTGWEHstj8VoGXovfujiRks1IolrVcfs64sTS3/gOeGQQ7MPrFbVDICyvp3ncjGeLNFYIi9L0WBZP3e90e1eqEEWSJfrhQ3jn3nPTmiE7cLA/wufVpEnv/rpMi0gAAAAAD/AwAAAAMBAAkDKSsDwAc9Aj0CoQ8QBtwcTu55NSClHf9ItJ6LpVIojAGEMCcAjgEN6NAdAZs09JtDuwPYALBcwP0ACOgDuQG8y0H+BgzqQ7wE9JuD8By4i8CFPJx/wIw9ANAD+wrgzw3/AAAAfwAAAAEBAQECgAg1GGD////rfQEdAf0SZQ3////3YP////MdAQNg////9x0BfQEyttpJaaInhiz6dNdcSNXVYXayxPMLksT4Mc76C47bWY3Rv8oaaWL4Vsjn0bOew/gk9ocAAAAA/wMAAAAAAAAAAAAAAAAAAAAAcEEKCAAAAAAAAAAAAAAAQAo=";
const SEAMS: &str = "RFJBQ08CAgEBAAAAGR4CHgUBHRABCu/TPV2frmlVnyr/AREPBLV9coDqBBhe2oYD/wABAAEAAQEAAQAJAwAAAgEBCQMAAQMBAwkCAAICBAEBAQf/B/UikQLc/wPc/wfctQG1AbUB//8P3NyRArUB3P//C9wH3P+HtQHctQFpA////////+vc/wO1AR1BJkN5rKi0ACN0G9sYejiy8BaKpYbBpTSuLcrPvBDABADe8IEM1QNkII4AAAAAAAD/AwAAAAAAAAAAAAAAAAAAAABwQQoGAwEBBf8BZSAdAUEP////60EPJLQPPAxfG0bsZhKEKdkQ004fARPv9CRp63pPPD7yl1rPbcj4X/8AAAB/AAAA/wKbRggFAQEACwslAkUEA4kI3R3NDEUEJQILg0frsSqOdpfIH4EBAggQYHsyDOPKgK8vDmhHp+N8E0fGWt98j9MfwP9/k+cyQL3TH3f9BTAAKwAOqDtYzIdoAxoAAAAKA/wuhAAAAAD/AwAAAAAAAAAAAAAAAABACg==";

/// Allowed errors of positions (half a step of 15 / 1023), texture coordinates (of 2 / 1023) and normals (of 8 bits).
const NEAR: [f64; 3] = [0.0075, 0.001, 0.02];

/// A corner: position and texture coordinates.
type Corner = (DVec3, [f64; 2]);

/// The triangles of the mesh that was encoded: squares of 5 x 5 vertices without one, and a seam along the middle.
fn expected() -> Vec<[Corner; 3]> {
    const HEIGHTS: [[u8; 5]; 5] = [
        [0, 1, 2, 1, 0],
        [3, 7, 9, 4, 1],
        [2, 8, 15, 8, 2],
        [1, 4, 9, 7, 3],
        [0, 1, 2, 1, 0],
    ];
    let mut faces = Vec::new();
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
        let corner = |[i, j]: [usize; 2], shift: f64| {
            let (x, y) = (i as f64 / 4.0, j as f64 / 4.0);
            let position = DVec3::new(15.0 * x, 15.0 * y, f64::from(HEIGHTS[i][j]));
            (position, [x + shift, y])
        };
        let shift = if j >= 2 { 1.0 } else { 0.0 };
        for other in [[i + 1, j], [i, j + 1]] {
            let all = [[i, j], other, [i + 1, j + 1]].map(|at| corner(at, shift));
            let [a, b, c] = all;
            faces.push(if other[0] > i { [a, b, c] } else { [a, c, b] });
        }
    }
    // The square that is missing is number 6 of 16.
    faces.drain(12..14);
    faces
}

/// A file whose first primitive is a stream; its buffer begins with other bytes and ends with an image.
fn file(stream: &str, change: impl Fn(&mut Value)) -> Vec<u8> {
    let stream = BASE64.decode(stream).unwrap();
    let mut data = b"123456".to_vec();
    data.extend(&stream);
    data.extend(b"image");
    let uri = format!("data:;base64,{}", BASE64.encode(&data));
    let mut json = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "extensionsUsed": [DRACO], "extensionsRequired": [DRACO],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 1 }, "indices": 0, "mode": 5,
            "extensions": { DRACO: { "bufferView": 0, "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 } } } }] }],
        "accessors": [
            { "componentType": 5121, "count": 9, "type": "SCALAR" },
            { "componentType": 5126, "count": 9, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1] },
            { "componentType": 5126, "count": 9, "type": "VEC3" },
            { "componentType": 5126, "count": 9, "type": "VEC2" }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 6, "byteLength": stream.len() },
            { "buffer": 0, "byteOffset": 6 + stream.len(), "byteLength": 5 }],
        "images": [{ "bufferView": 1, "mimeType": "image/png" }],
        "buffers": [{ "byteLength": data.len(), "uri": uri }],
    });
    change(&mut json);
    serde_json::to_vec(&json).unwrap()
}

/// The same with normals and texture coordinates.
fn with_attributes(json: &mut Value) {
    json["meshes"][0]["primitives"][0]["attributes"] =
        json!({ "POSITION": 1, "NORMAL": 2, "TEXCOORD_0": 3 });
}

fn read(bytes: &[u8]) -> Loaded {
    read_alone(bytes, Format::Gltf).unwrap()
}

fn written(loaded: &Loaded, format: Format) -> Vec<u8> {
    let model = Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document: loaded.document.as_ref(),
    };
    let written = model_to_bytes(&model, format, &WriteOptions::default());
    written.unwrap().bytes
}

/// Finds each expected triangle among the faces, in any order; compares texture coordinates and normals where there are any.
fn assert_expected(loaded: &Loaded, name: &str) {
    let mesh = &loaded.mesh;
    let expected = expected();
    assert_eq!(mesh.faces.len(), expected.len(), "{name}");
    let uvs = loaded.attributes.vertex_role(Role::Uv(0));
    let normals = loaded.attributes.vertex_role(Role::Normal);
    for corners in expected {
        let normal = (corners[1].0 - corners[0].0).cross(corners[2].0 - corners[0].0);
        let fits = |vertex: u32, (point, uv): Corner| {
            let near = |value: Option<&[f64]>, wanted: &[f64], error: f64| {
                value.is_none_or(|v| v.iter().zip(wanted).all(|(a, b)| (a - b).abs() < error))
            };
            let at = vertex as usize;
            near(
                Some(&mesh.positions[at].to_array()),
                &point.to_array(),
                NEAR[0],
            ) && near(uvs.and_then(|a| a.get(at)), &uv, NEAR[1])
                && near(
                    normals.and_then(|a| a.get(at)),
                    &normal.normalize().to_array(),
                    NEAR[2],
                )
        };
        let is_it = |face: &[u32; 3]| {
            (0..3).any(|turn| (0..3).all(|k| fits(face[(k + turn) % 3], corners[k])))
        };
        assert!(
            mesh.faces.iter().any(is_it),
            "{name}: {corners:?} is missing"
        );
    }
}

#[test]
fn streams_of_every_connectivity_are_decoded() {
    for (name, stream) in [
        ("sequential", SEQUENTIAL),
        ("standard", STANDARD),
        ("valence", VALENCE),
    ] {
        let loaded = read(&file(stream, |_| {}));
        assert_expected(&loaded, name);
        assert_eq!(loaded.mesh.positions.len(), 25, "{name}");
        let note =
            "the file is compressed by KHR_draco_mesh_compression; glTF is written uncompressed";
        assert_eq!(loaded.notes, [note]);
    }
}

#[test]
fn attributes_with_seams_are_decoded() {
    for (name, stream) in [("copies", COPIES), ("seams", SEAMS)] {
        let loaded = read(&file(stream, with_attributes));
        assert_expected(&loaded, name);
        let names: Vec<&str> = loaded
            .attributes
            .vertex
            .iter()
            .map(|a| &a.name[..])
            .collect();
        assert_eq!(names, ["NORMAL", "TEXCOORD_0"], "{name}");
        assert!(
            loaded
                .attributes
                .vertex
                .iter()
                .all(|a| a.missing.is_empty())
        );
    }
}

#[test]
fn the_file_is_written_without_the_extension_and_the_compressed_bytes() {
    let loaded = read(&file(SEAMS, with_attributes));
    let bytes = written(&loaded, Format::Glb);
    let again = read_alone(&bytes, Format::Glb).unwrap();
    assert_eq!(
        (&again.mesh, &again.attributes),
        (&loaded.mesh, &loaded.attributes)
    );
    assert_eq!(again.notes, Vec::<String>::new());
    assert!(!String::from_utf8_lossy(&bytes).contains("draco"));
    let document = again.document.as_ref().and_then(|d| d.gltf()).unwrap();
    assert_eq!(
        again.document.as_ref().unwrap().image(0),
        Some(super::super::Image::Bytes(b"image".to_vec()))
    );
    let data = document.buffers[0].as_ref().unwrap();
    assert!(!data.windows(5).any(|bytes| bytes == b"DRACO"));
    // The bounds belong to the decoded positions.
    let accessor = &document.json["accessors"][1];
    for (at, bound) in [("min", 0.0), ("max", 15.0)] {
        assert_eq!(accessor[at], json!([bound, bound, bound]));
    }
}

#[test]
fn values_for_other_programs_are_read_unless_the_extension_is_required() {
    let points: Vec<u8> = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let plain = |json: &mut Value| {
        let uri = format!(
            "data:;base64,{}",
            BASE64.encode([&points[..], &[0, 1, 2]].concat())
        );
        json["buffers"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "byteLength": 39, "uri": uri }));
        let views = json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 1, "byteLength": 36 }));
        views.push(json!({ "buffer": 1, "byteOffset": 36, "byteLength": 3 }));
        json["accessors"][0] =
            json!({ "bufferView": 3, "componentType": 5121, "count": 3, "type": "SCALAR" });
        json["accessors"][1] =
            json!({ "bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3" });
    };
    let required = read(&file(STANDARD, plain));
    assert_expected(&required, "required");
    let optional = file(STANDARD, |json| {
        plain(json);
        _ = json.as_object_mut().unwrap().remove("extensionsRequired");
    });
    assert_eq!(read(&optional).mesh.faces, [[0, 1, 2]]);
}

#[test]
fn primitives_that_share_a_stream_or_an_accessor_are_decoded_each() {
    let loaded = read(&file(STANDARD, |json| {
        let first = json["meshes"][0]["primitives"][0].clone();
        // The same accessors for the same stream, then for another one.
        let mut other = first.clone();
        other["extensions"][DRACO]["bufferView"] = json!(2);
        json["meshes"][0]["primitives"] = json!([first, first, other]);
        let data = BASE64.decode(SEQUENTIAL).unwrap();
        let uri = format!("data:;base64,{}", BASE64.encode(&data));
        let buffer = json!({ "byteLength": data.len(), "uri": uri });
        json["buffers"].as_array_mut().unwrap().push(buffer);
        let view = json!({ "buffer": 1, "byteLength": data.len() });
        json["bufferViews"].as_array_mut().unwrap().push(view);
    }));
    // The first two share their vertices.
    assert_eq!(loaded.mesh.positions.len(), 50);
    assert_eq!(loaded.mesh.faces.len(), 90);
    for start in [0, 30, 60] {
        let mut part = loaded.clone();
        part.mesh.faces = loaded.mesh.faces[start..start + 30].to_vec();
        assert_expected(&part, "shared");
    }
    // The buffer that held a stream only is left out.
    let document = loaded.document.as_ref().and_then(|d| d.gltf()).unwrap();
    assert_eq!(document.buffers[1].as_ref().unwrap().len(), 0);
}

#[test]
fn values_are_converted_to_the_component_type_of_the_accessor() {
    let loaded = read(&file(STANDARD, |json| {
        json["accessors"][1]["componentType"] = json!(5122)
    }));
    assert!(loaded.mesh.positions.iter().all(|p| p.round() == *p));
    let heights: f64 = loaded.mesh.positions.iter().map(|p| p.z).sum();
    assert!((heights - 91.0).abs() < 1e-9, "{heights}");
}

#[test]
fn faults_are_named() {
    let message = |change: &dyn Fn(&mut Value)| refusal(&file(STANDARD, change), Format::Gltf);
    let extension = |json: &mut Value, change: &dyn Fn(&mut Value)| {
        change(&mut json["meshes"][0]["primitives"][0]["extensions"][DRACO]);
    };
    let missing = message(&|json| extension(json, &|e| e["attributes"]["POSITION"] = json!(7)));
    assert!(
        missing.contains("mesh 0") && missing.contains("has no attribute 7"),
        "{missing}"
    );
    let damaged = message(&|json| extension(json, &|e| e["bufferView"] = json!("x")));
    assert!(
        damaged.contains("mesh 0") && damaged.contains("damaged"),
        "{damaged}"
    );
    let beyond = message(&|json| extension(json, &|e| e["bufferView"] = json!(9)));
    assert!(beyond.contains("buffer view 9"), "{beyond}");
    let other = message(&|json| extension(json, &|e| e["bufferView"] = json!(1)));
    assert!(other.contains("cannot be decoded"), "{other}");
    let components = message(&|json| json["accessors"][1]["type"] = json!("VEC2"));
    assert!(
        components.contains("has 3 components of attribute 0, but its accessor has 2"),
        "{components}"
    );
    let accessor = message(&|json| json["meshes"][0]["primitives"][0]["indices"] = json!(4));
    assert!(accessor.contains("does not exist"), "{accessor}");
}

#[test]
fn damaged_streams_are_survived() {
    for stream in [SEQUENTIAL, STANDARD, VALENCE, SEAMS] {
        let bytes = BASE64.decode(stream).unwrap();
        let tried = |bytes: &[u8]| {
            let _ = read_alone(&file(&BASE64.encode(bytes), with_attributes), Format::Gltf);
        };
        (0..bytes.len()).for_each(|length| tried(&bytes[..length]));
        for at in 0..bytes.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff] {
                let mut damaged = bytes.clone();
                damaged[at] = value;
                tried(&damaged);
            }
        }
    }
}

#[test]
fn meshes_beyond_the_limit_of_memory_are_refused() {
    for stream in [SEQUENTIAL, STANDARD, VALENCE, SEAMS] {
        let bytes = BASE64.decode(stream).unwrap();
        let stream = Stream::decoded(&bytes, 4096).unwrap();
        assert_eq!(stream.corners(), 90);
        let message = Stream::decoded(&bytes, 29 * 24).err().unwrap();
        assert!(message.contains("more memory than the limit"), "{message}");
    }
    // The number of faces is in byte 11, in groups of seven bits.
    let mut claim = BASE64.decode(SEQUENTIAL).unwrap();
    claim.splice(11..12, [0xff, 0xff, 0xff, 0xff, 0x07]);
    let message = refusal(&file(&BASE64.encode(&claim), |_| {}), Format::Gltf);
    assert!(message.contains("mesh 0"), "{message}");
}
