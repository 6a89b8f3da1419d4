//! The report as a page, and the picture.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use isomend::Mesh;
use isomend::report::FillReport;
use isomend::report::html::{Page, page};
use isomend::report::picture::picture;
use isomend::report::view::{Change, Scene};

use super::json::Target;
use super::output;

/// Most faces that are drawn.
const FACES: usize = 300_000;

/// Options of what is drawn.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Write a page to look at: both meshes in a 3D view, holes, plots and tables, in one HTML file that needs nothing else.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,

    /// Draw the mesh before and after into a PNG file.
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
    pub fn check(&self, input: &Path, mesh: &Path, json: Option<&Target>) -> anyhow::Result<()> {
        let mut taken = vec![("the input", input), ("the mesh", mesh)];
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
        let positions = &self.first.positions;
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
            rims: self
                .report
                .holes
                .iter()
                .map(|h| h.hole.rim.iter().map(|&v| positions[v as usize]).collect())
                .collect(),
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
        let name = |path: &Path| path.file_name().map(|n| n.to_string_lossy().into_owned());
        page(&Page {
            title: &name(self.input).unwrap_or_default(),
            command: self.command,
            command_line: &command_line(),
            version: env!("CARGO_PKG_VERSION"),
            facts: &facts,
            notes: self.notes,
            holes: &report.holes,
            regions: &report.regions,
            scene,
        })
    }
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
