//! Standard input and output, several inputs, and conversions.

use std::fs;
use std::io::Read;
use std::process::Stdio;

use isomend::io::{Format, read_path};
use serde_json::Value;

use crate::desk::{Desk, assert_code, assert_usage, ball, bytes, text};
use crate::shapes::unfillable;

#[test]
fn meshes_go_through_standard_input_and_output() {
    let desk = Desk::new();
    let small = ["--holes", "2"];
    let done = desk.run(&[&["fill", "ball.ply", "-o", "out.stl"], &small[..]].concat());
    assert_code(&done, 0);
    for format in [
        Format::Ply,
        Format::Obj,
        Format::Stl,
        Format::Vtk,
        Format::Vtp,
        Format::Glb,
        Format::Gltf,
    ] {
        let mut command = desk.command(&["fill", "-", "-o", "-", "--to", "stl", "--holes", "2"]);
        let done = command
            .write_stdin(bytes(&ball(), format))
            .output()
            .unwrap();
        assert_code(&done, 0);
        assert!(text(&done.stderr).contains("1 of 2 holes closed (1 by the level set)"));
        if format == Format::Ply {
            assert_eq!(done.stdout, fs::read(desk.path("out.stl")).unwrap());
        }
        let done = desk.run(&[
            "fill",
            "ball.ply",
            "--output=-",
            "--to",
            format.extension(),
            "--holes=2",
        ]);
        assert_code(&done, 0);
        let name = format!("back.{format}");
        fs::write(desk.path(&name), &done.stdout).unwrap();
        let back = read_path(&desk.path(&name), Some(format)).unwrap();
        assert!(back.mesh.faces.len() > ball().faces.len());
    }
}

#[test]
fn the_other_commands_read_standard_input_too() {
    let desk = Desk::new();
    let pipe = |arguments: &[&str], input: Vec<u8>| {
        let done = desk.command(arguments).write_stdin(input).output().unwrap();
        assert_code(&done, 0);
        done.stdout
    };
    let ply = || bytes(&ball(), Format::Ply);
    assert!(text(&pipe(&["inspect", "-"], ply())).contains("2 holes"));
    assert!(
        text(&pipe(
            &["compare", "ball.ply", "-", "--samples", "100"],
            ply()
        ))
        .contains("A to B")
    );
    let report: Value =
        serde_json::from_slice(&pipe(&["inspect", "-", "--json", "-"], ply())).unwrap();
    assert_eq!(report["input"]["path"], "-");
    let volume = pipe(&["sdf", "-", "-o", "-", "--voxel", "0.2"], ply());
    assert!(volume.starts_with(b"<?xml"));
    let surface = pipe(&["surface", "-", "-o", "-", "--to", "obj"], volume);
    assert!(text(&surface).lines().any(|line| line.starts_with("f ")));
    let restored = pipe(
        &[
            "restore",
            "-",
            "-o",
            "-",
            "--to",
            "ply",
            "--ball",
            "0,0,-1,0.3",
        ],
        ply(),
    );
    assert!(restored.starts_with(b"ply"));
}

#[test]
fn invalid_uses_of_standard_input_and_output_are_refused() {
    let desk = Desk::new();
    assert_usage(&desk.run(&["fill", "ball.ply", "-o", "-"]), &["--to"]);
    let both = ["fill", "ball.ply", "-o", "-", "--to", "ply", "--json", "-"];
    assert_usage(&desk.run(&both), &["--json", "--output"]);
    let both = ["sdf", "ball.ply", "-o", "-", "--json", "-"];
    assert_usage(&desk.run(&both), &["--json"]);
    assert_usage(&desk.run(&["compare", "-", "-"]), &["standard input"]);
    assert_usage(
        &desk.run(&["fill", "-", "ball.ply", "-o", "out/"]),
        &["standard input"],
    );
    assert_usage(&desk.run(&["fill", "-", "-o", "out/"]), &["no name"]);
    let refused = |input: &[u8], words: &[&str]| {
        let mut command = desk.command(&["fill", "-", "-o", "out.ply"]);
        let done = command.write_stdin(input).output().unwrap();
        assert_code(&done, 1);
        let said = text(&done.stderr);
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    };
    refused(b"", &["standard input is empty"]);
    refused(b"hello", &["standard input", "--from"]);
    refused(
        b"ply\nformat ascii 1.0\n",
        &["standard input", "end_header"],
    );
    let gltf = br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"points.bin"}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"count":3,"componentType":5126,"type":"VEC3"}]}"#;
    refused(gltf, &["standard input", "points.bin", "GLB"]);
    assert_eq!(desk.files(), ["ball.ply"]);
}

#[test]
fn a_closed_reader_gives_a_code_for_a_mesh_and_none_for_text() {
    let (code, said) = without_reader(&["fill", "ball.ply", "-o", "-", "--to", "obj", "-q"]);
    assert_eq!((code, &said[..]), (Some(141), ""));
    let (code, said) = without_reader(&["inspect", "ball.ply", "-q"]);
    assert_eq!((code, &said[..]), (Some(0), ""));
}

#[cfg(unix)]
#[test]
fn a_closed_standard_output_is_an_error_for_a_mesh() {
    let desk = Desk::new();
    let run = |end: &str| {
        let line = format!("exec \"$0\" fill ball.ply -o - --to ply --holes 2 -q {end}");
        let program = assert_cmd::cargo::cargo_bin!("isomend");
        let done = std::process::Command::new("sh")
            .current_dir(desk.0.path())
            .args(["-c", &line])
            .arg(program)
            .output()
            .unwrap();
        (done.status.code(), text(&done.stderr))
    };
    let (code, said) = run(">&-");
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("standard output") && said.contains("closed"),
        "{said}"
    );
    assert_eq!(run("> /dev/null"), (Some(0), text(b"")));
}

/// The exit code and the text on standard error if the reader of standard output has closed it.
fn without_reader(arguments: &[&str]) -> (Option<i32>, String) {
    let desk = Desk::new();
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("isomend"))
        .current_dir(desk.0.path())
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut said = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    (child.wait().unwrap().code(), said)
}

#[test]
fn several_inputs_are_written_to_a_folder_under_their_names() {
    let desk = Desk::new();
    desk.save("b.obj", &ball(), Format::Obj);
    desk.text("bad.ply", "ply\n");
    let inputs = ["fill", "ball.ply", "bad.ply", "b.obj", "--json", "all.json"];
    let done = desk.run(&[&inputs[..], &["-o", "new/"]].concat());
    assert_code(&done, 1);
    let said = text(&done.stderr);
    for words in [
        "ball.ply -> new/ball.ply",
        "isomend: bad.ply: PLY",
        "3 files: 2 done, 1 failed",
    ] {
        assert!(said.contains(words), "{said}");
    }
    let reports = desk.json("all.json");
    let of = |i: usize| &reports[i];
    assert_eq!(reports.as_array().unwrap().len(), 3);
    assert_eq!(of(0)["output"]["path"], "new/ball.ply");
    assert_eq!(
        (&of(1)["input"]["path"], of(1).get("holes")),
        (&"bad.ply".into(), None)
    );
    assert!(of(1)["error"].as_str().unwrap().contains("end_header"));
    assert_eq!(of(2)["output"]["format"], "obj");
    assert_code(&desk.run(&["fill", "ball.ply", "-o", "one.ply"]), 0);
    let (one, batch) = (
        fs::read(desk.path("one.ply")),
        fs::read(desk.path("new/ball.ply")),
    );
    assert_eq!(one.unwrap(), batch.unwrap());
    // An existing folder and a single input: the report is not a list.
    let done = desk.run(&[
        "fill", "b.obj", "-o", "new", "--to", "stl", "--json", "one.json",
    ]);
    assert_code(&done, 0);
    assert!(desk.path("new/b.stl").exists());
    assert_eq!(desk.json("one.json")["output"]["path"], "new/b.stl");
}

#[test]
fn the_exit_code_of_several_inputs_is_the_most_serious_one() {
    let desk = Desk::new();
    // A hole with diagonals that are already edges cannot be filled.
    desk.save("part.ply", &unfillable(), Format::Ply);
    let done = desk.run(&["fill", "ball.ply", "part.ply", "-o", "out/", "-q"]);
    assert_code(&done, 3);
    assert!(
        text(&done.stderr).contains("part.ply: hole"),
        "{}",
        text(&done.stderr)
    );
    let done = desk.run(&["fill", "part.ply", "none.ply", "ball.ply", "-o", "out/"]);
    assert_code(&done, 1);
    assert!(text(&done.stderr).contains("3 files: 1 done, 1 in part, 1 failed"));
}

#[test]
fn clashing_output_names_are_refused_before_any_fill() {
    let desk = Desk::new();
    fs::create_dir(desk.path("sub")).unwrap();
    desk.save("sub/ball.ply", &ball(), Format::Ply);
    desk.save("ball.obj", &ball(), Format::Obj);
    let clash = desk.run(&["fill", "ball.ply", "sub/ball.ply", "-o", "out/"]);
    assert_usage(&clash, &["sub/ball.ply", "out/ball.ply"]);
    let clash = desk.run(&["fill", "ball.ply", "ball.obj", "-o", "out/", "--to", "stl"]);
    assert_usage(&clash, &["ball.obj", "out/ball.stl"]);
    let plain = desk.run(&["fill", "ball.ply", "ball.obj", "-o", "out.ply"]);
    assert_usage(&plain, &["out.ply", "folder"]);
    let file = desk.run(&["fill", "ball.ply", "ball.obj", "-o", "sub/ball.ply/"]);
    assert_usage(&file, &["sub/ball.ply", "folder"]);
    let json = desk.run(&[
        "fill",
        "ball.ply",
        "ball.obj",
        "-o",
        "sub",
        "--json",
        "sub/ball.obj",
    ]);
    assert_usage(&json, &["--json"]);
    assert_eq!(desk.files(), ["ball.obj", "ball.ply", "sub"]);
    #[cfg(unix)]
    {
        fs::create_dir(desk.path("links")).unwrap();
        std::os::unix::fs::symlink(desk.path("ball.obj"), desk.path("links/ball.ply")).unwrap();
        let crossing = desk.run(&["fill", "ball.ply", "ball.obj", "-o", "links"]);
        assert_usage(&crossing, &["another input"]);
    }
}

#[test]
fn a_conversion_changes_nothing() {
    let desk = Desk::new();
    let done = desk.run(&[
        "convert",
        "ball.ply",
        "-o",
        "again.ply",
        "--json",
        "-",
        "-q",
    ]);
    crate::desk::assert_code(&done, 0);
    let again = fs::read(desk.path("again.ply")).unwrap();
    assert!(again == fs::read(desk.path("ball.ply")).unwrap());
    let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(document["command"], "convert");
    assert_eq!(document["input"]["faces"], document["output"]["faces"]);
    let plan = desk.run(&["convert", "ball.ply", "--dry-run"]);
    assert!(crate::desk::text(&plan.stdout).contains("would be written unchanged"));
    // A note lists data of the OBJ file that STL cannot hold.
    desk.text(
        "named.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl skin\nf 1/1 2/1 3/1\n",
    );
    let done = desk.run(&["convert", "named.obj", "-o", "plain.stl"]);
    crate::desk::assert_code(&done, 0);
    assert!(
        crate::desk::text(&done.stderr).contains("plain.stl: "),
        "a note on what is lost"
    );
}
