//! `check` and `inspect` of several files, the recommended command to weld, and the last lines of repairs and fills.

use crate::desk::{Desk, assert_code, assert_usage, ball, text};
use crate::shapes::{cut, joined, moved, sphere, turned};
use glam::DVec3;
use isomend::Mesh;
use isomend::io::Format;

#[test]
fn several_files_are_checked_in_a_table_a_list_and_one_exit_code() {
    let desk = Desk::new();
    desk.save("good.stl", &turned(sphere(4)), Format::Stl);
    desk.save("other.ply", &turned(sphere(3)), Format::Ply);
    let both = desk.run(&["check", "good.stl", "other.ply", "--json", "both.json"]);
    assert_code(&both, 0);
    let said = text(&both.stdout);
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 3, "{said}");
    assert!(lines[0].contains("file") && lines[0].contains("watertight and printable"));
    assert!(lines[1].starts_with("good.stl") && lines[1].ends_with("yes"));
    let list = desk.json("both.json");
    assert_eq!(list.as_array().unwrap().len(), 2);
    assert_eq!(list[1]["input"]["path"], "other.ply");
    assert_eq!(list[0]["sound"], true);

    let part = desk.run(&["check", "good.stl", "ball.ply"]);
    assert_code(&part, 3);
    assert!(text(&part.stdout).contains("no: 2 holes are open"));

    let failed = desk.run(&["check", "none.ply", "ball.ply", "good.stl", "--json", "-"]);
    assert_code(&failed, 1);
    let list: serde_json::Value = serde_json::from_slice(&failed.stdout).unwrap();
    assert!(list[0]["error"].is_string() && list[1]["sound"] == false);
    assert_eq!(list[2]["sound"], true);
    assert!(text(&failed.stderr).contains("none.ply"));

    assert_code(&desk.run(&["check", "good.stl", "ball.ply", "-q"]), 3);
    let drawn = ["check", "good.stl", "ball.ply", "--report", "x.html"];
    assert_usage(&desk.run(&drawn), &["--report", "several"]);
    assert_usage(&desk.run(&["check", "good.stl", "-"]), &["standard input"]);
}

#[test]
fn several_files_are_inspected_in_a_table() {
    let desk = Desk::new();
    desk.save("good.stl", &turned(sphere(4)), Format::Stl);
    let all = desk.run(&["inspect", "good.stl", "ball.ply", "--json", "all.json"]);
    assert_code(&all, 0);
    let said = text(&all.stdout);
    let cells: Vec<Vec<&str>> = said
        .lines()
        .map(|l| l.split_whitespace().collect())
        .collect();
    assert_eq!(cells.len(), 3, "{said}");
    assert_eq!(cells[1][..2], ["good.stl", "STL"]);
    assert_eq!(cells[2][5], "2", "{said}");
    assert_eq!(
        desk.json("all.json")[1]["holes"].as_array().unwrap().len(),
        2
    );
    assert_code(&desk.run(&["inspect", "ball.ply", "none.ply"]), 1);
}

#[test]
fn the_check_recommends_a_command_that_welds() {
    let desk = Desk::new();
    let good = turned(sphere(5));
    let half = |above: bool| {
        let z = |f: &[u32; 3]| f.map(|v| good.positions[v as usize].z).iter().sum::<f64>();
        let faces = good.faces.iter().filter(|f| (z(f) > 0.0) == above);
        Mesh::new(good.positions.clone(), faces.copied().collect())
    };
    let torn = joined(&half(true), &moved(&half(false), 1.0, DVec3::X * 8e-3));
    desk.save("torn.stl", &torn, Format::Stl);
    let checked = desk.run(&["check", "torn.stl"]);
    assert_code(&checked, 3);
    let said = text(&checked.stdout);
    let command = said.lines().last().unwrap();
    let (_, command) = command.split_once("isomend ").unwrap();
    let command = command.replace("OUT", "whole.stl");
    let arguments: Vec<&str> = command.split(' ').collect();
    assert!(arguments.contains(&"--weld"), "{said}");
    assert_code(&desk.run(&arguments), 0);
    assert_code(&desk.run(&["check", "whole.stl", "-q"]), 0);
}

#[test]
fn a_repair_takes_flat_caps_by_numbers_of_the_input_and_ends_with_the_verdict() {
    let desk = Desk::new();
    // A small component comes first, so that removing it changes the numbers of the holes.
    let lid = moved(
        &cut(&turned(sphere(3)), |p| p.z > -0.3),
        1.2,
        DVec3::Z * 5.0,
    );
    let mesh = joined(&lid, &ball());
    desk.save("pair.ply", &mesh, Format::Ply);
    let arguments = [
        "repair", "pair.ply", "-o", "out.stl", "--flat", "2", "--debris", "0.9", "-v", "--json",
        "out.json",
    ];
    let done = desk.run(&arguments);
    assert_code(&done, 0);
    let document = desk.json("out.json");
    let holes = document["holes"].as_array().unwrap();
    let outcome = |id: u64| {
        let own = holes.iter().find(|h| h["id"] == id);
        own.map(|h| h["closed_by"].as_str().unwrap().to_owned())
    };
    assert_eq!(outcome(1), None, "{holes:?}");
    assert_eq!(outcome(2).as_deref(), Some("flat"), "{holes:?}");
    assert_eq!(outcome(3).as_deref(), Some("level_set"), "{holes:?}");
    let said = text(&done.stderr);
    let last = said.lines().last().unwrap();
    assert!(last.contains("watertight and printable: yes"), "{said}");
    let lid = lid.faces.len();
    assert!(
        said.contains(&format!("including 1 component of {lid} faces")),
        "{said}"
    );
}

#[test]
fn a_fill_without_holes_reports_rounded_positions() {
    let desk = Desk::new();
    desk.text("exact.obj", &obj(&turned(sphere(2))));
    let said = |output: &str| text(&desk.run(&["fill", "exact.obj", "-o", output]).stderr);
    assert!(said("out.obj").contains("copied unchanged"));
    let stl = said("out.stl");
    assert!(
        !stl.contains("copied unchanged") && stl.contains("rounded"),
        "{stl}"
    );
}

fn obj(mesh: &Mesh) -> String {
    let vertices = mesh
        .positions
        .iter()
        .map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let faces = mesh
        .faces
        .iter()
        .map(|f| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1));
    vertices.chain(faces).collect()
}
