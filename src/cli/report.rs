//! The report as a page, and the picture.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use isomend::glam::DVec3;
use isomend::io::Loaded;
use isomend::mesh::Hole;
use isomend::report::html::{Page, page};
use isomend::report::picture::{picture, picture_of_one};
use isomend::report::view::{Change, Scene};
use isomend::report::{FillReport, HoleOutcome, HoleReport, point};
use isomend::{Inspection, Mesh};

use super::json::Target;
use super::output;

/// Most faces that are drawn.
const FACES: usize = 300_000;

/// Options of what is drawn.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Write a page to look at: a 3D view with the holes and their numbers, plots and tables, in one HTML file that needs
    /// nothing else.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,

    /// Draw the mesh with its holes, before and after where it changes, into a PNG file.
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
}

/// A mesh some of whose faces went.
#[derive(Debug)]
pub struct Before {
    /// The mesh as it was read.
    pub mesh: Mesh,
    /// For each of its faces whether it went.
    pub gone: Vec<bool>,
}

/// What is drawn and told.
pub struct Drawn<'a> {
    /// The name of the command.
    pub command: &'static str,
    /// The mesh read.
    pub input: &'a Path,
    /// The mesh written.
    pub output: &'a Path,
    /// The mesh before, where it is not `first`.
    pub before: Option<&'a Before>,
    /// The mesh whose vertices and faces come first, and whose vertices the rims name.
    pub first: &'a Mesh,
    /// The mesh after.
    pub after: &'a Mesh,
    /// So many of its faces, from the first on, were there before.
    pub kept: usize,
    /// Remarks.
    pub notes: &'a [String],
    /// What was found and done.
    pub report: &'a FillReport,
}

impl ReportArgs {
    /// Whether anything is drawn.
    pub fn is_wanted(&self) -> bool {
        self.report.is_some() || self.picture.is_some()
    }

    /// Refuses files that cannot be written, have another file's name or are another output.
    pub fn check(
        &self,
        input: &Path,
        mesh: Option<&Path>,
        json: Option<&Target>,
    ) -> anyhow::Result<()> {
        let mut taken = vec![("the input", input)];
        taken.extend(mesh.map(|mesh| ("the mesh", mesh)));
        if let Some(Target::File(path)) = json {
            taken.push(("the report of --json", path));
        }
        let kinds: [(&str, &Option<PathBuf>, &[&str]); 2] = [
            ("--report", &self.report, &["html", "htm"]),
            ("--picture", &self.picture, &["png"]),
        ];
        for (option, path, extensions) in kinds {
            let Some(path) = path else {
                continue;
            };
            let extension = path.extension().and_then(|e| e.to_str());
            if !extension.is_some_and(|e| extensions.contains(&e.to_ascii_lowercase().as_str())) {
                bail!(
                    "{option} {} would not be a file of its kind; end its name in .{}",
                    path.display(),
                    extensions[0]
                );
            }
            output::check_writable(path)?;
            if let Some((what, _)) = taken.iter().find(|(_, t)| output::same_file(path, t)) {
                bail!(
                    "{option} {} is {what} too; name another file",
                    path.display()
                );
            }
            taken.push((option, path));
        }
        Ok(())
    }

    /// Draws a mesh that is only looked at.
    pub fn write_looked_at(
        &self,
        input: &Path,
        loaded: &Loaded,
        found: &Inspection,
    ) -> anyhow::Result<()> {
        let mesh = &loaded.mesh;
        let change = Change {
            before: mesh,
            after: mesh,
            kept: mesh.faces.len(),
            gone: vec![false; mesh.faces.len()],
            patches: Vec::new(),
            rims: rims(mesh, found.holes.iter()),
        };
        let scene = Scene::new(&change, FACES);
        if let Some(path) = &self.report {
            output::write_text(path, &page_of_one(input, loaded, found, &scene))?;
        }
        if let Some(path) = &self.picture {
            output::write_bytes(path, &picture_of_one(&scene)?)?;
        }
        Ok(())
    }

    /// Writes what was asked for.
    pub fn write(&self, drawn: &Drawn) -> anyhow::Result<()> {
        let scene = drawn.scene();
        if let Some(path) = &self.report {
            output::write_text(path, &drawn.page(&scene))?;
        }
        if let Some(path) = &self.picture {
            output::write_bytes(path, &picture(&scene)?)?;
        }
        Ok(())
    }
}

impl Drawn<'_> {
    fn scene(&self) -> Scene {
        let gone = match self.before {
            Some(before) => before.gone.clone(),
            None => vec![self.kept == 0; self.first.faces.len()],
        };
        let change = Change {
            before: self.before.map_or(self.first, |b| &b.mesh),
            after: self.after,
            kept: self.kept,
            gone,
            patches: self.report.regions.iter().map(|r| r.new_faces).collect(),
            rims: rims(self.first, self.report.holes.iter().map(|h| &h.hole)),
        };
        Scene::new(&change, FACES)
    }

    fn page(&self, scene: &Scene) -> String {
        let report = self.report;
        let defects = isomend::report::defect_lines(&report.defects);
        let mut facts = vec![
            ("input", self.input.display().to_string()),
            ("output", self.output.display().to_string()),
            ("faces before", report.faces.to_string()),
            ("faces after", self.after.faces.len().to_string()),
            (
                "new faces",
                (self.after.faces.len() - self.kept).to_string(),
            ),
            ("pieces", report.pieces.to_string()),
            ("seconds", format!("{:.2}", report.seconds)),
        ];
        if let Some(before) = self.before {
            let gone = before.gone.iter().filter(|gone| **gone).count();
            facts.insert(5, ("faces cut out", gone.to_string()));
        }
        if !defects.is_empty() {
            facts.push(("defects of the input", defects.join("; ")));
        }
        page(&Page {
            title: &title(self.input),
            command: self.command,
            command_line: &command_line(),
            version: env!("CARGO_PKG_VERSION"),
            facts: &facts,
            notes: self.notes,
            holes: &report.holes,
            regions: &report.regions,
            scene,
            single: false,
        })
    }
}

/// The page of a mesh that is only looked at.
fn page_of_one(input: &Path, loaded: &Loaded, found: &Inspection, scene: &Scene) -> String {
    let [low, high] = loaded.mesh.bounds();
    let size = low.distance(high);
    let mut facts = vec![
        ("input", input.display().to_string()),
        ("vertices", loaded.mesh.positions.len().to_string()),
        ("faces", loaded.mesh.faces.len().to_string()),
        ("pieces", found.topology.piece_faces.len().to_string()),
        ("from", point(low, size)),
        ("to", point(high, size)),
    ];
    let defects = isomend::report::defect_lines(&found.topology.defects);
    if !defects.is_empty() {
        facts.push(("defects", defects.join("; ")));
    }
    let holes: Vec<HoleReport> = found
        .holes
        .iter()
        .map(|hole| HoleReport {
            hole: hole.clone(),
            outcome: HoleOutcome::Left(String::new()),
            region: 0,
        })
        .collect();
    page(&Page {
        title: &title(input),
        command: "inspect",
        command_line: &command_line(),
        version: env!("CARGO_PKG_VERSION"),
        facts: &facts,
        notes: &loaded.notes,
        holes: &holes,
        regions: &[],
        scene,
        single: true,
    })
}

fn title(input: &Path) -> String {
    let name = input.file_name();
    name.map(|n| n.to_string_lossy().into_owned())
        .unwrap_or_default()
}

/// The rims of holes as points.
fn rims<'a>(mesh: &Mesh, holes: impl Iterator<Item = &'a Hole>) -> Vec<Vec<DVec3>> {
    let points = |hole: &Hole| {
        let rim = hole.rim.iter();
        rim.map(|&v| mesh.positions[v as usize]).collect()
    };
    holes.map(points).collect()
}

/// The command line, quoted for a shell where it has to be.
fn command_line() -> String {
    let quoted = |argument: std::ffi::OsString| {
        let text = argument.to_string_lossy().into_owned();
        let plain = |c: char| c.is_alphanumeric() || "-_./:,=+@%".contains(c);
        if !text.is_empty() && text.chars().all(plain) {
            text
        } else {
            format!("'{}'", text.replace('\'', "'\\''"))
        }
    };
    let arguments: Vec<String> = std::env::args_os().skip(1).map(quoted).collect();
    format!("isomend {}", arguments.join(" "))
}
