//! The command line's option files (`--config`), dry runs, and colours in terminals.

use std::fs;

use isomend::io::Format;
use serde_json::Value;

use crate::desk::{Desk, assert_code, assert_usage, text};

fn outcomes(report: &Value) -> Vec<&str> {
    let holes = report["holes"].as_array().unwrap();
    holes
        .iter()
        .map(|h| h["outcome"].as_str().unwrap())
        .collect()
}

#[test]
fn an_option_file_sets_options_that_the_command_line_omits() {
    let desk = Desk::new();
    let options = "voxel = 0.08\nquiet = true\ncolour = 'ff0000'\n\n[fill]\nholes = [2]\n\n[restore]\nvoxel = 0.5\n";
    desk.text("options.toml", options);
    let fill = ["fill", "ball.ply", "-o", "out.ply", "--json", "report.json"];
    let with_file = [&fill[..], &["--config", "options.toml"]].concat();
    let done = desk.run(&with_file);
    assert_code(&done, 0);
    assert_eq!(text(&done.stderr), "");
    let report = desk.json("report.json");
    assert_eq!(outcomes(&report), ["left", "closed"]);
    assert_eq!(report["regions"][0]["voxel"], 0.08);
    // Options of the command line override the file; `-v` overrides `quiet`, which it excludes.
    let done = desk.run(&[&with_file[..], &["--holes=1", "--voxel", "0.1", "-v"]].concat());
    assert_code(&done, 0);
    assert!(text(&done.stderr).contains("options from options.toml"));
    let report = desk.json("report.json");
    assert_eq!(outcomes(&report), ["closed", "left"]);
    assert_eq!(report["regions"][0]["voxel"], 0.1);
}

#[test]
fn an_option_file_may_hold_paths_and_lists() {
    let desk = Desk::new();
    fs::create_dir(desk.path("sub")).unwrap();
    let options = "[restore]\noutput = 'out.ply'\njson = 'r.json'\nball = [[0, 0, -1, 0.3], [0, -1.0, 0, 3e-1]]\n\
                   [fill]\noutput = '-'\nto = 'stl'\nbridge = ['1+2']\nascii = false\n";
    desk.text("sub/options.toml", options);
    assert_code(
        &desk.run(&["restore", "ball.ply", "--config=sub/options.toml"]),
        0,
    );
    assert!(desk.path("sub/out.ply").exists());
    assert_eq!(
        desk.json("sub/r.json")["regions"].as_array().unwrap().len(),
        2
    );
    // A list on the command line replaces the whole list of the file.
    let done = desk.run(&[
        "restore",
        "ball.ply",
        "--ball=0,0,-1,0.3",
        "--config=sub/options.toml",
    ]);
    assert_code(&done, 0);
    assert_eq!(
        desk.json("sub/r.json")["regions"].as_array().unwrap().len(),
        1
    );
    let done = desk.run(&["fill", "ball.ply", "--config", "sub/options.toml"]);
    assert_code(&done, 0);
    assert_eq!(Format::sniff(&done.stdout).unwrap(), Some(Format::Stl));
    // One region, in which each hole got a patch of its own.
    assert_eq!(text(&done.stderr).matches(" 1, 2 ").count(), 1);
}

#[test]
fn mistakes_in_an_option_file_are_reported_with_their_line() {
    let desk = Desk::new();
    for (options, words) in [
        (
            "[fill]\n\nvoxels = 1",
            &["line 3", "'voxels'", "voxel,"][..],
        ),
        ("voxle = 1", &["line 1", "'voxle' of any command"]),
        ("# all\nvoxel = 'big'", &["line 2", "--voxel", "'big'"]),
        ("voxel = true", &["line 1", "'voxel'", "number"]),
        ("\nascii = 1", &["line 2", "'ascii'", "true or false"]),
        ("holes = [[1], 'x']", &["line 1", "'holes'"]),
        (
            "max-diameter = -2",
            &["line 1", "--max-diameter", "positive"],
        ),
        ("sharp = 'half'", &["line 1", "auto, off"]),
        ("[fil]\nvoxel = 1", &["line 1", "'fil'"]),
        ("voxel = 1\nvoxel = 2", &["line 2"]),
        ("voxel =", &["line 1"]),
        ("config = 'other.toml'", &["line 1", "'config'"]),
        ("[sdf]\nvoxels = 1", &["line 2", "isomend sdf"]),
    ] {
        desk.text("options.toml", options);
        let done = desk.run(&[
            "fill",
            "ball.ply",
            "-o",
            "out.ply",
            "--config",
            "options.toml",
        ]);
        assert_usage(&done, &[&["options.toml"], words].concat());
    }
    let done = desk.run(&["fill", "ball.ply", "-o", "out.ply", "--config", "none.toml"]);
    assert_usage(&done, &["none.toml"]);
    assert_eq!(desk.files(), ["ball.ply", "options.toml"]);
}

#[test]
fn a_dry_run_reports_what_would_be_filled_and_writes_nothing() {
    let desk = Desk::new();
    let done = desk.run(&["fill", "ball.ply", "--dry-run", "--max-diameter", "0.9"]);
    assert_code(&done, 0);
    assert_eq!(text(&done.stderr), "");
    let said = text(&done.stdout);
    for words in [
        "hole 2: would be filled",
        "hole 1: would be left open: wider",
        "nodes",
        "1 of 2 holes would be",
    ] {
        assert!(said.contains(words), "{said}");
    }
    let done = desk.run(&["fill", "ball.ply", "--dry-run", "--flat", "2"]);
    let said = text(&done.stdout);
    assert!(
        said.contains("hole 2: would be closed by a flat cap"),
        "{said}"
    );
    let done = desk.run(&[
        "fill",
        "ball.ply",
        "-o",
        "out.ply",
        "--dry-run",
        "--json",
        "-",
        "--holes",
        "1",
    ]);
    let plan: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(plan["dry_run"], true);
    assert_eq!(outcomes(&plan), ["would_be_closed", "left"]);
    assert_eq!(desk.files(), ["ball.ply"]);
    // The run does what the dry run reported.
    let fill = [
        "fill",
        "ball.ply",
        "-o",
        "out.ply",
        "--json",
        "report.json",
        "--holes",
        "1",
    ];
    assert_code(&desk.run(&fill), 0);
    let report = desk.json("report.json");
    for field in ["id", "holes", "diameter", "bridge"] {
        assert_eq!(
            plan["regions"][0][field], report["regions"][0][field],
            "{field}"
        );
    }
    assert_same_voxel(&plan, &report);
    let unknown = desk.run(&["fill", "ball.ply", "--dry-run", "--holes", "9"]);
    assert_code(&unknown, 1);
    assert!(text(&unknown.stderr).contains("no hole 9"));
}

#[test]
fn a_dry_run_of_restore_reports_what_would_be_cut_out() {
    let desk = Desk::new();
    let mask = [
        "restore",
        "ball.ply",
        "--ball",
        "0,0,-1,0.6",
        "--json",
        "plan.json",
    ];
    let done = desk.run(&[&mask[..], &["--dry-run"]].concat());
    assert_code(&done, 0);
    assert!(text(&done.stdout).contains("would be cut out"));
    let plan = desk.json("plan.json");
    assert_code(&desk.run(&[&mask[..], &["-o", "out.ply"]].concat()), 0);
    let report = desk.json("plan.json");
    for field in [
        "marked_faces",
        "removed_faces",
        "removed_vertices",
        "vertices",
        "faces",
    ] {
        assert_eq!(plan[field], report[field], "{field}");
    }
    assert_same_voxel(&plan, &report);
    let reasons: Vec<&Value> = plan["holes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|h| &h["reason"])
        .collect();
    assert_eq!(
        reasons
            .iter()
            .filter(|r| **r == "not in the marked region")
            .count(),
        2
    );
    let border = desk.run(&["restore", "ball.ply", "--dry-run", "--ball", "9,9,9,0.1"]);
    assert_code(&border, 1);
}

#[test]
fn output_is_coloured_in_terminals_only_unless_the_environment_says_otherwise() {
    let desk = Desk::new();
    let table = |environment: &[(&str, &str)]| {
        let mut command = desk.command(&["inspect", "ball.ply"]);
        command.envs(environment.iter().copied());
        command.output().unwrap().stdout
    };
    let plain = table(&[]);
    assert!(!plain.contains(&0x1b));
    let coloured = table(&[("CLICOLOR_FORCE", "1")]);
    assert!(coloured.contains(&0x1b) && coloured.len() > plain.len());
    assert_eq!(table(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]), plain);
    assert_eq!(table(&[("CLICOLOR_FORCE", "")]), plain);
    assert_eq!(table(&[("CLICOLOR", "0")]), plain);
    // JSON and meshes are never coloured; errors are.
    let mut command = desk.command(&["inspect", "none.ply", "--json", "-"]);
    let done = command.env("CLICOLOR_FORCE", "1").output().unwrap();
    assert!(done.stderr.starts_with(b"\x1b["), "{}", text(&done.stderr));
    let mut command = desk.command(&["inspect", "ball.ply", "--json", "-"]);
    let done = command.env("CLICOLOR_FORCE", "1").output().unwrap();
    assert!(!done.stdout.contains(&0x1b));
}

/// Asserts that the voxel of the first region is the same up to rounding: regions are solved in units of their own.
fn assert_same_voxel(plan: &Value, report: &Value) {
    let voxel = |document: &Value| document["regions"][0]["voxel"].as_f64().unwrap();
    assert!((voxel(plan) / voxel(report) - 1.0).abs() < 1e-6);
}
