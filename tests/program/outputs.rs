//! What is written where: files that are read stay, errors after writing say so, tables fit the terminal, run times are left out.
#![cfg(unix)]

use std::fs;
use std::process::Stdio;

use isomend::io::Format;

use crate::desk::{Desk, assert_code, assert_usage, text};
use crate::shapes::sphere;

#[test]
fn files_that_are_read_are_not_written_over() {
    let desk = Desk::new();
    let faces: Vec<String> = (0..30).map(|f| f.to_string()).collect();
    desk.text("faces.txt", &faces.join("\n"));
    desk.text("options.toml", "voxel = 0.2\n");
    desk.save("template.ply", &sphere(12), Format::Ply);
    desk.save("mask.ply", &sphere(12), Format::Ply);
    std::os::unix::fs::symlink("faces.txt", desk.path("link.json")).unwrap();
    let cases: [(&[&str], &str); 8] = [
        (
            &[
                "restore",
                "--faces",
                "faces.txt",
                "-o",
                "o.ply",
                "--json",
                "faces.txt",
            ],
            "faces.txt",
        ),
        (
            &[
                "restore",
                "--faces",
                "faces.txt",
                "-o",
                "o.ply",
                "--json",
                "link.json",
            ],
            "link.json",
        ),
        (
            &["restore", "--mask", "mask.ply", "-o", "mask.ply"],
            "mask.ply",
        ),
        (
            &[
                "fair",
                "--mask",
                "mask.ply",
                "-o",
                "o.ply",
                "--patches",
                "mask.ply",
            ],
            "mask.ply",
        ),
        (
            &["fill", "--like", "template.ply", "-o", "template.ply"],
            "template.ply",
        ),
        (
            &[
                "fill",
                "--config",
                "options.toml",
                "-o",
                "o.ply",
                "--json",
                "options.toml",
            ],
            "options.toml",
        ),
        (
            &["inspect", "--config=options.toml", "--json=./options.toml"],
            "options.toml",
        ),
        (
            &["sdf", "-o", "options.toml", "--config", "options.toml"],
            "options.toml",
        ),
    ];
    for (arguments, file) in cases {
        let before = fs::read(desk.path(file)).unwrap();
        let arguments = [&arguments[..1], &["ball.ply"], &arguments[1..]].concat();
        let done = desk.run(&arguments);
        if !text(&done.stderr).contains("--patches") {
            assert_usage(&done, &[file]);
        }
        assert_eq!(fs::read(desk.path(file)).unwrap(), before, "{arguments:?}");
    }
    // The mesh itself may be replaced, also where it is the template of its own counterpart.
    let done = desk.run(&[
        "fill", "ball.ply", "-o", "ball.ply", "--like", "ball.ply", "--voxel", "0.2",
    ]);
    assert!(
        matches!(done.status.code(), Some(0 | 3)),
        "{}",
        text(&done.stderr)
    );
}

#[test]
fn contradictions_and_incomplete_options_are_wrong_usage_in_words_of_the_command_line() {
    let desk = Desk::new();
    let cases: [(&[&str], &[&str]); 6] = [
        (&["repair", "--wall", "0.1"], &["--wall", "--close-borders"]),
        (
            &["fill", "--holes", "1", "--keep-open", "1"],
            &["--holes", "--keep-open"],
        ),
        (
            &["fill", "--flat", "2", "--keep-open", "2"],
            &["--flat", "--keep-open"],
        ),
        (
            &["fill", "--bridge", "1+2", "--keep-open", "2"],
            &["--bridge", "--keep-open"],
        ),
        (
            &["repair", "--base-offset", "1"],
            &["--base-offset", "--flat-base"],
        ),
        (
            &["fill", "--grain", "--finish", "none"],
            &["--grain", "--finish"],
        ),
    ];
    let far = desk.run(&[
        "repair",
        "ball.ply",
        "-o",
        "o.ply",
        "--flat-base",
        "--base-offset",
        "1e300",
    ]);
    assert_usage(&far, &["--base-offset", "thousand times"]);
    for (arguments, words) in cases {
        let arguments = [
            &arguments[..1],
            &["ball.ply", "-o", "o.ply"],
            &arguments[1..],
        ]
        .concat();
        assert_usage(&desk.run(&arguments), words);
        assert!(!desk.path("o.ply").exists(), "{arguments:?}");
    }
}

#[test]
fn an_error_after_writing_names_what_was_written() {
    if !std::path::Path::new("/dev/full").exists() {
        return;
    }
    let desk = Desk::new();
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let program = assert_cmd::cargo::cargo_bin("isomend");
    let done = std::process::Command::new(program)
        .current_dir(desk.0.path())
        .args([
            "fill", "ball.ply", "-o", "o.ply", "-q", "--json", "-", "--voxel", "0.2",
        ])
        .stdout(Stdio::from(full))
        .output()
        .unwrap();
    assert_code(&done, 1);
    let said = text(&done.stderr);
    assert!(
        said.contains("standard output") && said.contains("written before: o.ply"),
        "{said}"
    );
    assert!(desk.path("o.ply").exists());
}

#[test]
fn a_reader_that_has_enough_is_told_by_the_exit_code_only() {
    let desk = Desk::new();
    let program = assert_cmd::cargo::cargo_bin("isomend");
    let mut child = std::process::Command::new(program)
        .current_dir(desk.0.path())
        .args(["convert", "ball.ply", "-o", "-", "--to", "obj", "-q"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let done = child.wait_with_output().unwrap();
    assert_code(&done, 141);
    assert_eq!(text(&done.stderr), "");
}

#[test]
fn many_threads_cost_no_more_than_a_few() {
    let desk = Desk::new();
    let done = desk.run(&[
        "fill",
        "ball.ply",
        "-o",
        "o.ply",
        "--threads",
        "1024",
        "--voxel",
        "0.2",
    ]);
    assert_code(&done, 0);
    let many = fs::read(desk.path("o.ply")).unwrap();
    assert_code(
        &desk.run(&[
            "fill",
            "ball.ply",
            "-o",
            "o.ply",
            "--threads",
            "1",
            "--voxel",
            "0.2",
        ]),
        0,
    );
    assert_eq!(fs::read(desk.path("o.ply")).unwrap(), many);
}

#[test]
fn tables_fit_the_terminal() {
    let desk = Desk::new();
    let mut far = crate::desk::ball();
    far.positions
        .iter_mut()
        .for_each(|p| *p = 123.456 * *p - 1234.5);
    desk.save("far.ply", &far, Format::Ply);
    let ball = "--ball=-1234.5,-1234.5,-1111.044,60";
    let commands: [&[&str]; 9] = [
        &["inspect", "far.ply"],
        &["inspect", "far.ply", "ball.ply"],
        &["check", "far.ply"],
        &["compare", "far.ply", "ball.ply"],
        &["fill", "far.ply", "-o", "o.ply", "--voxel", "20", "-v"],
        &["repair", "far.ply", "-o", "o.ply", "--voxel", "20"],
        &["restore", "far.ply", "-o", "o.ply", "--voxel", "20", ball],
        &["fair", "far.ply", "-o", "o.ply", "--strength", "20", ball],
        &["convert", "far.ply", "-o", "o.stl"],
    ];
    for command in commands {
        for columns in [60, 80, 100] {
            let mut run = desk.command(command);
            let done = run.env("COLUMNS", columns.to_string()).output().unwrap();
            let said = text(&done.stdout) + &text(&done.stderr);
            for row in said.lines() {
                assert!(
                    row.chars().count() <= columns,
                    "{command:?} at {columns}: {row:?} in\n{said}"
                );
            }
            assert!(!said.contains(".00000") && !said.contains("e0"), "{said}");
        }
    }
}

#[test]
fn archived_reports_have_no_run_times() {
    let desk = Desk::new();
    let done = desk.run(&[
        "fill", "ball.ply", "-o", "o.ply", "--json", "r.json", "--unit", "mm", "-v",
    ]);
    assert_code(&done, 0);
    let report = fs::read_to_string(desk.path("r.json")).unwrap();
    assert!(
        !report.contains("seconds") && report.contains("\"levels\""),
        "{report}"
    );
    let said = text(&done.stderr);
    assert!(!said.contains("0.00 s"), "{said}");
    assert_code(
        &desk.run(&["fill", "ball.ply", "-o", "o.ply", "--json", "r.json"]),
        0,
    );
    let report = desk.json("r.json");
    assert!(report["seconds"].as_f64().unwrap() > 0.0);
    assert!(
        report["regions"][0]["levels"][0]["seconds"].is_array(),
        "{report}"
    );
}
