//! Test helper: a temporary folder with a mesh, in which the program runs.
#![allow(dead_code)] // Each test file uses some of it.

use std::fs;
use std::path::PathBuf;
use std::process::Output;

use assert_cmd::Command;
use glam::DVec3;
use isomend::Mesh;
use isomend::io::{Format, Precision, WriteOptions, to_bytes};
use serde_json::Value;
use tempfile::TempDir;

use crate::shapes::{cut, polar, sphere};

/// A temporary folder with a mesh, in which the program runs.
pub struct Desk(pub TempDir);

impl Desk {
    /// With `ball.ply`: a sphere with a wide hole, number 1, and a narrow one, number 2.
    pub fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        desk.save("ball.ply", &ball(), Format::Ply);
        desk
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn save(&self, name: &str, mesh: &Mesh, format: Format) {
        fs::write(self.path(name), bytes(mesh, format)).unwrap();
    }

    pub fn text(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::cargo_bin("isomend").unwrap();
        command.current_dir(self.0.path()).args(arguments);
        command.env("XDG_STATE_HOME", self.path(STATE));
        for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE"] {
            command.env_remove(name);
        }
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap()
    }

    /// The names in the folder, without the folder for the state of programs.
    pub fn files(&self) -> Vec<String> {
        let mut names = names_in(self.0.path().to_path_buf());
        names.retain(|name| name != STATE);
        names
    }

    /// The files that the program keeps in the user's folder for the state of programs.
    pub fn kept(&self) -> Vec<PathBuf> {
        let folder = self.path(STATE).join("isomend");
        let names = names_in(folder.clone());
        names.iter().map(|name| folder.join(name)).collect()
    }

    /// The recovery file of the only session.
    pub fn session(&self) -> Option<PathBuf> {
        let is_session = |p: &PathBuf| p.to_string_lossy().ends_with(".session.json");
        self.kept().into_iter().find(is_session)
    }
}

/// The folder for the state of programs, in the desk's folder.
pub const STATE: &str = "state";

/// The names in a folder, in ascending order.
fn names_in(folder: PathBuf) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

pub fn bytes(mesh: &Mesh, format: Format) -> Vec<u8> {
    let options = WriteOptions {
        precision: Precision::F32,
        ascii: false,
    };
    to_bytes(mesh, format, &options).unwrap().bytes
}

/// A sphere with two holes; its coordinates are exact in 32-bit floats.
pub fn ball() -> Mesh {
    let mut mesh = cut(&sphere(8), |p| {
        polar(p) < 35.0 || p.distance(DVec3::X) < 0.35
    });
    for p in &mut mesh.positions {
        *p = p.as_vec3().as_dvec3();
    }
    mesh
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[track_caller]
pub fn assert_code(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "{}", text(&output.stderr));
}

/// Asserts exit code 2 (wrong usage), one line on standard error that contains all the words, and an empty standard output.
#[track_caller]
pub fn assert_usage(output: &Output, words: &[&str]) {
    assert_code(output, 2);
    let said = text(&output.stderr);
    assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    assert!(output.stdout.is_empty());
    for word in words {
        assert!(said.contains(word), "{word}: {said}");
    }
}
