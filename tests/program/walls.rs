//! Walls on the command line: their thickness in reports, and verdicts on walls that are too thin.

use crate::desk::{Desk, assert_code, text};
use crate::shapes::{cut, joined, sphere};
use glam::DVec3;
use isomend::Mesh;
use isomend::io::Format;

/// A wavy sheet of `n` by `n` squares at a height.
fn sheet(n: u32, z: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        for j in 0..=n {
            let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            let wave = 0.1 * (4.0 * u).sin() * (3.0 * v).cos();
            mesh.positions.push(DVec3::new(u, v, z + wave));
        }
    }
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            let b = a + n + 1;
            mesh.faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    mesh
}

#[test]
fn a_sheet_gets_walls_and_the_report_gives_their_thickness() {
    let desk = Desk::new();
    desk.save("sheet.ply", &sheet(12, 0.0), Format::Ply);
    let arguments = [
        "repair",
        "sheet.ply",
        "-o",
        "out.stl",
        "--close-borders",
        "--wall",
        "0.05",
        "--json",
        "out.json",
    ];
    let done = desk.run(&arguments);
    assert_code(&done, 0);
    let said = text(&done.stderr);
    assert!(
        said.contains("component 1 got an offset shell: walls 0.0"),
        "{said}"
    );
    assert!(
        said.contains("by walls") && !said.contains("still open"),
        "{said}"
    );
    let document = desk.json("out.json");
    assert_eq!(document["holes"][0]["closed_by"], "walls");
    let shell = &document["offset_shells"][0];
    assert_eq!(shell["component"], 1);
    assert!(
        (shell["mean_wall"].as_f64().unwrap() - 0.05).abs() < 0.005,
        "{shell}"
    );
    assert!(shell["too_thin"].is_null());
    // A check of the file reports the thickness of its walls, and fails if they are thinner than a limit.
    let checked = desk.run(&["check", "out.stl"]);
    assert_code(&checked, 0);
    assert!(text(&checked.stdout).contains("walls:                 least thickness 0.0"));
    assert_code(&desk.run(&["check", "out.stl", "--min-wall", "0.03"]), 0);
    let thin = desk.run(&["check", "out.stl", "--min-wall", "0.1"]);
    assert_code(&thin, 3);
    let said = text(&thin.stdout);
    assert!(
        said.contains("walls are thinner than 0.1 (component 1: 0.0"),
        "{said}"
    );
    let strict = [
        "--close-borders",
        "--wall",
        "0.05",
        "--min-wall",
        "0.1",
        "-q",
    ];
    let arguments = [&["repair", "sheet.ply", "-o", "thin.stl"], &strict[..]].concat();
    assert_code(&desk.run(&arguments), 3);
}

#[test]
fn walls_that_are_too_thin_fail_with_advice() {
    let desk = Desk::new();
    let pair = joined(&sheet(12, 0.0), &sheet(12, 1e-3));
    desk.save("pair.ply", &pair, Format::Ply);
    let arguments = ["repair", "pair.ply", "-o", "out.ply", "--close-borders"];
    let done = desk.run(&arguments);
    assert_code(&done, 3);
    let said = text(&done.stderr);
    let last = said.lines().last().unwrap();
    for word in [
        "watertight, but the shape is doubtful: walls that the repair made",
        "component 2: ",
        "flat base",
    ] {
        assert!(last.contains(word), "{said}");
    }
    assert!(
        said.contains("--flat-base") && said.contains("--wall"),
        "{said}"
    );
    // With `--min-wall` this limit decides; a check without it reports the thickness only.
    let arguments = [&arguments[..], &["--min-wall", "1e-5"]].concat();
    assert_code(&desk.run(&arguments), 0);
    assert_code(&desk.run(&["check", "out.ply", "-q"]), 0);
}

#[test]
fn a_base_that_nothing_stands_on_is_named_with_the_flat_cap_instead() {
    let desk = Desk::new();
    desk.save("bowl.ply", &cut(&sphere(8), |p| p.z < -0.6), Format::Ply);
    for command in ["fill", "repair"] {
        let done = desk.run(&[command, "bowl.ply", "-o", "out.ply", "--flat-base"]);
        let said = text(&done.stderr);
        assert!(
            said.contains("nothing was put on a flat base; --flat 1 gives hole 1"),
            "{said}"
        );
        let done = desk.run(&[
            command,
            "bowl.ply",
            "-o",
            "out.ply",
            "--flat-base",
            "--flat",
            "1",
        ]);
        let said = text(&done.stderr);
        assert!(said.contains("nothing was put on a flat base\n"), "{said}");
    }
    desk.save("sheet.ply", &sheet(12, 0.0), Format::Ply);
    let done = desk.run(&["fill", "sheet.ply", "-o", "out.ply", "--flat-base"]);
    assert!(
        !text(&done.stderr).contains("nothing was put"),
        "{}",
        text(&done.stderr)
    );
}
