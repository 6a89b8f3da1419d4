//! The command line: exit codes, standard output and standard error, and that no failure changes a file.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use glam::DVec3;
use isomend::Mesh;
use isomend::io::{Format, Precision, WriteOptions, read_path, to_bytes};
use serde_json::Value;
use tempfile::TempDir;

use crate::shapes::{self, bits, cut, polar, unfillable};

/// A temporary folder with a mesh, in which the program runs.
struct Desk {
    folder: TempDir,
}

impl Desk {
    /// With `ball.ply`: a sphere with a wide hole, number 1, and a narrow one, number 2.
    fn new() -> Self {
        let desk = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        desk.save("ball.ply", &ball(), Format::Ply);
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn save(&self, name: &str, mesh: &Mesh, format: Format) {
        let options = WriteOptions {
            precision: Precision::F32,
            ascii: false,
        };
        fs::write(
            self.path(name),
            to_bytes(mesh, format, &options).unwrap().bytes,
        )
        .unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::cargo_bin("isomend").unwrap();
        command.current_dir(self.folder.path()).args(arguments);
        command.output().unwrap()
    }

    fn fill(&self, more: &[&str]) -> Output {
        self.run(&[&["fill", "ball.ply", "-o", "out.ply"], more].concat())
    }

    /// The JSON report of a fill of `ball.ply`.
    fn report(&self, more: &[&str]) -> Value {
        let output = self.fill(&[&["--json", "-", "-q"], more].concat());
        serde_json::from_str(&text(&output.stdout)).unwrap()
    }

    fn files(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

/// A sphere with two holes; its coordinates are exact in 32-bit floats.
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

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

/// Asserts a failure with an exit code, a message on standard error with all the words (one line for code 1), and an empty standard
/// output.
fn assert_refused(output: &Output, expected: i32, words: &[&str]) {
    let message = text(&output.stderr);
    assert_eq!(code(output), expected, "{message}");
    assert_eq!(text(&output.stdout), "");
    if expected == 1 {
        assert!(message.starts_with("isomend: "), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    for word in words {
        assert!(message.contains(word), "'{word}' is not in: {message}");
    }
}

fn outcomes(report: &Value) -> Vec<String> {
    let holes = report["holes"].as_array().unwrap();
    holes
        .iter()
        .map(|h| h["outcome"].as_str().unwrap().to_owned())
        .collect()
}

#[test]
fn a_fill_writes_the_mesh_and_reports_on_standard_error_only() {
    let desk = Desk::new();
    let output = desk.fill(&[]);
    let said = text(&output.stderr);
    assert_eq!(code(&output), 0, "{said}");
    assert!(output.stdout.is_empty());
    assert!(
        said.contains("expected error")
            && said.contains("both holes are closed (2 by the level set)"),
        "{said}"
    );
    assert!(!said.contains(['\r', '\x1b']), "no progress bar: {said:?}");
    let filled = read_path(&desk.path("out.ply"), None).unwrap().mesh;
    assert_eq!(shapes::topology(&filled), (0, 2));
    assert_eq!(desk.files(), ["ball.ply", "out.ply"]);
}

#[test]
fn quiet_prints_nothing_and_verbose_prints_details() {
    let desk = Desk::new();
    let quiet = desk.fill(&["-q"]);
    assert_eq!((code(&quiet), text(&quiet.stderr)), (0, String::new()));
    let verbose = text(&desk.fill(&["-v"]).stderr);
    assert!(verbose.contains("unknowns"), "{verbose}");
    assert_refused(&desk.fill(&["-q", "-v"]), 2, &["--quiet"]);
}

#[test]
fn inspect_prints_a_table() {
    let desk = Desk::new();
    let output = desk.run(&["inspect", "ball.ply"]);
    let table = text(&output.stdout);
    assert_eq!((code(&output), text(&output.stderr)), (0, String::new()));
    assert!(
        table.contains("2 holes") && table.contains("diameter"),
        "{table}"
    );
    assert_eq!(table.lines().count(), 8, "{table}");
}

#[test]
fn inspect_gives_json_alone_or_beside_the_table() {
    let desk = Desk::new();
    let alone: Value = serde_json::from_str(&text(
        &desk.run(&["inspect", "ball.ply", "--json", "-"]).stdout,
    ))
    .unwrap();
    assert_eq!(alone["command"], "inspect");
    assert_eq!(alone["holes"].as_array().unwrap().len(), 2);
    let both = desk.run(&["inspect", "ball.ply", "--json", "holes.json"]);
    assert!(text(&both.stdout).contains("diameter"));
    let written: Value =
        serde_json::from_str(&fs::read_to_string(desk.path("holes.json")).unwrap()).unwrap();
    assert_eq!(written, alone);
}

#[test]
fn the_json_report_of_a_fill_is_complete_and_alone_on_standard_output() {
    let desk = Desk::new();
    let report = desk.report(&[]);
    assert_eq!(report["command"], "fill");
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(report["complete"], true);
    assert_eq!(report["input"]["path"], "ball.ply");
    assert_eq!(report["input"]["format"], "ply");
    assert_eq!(report["input"]["faces"], report["faces"]);
    assert!(report["output"]["faces"].as_u64() > report["faces"].as_u64());
    assert_eq!(outcomes(&report), ["closed", "closed"]);
    let region = &report["regions"][0];
    assert!(region["levels"].as_array().is_some_and(|l| !l.is_empty()));
    for field in [
        "diameter",
        "voxel",
        "seam_angle_mean",
        "quality_mean",
        "seconds",
    ] {
        assert!(region[field].is_number(), "{field}");
    }
}

#[test]
fn wrong_usage_exits_with_2() {
    let desk = Desk::new();
    assert_refused(&desk.run(&[]), 2, &["Usage"]);
    assert_refused(&desk.run(&["fill", "ball.ply"]), 2, &["--output"]);
    assert_refused(&desk.run(&["mend", "ball.ply"]), 2, &["mend"]);
    let wrong = [
        ("--voxel", "0"),
        ("--voxel", "nan"),
        ("--holes", "one"),
        ("--holes", "0"),
        ("--keep-open", "1;2"),
        ("--bridge", "3"),
        ("--max-diameter", "-1"),
        ("--edge-ratio", "100"),
        ("--threads", "0"),
        ("--sharp", "half"),
        ("--from", "fbx"),
        ("--to", "png"),
    ];
    for (option, value) in wrong {
        let given = format!("{option}={value}");
        assert_refused(&desk.fill(&[&given]), 2, &[option, value]);
    }
    assert_eq!(desk.files(), ["ball.ply"]);
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_the_input_is_read() {
    let desk = Desk::new();
    let fill = |out: &str| desk.run(&["fill", "not-there.ply", "-o", out]);
    assert_refused(&fill("out.xyz"), 2, &["out.xyz", "--to", ".glb"]);
    assert_refused(&fill("out"), 2, &["out", "--to"]);
    assert_refused(&fill("no/out.ply"), 1, &["no/out.ply", "no folder no"]);
    fs::create_dir(desk.path("folder.ply")).unwrap();
    fs::create_dir(desk.path("folder.ply/not-there.ply")).unwrap();
    assert_refused(
        &fill("folder.ply"),
        1,
        &["folder.ply/not-there.ply", "folder"],
    );
    let json = |file: &str| desk.fill(&["--json", file]);
    assert_refused(&json("no/report.json"), 1, &["no/report.json"]);
    assert_refused(&json("out.ply"), 2, &["out.ply", "overwrite"]);
    assert_refused(&json("ball.ply"), 2, &["ball.ply", "overwrite"]);
    assert_refused(&fill("out.ply"), 1, &["not-there.ply"]);
    assert_refused(&desk.run(&["inspect", "folder.ply"]), 1, &["folder"]);
    assert_eq!(desk.files(), ["ball.ply", "folder.ply"]);
}

#[test]
fn malformed_files_are_refused_in_one_line_and_the_output_stays_unchanged() {
    let desk = Desk::new();
    let whole = fs::read(desk.path("ball.ply")).unwrap();
    let mut huge = b"glTF\x02\0\0\0\xff\xff\xff\x7f".to_vec();
    huge.extend([0; 40]);
    let mut facets = vec![0; 84];
    facets[80..].copy_from_slice(&u32::MAX.to_le_bytes());
    let files: [(&str, &[u8], &str); 12] = [
        ("cut.ply", &whole[..whole.len() / 2], "cut.ply"),
        ("empty.obj", b"", "empty"),
        (
            "nan.obj",
            b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
            "finite",
        ),
        (
            "index.obj",
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
            "line 4",
        ),
        ("points.obj", b"v 0 0 0\nv 1 0 0\n", "no faces"),
        ("flat.obj", b"v 0 0 0\nv 1 0 0\nf 1 2 1\n", "degenerate"),
        ("huge.glb", &huge, "huge.glb"),
        ("facets.stl", &facets, "4294967295"),
        ("mesh.fbx", b"Kaydara FBX Binary\n", "FBX"),
        ("short.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n", "line 4"),
        (
            "short.vtk",
            b"# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 9 float\n1",
            "short.vtk",
        ),
        ("noise.xyz", b"\x01\x02\x03", "supported"),
    ];
    fs::write(desk.path("out.ply"), b"precious").unwrap();
    for (name, content, word) in files {
        fs::write(desk.path(name), content).unwrap();
        assert_refused(
            &desk.run(&["fill", name, "-o", "out.ply"]),
            1,
            &[name, word],
        );
        assert_refused(&desk.run(&["inspect", name]), 1, &[name, word]);
    }
    assert_eq!(fs::read(desk.path("out.ply")).unwrap(), b"precious");
    assert_eq!(desk.files().len(), files.len() + 2);
}

#[test]
fn unknown_hole_numbers_are_refused_by_number() {
    let desk = Desk::new();
    for option in ["--holes=3", "--keep-open=3", "--bridge=1+3"] {
        assert_refused(&desk.fill(&[option]), 1, &["no hole 3", "has 2"]);
    }
    assert_eq!(desk.files(), ["ball.ply"]);
}

#[test]
fn holes_are_chosen_by_number_and_by_diameter() {
    let desk = Desk::new();
    assert_eq!(
        outcomes(&desk.report(&["--holes", "2"])),
        ["left", "closed"]
    );
    assert_eq!(
        outcomes(&desk.report(&["--holes", "2,1"])),
        ["closed", "closed"]
    );
    assert_eq!(
        outcomes(&desk.report(&["--keep-open", "2"])),
        ["closed", "left"]
    );
    let report = desk.report(&["--max-diameter", "0.9"]);
    assert_eq!(outcomes(&report), ["left", "closed"]);
    assert!(
        report["holes"][0]["reason"]
            .as_str()
            .unwrap()
            .contains("diameter")
    );
    let said = text(&desk.fill(&["--keep-open", "1"]).stderr);
    assert!(
        said.contains("hole 1 left open: asked to keep it open"),
        "{said}"
    );
}

#[test]
fn a_bridge_puts_holes_into_one_region() {
    let desk = Desk::new();
    assert_eq!(desk.report(&[])["regions"].as_array().unwrap().len(), 2);
    let report = desk.report(&["--bridge", "1+2"]);
    assert_eq!(report["regions"][0]["holes"], serde_json::json!([1, 2]));
}

#[test]
fn the_voxel_size_and_the_edge_ratio_are_used() {
    let desk = Desk::new();
    let report = desk.report(&["--voxel", "0.05", "--holes", "2"]);
    assert!(report["regions"][0]["voxel"].as_f64().unwrap() < 0.0501);
    let faces = |report: &Value| report["regions"][0]["new_faces"].as_u64().unwrap();
    let fine = desk.report(&["--edge-ratio", "0.4", "--holes", "1"]);
    let usual = desk.report(&["--holes", "1"]);
    let (fine, usual) = (faces(&fine), faces(&usual));
    assert!(fine > 2 * usual, "{fine} and {usual} faces");
}

/// Asserts that the output begins with the input's vertices and faces, bit for bit, and has more faces.
fn assert_kept(input: &Path, output: &Path) {
    let (before, after) = (
        read_path(input, None).unwrap(),
        read_path(output, None).unwrap(),
    );
    let (n, m) = (before.mesh.positions.len(), before.mesh.faces.len());
    assert_eq!(
        bits(&after.mesh.positions[..n]),
        bits(&before.mesh.positions)
    );
    assert_eq!(after.mesh.faces[..m], before.mesh.faces);
    assert!(after.mesh.faces.len() > m);
}

#[test]
fn input_vertices_and_faces_are_kept_bit_for_bit_and_in_order() {
    let desk = Desk::new();
    for out in ["out.ply", "out.obj", "out.glb", "out.vtk"] {
        let output = desk.run(&["fill", "ball.ply", "-o", out]);
        assert!(!text(&output.stderr).contains("rounded"), "{output:?}");
        assert_kept(&desk.path("ball.ply"), &desk.path(out));
    }
    // Coordinates that need 64 bits, and a vertex that no face uses.
    let mut fine = cut(&shapes::sphere(6), |p| polar(p) < 40.0);
    fine.positions.iter_mut().for_each(|p| *p /= 3.0);
    fine.positions.push(DVec3::splat(0.1));
    desk.save("fine.obj", &fine, Format::Obj);
    for out in ["out.ply", "out.obj", "text.ply", "out.vtp"] {
        let ascii = if out == "text.ply" { "--ascii" } else { "-q" };
        assert_eq!(code(&desk.run(&["fill", "fine.obj", "-o", out, ascii])), 0);
        assert_kept(&desk.path("fine.obj"), &desk.path(out));
    }
    let said = text(&desk.run(&["fill", "fine.obj", "-o", "out.stl"]).stderr);
    assert_eq!(said.matches("rounded").count(), 1, "said once: {said}");
}

#[test]
fn formats_follow_the_extension_unless_they_are_given() {
    let desk = Desk::new();
    for format in Format::ALL {
        let name = format!("out.{}", format.extension());
        assert_eq!(code(&desk.run(&["fill", "ball.ply", "-o", &name])), 0);
        let loaded = read_path(&desk.path(&name), None).unwrap();
        assert_eq!(loaded.format, format);
    }
    let output = desk.run(&[
        "fill", "ball.ply", "-o", "out.dat", "--to", "stl", "--ascii",
    ]);
    assert_eq!(code(&output), 0);
    assert!(
        fs::read(desk.path("out.dat"))
            .unwrap()
            .starts_with(b"solid")
    );
    fs::copy(desk.path("out.obj"), desk.path("model.txt")).unwrap();
    assert_eq!(
        code(&desk.run(&["inspect", "model.txt", "--from", "obj"])),
        0
    );
    assert_refused(
        &desk.run(&["inspect", "model.txt", "--from", "stl"]),
        1,
        &["STL"],
    );
}

#[test]
fn the_input_may_be_overwritten() {
    let desk = Desk::new();
    let before = read_path(&desk.path("ball.ply"), None).unwrap().mesh;
    assert_eq!(code(&desk.run(&["fill", "ball.ply", "-o", "ball.ply"])), 0);
    let after = read_path(&desk.path("ball.ply"), None).unwrap().mesh;
    assert_eq!(after.faces[..before.faces.len()], before.faces);
    assert_eq!(shapes::topology(&after), (0, 2));
}

#[test]
fn one_and_two_threads_write_the_same_bytes() {
    let desk = Desk::new();
    let bytes = |threads: &str| {
        assert_eq!(code(&desk.fill(&["--threads", threads])), 0);
        fs::read(desk.path("out.ply")).unwrap()
    };
    assert!(bytes("1") == bytes("2"));
}

#[test]
fn a_hole_that_cannot_be_filled_exits_with_3_and_the_rest_is_written() {
    let desk = Desk::new();
    desk.save("bad.obj", &unfillable(), Format::Obj);
    let output = desk.run(&["fill", "bad.obj", "-o", "out.obj", "-q"]);
    let said = text(&output.stderr);
    assert_eq!(code(&output), 3, "{said}");
    assert!(
        said.contains("still open") && said.contains("edges"),
        "{said}"
    );
    assert_eq!(desk.files(), ["bad.obj", "ball.ply", "out.obj"]);
}

#[test]
fn a_study_prints_its_table_and_writes_the_requested_files() {
    let desk = Desk::new();
    let arguments = [
        "study", "table1", "--finest", "16", "-q", "--csv", "t.csv", "--json", "t.json", "--plot",
        "t.svg", "--series", "fields",
    ];
    let output = desk.run(&arguments);
    let printed = text(&output.stdout);
    assert!(
        printed.contains("variant gauss-newton") && printed.contains("pass  variant I: errors")
    );
    assert!(text(&output.stderr).is_empty(), "{}", text(&output.stderr));
    let read = |name: &str| fs::read_to_string(desk.path(name)).expect("a file");
    assert!(read("t.csv").contains("h,L2 error,order"));
    assert!(read("t.svg").contains("</svg>"));
    let report: Value = serde_json::from_str(&read("t.json")).expect("JSON");
    assert_eq!(report["command"], "study");
    assert_eq!(report["tables"].as_array().map(Vec::len), Some(3));
    let collection = read("fields/table1-16-I.pvd");
    let field = collection.split('"').find(|part| part.ends_with(".vti"));
    let field = fs::read(desk.path("fields").join(field.expect("a field"))).unwrap();
    let field = String::from_utf8_lossy(&field);
    assert!(field.contains("Name=\"phi\"") && field.contains("WholeExtent=\"0 16 0 16 0 0\""));
}

#[test]
fn a_study_refuses_invalid_options_before_it_starts() {
    let desk = Desk::new();
    assert_refused(
        &desk.run(&["study", "fig9"]),
        2,
        &["fig9", "table1", "merge"],
    );
    assert_refused(
        &desk.run(&["study", "merge", "--plot", "plate.png"]),
        1,
        &["plate.png", ".svg"],
    );
    assert_refused(
        &desk.run(&["study", "merge", "--finest", "64"]),
        1,
        &["--finest"],
    );
    for name in ["table1", "circle", "patches", "surfaces"] {
        assert_refused(
            &desk.run(&["study", name, "--finest", "3"]),
            1,
            &["--finest 3 leaves no grid"],
        );
    }
}

#[test]
fn compare_reports_kept_faces_and_distances_of_patches() {
    let desk = Desk::new();
    desk.fill(&["-q"]);
    let output = desk.run(&[
        "compare",
        "ball.ply",
        "out.ply",
        "--samples",
        "5000",
        "--json",
        "-",
    ]);
    assert_eq!(code(&output), 0, "{}", text(&output.stderr));
    let report: Value = serde_json::from_str(&text(&output.stdout)).expect("JSON");
    let (first, kept) = (&report["a"], &report["kept"]);
    assert_eq!(kept["vertices_in_order"], first["vertices"]);
    assert_eq!(kept["faces_in_order"], first["faces"]);
    assert_eq!(report["a_to_b"]["samples"], 5000);
    assert!(report["a_to_b"]["max"].as_f64().is_some_and(|d| d < 1e-6));
    // The middles of the caps are far from the rims.
    assert!(report["b_to_a"]["max"].as_f64().is_some_and(|d| d > 0.3));
    let table = desk.run(&["compare", "ball.ply", "out.ply", "--samples", "500"]);
    assert!(text(&table.stdout).contains("B to A"));
}
