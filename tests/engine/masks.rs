//! `isomend inspect` with a mask: which faces masks mark, and which masks are refused.

use std::fs;
use std::process::Output;

use crate::shapes;
use assert_cmd::Command;
use isomend::io::{WriteOptions, write_path};
use serde_json::Value;
use tempfile::TempDir;

struct Desk(TempDir);

impl Desk {
    /// With `ball.obj`, a unit sphere of 1280 faces.
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        let path = desk.0.path().join("ball.obj");
        write_path(&path, &shapes::sphere(8), None, &WriteOptions::default()).unwrap();
        desk
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.path().join(name), text).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::cargo_bin("isomend").unwrap();
        command.current_dir(self.0.path());
        command.args(["inspect", "ball.obj"]).args(arguments);
        command.output().unwrap()
    }

    fn mask(&self, arguments: &[&str]) -> Value {
        let output = self.run(&[arguments, &["--json", "-"]].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        report["mask"].clone()
    }

    fn refused(&self, arguments: &[&str], code: i32, word: &str) {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(word), "'{word}' is not in: {said}");
    }
}

#[test]
fn boxes_balls_face_lists_and_mask_meshes_add_up() {
    let desk = Desk::new();
    let all = shapes::sphere(8).faces.len() as u64;
    assert_eq!(desk.mask(&[]), Value::Null);
    let half = desk.mask(&["--box", "-2,-2,0,2,2,2"]);
    let faces = half["faces"].as_u64().unwrap();
    assert!(faces > all * 2 / 5 && faces < all * 3 / 5 && half["components"] == 1);
    let area = half["area"].as_f64().unwrap();
    assert!(
        (area / (2.0 * std::f64::consts::PI) - 1.0).abs() < 0.1,
        "{area}"
    );
    let ball = desk.mask(&["--ball", "0,0,-1,0.5"]);
    let both = desk.mask(&["--box=-2,-2,0,2,2,2", "--ball=0,0,-1,0.5"]);
    assert_eq!(
        both["faces"].as_u64(),
        Some(faces + ball["faces"].as_u64().unwrap())
    );
    assert_eq!(both["components"], 2);
    let grown = desk.mask(&["--ball", "0,0,-1,0.5", "--grow", "0.3"]);
    assert!(grown["faces"].as_u64() > ball["faces"].as_u64());
    desk.write("some.txt", "0\n7 # remark\n\n7\n");
    desk.write("some.json", "[0, 1, 2]");
    assert_eq!(desk.mask(&["--faces", "some.txt"])["faces"], 2);
    assert_eq!(
        desk.mask(&["--faces", "some.txt", "--faces", "some.json"])["faces"],
        4
    );
    // A closed mesh as the mask marks faces with their centroid inside: the ball scaled by 1.1 marks all of them.
    let mut large = shapes::sphere(8);
    large.positions.iter_mut().for_each(|p| *p *= 1.1);
    write_path(
        &desk.0.path().join("large.ply"),
        &large,
        None,
        &WriteOptions::default(),
    )
    .unwrap();
    assert_eq!(desk.mask(&["--mask", "large.ply"])["faces"], all);
    let text = String::from_utf8(desk.run(&["--ball", "0,0,-1,0.5"]).stdout).unwrap();
    assert!(
        text.contains("mask: ") && text.contains("1 component"),
        "{text}"
    );
}

#[test]
fn masks_select_faces_by_colour_and_material() {
    let desk = Desk::new();
    let mut text = String::new();
    for i in 0..4 {
        let red = if i < 3 { "1 0.5 0" } else { "0 0 0" };
        text += &format!("v {i} {} 0 {red}\n", i * i);
    }
    desk.write(
        "ball.obj",
        &(text + "usemtl skin\nf 1 2 3\nusemtl bone\nf 2 3 4\n"),
    );
    assert_eq!(desk.mask(&["--colour", "ff8000,1"])["faces"], 1);
    assert_eq!(desk.mask(&["--colour", "ff8000,0"])["faces"], 0);
    assert_eq!(desk.mask(&["--material", "bone"])["faces"], 1);
    assert_eq!(
        desk.mask(&["--material", "bone", "--colour", "#ff8000,2"])["faces"],
        2
    );
    desk.refused(&["--material", "wood"], 1, "'skin', 'bone'");
}

#[test]
fn invalid_masks_are_refused() {
    let desk = Desk::new();
    desk.refused(&["--box", "1,2,3"], 2, "6 numbers");
    desk.refused(&["--ball", "0,0,0,nan"], 2, "4 numbers");
    for radius in ["-1", "0"] {
        desk.refused(&["--ball", &format!("0,0,0,{radius}")], 2, "radius");
    }
    for (corners, axis) in [
        ("1,0,0,0,1,1", "low x, 1, exceeds"),
        ("0,1,0,1,-1,1", "low y, 1, exceeds"),
        ("0,0,1,1,1,0.5", "low z, 1, exceeds"),
        ("0,0,inf,1,1,1", "6 numbers"),
    ] {
        desk.refused(&["--box", corners], 2, axis);
    }
    desk.refused(&["--colour", "red"], 2, "hexadecimal");
    desk.refused(&["--colour", "ff0000,999"], 2, "tolerance");
    desk.refused(&["--colour", "ff0000"], 1, "colour");
    desk.refused(&["--grow", "1"], 2, "--ball");
    desk.refused(&["--faces", "gone.txt"], 1, "gone.txt");
    desk.write("bad.txt", "1\nx\n");
    desk.refused(&["--faces", "bad.txt"], 1, "line 2");
    desk.write("bad.json", "[1, -2]");
    desk.refused(&["--faces", "bad.json"], 1, "bad.json");
    desk.write("far.txt", "99999");
    desk.refused(&["--faces", "far.txt"], 1, "99999");
    let open = shapes::cut(&shapes::sphere(8), |p| p.z > 0.5);
    write_path(
        &desk.0.path().join("open.ply"),
        &open,
        None,
        &WriteOptions::default(),
    )
    .unwrap();
    desk.refused(&["--mask", "open.ply"], 1, "not closed");
}
