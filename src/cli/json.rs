//! Reports as JSON. The README describes the fields; they are kept stable.

use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context, bail};
use glam::DVec3;
use isomend::io::{Format, Loaded};
use isomend::mesh::mask::Selection;
use isomend::mesh::{Defects, Hole};
use isomend::report::FillReport;
use isomend::{Inspection, Mesh};
use serde::Serialize;

use super::{console, output};

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
    /// Refuses a file that cannot be written or is one of the meshes.
    pub fn check(&self, meshes: &[&Path]) -> anyhow::Result<()> {
        let Target::File(path) = self else {
            return Ok(());
        };
        output::check_writable(path)?;
        if meshes.iter().any(|mesh| output::same_file(path, mesh)) {
            bail!(
                "--json {} would overwrite a mesh; name another file",
                path.display()
            );
        }
        Ok(())
    }

    /// Writes a document.
    pub fn write(&self, document: &impl Serialize) -> anyhow::Result<()> {
        let mut text =
            serde_json::to_string_pretty(document).context("cannot make the JSON report")?;
        text.push('\n');
        match self {
            Target::Stdout => console::print(&text).context("cannot write to standard output"),
            Target::File(path) => output::write_text(path, &text),
        }
    }
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
    open_chains: usize,
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
            bounds: bounds(&loaded.mesh),
            pieces: found.topology.piece_faces.len(),
            piece_faces: &found.topology.piece_faces,
            defects: found.topology.defects,
            open_chains: found.open_chains,
            holes: &found.holes,
            mask,
        }
    }
}

/// Smallest and largest coordinates of the vertices that faces use.
pub fn bounds(mesh: &Mesh) -> [DVec3; 2] {
    let used = mesh.faces.iter().flatten();
    let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    used.map(|&v| mesh.positions[v as usize])
        .fold(start, |[low, high], p| [low.min(p), high.max(p)])
}
