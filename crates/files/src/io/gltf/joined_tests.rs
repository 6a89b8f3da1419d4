//! Tests of bodies that new faces join from nodes with different transforms.

use glam::DVec3;

use super::super::samples::read_alone;
use super::tests::{STRIP, gltf};
use super::*;
use isomend_core::mesh::Attributes;
use isomend_core::mesh::attributes::PATCH_NAME;

/// The distinct positions of the corners of a mesh's faces.
fn corner_positions(loaded: &Loaded) -> Vec<[u64; 3]> {
    let corners = loaded.mesh.faces.iter().flatten();
    let mut all: Vec<_> = corners
        .map(|v| {
            loaded.mesh.positions[*v as usize]
                .to_array()
                .map(f64::to_bits)
        })
        .collect();
    all.sort_unstable();
    all.dedup();
    all
}

#[test]
fn faces_that_join_nodes_meet_exactly() {
    let nodes = r#"{"children":[1,2]},{"mesh":0,"rotation":[0.1,0.2,0.3,0.9273618495495703]},
        {"mesh":0,"translation":[0.1,0.7,2.3]}"#;
    let loaded = read_alone(gltf(nodes, STRIP).as_bytes(), Format::Gltf).unwrap();
    let mut mesh = loaded.mesh.clone();
    // A point of its own, and faces from it to both nodes.
    let own = mesh.positions.len() as u32;
    mesh.positions.push(DVec3::new(0.3, -0.2, 1.1));
    mesh.faces.extend([[0, 1, own], [own, 5, 4], [1, 5, own]]);
    let model = Contents {
        mesh: &mesh,
        attributes: &Attributes::default(),
        document: loaded.document.as_ref(),
    };
    let written = write(&model, Format::Glb).unwrap();
    let is_told = |note: &String| note.contains("2 faces are written under the node");
    assert!(written.notes.iter().any(is_told), "{:?}", written.notes);

    let again = read_alone(&written.bytes, Format::Glb).unwrap();
    assert_eq!(again.mesh.faces.len(), 7);
    assert_eq!(corner_positions(&again).len(), 9);
    let marks = again.attributes.face.iter().find(|a| a.name == PATCH_NAME);
    let marked = marks.unwrap().values.iter().filter(|mark| **mark > 0.0);
    assert_eq!(marked.count(), 3);
    // The body of the first node stays as it is.
    assert_eq!(again.mesh.positions[..4], loaded.mesh.positions[..4]);
}

#[test]
fn a_patch_of_one_node_moves_no_others() {
    let nodes = r#"{"children":[1,2]},{"mesh":0,"rotation":[0.1,0.2,0.3,0.9273618495495703]},
        {"mesh":0,"translation":[0.1,0.7,2.3]}"#;
    let loaded = read_alone(gltf(nodes, STRIP).as_bytes(), Format::Gltf).unwrap();
    let mut mesh = loaded.mesh.clone();
    let own = mesh.positions.len() as u32;
    mesh.positions.push(DVec3::new(0.3, -0.2, 1.1));
    mesh.faces.push([own, 5, 4]);
    let model = Contents {
        mesh: &mesh,
        attributes: &Attributes::default(),
        document: loaded.document.as_ref(),
    };
    let written = write(&model, Format::Glb).unwrap();
    assert!(written.notes.is_empty(), "{:?}", written.notes);
    let again = read_alone(&written.bytes, Format::Glb).unwrap();
    assert_eq!(again.mesh.positions[..8], loaded.mesh.positions[..8]);
    assert_eq!(corner_positions(&again).len(), 9);
}
