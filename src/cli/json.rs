//! Reports as JSON. `docs/json.md` describes the fields; they are kept stable.

use std::cell::RefCell;
use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context, bail};
use glam::DVec3;
use isomend::io::{Format, Loaded};
use isomend::mesh::mask::Selection;
use isomend::mesh::{Defects, Hole, OpenChain};
use isomend::report::{FillReport, Plan, Tally};
use isomend::{Inspection, Mesh};
use serde::Serialize;

use super::input::is_stream;
use super::{Usage, console, output};

/// Where a report goes.
#[derive(Clone, Debug)]
pub enum Target {
    /// Standard output.
    Stdout,
    /// A file.
    File(PathBuf),
}

impl FromStr for Target {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text {
            "-" => Target::Stdout,
            path => Target::File(path.into()),
        })
    }
}

impl Target {
    /// Whether it is standard output.
    pub fn is_stdout(&self) -> bool {
        matches!(self, Target::Stdout)
    }

    /// Refuses a file that cannot be written or is one of the meshes, and standard output where a mesh goes there.
    pub fn check(&self, inputs: &[&Path], outputs: &[&Path]) -> anyhow::Result<()> {
        let Target::File(path) = self else {
            if outputs.iter().any(|output| is_stream(output)) {
                let what = "--json - and --output - cannot both have standard output; name a file for one of them";
                return Err(Usage(what.to_owned()).into());
            }
            return Ok(());
        };
        let mut meshes = inputs.iter().chain(outputs).filter(|m| !is_stream(m));
        output::check_writable(path)?;
        if meshes.any(|mesh| output::same_file(path, mesh)) {
            bail!(
                "--json {} would overwrite a mesh; name another file",
                path.display()
            );
        }
        Ok(())
    }

    /// Writes a document.
    pub fn write(&self, document: &impl Serialize) -> anyhow::Result<()> {
        self.write_text(&(pretty(document)? + "\n"))
    }

    fn write_text(&self, text: &str) -> anyhow::Result<()> {
        match self {
            Target::Stdout => {
                console::write(text.as_bytes()).context("cannot write to standard output")
            }
            Target::File(path) => output::write_text(path, text),
        }
    }
}

fn pretty(document: &impl Serialize) -> anyhow::Result<String> {
    serde_json::to_string_pretty(document).context("cannot make the JSON report")
}

/// The reports of several inputs.
#[derive(Debug, Default)]
pub struct Documents(RefCell<Vec<String>>);

impl Documents {
    /// Adds the report of one.
    pub fn add(&self, document: &impl Serialize) -> anyhow::Result<()> {
        self.0.borrow_mut().push(pretty(document)?);
        Ok(())
    }

    /// Writes the only one, or a list of all.
    pub fn write(&self, target: &Target, list: bool) -> anyhow::Result<()> {
        let mut text = self.0.borrow().join(",\n");
        if list {
            // No line of a JSON document ends inside a string.
            text = format!("[\n  {}\n]", text.replace('\n', "\n  "));
        }
        target.write_text(&(text + "\n"))
    }
}

/// What stands for the report of an input that failed.
#[derive(Debug, Serialize)]
pub struct FailedDocument<'a> {
    command: &'static str,
    version: &'static str,
    input: FailedFile,
    error: &'a str,
}

#[derive(Debug, Serialize)]
struct FailedFile {
    path: String,
}

impl<'a> FailedDocument<'a> {
    /// Of a command and its input.
    pub fn new(command: &'static str, input: &Path, error: &'a str) -> Self {
        Self {
            command,
            version: env!("CARGO_PKG_VERSION"),
            input: FailedFile {
                path: input.display().to_string(),
            },
            error,
        }
    }
}

/// What `isomend fill` and `isomend restore` would do.
#[derive(Debug, Serialize)]
pub struct PlanDocument<'a> {
    /// `fill` or `restore`.
    pub command: &'static str,
    /// Version of isomend.
    pub version: &'static str,
    /// Always true.
    pub dry_run: bool,
    /// The mesh read.
    pub input: FileInfo,
    /// Remarks of the reader.
    pub notes: &'a [String],
    /// What would be cut out before.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub cut: Option<Cut>,
    /// What would be filled.
    #[serde(flatten)]
    pub plan: &'a Plan,
}

/// A mesh file.
#[derive(Debug, Serialize)]
pub struct FileInfo {
    path: String,
    format: &'static str,
    vertices: usize,
    faces: usize,
}

impl FileInfo {
    /// What is known of a mesh and its file.
    pub fn new(path: &Path, format: Format, mesh: &Mesh) -> Self {
        Self::of(path, format, mesh.positions.len(), mesh.faces.len())
    }

    /// The same from its numbers of vertices and faces.
    pub fn of(path: &Path, format: Format, vertices: usize, faces: usize) -> Self {
        Self {
            path: path.display().to_string(),
            format: format.extension(),
            vertices,
            faces,
        }
    }
}

/// The report of `isomend fill` and `isomend restore`.
#[derive(Debug, Serialize)]
pub struct FillDocument<'a> {
    /// `fill` or `restore`.
    pub command: &'static str,
    /// Version of isomend.
    pub version: &'static str,
    /// The mesh read.
    pub input: FileInfo,
    /// The mesh written.
    pub output: FileInfo,
    /// Remarks of the reader and the writer.
    pub notes: &'a [String],
    /// Whether each hole of more than four edges that was to be filled got a steady surface that crosses nothing.
    pub flawless: bool,
    /// How many holes ended in which way.
    pub outcomes: Tally,
    /// Whether every hole that was to be filled is.
    pub complete: bool,
    /// What was cut out before.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub cut: Option<Cut>,
    /// What was found and done.
    #[serde(flatten)]
    pub report: &'a FillReport,
}

/// What `isomend restore` cut out.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Cut {
    /// Faces that were marked.
    pub marked_faces: usize,
    /// Faces taken out.
    pub removed_faces: usize,
    /// Vertices taken out.
    pub removed_vertices: usize,
    /// The part of the shape that was to be kept.
    pub keep_shape: f64,
}

/// The report of `isomend inspect`.
#[derive(Debug, Serialize)]
pub struct InspectDocument<'a> {
    command: &'static str,
    version: &'static str,
    input: FileInfo,
    notes: &'a [String],
    vertices: usize,
    faces: usize,
    /// Smallest and largest coordinates.
    bounds: [DVec3; 2],
    pieces: usize,
    piece_faces: &'a [usize],
    defects: Defects,
    open_chains: &'a [OpenChain],
    holes: &'a [Hole],
    /// What the mask selects, where one is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    mask: Option<&'a Selection>,
}

impl<'a> InspectDocument<'a> {
    /// What a mesh holds.
    pub fn new(
        path: &Path,
        loaded: &'a Loaded,
        found: &'a Inspection,
        mask: Option<&'a Selection>,
    ) -> Self {
        Self {
            command: "inspect",
            version: env!("CARGO_PKG_VERSION"),
            input: FileInfo::new(path, loaded.format, &loaded.mesh),
            notes: &loaded.notes,
            vertices: loaded.mesh.positions.len(),
            faces: loaded.mesh.faces.len(),
            bounds: loaded.mesh.bounds(),
            pieces: found.topology.piece_faces.len(),
            piece_faces: &found.topology.piece_faces,
            defects: found.topology.defects,
            open_chains: &found.open_chains,
            holes: &found.holes,
            mask,
        }
    }
}
