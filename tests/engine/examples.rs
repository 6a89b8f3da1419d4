//! The programs in `examples/` run and give accurate results.
#![allow(dead_code)] // Their `main` functions are not called here.

#[path = "../../examples/choose_holes.rs"]
mod choose_holes;
#[path = "../../examples/fill_hole.rs"]
mod fill_hole;
#[path = "../../examples/own_energy.rs"]
mod own_energy;
#[path = "../../examples/restore_dent.rs"]
mod restore_dent;

use std::fmt::Write;
use std::fs;

use crate::shapes;
use glam::DVec3;
use isomend::HoleOutcome;
use isomend::Role;
use isomend::io::read_path;

#[test]
fn a_ball_without_its_top_is_filled_to_the_sphere() {
    let farthest = fill_hole::run().unwrap();
    assert!(farthest > 0.0 && farthest < 0.02, "{farthest}");
}

#[test]
fn an_own_energy_continues_a_tube_that_the_willmore_energy_does_not() {
    let [willmore, own] = own_energy::run().unwrap();
    assert!(
        willmore > 0.005 && own < 0.2 * willmore,
        "{willmore}, {own}"
    );
}

#[test]
fn a_dented_ball_is_restored_to_the_sphere() {
    let [before, after] = restore_dent::run().unwrap();
    assert!(before > 0.19 && after < 0.01, "{before}, {after}");
}

/// The text of an OBJ file with a colour at each vertex.
fn coloured(mesh: &isomend::Mesh) -> String {
    let mut text = String::new();
    for p in &mesh.positions {
        writeln!(text, "v {} {} {} 0.25 0.5 0.75", p.x, p.y, p.z).unwrap();
    }
    for f in &mesh.faces {
        let [a, b, c] = f.map(|v| v + 1);
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    text
}

#[test]
fn holes_up_to_a_diameter_are_filled_and_patches_coloured() {
    let folder = tempfile::tempdir().unwrap();
    let [input, output] = ["in.obj", "out.ply"].map(|name| folder.path().join(name));
    let at_hole = |p: DVec3| p.z > 0.8 || (p - DVec3::X).length() < 0.3;
    let mesh = shapes::cut(&shapes::sphere(12), at_hole);
    fs::write(&input, coloured(&mesh)).unwrap();
    let report = choose_holes::run(&input, &output, 0.8).unwrap();
    let outcomes: Vec<&HoleOutcome> = report.holes.iter().map(|hole| &hole.outcome).collect();
    assert!(
        matches!(outcomes[..], [HoleOutcome::Left(_), HoleOutcome::Closed(_)]),
        "{outcomes:?}"
    );
    let written = read_path(&output, None).unwrap();
    assert!(written.mesh.faces.len() > mesh.faces.len());
    assert_eq!(written.mesh.faces[..mesh.faces.len()], mesh.faces);
    let colours = written.attributes.vertex_role(Role::Colour).unwrap();
    assert_eq!(colours.len(), written.mesh.positions.len());
    for vertex in 0..colours.len() {
        let colour = colours.get(vertex).unwrap();
        for (value, wanted) in colour.iter().zip([0.25, 0.5, 0.75]) {
            assert!(
                (value / colours.unit() - wanted).abs() < 0.003,
                "{colour:?}"
            );
        }
    }
}
