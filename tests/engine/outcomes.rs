//! The command line's summary of a run: the count of each outcome, and exit codes.

use crate::desk::{Desk, assert_code, text};
use crate::shapes::{cut, polar, sphere};
use glam::DVec3;
use isomend::io::Format;
use isomend::{FillParams, Mesh};

/// A sphere with a wide hole whose rim is a zigzag: only triangles between the rim's vertices close it.
fn zigzag_rim() -> Mesh {
    let mut mesh = cut(&sphere(10), |p| polar(p) < 30.0);
    let rim = isomend::inspect(&mesh).unwrap().holes[0].rim.clone();
    for (i, &v) in rim.iter().enumerate() {
        let p = &mut mesh.positions[v as usize];
        *p += DVec3::new(0.0, 0.0, if i % 2 == 0 { 2.0 } else { -2.0 });
    }
    mesh
}

#[test]
fn the_last_line_counts_each_outcome() {
    let desk = Desk::new();
    let done = desk.run(&["fill", "ball.ply", "-o", "out.ply", "--keep-open", "2"]);
    assert_code(&done, 0);
    let said = text(&done.stderr);
    let last = said.lines().last().unwrap();
    let wanted = "out.ply: 1 of 2 holes closed (1 by the level set), 1 left open; no patch intersects other faces";
    assert!(last.starts_with(wanted), "{last}");
    assert!(said.contains("hole 2 left open"), "{said}");
}

#[test]
fn strict_fails_if_only_rim_triangles_close_a_hole() {
    let desk = Desk::new();
    desk.save("bad.ply", &zigzag_rim(), Format::Ply);
    let arguments = ["fill", "bad.ply", "-o", "out.ply", "--json", "out.json"];
    let done = desk.run(&arguments);
    assert_code(&done, 0);
    let said = text(&done.stderr);
    let document = desk.json("out.json");
    assert_eq!(document["flawless"], false, "{said}");
    assert_eq!(document["outcomes"]["rim_triangles"], 1, "{said}");
    assert!(
        said.contains("the hole is closed (1 by rim triangles)"),
        "{said}"
    );
    let region = &document["regions"][0];
    assert_eq!(region["closed_by"], "rim_triangles");
    assert!(region["seam_angle_mean"].is_null());
    assert!(!said.contains("seam"), "{said}");
    let strict = desk.run(&[&arguments[..], &["--strict"]].concat());
    assert_code(&strict, 3);
    let why = "note: hole 1: not closed well, which --strict asks for (-v says why)";
    assert!(
        text(&strict.stderr).contains(why),
        "{}",
        text(&strict.stderr)
    );
    let good = [
        "fill", "ball.ply", "-o", "out.ply", "--strict", "--json", "out.json",
    ];
    assert_code(&desk.run(&good), 0);
    assert_eq!(desk.json("out.json")["flawless"], true);
}

#[test]
fn a_mesh_without_holes_is_reported_as_copied() {
    let desk = Desk::new();
    desk.save("closed.ply", &sphere(4), Format::Ply);
    let done = desk.run(&["fill", "closed.ply", "-o", "out.ply"]);
    assert_code(&done, 0);
    let said = text(&done.stderr);
    assert!(
        said.contains("no holes") && said.contains("copied unchanged"),
        "{said}"
    );
}

#[test]
fn the_table_lists_each_hole_once_and_verbose_adds_details() {
    let desk = Desk::new();
    let done = desk.run(&["fill", "ball.ply", "-o", "out.ply"]);
    let said = text(&done.stderr);
    let heading = said
        .lines()
        .position(|l| l.trim_start().starts_with("hole "));
    let rows: Vec<&str> = said.lines().skip(heading.unwrap() + 1).take(2).collect();
    assert!(
        rows.iter()
            .all(|l| l.contains("level set") && l.len() <= 80),
        "{said}"
    );
    assert!(!said.contains("energy"), "{said}");
    let done = desk.run(&["fill", "ball.ply", "-o", "out.ply", "-v"]);
    let said = text(&done.stderr);
    for hole in ["hole 1: ", "hole 2: "] {
        let count = said.lines().filter(|l| l.starts_with(hole)).count();
        assert_eq!(count, 1, "{said}");
    }
    desk.save("closed.ply", &sphere(6), Format::Ply);
    let done = desk.run(&["fair", "closed.ply", "-o", "out.ply", "-v"]);
    let said = text(&done.stderr);
    assert_eq!(said.matches("whole surface: ").count(), 1, "{said}");
}

#[test]
fn self_intersections_are_counted_in_the_positions_as_written() {
    // At 2e6 neighbouring 32-bit floats are 0.125 apart, about 1.4 edges: rounding folds faces over each other.
    let desk = Desk::new();
    let mut mesh = cut(&sphere(12), |p| polar(p) < 40.0);
    for p in &mut mesh.positions {
        *p += DVec3::new(2_000_000.0, 0.0, 0.0);
    }
    desk.text("far.obj", &obj(&mesh));
    let count = |out: &str| {
        let done = desk.run(&["fill", "far.obj", "-o", out, "--json", "out.json"]);
        assert_code(&done, 0);
        desk.json("out.json")["outcomes"]["intersecting_faces"]
            .as_u64()
            .unwrap()
    };
    assert_eq!(count("out.obj"), 0);
    assert!(count("out.stl") > 0);
}

fn obj(mesh: &Mesh) -> String {
    let mut text = String::new();
    for p in &mesh.positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.faces {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    text
}

#[test]
fn the_default_edge_ratio_depends_on_energy_and_finish() {
    let mut params = FillParams::default();
    assert_eq!(params.edge_ratio(), 0.7);
    params.finish = isomend::Finish::None;
    assert_eq!(params.edge_ratio(), 0.8);
    params.energy = isomend::Energy::CurvatureVariation;
    assert_eq!(params.edge_ratio(), 0.45);
    params.edge_ratio = Some(1.5);
    assert_eq!(params.edge_ratio(), 1.5);
}
