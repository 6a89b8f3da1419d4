//! Tests of `EXT_mesh_gpu_instancing`: instances are read with their transforms, and are nodes in the written document.

use base64::Engine;
use glam::DVec3;

use super::super::samples::*;
use super::tests::{STRIP, gltf};
use super::*;

/// A file with a node of three instances, which has a child: translations, rotations as normalised 16-bit integers, and scales.
fn instanced(rotations: usize) -> String {
    let translations: [[f32; 3]; 3] = [[0.0; 3], [5.0, 0.0, 0.0], [0.0, 7.0, 1.0]];
    // None, and a quarter turn about z.
    let quarter = (32767.0 * 0.5f64.sqrt()).round() as i16;
    let turns: [[i16; 4]; 3] = [[0, 0, 0, 32767], [0, 0, quarter, quarter], [0, 0, 0, 32767]];
    let scales: [[f32; 3]; 3] = [[1.0; 3], [1.0; 3], [2.0, 2.0, -2.0]];
    let floats = |rows: &[[f32; 3]; 3]| -> Vec<u8> {
        rows.iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes())
            .collect()
    };
    let mut data = floats(&translations);
    data.extend(turns.iter().flatten().flat_map(|x| x.to_le_bytes()));
    data.extend(floats(&scales));
    let uri = base64::engine::general_purpose::STANDARD.encode(&data);
    let node = r#"{"mesh":0,"translation":[0,0,10],"children":[1],"extensions":{"EXT_mesh_gpu_instancing":{"attributes":
        {"TRANSLATION":6,"ROTATION":7,"SCALE":8}},"OTHER":{}}},{"mesh":0}"#;
    let views = r#"{"buffer":1,"byteLength":36},{"buffer":1,"byteOffset":36,"byteLength":24},{"buffer":1,"byteOffset":60,"byteLength":36}"#;
    let accessors = format!(
        r#"{{"bufferView":4,"count":3,"componentType":5126,"type":"VEC3"}},{{"bufferView":5,"count":{rotations},"componentType":5122,
        "normalized":true,"type":"VEC4"}},{{"bufferView":6,"count":3,"componentType":5126,"type":"VEC3"}}"#
    );
    let mut text = gltf(node, STRIP);
    let second = format!(
        r#",{{"byteLength":{},"uri":"data:application/octet-stream;base64,{uri}"}}],
        "bufferViews":["#,
        data.len()
    );
    let end = text.find("],\n        \"bufferViews\":[").unwrap();
    let rest = text[end..].find('[').unwrap() + end + 1;
    text.replace_range(end..rest, &second);
    text = text.replacen(
        "\"byteOffset\":76,\"byteLength\":12}",
        &format!("\"byteOffset\":76,\"byteLength\":12}},{views}"),
        1,
    );
    let last = r#""componentType":5122,"normalized":true,"type":"VEC3"}"#;
    text = text.replacen(last, &format!("{last},{accessors}"), 1);
    text.replacen(
        '{',
        r#"{"extensionsUsed":["EXT_mesh_gpu_instancing","OTHER"],"extensionsRequired":["EXT_mesh_gpu_instancing"],"#,
        1,
    )
}

#[test]
fn instances_are_read_with_their_transforms_and_written_as_nodes() {
    let loaded = read_alone(instanced(3).as_bytes(), Format::Gltf).unwrap();
    assert!(
        loaded
            .notes
            .iter()
            .any(|n| n.contains("EXT_mesh_gpu_instancing") && n.ends_with(": 3"))
    );
    // Three instances of four vertices and two faces, and the child, which has no instances.
    assert_eq!(
        (loaded.mesh.positions.len(), loaded.mesh.faces.len()),
        (16, 8)
    );
    // The vertex (1, 0, 0) of each, in the place of the node.
    let at = |k: usize| loaded.mesh.positions[4 * k + 1];
    for (k, wanted) in [
        [1.0, 0.0, 10.0],
        [5.0, 1.0, 10.0],
        [2.0, 7.0, 11.0],
        [1.0, 0.0, 10.0],
    ]
    .into_iter()
    .enumerate()
    {
        assert!(
            at(k).distance(DVec3::from_array(wanted)) < 1e-4,
            "{k}: {}",
            at(k)
        );
    }
    // A mirroring scale turns the faces, so that their front sides stay front sides.
    let up = |f: u32| {
        let [a, b, c] = loaded.mesh.corners(f);
        (b - a).cross(c - a).z > 0.0
    };
    assert_eq!(up(0), up(2));
    assert_ne!(up(0), up(4));

    let model = Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document: loaded.document.as_ref(),
    };
    let written = write(&model, Format::Gltf).unwrap().bytes;
    let again = read_alone(&written, Format::Gltf).unwrap();
    assert_eq!(again.mesh, loaded.mesh);
    let text = String::from_utf8(written).unwrap();
    assert!(!text.contains("EXT_mesh_gpu_instancing") && text.contains("OTHER"));
}

#[test]
fn damaged_instances_are_refused() {
    let said = refusal(instanced(2).as_bytes(), Format::Gltf);
    assert!(said.contains("3 instances, but 2 of ROTATION"), "{said}");
    let other = instanced(3).replace(r#""SCALE":8"#, r#""SCALE":1"#);
    let said = refusal(other.as_bytes(), Format::Gltf);
    assert!(said.contains("1 components, not 3"), "{said}");
    assert!(
        !refusal(
            instanced(3)
                .replace(r#""SCALE":8"#, r#""SCALE":99"#)
                .as_bytes(),
            Format::Gltf
        )
        .is_empty()
    );
}
