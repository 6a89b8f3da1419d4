//! Messages on mistakes in options and masks, and the table of `inspect` at any scale.

use std::fs;

use glam::DVec3;
use isomend::io::{Format, WriteOptions, write_path};
use serde_json::{Value, json};

use crate::desk::{Desk, assert_code, assert_usage, ball, text};
use crate::shapes;

#[test]
fn holes_are_listed_with_normals_and_heights_in_aligned_columns_at_any_scale() {
    let desk = Desk::new();
    for scale in [1.0, 1e31, 1e-20] {
        let mut mesh = ball();
        mesh.positions.iter_mut().for_each(|p| *p *= scale);
        desk.save("scaled.obj", &mesh, Format::Obj);
        let done = desk.run(&["inspect", "scaled.obj", "--json", "r.json"]);
        assert_code(&done, 0);
        let table = text(&done.stdout);
        let lines: Vec<&str> = table.lines().collect();
        assert!(lines[2].starts_with("bounds: from "), "{table}");
        assert!(lines.iter().all(|l| l.len() < 200), "{table}");
        let is_heading = |line: &&str| line.contains("planarity");
        let at = lines.iter().position(is_heading).unwrap();
        let ends = |name: &str| lines[at].find(name).unwrap() + name.len();
        for row in &lines[at + 1..] {
            for name in ["hole", "edges", "length", "diameter", "height", "planarity"] {
                let (cell, next) = (&row[..ends(name)], row.as_bytes()[ends(name)]);
                assert!(!cell.ends_with(' ') && next == b' ', "{name} in\n{table}");
            }
            let column = lines[at].find("normal").unwrap();
            assert!(
                row[..column].ends_with("  ") && !row[column..].starts_with(' '),
                "{table}"
            );
        }
        let report = desk.json("r.json");
        for hole in report["holes"].as_array().unwrap() {
            let of = |key: &str| -> Vec<f64> { serde_json::from_value(hole[key].clone()).unwrap() };
            let (normal, centre) = (
                DVec3::from_slice(&of("normal")),
                DVec3::from_slice(&of("centre")),
            );
            // The normal points out of the ball.
            assert!(normal.dot(centre) > 0.99 * centre.length(), "{hole}");
            let height = hole["height"].as_f64().unwrap() / scale;
            assert!(height > 0.0 && height < 0.2, "{hole}");
        }
    }
}

#[test]
fn what_the_options_alone_show_is_wrong_usage() {
    let desk = Desk::new();
    desk.save("ball.ply", &ball(), Format::Ply);
    let cases: [(&[&str], &str); 7] = [
        (&["restore"], "no region is marked"),
        (&["restore", "--grow", "1"], "no mask is given"),
        (&["fair", "--shrink", "1"], "no mask is given"),
        (&["fill", "--report", "r.ply"], "wrong extension"),
        (&["fill", "--picture", "r.ply"], "wrong extension"),
        (
            &["fill", "--json", "o.ply"],
            "--json: the document o.ply would overwrite a mesh",
        ),
        (
            &["fill", "--json", "r.html", "--report", "r.html"],
            "file of --json too",
        ),
    ];
    for (words, expected) in cases {
        let arguments = [words, &["ball.ply", "-o", "o.ply"]].concat();
        assert_usage(&desk.run(&arguments), &[expected]);
    }
    assert_eq!(desk.files(), ["ball.ply"]);
}

#[test]
fn a_mask_that_marks_nothing_reports_the_bounds_of_the_mesh() {
    let desk = Desk::new();
    let bounds = "the mesh reaches from -1, -1, -1 to 0.9";
    let cases: [(&[&str], &[&str]); 4] = [
        (
            &["--ball", "3,0,0,0.5"],
            &[
                bounds,
                "nearest to the centre of the ball at 3, 0, 0",
                "away",
            ],
        ),
        (
            &["--box", "2,2,2,3,3,3"],
            &[bounds, "nearest to the box is 0.5"],
        ),
        (
            &["--ball", "0,0,-1,0.3", "--shrink", "5"],
            &["shrink it less"],
        ),
        (&["--ball", "0,-1,0,1e-6"], &[bounds, "centroid of no face"]),
    ];
    for (mask, words) in cases {
        let restore = [&["restore", "ball.ply", "-o", "out.ply"], mask].concat();
        let fair = [&["fair", "ball.ply", "-o", "out.ply"], mask].concat();
        for arguments in [&restore, &fair] {
            let done = desk.run(arguments);
            assert_code(&done, 1);
            let said = text(&done.stderr);
            assert_eq!(said.lines().count(), 1, "{said}");
            for word in words {
                assert!(said.contains(word), "{word}: {said}");
            }
        }
        let done = desk.run(&[&["inspect", "ball.ply"], mask].concat());
        assert_code(&done, 0);
        let table = text(&done.stdout);
        let line = table.lines().last().unwrap();
        assert!(line.starts_with("mask: no faces: "), "{table}");
        assert!(words.iter().all(|word| line.contains(word)), "{table}");
    }
    let mut far = shapes::sphere(4);
    far.positions.iter_mut().for_each(|p| p.z += 4.0);
    write_path(&desk.path("far.ply"), &far, None, &WriteOptions::default()).unwrap();
    let done = desk.run(&["restore", "ball.ply", "--dry-run", "--mask", "far.ply"]);
    assert_code(&done, 1);
    let said = text(&done.stderr);
    assert!(
        said.contains("the mask's own bounds") && said.contains("2.149"),
        "{said}"
    );
    assert_eq!(desk.files(), ["ball.ply", "far.ply"]);
}

#[test]
fn masks_without_a_match_list_the_colours_and_materials_of_the_file() {
    let desk = Desk::new();
    let text_of = "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nv 1 1 0 0 0.5019608 0\nusemtl skin\nf 1 2 3\nf 2 4 3\n";
    desk.text("painted.obj", text_of);
    let said = |mask: &[&str]| {
        let done = desk.run(&[&["restore", "painted.obj", "--dry-run"], mask].concat());
        assert_code(&done, 1);
        text(&done.stderr)
    };
    let colour = said(&["--colour", "0000ff"]);
    assert!(
        colour.contains("ff0000 (3 vertices), 008000 (1 vertices)"),
        "{colour}"
    );
    let material = said(&["--material", "bone"]);
    assert!(material.contains("'skin'"), "{material}");
}

#[test]
fn numbers_out_of_bounds_are_refused_with_the_bounds() {
    let desk = Desk::new();
    let fill = |option: &str| desk.run(&["fill", "ball.ply", "-o", "out.ply", option]);
    let long = "18446744073709551615";
    for value in [long, "0", "99999999999999999999"] {
        let done = fill(&format!("--threads={value}"));
        assert_code(&done, 2);
        assert!(text(&done.stderr).contains("from 1 to"), "{value}");
    }
    assert!(text(&fill("--threads=100000").stderr).contains("to 1024"));
    let done = desk.run(&["compare", "ball.ply", "ball.ply", "--samples", long]);
    assert_code(&done, 2);
    assert!(text(&done.stderr).contains("from 1 to 100000000"));
    assert_eq!(desk.files(), ["ball.ply"]);
}

#[test]
fn invalid_voxels_are_refused_with_a_valid_one() {
    let desk = Desk::new();
    let refused = |arguments: &[&str], words: &[&str]| {
        let done = desk.run(arguments);
        assert_code(&done, 1);
        let said = text(&done.stderr);
        assert!(said.len() < 300, "{said}");
        for word in words {
            assert!(said.contains(word), "{word}: {said}");
        }
    };
    // The wide hole is slightly more than 2 sin 35 degrees across, and at most 1024 voxels fit across it.
    let fits: &[&str] = &["1.000e-300", "the smallest that fits is about 0.0012"];
    refused(
        &["fill", "ball.ply", "-o", "out.ply", "--voxel", "1e-300"],
        fits,
    );
    refused(
        &["fill", "ball.ply", "--dry-run", "--voxel", "1e-300"],
        fits,
    );
    let restore = [
        "restore",
        "ball.ply",
        "-o",
        "out.ply",
        "--ball",
        "0,0,-1,0.3",
        "--voxel",
        "1e-9",
    ];
    refused(&restore, &["smallest that fits"]);
    refused(
        &[&restore[..], &["--keep-shape", "0.5"]].concat(),
        &["smallest that fits"],
    );
    for voxel in ["1e300", "9"] {
        refused(
            &["sdf", "ball.ply", "-o", "out.vti", "--voxel", voxel],
            &["larger than the model"],
        );
    }
    refused(
        &["sdf", "ball.ply", "-o", "out.vti", "--voxel", "1e-300"],
        &["1.000e-300", "smallest"],
    );
    let closed = shapes::sphere(6);
    desk.save("closed.ply", &closed, Format::Ply);
    for option in [
        ["--voxel", "1e300"],
        ["--strength", "1e30"],
        ["--time", "1e300"],
    ] {
        refused(
            &[&["fair", "closed.ply", "-o", "out.ply"], &option[..]].concat(),
            &["too large"],
        );
    }
    refused(
        &[
            "fair",
            "closed.ply",
            "-o",
            "out.ply",
            "--voxel",
            "0.1",
            "--time",
            "1e300",
        ],
        &["a strength of", "too large"],
    );
    assert_eq!(desk.files(), ["ball.ply", "closed.ply"]);
    // A voxel that fits the chosen hole is accepted, whatever the other holes would need.
    let narrow = [
        "fill",
        "ball.ply",
        "--dry-run",
        "--voxel",
        "0.001",
        "--holes",
        "2",
    ];
    assert_code(&desk.run(&narrow), 0);
}

#[test]
fn former_options_are_refused_with_what_takes_their_place() {
    let desk = Desk::new();
    let of = |command: &str, option: &[&str]| {
        desk.run(&[&[command, "ball.ply", "-o", "o.ply"], option].concat())
    };
    assert_usage(
        &of("fill", &["--repair"]),
        &["--repair", "`isomend repair`"],
    );
    assert_usage(&of("repair", &["--keep-holes"]), &["--skip holes"]);
    assert_usage(
        &of("restore", &["--like-scale=1"]),
        &["--like-scale", "--like"],
    );
    desk.text("old.toml", "[repair]\nkeep-crossings = true\n");
    let configured = of("repair", &["--config", "old.toml"]);
    assert_usage(&configured, &["old.toml, line 2", "--skip intersections"]);
    let unknown = of("repair", &["--skip", "holes,hole"]);
    assert_code(&unknown, 2);
    let said = text(&unknown.stderr);
    assert!(
        said.contains("'hole' is none of duplicates, orientation, non-manifold"),
        "{said}"
    );
    let both = of("repair", &["--skip", "holes", "--close-borders"]);
    assert_usage(&both, &["--close-borders", "--skip"]);
    desk.text(
        "new.toml",
        "[repair]\nskip = [\"holes\", \"orientation\"]\n",
    );
    let skipped = of(
        "repair",
        &["--config", "new.toml", "-q", "--json", "r.json"],
    );
    assert_code(&skipped, 3);
    assert_eq!(
        desk.json("r.json")["options"]["work"]["repair"]["skip"],
        json!(["holes", "orientation"])
    );
}

#[test]
fn options_without_effect_are_refused() {
    let desk = Desk::new();
    let trial = ["fill", "ball.ply", "--dry-run"];
    for drawing in [["--report", "a.html"], ["--picture", "a.png"]] {
        assert_usage(
            &desk.run(&[&trial[..], &drawing].concat()),
            &["--dry-run", drawing[0]],
        );
    }
    assert_usage(
        &desk.run(&["fill", "ball.ply", "-o", "out.glb", "--ascii"]),
        &["--ascii", "gltf has"],
    );
    assert_usage(
        &desk.run(&["fill", "ball.ply", "-o", "out/", "--to", "vtp", "--ascii"]),
        &["--ascii", "vtk has"],
    );
    assert_code(
        &desk.run(&["sdf", "ball.ply", "-o", "ball.vti", "--voxel", "0.3", "-q"]),
        0,
    );
    let surface = ["surface", "ball.vti", "-o", "out.stl", "--f64"];
    assert_usage(&desk.run(&surface), &["--f64", "STL"]);
    assert_eq!(desk.files(), ["ball.ply", "ball.vti"]);
    let named = [
        "fill",
        "ball.ply",
        "--dry-run",
        "--holes",
        "2",
        "--max-diameter",
        "0.1",
    ];
    let done = desk.run(&named);
    assert_code(&done, 0);
    assert!(text(&done.stderr).contains("--max-diameter has no effect"));
    // Formats with a text form accept `--ascii`.
    for name in ["text.obj", "text.gltf", "text.vtk"] {
        assert_code(
            &desk.run(&["fill", "ball.ply", "-o", name, "--ascii", "-q"]),
            0,
        );
    }
}

#[test]
fn an_inspected_mesh_is_drawn_with_its_holes() {
    let desk = Desk::new();
    let done = desk.run(&[
        "inspect",
        "ball.ply",
        "--report",
        "a.html",
        "--picture",
        "a.png",
        "--json",
        "-",
    ]);
    assert_code(&done, 0);
    let report: Value = serde_json::from_slice(&done.stdout).unwrap();
    let page = fs::read_to_string(desk.path("a.html")).unwrap();
    let data = page
        .split("id=\"data\">")
        .nth(1)
        .unwrap()
        .split("</script>")
        .next()
        .unwrap();
    let data: Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["single"], true);
    assert_eq!(
        data["holes"].as_array().map(Vec::len),
        report["holes"].as_array().map(Vec::len)
    );
    assert_eq!(data["scene"]["new"], 0);
    assert!(
        data["scene"]["origin"]
            .as_array()
            .is_some_and(|o| o.len() == 3)
    );
    assert!(
        page.contains("<li class=\"left\">2 open</li>")
            && page.contains("<body class=\"inspect\">")
    );
    assert!(
        fs::read(desk.path("a.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    for (drawing, word) in [
        (&["--report", "a.txt"][..], ".html"),
        (&["--picture", "ball.ply"], ".png"),
        (&["--report", "b.html", "--json", "b.html"], "--json too"),
    ] {
        let done = desk.run(&[&["inspect", "ball.ply"], drawing].concat());
        assert_usage(&done, &[word]);
    }
    assert_eq!(desk.files(), ["a.html", "a.png", "ball.ply"]);
}
