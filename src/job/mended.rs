//! A mesh that a job mended, before it is written: what it is, its page and picture, and its writing.

use std::borrow::Cow;
use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::deliver::{Deliverables, Delivered, forget_clock};
use super::draw::{Before, Drawings, Drawn};
use super::outcome::JobResult;
use super::output::Saving;
use super::result::{Extent, Kept};
use super::staging::Staging;
use super::unchanged::Unchanged;
use super::{JobError, JobSpec, Output, Place};
use crate::attributes::transfer;
use crate::cancel::Cancel;
use crate::fill::RegionReport;
use crate::io::Loaded;
use crate::mend::{FillReport, Inspection};
use crate::mesh::{Mesh, Model};

/// A job whose mesh was mended. A copy shares its meshes. As a value it can be written and read again, whole: its mesh, what that carries, its report.
#[derive(Clone, Serialize, Deserialize)]
pub struct Mended<'s> {
    pub(super) spec: Cow<'s, JobSpec>,
    /// The mesh whose vertices and faces come first; that which was read where all of it is there.
    pub(super) first: Arc<Loaded>,
    /// Vertices and faces of the mesh that was read.
    pub(super) size: [usize; 2],
    /// The mesh before, where something was cut out and it is to be drawn.
    pub(super) before: Option<Before>,
    /// The mesh after; of a copy it is empty, and `first` has the mesh.
    pub(super) made: Arc<Mesh>,
    /// For each vertex of a patch its expected error.
    pub(super) expected_error: Vec<Option<f64>>,
    /// Whether nothing of the input is in it.
    pub(super) whole: bool,
    /// Which vertices and faces of the input are kept, where something was cut out.
    pub(super) kept: Option<Kept>,
    /// For each face of `first` the face of the input that it is or was made of.
    pub(super) face_origins: Vec<u32>,
    /// SHA-256 of what was read, where it was a file or bytes.
    #[serde(default)]
    pub(super) sha256: Option<String>,
    /// The token that stops its writing.
    #[serde(skip)]
    pub(super) cancel: Cancel,
    /// What was done beside filling.
    pub extent: Extent,
    /// What was found and done.
    pub report: FillReport,
}

impl<'s> Mended<'s> {
    /// The mesh, in full precision.
    pub fn mesh(&self) -> &Mesh {
        match self.extent {
            Extent::Copied => &self.first.mesh,
            _ => &self.made,
        }
    }

    /// Whether nothing that was to be filled is still open.
    pub fn complete(&self) -> bool {
        self.extent.is_complete(&self.report)
    }

    /// The same, after a repair with the verdict on the mesh in full precision. [`Mended::write`] gives that on what is written.
    ///
    /// # Errors
    /// When the mesh cannot be measured.
    pub fn judged(mut self) -> Result<Self, JobError> {
        self.extent.judge(&self.made, None)?;
        Ok(self)
    }

    /// The name of the command that made it.
    pub fn command(&self) -> &'static str {
        self.spec.work.name()
    }

    /// The same with a job of its own.
    pub fn into_owned(self) -> Mended<'static> {
        Mended {
            spec: Cow::Owned(self.spec.into_owned()),
            first: self.first,
            size: self.size,
            before: self.before,
            made: self.made,
            expected_error: self.expected_error,
            whole: self.whole,
            kept: self.kept,
            face_origins: self.face_origins,
            sha256: self.sha256,
            cancel: self.cancel,
            extent: self.extent,
            report: self.report,
        }
    }

    /// The same, with this handed on beside it when it is written, and reported so.
    ///
    /// # Errors
    /// [`JobError::Deliverable`] where that makes no sense.
    pub fn delivering(mut self, deliverables: Deliverables) -> Result<Self, JobError> {
        deliverables.check(&self.spec)?;
        if deliverables.is_filed() {
            forget_clock(&mut self.report);
        }
        self.spec.to_mut().deliverables = deliverables;
        Ok(self)
    }

    /// The same, to be written elsewhere.
    #[must_use]
    pub fn to(mut self, output: Output) -> Self {
        self.spec.to_mut().output = Some(output);
        // The run that made it is over.
        self.cancel = Cancel::new();
        self
    }

    /// The same, drawn in these files.
    #[must_use]
    pub fn drawn(mut self, drawings: Drawings) -> Self {
        self.spec.to_mut().drawings = drawings;
        self
    }

    /// The mesh with what it carries, in full precision.
    pub fn model(&self) -> Model {
        match (self.whole, &self.extent) {
            (true, _) => Mesh::clone(&self.made).into(),
            (false, Extent::Copied) => Loaded::clone(&self.first).into(),
            (false, _) => {
                let made = Mesh::clone(&self.made);
                transfer(&self.first.mesh, &self.first.attributes, made)
            }
        }
    }

    /// So many of the mesh's vertices and faces, from the first on, are the input's.
    pub fn kept_size(&self) -> [usize; 2] {
        match self.whole {
            true => [0, 0],
            false => [self.first.mesh.positions.len(), self.first.mesh.faces.len()],
        }
    }

    /// Which vertices and faces of the input are kept; none where all or none are.
    pub fn kept(&self) -> Option<&Kept> {
        self.kept.as_ref()
    }

    /// The corners of a face, if there is such a face.
    pub fn face_corners(&self, face: usize) -> Option<[DVec3; 3]> {
        let mesh = self.mesh();
        let face = mesh.faces.get(face)?;
        Some(face.map(|v| mesh.positions[v as usize]))
    }

    /// For each face of the mesh the face of the input that it is or was made of, turned over or with corners moved apart; none for a
    /// new one.
    pub fn face_origins(&self) -> Vec<Option<u32>> {
        let mut origins = vec![None; self.mesh().faces.len()];
        if !self.whole {
            let old = self.face_origins.iter().map(|old| Some(*old));
            origins
                .iter_mut()
                .zip(old)
                .for_each(|(face, old)| *face = old);
        }
        origins
    }

    /// For each new vertex its expected error in the mesh's units, none where nothing can be said; empty for a whole level set
    /// and a faired surface.
    pub fn expected_error(&self) -> &[Option<f64>] {
        &self.expected_error
    }

    /// Number of vertices that are not the input's, without copies of others that [`Mended::model`] may add.
    pub fn new_vertices(&self) -> usize {
        self.mesh().positions.len() - self.kept_size()[0]
    }

    /// The vertices, those of the input that are kept first, in full precision, without the copies that [`Mended::model`] may add.
    pub fn positions(&self) -> &[DVec3] {
        &self.mesh().positions
    }

    /// Where the mesh was read from.
    pub fn source(&self) -> &Place {
        &self.spec.source.place
    }

    /// What was read, or what is left of it where something was cut out.
    pub fn first(&self) -> &Arc<Loaded> {
        &self.first
    }

    /// The page of the mesh in full precision: an HTML file that shows a command line. What was cut out is on it where the job was to
    /// be drawn.
    ///
    /// # Errors
    /// When a mesh that was copied cannot be measured.
    pub fn page(&self, command_line: &str) -> Result<String, JobError> {
        match self.extent {
            Extent::Copied => self.unchanged(|drawn| Ok(drawn.page(command_line))),
            _ => {
                let (nowhere, notes) = (nowhere(), &self.first.notes);
                let drawn = self.drawing(&self.made, &nowhere, notes, self.filed_facts(None, None));
                Ok(drawn.page(command_line))
            }
        }
    }

    /// The picture of the mesh in full precision: a PNG file. It shows what was cut out where the job was to be drawn.
    ///
    /// # Errors
    /// As [`Mended::page`], and for want of memory.
    pub fn picture(&self) -> Result<Vec<u8>, JobError> {
        match self.extent {
            Extent::Copied => self.unchanged(|drawn| drawn.picture()),
            _ => Ok((self.drawing(&self.made, &nowhere(), &[], Vec::new())).picture()?),
        }
    }

    /// Calls a function with a mesh that was copied as it is drawn.
    fn unchanged<R>(
        &self,
        draw: impl FnOnce(&Unchanged<'_>) -> Result<R, JobError>,
    ) -> Result<R, JobError> {
        let found = Inspection::new(&self.first.mesh)?;
        draw(&Unchanged {
            place: &self.spec.source.place,
            loaded: &self.first,
            found: &found,
            crease_ends: &[],
            verdict: None,
            unit: self.spec.deliverables.unit,
        })
    }

    /// What is drawn: `after` is the mesh in the positions that are shown, `output` where it goes.
    fn drawing<'a>(
        &'a self,
        after: &'a Mesh,
        output: &'a Place,
        notes: &'a [String],
        filed: Vec<(&'static str, String)>,
    ) -> Drawn<'a> {
        Drawn {
            command: self.spec.work.name(),
            places: [&self.spec.source.place, output],
            before: self.before.as_ref(),
            first: &self.first.mesh,
            after,
            kept: self.kept_size()[1],
            errors: &self.expected_error,
            notes,
            filed,
            report: &self.report,
        }
    }

    /// Rounds, carries attributes over, checks what is written, writes and draws it.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(mut self) -> Result<JobResult<'s>, JobError> {
        let output = self.spec.output.clone().ok_or_else(|| JobError::Places {
            what: "the job names no output; set one with `Mended::to`".to_owned(),
        })?;
        self.spec.deliverables.check(&self.spec)?;
        let components = self.components();
        let mut delivered = Delivered {
            invented: self.invented(&components),
            ..Delivered::default()
        };
        let regions: &mut [RegionReport] = &mut self.report.regions;
        let own = std::mem::take(&mut self.made);
        let mut staging = Staging::default();
        let wanted = &self.spec.deliverables;
        let (mesh, notes, bytes, sha256) = match &self.extent {
            Extent::Copied => {
                let stored = output.write_copy(&self.first, wanted.unit, &mut staging)?;
                (None, stored.notes, stored.bytes, stored.sha256)
            }
            _ => {
                // Only where another has the mesh too, as the page's step has, is it copied.
                let own = Arc::unwrap_or_clone(own);
                let saving = Saving {
                    input: &self.first,
                    whole: self.whole,
                    expected_error: &self.expected_error,
                    judges: self.extent.judged_by(),
                    components: &components,
                    mark: wanted.mark,
                    unit: wanted.unit,
                    source: &self.spec.source.place,
                    plain_patches: wanted.has_plain_patches(),
                    cancel: &self.cancel,
                };
                let saved = output.write_mended(own, &saving, regions, &mut staging)?;
                self.deliver(&saved, &components, &mut delivered, &mut staging)?;
                self.extent.judge(&saved.mesh, saved.verdict)?;
                (Some(saved.mesh), saved.notes, saved.bytes, saved.sha256)
            }
        };
        let notes_read = self.first.notes.len();
        let notes = [&self.first.notes[..], &notes, &delivered.notes].concat();
        let filed = (&delivered, &sha256[..]);
        self.stage_drawings(mesh.as_ref(), &notes, filed, &mut staging)?;
        staging.finish(&self.cancel)?;
        Ok(JobResult {
            spec: self.spec,
            format: self.first.format,
            size: self.size,
            extent: self.extent,
            report: self.report,
            mesh: mesh.unwrap_or_else(|| Arc::unwrap_or_clone(self.first).mesh),
            bytes,
            notes,
            notes_read,
            sha256: [self.sha256, Some(sha256)],
            delivered,
        })
    }
}

impl Mended<'_> {
    /// Stages the drawings of a mesh as it was written; of a copy there is none. `delivered` and the hash of the mesh stand on the page.
    fn stage_drawings(
        &self,
        mesh: Option<&Mesh>,
        notes: &[String],
        (delivered, sha256): (&Delivered, &str),
        staging: &mut Staging,
    ) -> Result<(), JobError> {
        let drawings = &self.spec.drawings;
        let Some(mesh) = mesh else {
            return match drawings.is_wanted() {
                true => self.unchanged(|drawn| drawings.stage_unchanged(drawn, staging)),
                false => Ok(()),
            };
        };
        let nowhere = nowhere();
        let place = self.spec.output.as_ref().map_or(&nowhere, |o| &o.place);
        let filed = self.filed_facts(Some(delivered), Some(sha256));
        drawings.stage(&self.drawing(mesh, place, notes, filed), staging)
    }
}

/// The place of a result that is written nowhere, on its page.
fn nowhere() -> Place {
    Place::memory("in memory")
}
