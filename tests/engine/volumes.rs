//! `isomend sdf` and `isomend surface`: distance volumes of meshes, and surfaces of volumes.

use std::fs;
use std::path::PathBuf;
use std::process::Output;

use crate::shapes;
use assert_cmd::Command;
use glam::DVec3;
use isomend::io::{
    Precision, WriteOptions, read_path, read_volume_path, write_path, write_volume_path,
};
use isomend_core::spatial::Bvh;
use serde_json::Value;
use tempfile::TempDir;

struct Desk(TempDir);

impl Desk {
    /// With `ball.ply`, a unit sphere.
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        let options = WriteOptions {
            precision: Precision::F64,
            ascii: false,
        };
        write_path(&desk.path("ball.ply"), &shapes::sphere(8), None, &options).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::cargo_bin("isomend").unwrap();
        command.current_dir(self.0.path()).args(arguments);
        command.output().unwrap()
    }

    fn done(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        said
    }

    fn refused(&self, arguments: &[&str], code: i32, words: &[&str]) {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{said}");
        for word in words {
            assert!(said.contains(word), "'{word}' is not in: {said}");
        }
    }
}

#[test]
fn surfaces_of_a_distance_volume_are_spheres_of_the_given_level() {
    let desk = Desk::new();
    let said = desk.done(&[
        "sdf", "ball.ply", "-o", "ball.vti", "--voxel", "0.08", "--f64",
    ]);
    assert!(said.contains("nodes"), "{said}");
    let volume = read_volume_path(&desk.path("ball.vti"), Some("distance")).unwrap();
    assert_eq!(volume.spacing, DVec3::splat(0.08));
    for (level, radius) in [("0", 1.0), ("-0.25", 0.75), ("0.125", 1.125)] {
        desk.done(&[
            "surface", "ball.vti", "-o", "back.ply", "--level", level, "--f64",
        ]);
        let back = read_path(&desk.path("back.ply"), None).unwrap().mesh;
        assert_eq!(shapes::topology(&back), (0, 2), "closed, and a sphere");
        for p in &back.positions {
            assert!((p.length() - radius).abs() < 0.025, "{p} at level {level}");
        }
    }
    let json = desk.run(&[
        "sdf", "ball.ply", "-o", "ball.vti", "--band", "0.2", "--json", "-", "-q",
    ]);
    let report: Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(report["range"], serde_json::json!([-0.2, 0.2]));
    let voxel = report["voxel"].as_f64().unwrap();
    assert!((voxel - 2.0 / 128.0).abs() < 1e-3, "{voxel}");
    assert_eq!(report["array"], "distance");
}

#[test]
fn the_report_of_a_volume_lists_the_time_of_each_part() {
    let desk = Desk::new();
    let report = |arguments: &[&str]| -> Value {
        let common = ["sdf", "ball.ply", "-o", "b.vti", "--json", "-", "-q"];
        let output = desk.run(&[&common, arguments].concat());
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let nodes = |report: &Value| -> u64 {
        let dims = report["dims"].as_array().unwrap();
        dims.iter().map(|n| n.as_u64().unwrap()).product()
    };
    let whole = report(&["--voxel", "0.1"]);
    assert_eq!(whole["measured"].as_u64().unwrap(), nodes(&whole));
    let banded = report(&["--voxel", "0.1", "--band", "0.2"]);
    let measured = banded["measured"].as_u64().unwrap();
    // A shell from 0.2 inside to 0.2 outside the sphere has the volume of 5094 voxels.
    assert!((4000..6500).contains(&measured), "{measured}");
    for report in [whole, banded] {
        let seconds = |part: &str| report["seconds"][part].as_f64().unwrap();
        let parts = [
            "reading",
            "topology",
            "tree",
            "distances",
            "signs",
            "writing",
        ];
        assert!(parts.iter().all(|part| seconds(part) >= 0.0));
        let sum: f64 = parts.iter().map(|part| seconds(part)).sum();
        assert!(sum <= seconds("total") * (1.0 + 1e-9), "{report}");
    }
}

#[test]
fn the_distance_volume_of_a_mesh_with_a_hole_has_a_closed_surface() {
    let desk = Desk::new();
    let bowl = shapes::cut(&shapes::sphere(8), |p| shapes::polar(p) < 30.0);
    write_path(
        &desk.path("bowl.ply"),
        &bowl,
        None,
        &WriteOptions::default(),
    )
    .unwrap();
    desk.done(&["sdf", "bowl.ply", "-o", "bowl.vti", "--voxel", "0.08"]);
    desk.done(&["surface", "bowl.vti", "-o", "bowl.obj"]);
    let back = read_path(&desk.path("bowl.obj"), None).unwrap().mesh;
    assert_eq!(shapes::topology(&back).0, 0);
    // All vertices of the input are near the surface.
    let bvh = Bvh::new(&back, 0..back.faces.len() as u32);
    for p in &bowl.positions {
        assert!(
            bvh.closest(*p, f64::INFINITY).unwrap().distance < 0.04,
            "{p}"
        );
    }
}

#[test]
fn a_surface_is_closed_at_the_boundary_of_the_volume_on_request() {
    let desk = Desk::new();
    desk.done(&["sdf", "ball.ply", "-o", "ball.vti", "--voxel", "0.1"]);
    let mut half = read_volume_path(&desk.path("ball.vti"), None).unwrap();
    let layers = half.dims[2] / 2;
    half.values.truncate(half.dims[0] * half.dims[1] * layers);
    half.dims[2] = layers;
    write_volume_path(&desk.path("half.vti"), &half, "field", Precision::F32).unwrap();
    let euler = |close: &[&str]| {
        desk.done(&[&["surface", "half.vti", "-o", "half.stl"], close].concat());
        shapes::topology(&read_path(&desk.path("half.stl"), None).unwrap().mesh)
    };
    assert_eq!(euler(&["--close"]), (0, 2));
    let (open, disc) = euler(&[]);
    // `topology` counts a boundary edge half: without this, a disc has the Euler number 1.
    assert!(open > 0 && disc - open as i64 / 2 == 1, "{open} {disc}");
}

#[test]
fn wrong_input_is_refused() {
    let desk = Desk::new();
    desk.refused(&["sdf", "ball.ply", "-o", "ball.ply"], 2, &["ball.vti"]);
    desk.refused(
        &["sdf", "ball.ply", "-o", "a.vti", "--voxel", "1e-7"],
        1,
        &["nodes", "fits"],
    );
    desk.refused(
        &["sdf", "ball.ply", "-o", "a.vti", "--voxel", "0"],
        2,
        &["--voxel"],
    );
    desk.refused(
        &["sdf", "ball.ply", "-o", "a.vti", "--band=-1"],
        2,
        &["--band"],
    );
    desk.refused(
        &["sdf", "ball.ply", "-o", "a.vti", "--band", "1e-4"],
        1,
        &["band", "voxel"],
    );
    desk.refused(&["surface", "ball.ply", "-o", "a.ply"], 1, &["ball.ply"]);
    desk.done(&["sdf", "ball.ply", "-o", "ball.vti", "--voxel", "0.2"]);
    desk.refused(
        &["surface", "ball.vti", "-o", "a.ply", "--level", "99"],
        1,
        &["level 99", "range"],
    );
    desk.refused(
        &["surface", "ball.vti", "-o", "a.ply", "--array", "x"],
        1,
        &["'x'", "distance"],
    );
    desk.refused(&["surface", "ball.vti", "-o", "a.xyz"], 2, &["--to"]);
    desk.refused(&["inspect", "ball.vti"], 1, &["isomend surface"]);
    let bytes = fs::read(desk.path("ball.vti")).unwrap();
    fs::write(desk.path("cut.vti"), &bytes[..bytes.len() / 2]).unwrap();
    desk.refused(&["surface", "cut.vti", "-o", "a.ply"], 1, &["cut.vti"]);
    assert!(!desk.path("a.ply").exists() && !desk.path("a.vti").exists());
}

#[test]
fn one_and_two_threads_write_the_same_bytes() {
    let desk = Desk::new();
    let bytes = |threads: &str| {
        desk.done(&[
            "sdf",
            "ball.ply",
            "-o",
            "b.vti",
            "--voxel",
            "0.1",
            "--threads",
            threads,
        ]);
        desk.done(&["surface", "b.vti", "-o", "b.ply", "--threads", threads]);
        (
            fs::read(desk.path("b.vti")).unwrap(),
            fs::read(desk.path("b.ply")).unwrap(),
        )
    };
    assert!(bytes("1") == bytes("2"));
}
