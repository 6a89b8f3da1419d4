//! Tests of bodies that new faces join from nodes with different transforms.

use glam::DVec3;

use super::super::samples::read_alone;
use super::tests::{STRIP, gltf};
use super::*;
use isomend_core::mesh::attributes::PATCH_NAME;
use isomend_core::mesh::{Attributes, Mesh};

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

/// Two nodes with different transforms, of two faces each; and their mesh with a point of its own, from which the caller adds faces.
fn two_nodes() -> (Loaded, Mesh, u32) {
    let nodes = r#"{"children":[1,2]},{"mesh":0,"rotation":[0.1,0.2,0.3,0.9273618495495703]},
        {"mesh":0,"translation":[0.1,0.7,2.3]}"#;
    let loaded = read_alone(gltf(nodes, STRIP).as_bytes(), Format::Gltf).unwrap();
    let mut mesh = loaded.mesh.clone();
    let own = mesh.positions.len() as u32;
    mesh.positions.push(DVec3::new(0.3, -0.2, 1.1));
    (loaded, mesh, own)
}

/// Writes a mesh into the document of a scene; returns the remarks and the mesh as it is read again.
fn written(scene: &Loaded, mesh: &Mesh) -> (Vec<String>, Loaded) {
    let model = Contents {
        mesh,
        attributes: &Attributes::default(),
        document: scene.document.as_ref(),
    };
    let written = write(&model, Format::Glb).unwrap();
    let again = read_alone(&written.bytes, Format::Glb).unwrap();
    (written.notes, again)
}

#[test]
fn faces_that_join_nodes_meet_exactly() {
    let (loaded, mut mesh, own) = two_nodes();
    mesh.faces.extend([[0, 1, own], [own, 5, 4], [1, 5, own]]);
    let (notes, again) = written(&loaded, &mesh);
    let is_told = |note: &String| note.contains("2 faces are written under the node");
    assert!(notes.iter().any(is_told), "{notes:?}");

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
    let (loaded, mut mesh, own) = two_nodes();
    mesh.faces.push([own, 5, 4]);
    let (notes, again) = written(&loaded, &mesh);
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(again.mesh.positions[..8], loaded.mesh.positions[..8]);
    assert_eq!(corner_positions(&again).len(), 9);
}
