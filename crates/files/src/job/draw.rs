//! Drawings of a job: the HTML page and the PNG picture, and checks of their files.

use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::staging::Staging;
use super::unchanged::{FACES, Unchanged, badge_of, rims, title};
use super::{JobError, Place};
use crate::io::Loaded;
use crate::report::html::{Badge, HtmlPage, page};
use crate::report::picture::{PictureError, picture};
use crate::report::scene::{Scene, SceneChange};
use crate::report::{Standing, counted, defect_lines, every_hole, open_chains};
use isomend_core::cancel::Cancel;
use isomend_core::check::Verdict;
use isomend_core::mend::FillReport;
use isomend_core::mesh::Mesh;

/// The files to draw.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Drawings {
    /// File for an HTML page with a 3D view.
    pub page: Option<PathBuf>,
    /// File for a PNG picture.
    pub picture: Option<PathBuf>,
    /// The command line that the page shows.
    pub command_line: String,
    /// Keep the mesh before the cut, so that a page or picture can still be drawn from the result later.
    #[serde(skip)]
    pub may_follow: bool,
}

/// The input mesh of work that removed faces.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Before {
    /// The mesh as it was read. Serialized without its attributes.
    #[serde(with = "bare")]
    pub(super) loaded: Arc<Loaded>,
    /// For each of its faces, whether it was removed.
    pub(super) gone: Vec<bool>,
}

/// Serializes a loaded mesh as positions and faces only; drawings show no attributes.
mod bare {
    use std::sync::Arc;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use crate::io::Loaded;
    use isomend_core::mesh::{Attributes, Mesh};

    pub(super) fn serialize<S: Serializer>(value: &Arc<Loaded>, to: S) -> Result<S::Ok, S::Error> {
        value.mesh.serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<Loaded>, D::Error> {
        let mesh = Mesh::deserialize(from)?;
        Ok(Arc::new(Loaded::in_memory(mesh, Attributes::default())))
    }
}

/// The content of the drawings of a job.
pub(super) struct Drawn<'a> {
    pub(super) command: &'static str,
    /// The places of the input and of the output.
    pub(super) places: [&'a Place; 2],
    /// The mesh before, if it differs from `kept_input`.
    pub(super) before: Option<&'a Before>,
    /// The kept part of the input: `after` starts with its vertices and faces, and rims refer to its vertices.
    pub(super) kept_input: &'a Mesh,
    /// The mesh after.
    pub(super) after: &'a Mesh,
    /// The first `kept` faces of `after` are the input's.
    pub(super) kept: usize,
    /// The expected errors of the new vertices, which are the last of `after`.
    pub(super) errors: &'a [Option<f64>],
    /// Remarks.
    pub(super) notes: &'a [String],
    /// Further facts for the page: invented surface, unit and hashes.
    pub(super) filed: Vec<(&'static str, String)>,
    /// The report of the fill.
    pub(super) report: &'a FillReport,
    /// The verdict on the mesh after a repair.
    pub(super) verdict: Option<&'a Verdict>,
}

impl Drawings {
    /// Whether anything is drawn.
    pub fn is_wanted(&self) -> bool {
        self.page.is_some() || self.picture.is_some()
    }

    /// Refuses files that cannot be written, that have the wrong extension, or that are another file of the job.
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
                    "{name} {shown} has the wrong extension; end its name in .{}",
                    extensions[0]
                ));
            }
            let place = Place::from(path.clone());
            place.check_writable()?;
            if let Some((what, _)) = taken.iter().find(|(_, t)| place.is_same_file(t)) {
                return bad(format!(
                    "{name} would be written to {shown}, which is the file of {what}; name another file"
                ));
            }
            taken.push((name, place));
        }
        Ok(())
    }

    /// Draws a mesh that was not changed.
    pub(super) fn write_unchanged(&self, drawn: &Unchanged) -> Result<(), JobError> {
        let mut staging = Staging::default();
        self.stage_unchanged(drawn, &mut staging)?;
        staging.finish(&Cancel::new())
    }

    /// Stages the drawings of a mesh as it is.
    pub(super) fn stage_unchanged(
        &self,
        drawn: &Unchanged,
        staging: &mut Staging,
    ) -> Result<(), JobError> {
        if !self.is_wanted() {
            return Ok(());
        }
        let scene = drawn.scene();
        let page = || drawn.page_of(&scene, &self.command_line);
        self.stage_files(page, || drawn.picture_of(&scene), staging)
    }

    /// Stages the drawings of what became of a mesh.
    pub(super) fn stage(&self, drawn: &Drawn, staging: &mut Staging) -> Result<(), JobError> {
        if !self.is_wanted() {
            return Ok(());
        }
        let scene = drawn.scene();
        let page = || drawn.page_of(&scene, &self.command_line);
        self.stage_files(page, || picture(&scene), staging)
    }

    fn stage_files(
        &self,
        page: impl FnOnce() -> String,
        picture: impl FnOnce() -> Result<Vec<u8>, PictureError>,
        staging: &mut Staging,
    ) -> Result<(), JobError> {
        if let Some(path) = &self.page {
            staging.add(path, page().as_bytes())?;
        }
        if let Some(path) = &self.picture {
            staging.add(path, &picture()?)?;
        }
        Ok(())
    }
}

impl Drawn<'_> {
    /// The HTML page; it shows the command line.
    pub(super) fn page(&self, command_line: &str) -> String {
        self.page_of(&self.scene(), command_line)
    }

    /// The PNG picture.
    pub(super) fn picture(&self) -> Result<Vec<u8>, PictureError> {
        picture(&self.scene())
    }

    fn page_of(&self, scene: &Scene, command_line: &str) -> String {
        let report = self.report;
        let defects = defect_lines(&report.input.defects);
        let [input, output] = self.places;
        let mut facts = vec![
            ("input", input.name()),
            ("output", output.name()),
            ("faces before", report.input.faces.to_string()),
            ("faces after", self.after.faces.len().to_string()),
            (
                "new faces",
                (self.after.faces.len() - self.kept).to_string(),
            ),
            ("components", report.input.components.to_string()),
        ];
        if report.seconds > 0.0 {
            facts.push(("seconds", format!("{:.2}", report.seconds)));
        }
        facts.extend(self.filed.clone());
        if let Some(before) = self.before {
            let gone = before.gone.iter().filter(|gone| **gone).count();
            facts.insert(5, ("faces cut out", gone.to_string()));
        }
        if !defects.is_empty() {
            facts.push(("defects of the input", defects.join("; ")));
        }
        page(&HtmlPage {
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
            badge: self.badge(),
            defects: &[],
        })
    }

    /// The verdict of a repair, else how many holes are closed.
    fn badge(&self) -> Option<Badge> {
        if let Some(verdict) = self.verdict {
            return Some(badge_of(verdict));
        }
        let (all, tally) = (self.report.holes.len(), self.report.tally());
        let text = match (all - tally.closed, tally.open) {
            _ if all + tally.open_chains == 0 => return None,
            (0, _) if tally.open_chains > 0 => open_chains(tally.open_chains),
            (0, _) if tally.intersecting_patches > 0 => {
                let patches = counted(tally.intersecting_patches, "patch");
                format!("all closed, {patches} intersecting")
            }
            (0, _) => every_hole(all, ["is", "are"], "closed"),
            (open, 0) => format!("{open} of {} left open", counted(all, "hole")),
            (_, open) => format!("{open} of {all} holes could not be closed"),
        };
        let class = Standing::of_fill(self.report).class();
        Some(Badge { class, text })
    }

    fn scene(&self) -> Scene {
        let gone = match self.before {
            Some(before) => before.gone.clone(),
            None => vec![self.kept == 0; self.kept_input.faces.len()],
        };
        let change = SceneChange {
            before: self.before.map_or(self.kept_input, |b| &b.loaded.mesh),
            after: self.after,
            kept: self.kept,
            gone,
            patches: self.report.regions.iter().map(|r| r.new_faces).collect(),
            rims: rims(self.kept_input, self.report.holes.iter().map(|h| &h.hole)),
            errors: self.errors,
        };
        Scene::new(&change, FACES)
    }
}
