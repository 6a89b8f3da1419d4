//! What scripts rely on: files of options, standard input and output, several inputs, trial runs, colours.

mod shapes;

use std::fs;
use std::io::Read;
use std::path::PathBuf;
use std::process::{Output, Stdio};

use assert_cmd::Command;
use glam::DVec3;
use isomend::Mesh;
use isomend::io::{Format, Precision, WriteOptions, read_path, to_bytes};
use serde_json::Value;
use tempfile::TempDir;

use shapes::{cut, polar, unfillable};

/// A folder with a mesh in it, and isomend run there.
struct Desk(TempDir);

impl Desk {
    /// With `ball.ply`: a sphere with a wide hole, number 1, and a narrow one, number 2.
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        desk.save("ball.ply", &ball(), Format::Ply);
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn save(&self, name: &str, mesh: &Mesh, format: Format) {
        fs::write(self.path(name), bytes(mesh, format)).unwrap();
    }

    fn text(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::cargo_bin("isomend").unwrap();
        command.current_dir(self.0.path()).args(arguments);
        for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE"] {
            command.env_remove(name);
        }
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap()
    }

    fn files(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.0.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

fn bytes(mesh: &Mesh, format: Format) -> Vec<u8> {
    let options = WriteOptions {
        precision: Precision::F32,
        ascii: false,
    };
    to_bytes(mesh, format, &options).unwrap().bytes
}

/// A sphere with two holes, its coordinates 32-bit floats.
fn ball() -> Mesh {
    let mut mesh = cut(&shapes::sphere(8), |p| {
        polar(p) < 35.0 || p.distance(DVec3::X) < 0.35
    });
    for p in &mut mesh.positions {
        *p = p.as_vec3().as_dvec3();
    }
    mesh
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[track_caller]
fn assert_code(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "{}", text(&output.stderr));
}

/// Refused as wrong usage, with one line that holds all the words, and nothing on standard output.
#[track_caller]
fn assert_usage(output: &Output, words: &[&str]) {
    assert_code(output, 2);
    let said = text(&output.stderr);
    assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    assert!(output.stdout.is_empty());
    for word in words {
        assert!(said.contains(word), "{word}: {said}");
    }
}

fn outcomes(report: &Value) -> Vec<&str> {
    let holes = report["holes"].as_array().unwrap();
    holes
        .iter()
        .map(|h| h["outcome"].as_str().unwrap())
        .collect()
}

#[test]
fn a_file_of_options_fills_in_what_the_command_line_does_not_say() {
    let desk = Desk::new();
    let options = "voxel = 0.08\nquiet = true\ncolour = 'ff0000'\n\n[fill]\nholes = [2]\n\n[restore]\nvoxel = 0.5\n";
    desk.text("options.toml", options);
    let fill = ["fill", "ball.ply", "-o", "out.ply", "--json", "report.json"];
    let with_file = [&fill[..], &["--config", "options.toml"]].concat();
    let done = desk.run(&with_file);
    assert_code(&done, 0);
    assert_eq!(text(&done.stderr), "");
    let report = desk.json("report.json");
    assert_eq!(outcomes(&report), ["left", "filled"]);
    assert_eq!(report["regions"][0]["voxel"], 0.08);
    // The command line goes before the file, and -v before its quiet, which it does not go with.
    let done = desk.run(&[&with_file[..], &["--holes=1", "--voxel", "0.1", "-v"]].concat());
    assert_code(&done, 0);
    assert!(text(&done.stderr).contains("options from options.toml"));
    let report = desk.json("report.json");
    assert_eq!(outcomes(&report), ["filled", "left"]);
    assert_eq!(report["regions"][0]["voxel"], 0.1);
}

#[test]
fn paths_and_lists_in_a_file_of_options_are_taken_as_meant() {
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
    // What is given on the command line takes the place of a whole list.
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
    assert_eq!(text(&done.stderr).matches("hole 1+2").count(), 1);
}

#[test]
fn mistakes_in_a_file_of_options_are_named_with_their_line() {
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
        ("surface = 'half'", &["line 1", "stitched, whole"]),
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
        assert!(text(&done.stderr).contains("1 of 2 holes filled"));
        if format == Format::Ply {
            assert_eq!(done.stdout, fs::read(desk.path("out.stl")).unwrap());
        }
        let done = desk.run(&["fill", "ball.ply", "--output=-", "--to", format.extension()]);
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
fn streams_that_cannot_be_used_so_are_refused() {
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
fn a_reader_that_goes_away_is_no_panic() {
    let desk = Desk::new();
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("isomend"))
        .current_dir(desk.0.path())
        .args(["fill", "ball.ply", "-o", "-", "--to", "obj", "-q"])
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
    assert_eq!((child.wait().unwrap().code(), &said[..]), (Some(0), ""));
}

#[test]
fn several_inputs_go_into_a_folder_under_their_names() {
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
    // A folder that is there, and one input: its report is no list.
    let done = desk.run(&[
        "fill", "b.obj", "-o", "new", "--to", "stl", "--json", "one.json",
    ]);
    assert_code(&done, 0);
    assert!(desk.path("new/b.stl").exists());
    assert_eq!(desk.json("one.json")["output"]["path"], "new/b.stl");
}

#[test]
fn the_exit_code_of_several_inputs_is_the_worst() {
    let desk = Desk::new();
    // A hole whose two rims were pulled through each other cannot be filled.
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
fn names_that_clash_are_refused_before_anything_is_done() {
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
    assert_code(&json, 1);
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
fn a_trial_run_says_what_would_be_filled_and_writes_nothing() {
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
    assert_eq!(outcomes(&plan), ["would_be_filled", "left"]);
    assert_eq!(desk.files(), ["ball.ply"]);
    // What is done is what was said.
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
    for field in ["id", "holes", "voxel", "diameter", "bridge"] {
        assert_eq!(
            plan["regions"][0][field], report["regions"][0][field],
            "{field}"
        );
    }
    let unknown = desk.run(&["fill", "ball.ply", "--dry-run", "--holes", "9"]);
    assert_code(&unknown, 1);
    assert!(text(&unknown.stderr).contains("no hole 9"));
}

#[test]
fn a_trial_run_of_restore_says_what_would_be_cut_out() {
    let desk = Desk::new();
    let mask = [
        "restore",
        "ball.ply",
        "--ball",
        "0,0,-1,0.3",
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
    assert_eq!(plan["regions"][0]["voxel"], report["regions"][0]["voxel"]);
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
fn colours_are_for_terminals_and_follow_the_environment() {
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
    // JSON and meshes are never coloured, errors are.
    let mut command = desk.command(&["inspect", "none.ply", "--json", "-"]);
    let done = command.env("CLICOLOR_FORCE", "1").output().unwrap();
    assert!(done.stderr.starts_with(b"\x1b["), "{}", text(&done.stderr));
    let mut command = desk.command(&["inspect", "ball.ply", "--json", "-"]);
    let done = command.env("CLICOLOR_FORCE", "1").output().unwrap();
    assert!(!done.stdout.contains(&0x1b));
}
