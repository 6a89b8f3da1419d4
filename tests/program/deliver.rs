//! Files and data delivered with the mesh: patches alone, the missing piece, marks, units, tolerances, hashes.

use std::fs;

use crate::desk::{Desk, assert_code, assert_usage, text};
use crate::shapes::sphere;
use glam::DVec3;
use isomend::check::CheckParams;
use isomend::io::{Format, Loaded, read_path};
use isomend::{Inspection, Mesh, Unit};

/// A sphere with a chip broken off: a dent with a rough surface.
fn chipped() -> Mesh {
    let mut mesh = sphere(12);
    for p in &mut mesh.positions {
        let from = p.distance(DVec3::Z);
        if from < 0.45 {
            // A rough surface inside the dent.
            let rough = 0.02 * (40.0 * p.x).sin() * (37.0 * p.y).cos();
            *p *= 1.0 - 0.25 * (1.0 - from / 0.45) + rough;
        }
        *p = p.as_vec3().as_dvec3();
    }
    mesh
}

fn loaded(desk: &Desk, name: &str) -> Loaded {
    read_path(&desk.path(name), None).unwrap()
}

fn volume(mesh: &Mesh) -> f64 {
    let part = |f: u32| {
        let [a, b, c] = mesh.corners(f);
        a.dot(b.cross(c)) / 6.0
    };
    (0..mesh.faces.len() as u32).map(part).sum()
}

#[test]
fn patches_are_written_alone_with_their_holes_and_errors() {
    let desk = Desk::new();
    for format in [
        "ply", "vtp", "glb", "obj", "stl", "off", "3mf", "usda", "usdz",
    ] {
        let name = format!("patches.{format}");
        let done = desk.run(&["fill", "ball.ply", "-o", "out.ply", "--patches", &name]);
        assert_code(&done, 0);
        let (all, own) = (loaded(&desk, "out.ply"), loaded(&desk, &name));
        let kept = loaded(&desk, "ball.ply").mesh.faces.len();
        assert_eq!(own.mesh.faces.len(), all.mesh.faces.len() - kept, "{name}");
        let found = Inspection::new(&own.mesh).unwrap();
        assert_eq!(found.topology.component_faces.len(), 2, "{name}");
        let has = |name: &str| {
            own.attributes
                .vertex
                .iter()
                .any(|a| a.name.eq_ignore_ascii_case(name))
        };
        let errors = has("isomend_sigma") || has("_isomend_sigma");
        assert_eq!(
            errors,
            ["ply", "vtp", "glb", "usda", "usdz"].contains(&format),
            "{name}"
        );
        if format == "ply" {
            let holes = own
                .attributes
                .face
                .iter()
                .find(|a| a.name == "isomend_hole")
                .unwrap();
            assert!(holes.values.contains(&1.0) && holes.values.contains(&2.0));
        }
    }
    assert_usage(
        &desk.run(&["fill", "ball.ply", "-o", "out.ply", "--patches", "out.ply"]),
        &["the patches", "is the file of the mesh"],
    );
    let done = desk.run(&[
        "fill",
        "ball.ply",
        "-o",
        "out.ply",
        "--patches",
        "p.ply",
        "--json",
        "p.ply",
    ]);
    assert_usage(&done, &["p.ply would overwrite a mesh"]);
    desk.save("dent.ply", &sphere(4), Format::Ply);
    let inside = [
        "restore",
        "ball.ply",
        "-o",
        "out.ply",
        "--mask",
        "dent.ply",
        "--patches",
        "dent.ply",
    ];
    assert_usage(&desk.run(&inside), &["dent.ply", "is the file of a mask"]);
}

/// The piece in `chip.stl`, which is sound.
fn sound_piece(desk: &Desk) -> Mesh {
    let piece = loaded(desk, "chip.stl").mesh;
    let found = Inspection::new(&piece).unwrap();
    let verdict = found.check(&CheckParams::default());
    assert!(verdict.is_sound(), "{}", verdict.line());
    piece
}

#[test]
fn the_missing_piece_is_a_sound_solid_of_the_missing_volume() {
    let desk = Desk::new();
    desk.save("chipped.ply", &chipped(), Format::Ply);
    let restore = [
        "restore",
        "chipped.ply",
        "-o",
        "out.ply",
        "--ball",
        "0,0,0.9,0.55",
        "--piece",
        "chip.stl",
        "--json",
        "out.json",
    ];
    let done = desk.run(&restore);
    assert_code(&done, 0);
    let made = volume(&sound_piece(&desk));
    // The volume of the piece is the volume that is missing, up to the patch's error.
    let missing = volume(&sphere(12)) - volume(&chipped());
    assert!((made / missing - 1.0).abs() < 0.2, "{made} of {missing}");
    let document = desk.json("out.json");
    assert_eq!(document["piece"]["path"], "chip.stl");
    assert_eq!(document["piece"]["sha256"].as_str().unwrap().len(), 64);
    // A bump that is removed leaves no missing piece.
    let mut bump = sphere(12);
    for p in bump
        .positions
        .iter_mut()
        .filter(|p| p.distance(DVec3::Z) < 0.3)
    {
        *p = (*p * 1.1).as_vec3().as_dvec3();
    }
    desk.save("chipped.ply", &bump, Format::Ply);
    let earlier = fs::read(desk.path("chip.stl")).unwrap();
    let done = desk.run(&restore);
    assert_code(&done, 3);
    assert!(text(&done.stderr).contains("no piece was written: the patch is below"));
    // The piece of the run before is no result of this one, but is kept.
    assert!(!desk.path("chip.stl").exists());
    assert_eq!(fs::read(desk.path("chip_earlier.stl")).unwrap(), earlier);
    let reason = &desk.json("out.json")["piece"]["reason"];
    assert!(reason.as_str().unwrap().contains("nothing is missing"));
}

#[test]
fn a_clearance_makes_the_piece_smaller_and_needs_one() {
    let desk = Desk::new();
    desk.save("chipped.ply", &chipped(), Format::Ply);
    let made = |more: &[&str]| {
        let words = [
            "restore",
            "chipped.ply",
            "-o",
            "out.ply",
            "--ball",
            "0,0,0.9,0.55",
        ];
        desk.run(&[&words[..], more].concat())
    };
    let piece = |more: &[&str]| {
        assert_code(&made(&[&["--piece", "chip.stl"], more].concat()), 0);
        volume(&sound_piece(&desk))
    };
    let tight = piece(&[]);
    let loose = piece(&["--clearance", "0.01", "--json", "out.json"]);
    assert!((0.5..0.99).contains(&(loose / tight)), "{loose} of {tight}");
    assert_eq!(desk.json("out.json")["options"]["clearance"], 0.01);
    let refused = |more: &[&str], why: &str| {
        let done = made(more);
        assert_code(&done, 2);
        assert!(text(&done.stderr).contains(why));
    };
    refused(&["--clearance", "0.01"], "--piece");
    for wrong in ["0", "-1", "nan"] {
        let given = format!("--clearance={wrong}");
        refused(&["--piece", "chip.stl", &given], "positive number");
    }
}

#[test]
fn marks_are_written_in_formats_with_colours_and_refused_in_others() {
    let desk = Desk::new();
    for format in ["ply", "obj", "glb", "vtp", "off", "3mf", "usda", "usdz"] {
        let name = format!("out.{format}");
        let done = desk.run(&["fill", "ball.ply", "-o", &name, "--mark", "colour=ff0000"]);
        assert_code(&done, 0);
        let own = loaded(&desk, &name);
        let kept = loaded(&desk, "ball.ply").mesh.positions.len();
        let vertex = own.attributes.vertex.iter();
        let corner = own.attributes.corner.iter().map(|c| &c.pool);
        let all: Vec<_> = vertex.chain(corner).chain(&own.attributes.face).collect();
        let colours = all
            .iter()
            .find(|a| (3..=4).contains(&a.components) && a.role == isomend::Role::Colour);
        let colours = colours.unwrap_or_else(|| panic!("{name} has no colours"));
        let red = |i: usize| {
            colours
                .get(i)
                .is_some_and(|c| c[0] > c[1] && c[1] == 0.0 && c[2] == 0.0)
        };
        assert!((0..colours.len()).any(red), "{name}");
        if format == "ply" {
            assert!(!(0..kept).any(red) && (kept..colours.len()).all(red));
        }
    }
    assert_usage(
        &desk.run(&["fill", "ball.ply", "-o", "out.stl", "--mark", "hatch"]),
        &["STL has no colours", "patches alone"],
    );
    let done = desk.run(&["fill", "ball.ply", "-o", "out.ply", "--mark", "hatch"]);
    assert_code(&done, 0);
    let done = desk.run(&["fill", "ball.ply", "-o", "out.ply", "--mark", "red"]);
    assert_code(&done, 2);
    assert!(text(&done.stderr).contains("'red' is not a mark"));
}

#[test]
fn a_report_with_a_unit_has_hashes_and_errors_and_no_run_times() {
    let desk = Desk::new();
    let fill = |more: &[&str]| {
        let start = [
            "fill", "ball.ply", "-o", "out.ply", "--json", "out.json", "--unit", "mm",
        ];
        desk.run(&[&start[..], more].concat())
    };
    let done = fill(&["--tolerance", "0.5"]);
    assert_code(&done, 0);
    let said = text(&done.stderr);
    assert!(
        said.contains("lengths in mm") && said.contains("mm²"),
        "{said}"
    );
    assert!(!said.contains(" s\n"), "no run time: {said}");
    let document = desk.json("out.json");
    let first = fs::read(desk.path("out.json")).unwrap();
    assert_eq!(document["unit"], "mm");
    for file in ["input", "output"] {
        let path = document[file]["path"].as_str().unwrap();
        let hash = document[file]["sha256"].as_str().unwrap();
        let sum = std::process::Command::new("sha256sum")
            .arg(desk.path(path))
            .output();
        if let Ok(sum) = sum {
            assert!(text(&sum.stdout).starts_with(hash), "{path}");
        }
    }
    let invented = &document["invented"];
    assert_eq!(invented["patches"].as_array().unwrap().len(), 2);
    assert!(invented["percent"].as_f64().unwrap() > 5.0);
    assert_eq!(invented["beyond_tolerance"].as_array().unwrap().len(), 0);
    let done = fill(&["--tolerance", "0.5", "--threads", "1"]);
    assert_code(&done, 0);
    assert_eq!(fs::read(desk.path("out.json")).unwrap(), first);
    // No patch is within this tolerance.
    let done = fill(&["--tolerance", "1e-12"]);
    assert_code(&done, 3);
    assert!(text(&done.stderr).contains("may err by more than"));
    let beyond = &desk.json("out.json")["invented"]["beyond_tolerance"];
    assert!(!beyond.as_array().unwrap().is_empty());
    assert_ne!(
        desk.json("out.json")["options_sha256"],
        document["options_sha256"]
    );
}

#[test]
fn three_mf_keeps_the_unit_and_reports_an_unknown_one() {
    let desk = Desk::new();
    let done = desk.run(&["convert", "ball.ply", "-o", "ball.3mf"]);
    assert_code(&done, 0);
    assert!(text(&done.stderr).contains("millimetres are written"));
    let done = desk.run(&["convert", "ball.ply", "-o", "ball.3mf", "--unit", "in"]);
    assert_code(&done, 0);
    assert_eq!(loaded(&desk, "ball.3mf").attributes.unit, Some(Unit::Inch));
    let done = desk.run(&["fill", "ball.3mf", "-o", "filled.3mf"]);
    assert_code(&done, 0);
    let filled = loaded(&desk, "filled.3mf");
    assert_eq!(filled.attributes.unit, Some(Unit::Inch));
    let kept = loaded(&desk, "ball.ply").mesh.faces.len();
    let is_patch = |f: usize| filled.attributes.is_patch(f);
    assert!(!(0..kept).any(is_patch) && (kept..filled.mesh.faces.len()).all(is_patch));
    fs::write(
        desk.path("bad.3mf"),
        [&b"PK\x03\x04"[..], b"model.model"].concat(),
    )
    .unwrap();
    let done = desk.run(&["inspect", "bad.3mf"]);
    assert_code(&done, 1);
    assert!(text(&done.stderr).contains("ZIP archive is damaged"));
}
