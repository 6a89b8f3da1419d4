//! The page and the picture of a job.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::output::{write_bytes, write_text};
use super::{JobError, Place};
use crate::check::{DefectKind, Verdict};
use crate::fill::{HoleOutcome, LeftReason};
use crate::io::Loaded;
use crate::mend::{FillReport, HoleReport, Inspection};
use crate::mesh::{Hole, Mesh, point};
use crate::report::html::{Page, page};
use crate::report::picture::{PictureError, picture, picture_of_marked, picture_of_one};
use crate::report::scene::{Change, Colour, Scene};
use crate::report::{defect_lines, verdict_rows};

/// Most faces that are drawn.
const FACES: usize = 300_000;

/// What is drawn, in which files.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Drawings {
    /// A page to look at (HTML).
    pub page: Option<PathBuf>,
    /// A picture (PNG).
    pub picture: Option<PathBuf>,
    /// The command line that the page shows.
    pub command_line: String,
    /// Whether a page or a picture may be asked of the result later: what is cut out of the mesh is kept for it.
    #[serde(skip)]
    pub may_follow: bool,
}

/// A mesh some of whose faces went.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Before {
    /// The mesh as it was read. As a value it is written without what it carries.
    #[serde(with = "bare")]
    pub(super) loaded: Arc<Loaded>,
    /// For each of its faces whether it went.
    pub(super) gone: Vec<bool>,
}

/// A mesh that was read, as a value: without what it carries, which no drawing shows.
mod bare {
    use std::sync::Arc;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use crate::io::{Format, Loaded, Precision};
    use crate::mesh::{Attributes, Mesh};

    pub(super) fn serialize<S: Serializer>(value: &Arc<Loaded>, to: S) -> Result<S::Ok, S::Error> {
        value.mesh.serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<Loaded>, D::Error> {
        let mesh = Mesh::deserialize(from)?;
        Ok(Arc::new(Loaded {
            f32_exact: Precision::of(&mesh) == Precision::F32,
            mesh,
            format: Format::Ply,
            attributes: Attributes::default(),
            document: None,
            notes: Vec::new(),
        }))
    }
}

/// A mesh as it is, to be drawn: with its holes, or where there is a verdict with the faces that have defects.
#[derive(Clone, Copy)]
pub struct Unchanged<'a> {
    /// Where it came from.
    pub place: &'a Place,
    /// The mesh.
    pub loaded: &'a Loaded,
    /// What it holds.
    pub found: &'a Inspection<'a>,
    /// What is wrong with it, where that is drawn.
    pub verdict: Option<&'a Verdict>,
}

/// What is drawn and told of a job.
pub(super) struct Drawn<'a> {
    pub(super) command: &'static str,
    /// The mesh read and the mesh written.
    pub(super) places: [&'a Place; 2],
    /// The mesh before, where it is not `first`.
    pub(super) before: Option<&'a Before>,
    /// The mesh whose vertices and faces come first, and whose vertices the rims name.
    pub(super) first: &'a Mesh,
    /// The mesh after.
    pub(super) after: &'a Mesh,
    /// So many of its faces, from the first on, were there before.
    pub(super) kept: usize,
    /// The expected errors of its new vertices, which are the last.
    pub(super) errors: &'a [Option<f64>],
    /// Remarks.
    pub(super) notes: &'a [String],
    /// What was found and done.
    pub(super) report: &'a FillReport,
}

impl Drawings {
    /// Whether anything is drawn.
    pub fn is_wanted(&self) -> bool {
        self.page.is_some() || self.picture.is_some()
    }

    /// Refuses files that cannot be written, have another kind's name or are another file of the job.
    ///
    /// # Errors
    /// [`JobError::Unwritable`] and [`JobError::Drawing`].
    pub fn check(&self, input: &Place, mesh: Option<&Place>) -> Result<(), JobError> {
        let mut taken = vec![("the input", input.clone())];
        taken.extend(mesh.map(|mesh| ("the mesh", mesh.clone())));
        let kinds: [(&str, &Option<PathBuf>, &[&str]); 2] = [
            ("the page", &self.page, &["html", "htm"]),
            ("the picture", &self.picture, &["png"]),
        ];
        for (name, path, extensions) in kinds {
            let Some(path) = path else {
                continue;
            };
            let bad = |what: String| Err(JobError::Drawing { what });
            let shown = path.display();
            let extension = path.extension().and_then(|e| e.to_str());
            if !extension.is_some_and(|e| extensions.contains(&e.to_ascii_lowercase().as_str())) {
                return bad(format!(
                    "{name} {shown} would not be a file of its kind; end its name in .{}",
                    extensions[0]
                ));
            }
            let place = Place::from(path.clone());
            place.check_writable()?;
            if let Some((what, _)) = taken.iter().find(|(_, t)| place.is_same_file(t)) {
                return bad(format!("{name} {shown} is {what} too; name another file"));
            }
            taken.push((name, place));
        }
        Ok(())
    }

    /// Draws a mesh as it is.
    pub(super) fn write_unchanged(&self, drawn: &Unchanged) -> Result<(), JobError> {
        if !self.is_wanted() {
            return Ok(());
        }
        let scene = drawn.scene();
        let page = || drawn.page_of(&scene, &self.command_line);
        self.write_files(page, || drawn.picture_of(&scene))
    }

    /// Draws what became of a mesh.
    pub(super) fn write(&self, drawn: &Drawn) -> Result<(), JobError> {
        if !self.is_wanted() {
            return Ok(());
        }
        let scene = drawn.scene();
        let page = || drawn.page_of(&scene, &self.command_line);
        self.write_files(page, || picture(&scene))
    }

    fn write_files(
        &self,
        page: impl FnOnce() -> String,
        picture: impl FnOnce() -> Result<Vec<u8>, PictureError>,
    ) -> Result<(), JobError> {
        if let Some(path) = &self.page {
            write_text(path, &page())?;
        }
        if let Some(path) = &self.picture {
            write_bytes(path, &picture()?)?;
        }
        Ok(())
    }
}

impl Unchanged<'_> {
    /// The page: an HTML file that shows a command line.
    pub fn page(&self, command_line: &str) -> String {
        self.page_of(&self.scene(), command_line)
    }

    /// The picture: a PNG file.
    ///
    /// # Errors
    /// [`JobError::Picture`], for want of memory only.
    pub fn picture(&self) -> Result<Vec<u8>, JobError> {
        Ok(self.picture_of(&self.scene())?)
    }

    fn scene(&self) -> Scene {
        let mesh = &self.loaded.mesh;
        if let Some(verdict) = self.verdict {
            return marked_scene(mesh, self.found, verdict);
        }
        let change = Change {
            before: mesh,
            after: mesh,
            kept: mesh.faces.len(),
            gone: vec![false; mesh.faces.len()],
            patches: Vec::new(),
            rims: rims(mesh, self.found.holes.iter()),
            errors: &[],
        };
        Scene::new(&change, FACES)
    }

    fn picture_of(&self, scene: &Scene) -> Result<Vec<u8>, PictureError> {
        match self.verdict {
            Some(_) => picture_of_marked(scene),
            None => picture_of_one(scene),
        }
    }

    fn page_of(&self, scene: &Scene, command_line: &str) -> String {
        let (command, facts) = match self.verdict {
            Some(verdict) => ("check", self.facts_of_verdict(verdict)),
            None => ("inspect", self.facts()),
        };
        let open = |hole: &Hole| HoleReport {
            hole: hole.clone(),
            outcome: HoleOutcome::Left(LeftReason::NotChosen),
            region: 0,
        };
        let holes: Vec<HoleReport> = self.found.holes.iter().map(open).collect();
        page(&Page {
            title: &title(self.place),
            command,
            command_line,
            version: env!("CARGO_PKG_VERSION"),
            facts: &facts,
            notes: &self.loaded.notes,
            holes: &holes,
            regions: &[],
            scene,
            single: true,
        })
    }

    /// The rows of the page of a verdict: name and value.
    fn facts_of_verdict(&self, verdict: &Verdict) -> Vec<(&'static str, String)> {
        let [low, high] = self.loaded.mesh.bounds();
        let mut facts = vec![("input", self.place.name()), ("verdict", verdict.line())];
        facts.extend(verdict_rows(verdict, low.distance(high)));
        let marked = verdict.defects.iter().map(|d| {
            let colour = colour(d.kind).name;
            format!("{colour}: {}", d.kind.text(d.count))
        });
        let legend: Vec<String> = marked.collect();
        if !legend.is_empty() {
            facts.push(("colours", legend.join("; ")));
        }
        facts
    }

    /// The rows of the page of a mesh without a verdict: name and value.
    fn facts(&self) -> Vec<(&'static str, String)> {
        let mesh = &self.loaded.mesh;
        let topology = &self.found.topology;
        let [low, high] = mesh.bounds();
        let size = low.distance(high);
        let mut facts = vec![
            ("input", self.place.name()),
            ("vertices", mesh.positions.len().to_string()),
            ("faces", mesh.faces.len().to_string()),
            ("pieces", topology.piece_faces.len().to_string()),
            ("from", point(low, size)),
            ("to", point(high, size)),
        ];
        let defects = defect_lines(&topology.defects);
        if !defects.is_empty() {
            facts.push(("defects", defects.join("; ")));
        }
        facts
    }
}

/// A mesh with the faces that have defects as the new ones, each kind as a region.
fn marked_scene(mesh: &Mesh, found: &Inspection, verdict: &Verdict) -> Scene {
    let marks = verdict.marks();
    let of_kind = |kind: DefectKind| marks.iter().filter(move |(_, k)| **k == kind);
    let is_plain = |f: &u32| !marks.contains_key(f);
    let mut faces: Vec<u32> = (0..mesh.faces.len() as u32).filter(is_plain).collect();
    let kept = faces.len();
    for kind in DefectKind::ALL {
        faces.extend(of_kind(kind).map(|(f, _)| *f));
    }
    let sorted = faces.iter().map(|f| mesh.faces[*f as usize]).collect();
    let sorted = Mesh::new(mesh.positions.clone(), sorted);
    let change = Change {
        before: &sorted,
        after: &sorted,
        kept,
        gone: vec![false; faces.len()],
        patches: DefectKind::ALL.map(|kind| of_kind(kind).count()).to_vec(),
        rims: rims(mesh, found.holes.iter()),
        errors: &[],
    };
    Scene::new(&change, FACES).with_palette(&DefectKind::ALL.map(colour))
}

/// The colour of a kind of defect, with its name.
fn colour(kind: DefectKind) -> Colour {
    let (name, rgb) = match kind {
        DefectKind::Border => ("blue", [0x2b, 0x6c, 0xc4]),
        DefectKind::NonManifoldEdge => ("magenta", [0xd0, 0x2f, 0xa8]),
        DefectKind::NonManifoldVertex => ("violet", [0x7d, 0x3f, 0xc8]),
        DefectKind::Misoriented => ("teal", [0x12, 0x9c, 0x9a]),
        DefectKind::InsideOut => ("brown", [0x8a, 0x55, 0x2b]),
        DefectKind::Degenerate => ("black", [0x20, 0x20, 0x20]),
        DefectKind::Duplicate => ("green", [0x3c, 0x9a, 0x38]),
        DefectKind::Crossing => ("red", [0xdd, 0x22, 0x18]),
        DefectKind::Thin => ("yellow", [0xe8, 0xb4, 0x10]),
    };
    Colour { name, rgb }
}

impl Drawn<'_> {
    /// The page: an HTML file that shows a command line.
    pub(super) fn page(&self, command_line: &str) -> String {
        self.page_of(&self.scene(), command_line)
    }

    /// The picture: a PNG file.
    pub(super) fn picture(&self) -> Result<Vec<u8>, PictureError> {
        picture(&self.scene())
    }

    fn page_of(&self, scene: &Scene, command_line: &str) -> String {
        let report = self.report;
        let defects = defect_lines(&report.defects);
        let [input, output] = self.places;
        let mut facts = vec![
            ("input", input.name()),
            ("output", output.name()),
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
            title: &title(input),
            command: self.command,
            command_line,
            version: env!("CARGO_PKG_VERSION"),
            facts: &facts,
            notes: self.notes,
            holes: &report.holes,
            regions: &report.regions,
            scene,
            single: false,
        })
    }

    fn scene(&self) -> Scene {
        let gone = match self.before {
            Some(before) => before.gone.clone(),
            None => vec![self.kept == 0; self.first.faces.len()],
        };
        let change = Change {
            before: self.before.map_or(self.first, |b| &b.loaded.mesh),
            after: self.after,
            kept: self.kept,
            gone,
            patches: self.report.regions.iter().map(|r| r.new_faces).collect(),
            rims: rims(self.first, self.report.holes.iter().map(|h| &h.hole)),
            errors: self.errors,
        };
        Scene::new(&change, FACES)
    }
}

/// The name of the file without its folder.
fn title(input: &Place) -> String {
    let name = input.path().and_then(|path| path.file_name());
    name.map_or_else(|| input.name(), |n| n.to_string_lossy().into_owned())
}

/// The rims of holes as points.
fn rims<'a>(mesh: &Mesh, holes: impl Iterator<Item = &'a Hole>) -> Vec<Vec<DVec3>> {
    let points = |hole: &Hole| {
        let rim = hole.rim.iter();
        rim.map(|&v| mesh.positions[v as usize]).collect()
    };
    holes.map(points).collect()
}
