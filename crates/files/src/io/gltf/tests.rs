//! Tests of glTF reading and writing: accessors, transforms, side files, damaged and oversized scenes.

use super::super::samples::*;
use super::super::{
    Contents, Loaded, Precision, WriteOptions, model_to_bytes, read_bytes, to_bytes,
};
use super::*;
use base64::Engine;
use isomend_core::mesh::attributes::Role;

/// Four vertices, 0 1 2 3, as floats with a fourth number as padding, and indices.
fn buffer() -> Vec<u8> {
    let points: [[f32; 4]; 4] = [
        [0., 0., 0., 9.],
        [1., 0., 0., 9.],
        [0., 1., 0., 9.],
        [1., 1., 0., 9.],
    ];
    let mut data: Vec<u8> = points
        .iter()
        .flatten()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    data.extend([0u16, 1, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    data.extend([2u8, 0, 0, 0]);
    data.extend([0f32, 5., 0.].iter().flat_map(|v| v.to_le_bytes()));
    data
}

/// A file with the buffer of [`buffer`] and the given nodes and primitive.
pub(super) fn gltf(nodes: &str, primitive: &str) -> String {
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(buffer());
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{nodes}],
        "meshes":[{{"primitives":[{primitive}]}}],
        "buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{data}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":64,"byteStride":16}},{{"buffer":0,"byteOffset":64,"byteLength":8}},
        {{"buffer":0,"byteOffset":72,"byteLength":4}},{{"buffer":0,"byteOffset":76,"byteLength":12}}],
        "accessors":[{{"bufferView":0,"count":4,"componentType":5126,"type":"VEC3"}},
        {{"bufferView":1,"count":4,"componentType":5123,"type":"SCALAR"}},
        {{"bufferView":1,"byteOffset":2,"count":3,"componentType":5123,"type":"SCALAR"}},
        {{"bufferView":0,"count":4,"componentType":5126,"type":"VEC3","sparse":{{"count":1,
        "indices":{{"bufferView":2,"componentType":5121}},"values":{{"bufferView":3}}}}}},
        {{"count":4,"componentType":5126,"type":"VEC3","sparse":{{"count":1,
        "indices":{{"bufferView":2,"componentType":5121}},"values":{{"bufferView":3}}}}}},
        {{"bufferView":1,"count":2,"componentType":5122,"normalized":true,"type":"VEC3"}}]}}"#,
        buffer().len()
    )
}

const NODE: &str = r#"{"mesh":0}"#;
pub(super) const STRIP: &str = r#"{"attributes":{"POSITION":0},"indices":1,"mode":5}"#;

fn faces(nodes: &str, primitive: &str) -> Vec<[u32; 3]> {
    read_alone(gltf(nodes, primitive).as_bytes(), Format::Gltf)
        .unwrap()
        .mesh
        .faces
}

fn message(nodes: &str, primitive: &str) -> String {
    refusal(gltf(nodes, primitive).as_bytes(), Format::Gltf)
}

#[test]
fn round_trip_is_exact() {
    for format in [Format::Glb, Format::Gltf] {
        assert_round_trip(&open_tetrahedron(), format, WriteOptions::default());
        let fine = WriteOptions {
            precision: Precision::F64,
            ascii: false,
        };
        assert_eq!(
            to_bytes(&fine_tetrahedron(), format, &fine)
                .unwrap()
                .notes
                .len(),
            1
        );
    }
}

#[test]
fn written_files_are_valid() {
    for format in [Format::Glb, Format::Gltf] {
        let bytes = to_bytes(&open_tetrahedron(), format, &WriteOptions::default())
            .unwrap()
            .bytes;
        assert!(::gltf::Gltf::from_slice(&bytes).is_ok());
    }
}

#[test]
fn faces_without_texture_coordinates_leave_the_others_theirs() {
    let text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.5 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 2 4 3\n";
    let model = read_alone(text.as_bytes(), Format::Obj).unwrap();
    // The coordinates of each face, as values of its corners or of its vertices.
    let coordinates = |model: &Loaded| -> Vec<[Option<Vec<f64>>; 3]> {
        let all = &model.attributes;
        let corner = all.corner.iter().find(|c| c.pool.role == Role::Uv(0));
        let vertex = all.vertex_role(Role::Uv(0));
        let value = |f: usize, k: usize| match corner {
            Some(corner) => corner.get(f, k),
            None => vertex?.get(model.mesh.faces[f][k] as usize),
        };
        let of_face = |f| [0, 1, 2].map(|k| value(f, k).map(<[f64]>::to_vec));
        (0..model.mesh.faces.len()).map(of_face).collect()
    };
    let before = coordinates(&model);
    assert_eq!(before[0][0], Some(vec![0.5, 0.0]));
    assert_eq!(before[1], [const { None }; 3]);
    // glTF counts the second coordinate from the top of the image.
    let turned = [[0.5, 1.0], [1.0, 1.0], [0.0, 0.0]].map(|uv| Some(uv.to_vec()));
    let contents = Contents {
        mesh: &model.mesh,
        attributes: &model.attributes,
        document: None,
    };
    let written = model_to_bytes(&contents, Format::Glb, &WriteOptions::default()).unwrap();
    let after = read_alone(&written.bytes, Format::Glb).unwrap();
    assert_eq!(coordinates(&after)[0], turned);
    // Written in another format again they are as before; in glTF they stay.
    let contents = Contents {
        mesh: &after.mesh,
        attributes: &after.attributes,
        document: after.document.as_ref(),
    };
    for (format, wanted) in [(Format::Obj, &before[0]), (Format::Gltf, &turned)] {
        let written = model_to_bytes(&contents, format, &WriteOptions::default()).unwrap();
        let again = read_alone(&written.bytes, format).unwrap();
        assert_eq!(coordinates(&again)[0], *wanted, "{format:?}");
    }
}

#[test]
fn triangles_strips_and_fans_with_a_stride() {
    assert_eq!(faces(NODE, STRIP), [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(
        faces(NODE, r#"{"attributes":{"POSITION":0},"mode":6}"#),
        [[0, 1, 2], [0, 2, 3]]
    );
    assert_eq!(
        faces(NODE, r#"{"attributes":{"POSITION":0},"indices":2}"#),
        [[1, 2, 3]]
    );
}

#[test]
fn sparse_items_replace_values_or_zeros() {
    for (accessor, expected) in [(3, [1.0, 1.0, 0.0]), (4, [0.0; 3])] {
        let primitive =
            format!(r#"{{"attributes":{{"POSITION":{accessor}}},"indices":1,"mode":5}}"#);
        let read = read_alone(gltf(NODE, &primitive).as_bytes(), Format::Gltf);
        match read {
            Ok(loaded) => {
                assert_eq!(loaded.mesh.positions[2].to_array(), [0.0, 5.0, 0.0]);
                assert_eq!(loaded.mesh.positions[3].to_array(), expected);
            }
            Err(error) => assert!(
                accessor == 4 && matches!(error, IoError::AllDegenerate { .. }),
                "{error}"
            ),
        }
    }
}

#[test]
fn transforms_are_nested_and_a_mesh_used_twice_is_read_twice() {
    let nodes = r#"{"scale":[2,2,2],"children":[1,2]},{"mesh":0,"translation":[1,0,0]},
        {"mesh":0,"matrix":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,3,1]}"#;
    let loaded = read_alone(gltf(nodes, STRIP).as_bytes(), Format::Gltf).unwrap();
    assert_eq!(loaded.mesh.positions.len(), 8);
    assert_eq!(loaded.mesh.positions[1].to_array(), [4.0, 0.0, 0.0]);
    assert_eq!(loaded.mesh.positions[5].to_array(), [-2.0, 0.0, 6.0]);
    assert_eq!(
        loaded.mesh.faces,
        [[0, 1, 2], [2, 1, 3], [4, 6, 5], [6, 7, 5]]
    );
    let turned = r#"{"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476]}"#;
    let loaded = read_alone(gltf(turned, STRIP).as_bytes(), Format::Gltf).unwrap();
    assert!((loaded.mesh.positions[1] - glam::DVec3::Y).length() < 1e-12);
}

#[test]
fn primitives_that_share_positions_share_vertices() {
    let loaded = read_alone(
        gltf(NODE, &format!("{STRIP},{STRIP}")).as_bytes(),
        Format::Gltf,
    )
    .unwrap();
    assert_eq!(
        (loaded.mesh.positions.len(), loaded.mesh.faces.len()),
        (4, 4)
    );
}

#[test]
fn points_and_lines_are_passed_over() {
    let lines = r#"{"attributes":{"POSITION":0},"mode":1}"#;
    let loaded = read_alone(
        gltf(NODE, &format!("{STRIP},{lines}")).as_bytes(),
        Format::Gltf,
    )
    .unwrap();
    assert_eq!(loaded.notes.len(), 1);
    assert!(message(NODE, lines).contains("no faces"));
}

#[test]
fn morph_targets_are_applied_with_their_default_weights() {
    // Accessor 0 as displacements: every vertex moves by a part of its own position.
    let morphed = r#"{"attributes":{"POSITION":0},"indices":1,"mode":5,"targets":[{"POSITION":0},{"NORMAL":0},{"POSITION":0}]}"#;
    let at = |text: &str| {
        let loaded = read_alone(text.as_bytes(), Format::Gltf).unwrap();
        (loaded.mesh.positions[1].x, loaded.notes.len())
    };
    assert_eq!(at(&gltf(NODE, morphed)), (1.0, 0));
    let of_mesh = gltf(NODE, morphed).replacen(
        r#""meshes":[{"primitives""#,
        r#""meshes":[{"weights":[0.5,1,0.25],"primitives""#,
        1,
    );
    assert_eq!(at(&of_mesh), (1.75, 1));
    // The weights of a node replace the weights of its mesh.
    let of_node = of_mesh.replacen(
        r#""nodes":[{"mesh":0}]"#,
        r#""nodes":[{"mesh":0,"weights":[0,0,2]}]"#,
        1,
    );
    assert_eq!(at(&of_node), (3.0, 1));
    let short = of_mesh.replace(
        r#"{"NORMAL":0},{"POSITION":0}"#,
        r#"{"NORMAL":0},{"POSITION":5}"#,
    );
    let short = short.replace(
        r#""bufferView":1,"count":2,"componentType":5122,"normalized":true"#,
        r#""bufferView":0,"count":2,"componentType":5126"#,
    );
    assert!(refusal(short.as_bytes(), Format::Gltf).contains("2 displacements for 4 vertices"));
    // Written into its document, the mesh has the same shape.
    let loaded = read_alone(of_mesh.as_bytes(), Format::Gltf).unwrap();
    let model = Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document: loaded.document.as_ref(),
    };
    let written = write(&model, Format::Gltf).unwrap().bytes;
    let again = read_alone(&written, Format::Gltf).unwrap();
    assert_eq!(again.mesh, loaded.mesh);
}

#[test]
fn other_versions_are_named() {
    for text in [
        r#"{"asset":{"version":"1.0"},"meshes":{"a":{"primitives":[]}},"nodes":{}}"#,
        r#"{"asset":{"generator":"x"},"meshes":{"a":{"primitives":[]}}}"#,
        r#"{"asset":{"version":1.1},"meshes":{}}"#,
    ] {
        let message = refusal(text.as_bytes(), Format::Gltf);
        assert!(
            message.contains("glTF version 1.") && message.contains("convert"),
            "{message}"
        );
    }
    let later = gltf(NODE, STRIP).replace(r#""version":"2.0""#, r#""version":"3.0""#);
    assert!(refusal(later.as_bytes(), Format::Gltf).contains("version 3.0"));
}

#[test]
fn side_files_are_resolved_by_their_decoded_name() {
    let text = gltf(NODE, STRIP);
    let (before, rest) = text.split_once("data:").unwrap();
    let (_, after) = rest.split_once('"').unwrap();
    let text = format!("{before}my%20mesh.bin\"{after}");
    let resolve = |name: &str, _: u64| {
        assert_eq!(name, "my mesh.bin");
        Ok(buffer())
    };
    assert_eq!(
        read_bytes(text.as_bytes(), Format::Gltf, &resolve)
            .unwrap()
            .mesh
            .faces
            .len(),
        2
    );
    assert!(refusal(text.as_bytes(), Format::Gltf).contains("my mesh.bin"));
    let short = |_: &str, _: u64| Ok(vec![0; 10]);
    let error = read_bytes(text.as_bytes(), Format::Gltf, &short)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("buffer 0") && error.contains("has 10"),
        "{error}"
    );
}

#[test]
fn compression_is_refused_by_name() {
    for name in ["EXT_draco_mesh_compression", "KHR_meshopt_compression"] {
        let text =
            gltf(NODE, STRIP).replacen('{', &format!(r#"{{"extensionsRequired":["{name}"],"#), 1);
        let message = refusal(text.as_bytes(), Format::Gltf);
        assert!(
            message.contains(name) && message.contains("decompress"),
            "{message}"
        );
    }
    let text =
        gltf(NODE, STRIP).replacen('{', r#"{"extensionsRequired":["KHR_materials_unlit"],"#, 1);
    assert!(read_alone(text.as_bytes(), Format::Gltf).is_ok());
}

#[test]
fn faults_are_named() {
    assert!(message(r#"{"children":[1]},{"children":[0]}"#, STRIP).contains("cycle"));
    assert!(message(r#"{"children":[7]}"#, STRIP).contains("node 7"));
    assert!(message(r#"{"mesh":1}"#, STRIP).contains("mesh 1"));
    assert!(message(NODE, r#"{"attributes":{"POSITION":9}}"#).contains("accessor 9"));
    assert!(message(NODE, r#"{"attributes":{"POSITION":1}}"#).contains("type Scalar"));
    assert!(message(NODE, r#"{"attributes":{}}"#).contains("no positions"));
    assert!(
        message(NODE, r#"{"attributes":{"POSITION":0},"indices":1}"#).contains("whole triangles")
    );
    let edited = |from: &str, to: &str| {
        refusal(
            gltf(NODE, STRIP).replacen(from, to, 1).as_bytes(),
            Format::Gltf,
        )
    };
    assert!(
        edited(r#""bufferView":0,"count":4"#, r#""bufferView":0,"count":5"#).contains("do not fit")
    );
    assert!(
        edited(
            r#""bufferView":0,"count":4"#,
            r#""bufferView":0,"count":18446744073709551615"#
        )
        .contains("do not fit")
    );
    assert!(edited(r#""byteLength":64"#, r#""byteLength":6400"#).contains("buffer view 0"));
    assert!(
        edited(r#""bufferView":0,"count":4"#, r#""bufferView":0,"count":3"#).contains("index is 3")
    );
    assert!(edited("\"version\"", "\"varsion\"").contains("version"));
}

#[test]
fn damage_is_survived() {
    assert_survives_damage(gltf(NODE, STRIP).as_bytes(), Format::Gltf);
    let bytes = to_bytes(&open_tetrahedron(), Format::Glb, &WriteOptions::default())
        .unwrap()
        .bytes;
    assert_survives_damage(&bytes, Format::Glb);
}

/// A scene of `nodes` nodes that use one mesh of `points` points. All indices are 0. The mesh has `attributes`
/// attributes, from accessor `of`: accessor 1 has twelve bytes per point, accessor 2 has one.
fn crowd(nodes: usize, points: usize, mode: u32, [attributes, of]: [usize; 2]) -> String {
    let bytes = 12 * points;
    let uri = base64::engine::general_purpose::STANDARD.encode(vec![0; bytes]);
    let nodes = vec![r#"{"mesh":0}"#; nodes].join(",");
    let attributes: String = (0..attributes)
        .map(|i| format!(r#","_A{i}":{of}"#))
        .collect();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}],"meshes":[{{"primitives":[{{"mode":{mode},"indices":1,
        "attributes":{{"POSITION":0{attributes}}}}}]}}],
        "buffers":[{{"byteLength":{bytes},"uri":"data:;base64,{uri}"}}],"bufferViews":[{{"buffer":0,"byteLength":{bytes}}}],
        "accessors":[{{"bufferView":0,"count":{points},"componentType":5126,"type":"VEC3"}},
        {{"bufferView":0,"count":{bytes},"componentType":5121,"type":"SCALAR"}},
        {{"bufferView":0,"count":{points},"componentType":5121,"type":"SCALAR"}}]}}"#
    )
}

#[test]
fn small_files_do_not_become_enormous_scenes() {
    let start = std::time::Instant::now();
    for (name, text) in [
        ("nodes", crowd(20_000, 10_000, 4, [0, 1])),
        ("strips of nothing", crowd(30_000, 20_000, 5, [0, 1])),
        ("attributes", crowd(2000, 9_000, 4, [2000, 2])),
    ] {
        let message = refusal(text.as_bytes(), Format::Gltf);
        let is_refused = message.contains("memory") && message.contains("save the parts");
        assert!(is_refused, "{name}: {message}");
    }
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn attributes_of_other_lengths_are_not_read() {
    // 5000 names for an accessor of a million items, which is not the number of vertices.
    let text = crowd(1, 80_000, 4, [5000, 1]);
    let start = std::time::Instant::now();
    assert!(refusal(text.as_bytes(), Format::Gltf).contains("degenerate"));
    assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
}
