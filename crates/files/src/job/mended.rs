//! The result of a job in memory, before it is written: access to mesh and report, HTML page and picture, and writing to files.

use std::borrow::Cow;
use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::bodies::{checked, one_mesh_note};
use super::deliver::{Deliverables, Delivered, clear_run_times};
use super::draw::{Before, Drawings, Drawn};
use super::outcome::JobResult;
use super::output::Saving;
use super::painted;
use super::result::{KeptElements, OperationReport, ReplacedBody, label_replaced};
use super::staging::Staging;
use super::unchanged::Unchanged;
use super::{JobError, JobSpec, Output, Place, Work};
use super::{inside_out, no_base};
use crate::io::{Format, Loaded};
use crate::report::kept_object;
use isomend_core::attributes::transfer_without;
use isomend_core::cancel::Cancel;
use isomend_core::check::Verdict;
use isomend_core::fill::RegionReport;
use isomend_core::mend::{FillReport, Inspection};
use isomend_core::mesh::{Bodies, Mesh, Model};
use isomend_core::repair::RepairParams;

/// A job whose mesh has been mended. Clones share the meshes. Serialization keeps everything: the mesh, its attributes and the report.
#[derive(Clone, Serialize, Deserialize)]
pub struct Mended<'s> {
    pub(super) spec: Cow<'s, JobSpec>,
    /// The kept part of the input, or all of it if nothing was removed. `made` starts with its vertices and faces.
    #[serde(rename = "first")]
    pub(super) kept_input: Arc<Loaded>,
    /// Numbers of vertices and faces of the mesh that was read.
    pub(super) size: [usize; 2],
    /// The mesh before, if faces were removed and it is needed for a drawing or for the missing piece.
    pub(super) before: Option<Before>,
    /// The mended mesh. Empty for a copy, whose mesh is `kept_input`.
    pub(super) made: Arc<Mesh>,
    /// The expected error of each new vertex.
    pub(super) expected_error: Vec<Option<f64>>,
    /// Whether the mesh contains nothing of the input.
    pub(super) whole: bool,
    /// Which vertices and faces of the input are kept, if some were removed.
    pub(super) kept: Option<KeptElements>,
    /// For each face of `kept_input`, the face of the input that it is or was made from.
    pub(super) face_origins: Vec<u32>,
    /// The number of objects of the input, if they were mended as one mesh.
    #[serde(default)]
    pub(super) bodies_as_one: Option<usize>,
    /// The bodies of the input that were replaced as a whole, each by itself.
    #[serde(default)]
    pub(super) replaced: Vec<ReplacedBody>,
    /// SHA-256 of the file or the bytes that were read; `None` if the mesh was given in memory.
    #[serde(default)]
    pub(super) sha256: Option<String>,
    /// The token that stops its writing.
    #[serde(skip)]
    pub(super) cancel: Cancel,
    /// What was done beside filling.
    pub extent: OperationReport,
    /// What was found and done.
    pub report: FillReport,
}

impl<'s> Mended<'s> {
    /// The work that was asked for.
    #[doc(hidden)]
    pub fn work(&self) -> &Work {
        &self.spec.work
    }

    /// The mesh, in full precision.
    pub fn mesh(&self) -> &Mesh {
        match self.extent {
            OperationReport::Copied => &self.kept_input.mesh,
            _ => &self.made,
        }
    }

    /// Whether the work is complete: no hole that was to be filled is still open, and after a repair the mesh is sound.
    pub fn complete(&self) -> bool {
        self.extent.is_complete(&self.report)
    }

    /// After a repair, adds the verdict on the mesh in full precision. [`Mended::write`] gives the verdict on the written file instead.
    ///
    /// # Errors
    /// If the mesh cannot be inspected.
    pub fn judged(mut self) -> Result<Self, JobError> {
        let verdict = self.verdict_on_bodies()?;
        self.extent.judge(&self.made, verdict)?;
        Ok(self)
    }

    /// The verdict on a repaired mesh whose bodies were repaired by themselves.
    fn verdict_on_bodies(&self) -> Result<Option<Verdict>, JobError> {
        let Some(params) = self.extent.judged_by() else {
            return Ok(None);
        };
        if self.kept_input.bodies().is_none() {
            return Ok(None);
        }
        let Model {
            mesh, attributes, ..
        } = self.model();
        let bodies = Bodies::new(&mesh, &attributes);
        let found = Inspection::of_bodies(&mesh, bodies.as_ref())?;
        Ok(Some(checked(&found, bodies.as_ref(), &params)?))
    }

    /// The name of the command that does this work.
    pub fn command(&self) -> &'static str {
        self.spec.work.name()
    }

    /// The same, with an owned copy of the job.
    pub fn into_owned(self) -> Mended<'static> {
        Mended {
            spec: Cow::Owned(self.spec.into_owned()),
            kept_input: self.kept_input,
            size: self.size,
            before: self.before,
            made: self.made,
            expected_error: self.expected_error,
            whole: self.whole,
            kept: self.kept,
            face_origins: self.face_origins,
            bodies_as_one: self.bodies_as_one,
            replaced: self.replaced,
            sha256: self.sha256,
            cancel: self.cancel,
            extent: self.extent,
            report: self.report,
        }
    }

    /// Sets the deliverables to write and report.
    ///
    /// # Errors
    /// [`JobError::Deliverable`] if the job cannot make them or a file cannot be used.
    pub fn delivering(mut self, deliverables: Deliverables) -> Result<Self, JobError> {
        deliverables.check(&self.spec)?;
        if deliverables.is_filed() {
            clear_run_times(&mut self.report);
        }
        self.spec.to_mut().deliverables = deliverables;
        Ok(self)
    }

    /// Sets the output to write to.
    #[must_use]
    pub fn to(mut self, output: Output) -> Self {
        self.spec.to_mut().output = Some(output);
        // The run that made it is over.
        self.cancel = Cancel::new();
        self
    }

    /// Sets the drawings to make.
    #[must_use]
    pub fn drawn(mut self, drawings: Drawings) -> Self {
        self.spec.to_mut().drawings = drawings;
        self
    }

    /// The mesh with its attributes, in full precision.
    pub fn model(&self) -> Model {
        let (mesh, attributes) = (&self.kept_input.mesh, &self.kept_input.attributes);
        let made = || Mesh::clone(&self.made);
        let mut model: Model = match (self.whole, &self.extent) {
            (true, _) => made().into(),
            (false, OperationReport::Copied) => Loaded::clone(&self.kept_input).into(),
            (false, _) => transfer_without(mesh, attributes, made(), &self.spec.work.painted()),
        };
        let faces = model.mesh.faces.len();
        label_replaced(&self.replaced, attributes, &mut model.attributes, faces);
        model
    }

    /// Numbers of vertices and faces that are the input's; they are the first of the mesh.
    pub fn kept_size(&self) -> [usize; 2] {
        match self.whole {
            true => [0, 0],
            false => [
                self.kept_input.mesh.positions.len(),
                self.kept_input.mesh.faces.len(),
            ],
        }
    }

    /// Which vertices and faces of the input are kept; `None` if all are kept or none.
    pub fn kept(&self) -> Option<&KeptElements> {
        self.kept.as_ref()
    }

    /// The corners of a face; `None` if the mesh has fewer faces.
    pub fn face_corners(&self, face: usize) -> Option<[DVec3; 3]> {
        let mesh = self.mesh();
        let face = mesh.faces.get(face)?;
        Some(face.map(|v| mesh.positions[v as usize]))
    }

    /// For each face of the mesh, the face of the input that it is or was made from (flipped, or with separated corners); `None` for a new
    /// face.
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

    /// For each new vertex its expected error in the mesh's units, `None` if unknown. Empty for a whole level set and for a faired surface.
    pub fn expected_error(&self) -> &[Option<f64>] {
        &self.expected_error
    }

    /// For each of the first `vertices` vertices its expected error in the mesh's units: 0 for vertices of the input, NaN where there is no
    /// estimate. Copies of vertices that [`Mended::model`] may add at the end count as vertices of the input.
    pub fn expected_errors(&self, vertices: usize) -> Vec<f64> {
        let mut errors = vec![0.0; vertices];
        let new = errors
            .iter_mut()
            .skip(self.kept_size()[0])
            .take(self.new_vertices());
        let known = self.expected_error.iter().copied();
        for (error, known) in new.zip(known.chain(std::iter::repeat(None))) {
            *error = known.unwrap_or(f64::NAN);
        }
        errors
    }

    /// Number of new vertices, without the copies of vertices that [`Mended::model`] may add.
    pub fn new_vertices(&self) -> usize {
        self.mesh().positions.len() - self.kept_size()[0]
    }

    /// The vertices in full precision, first the kept ones of the input, without the copies that [`Mended::model`] may add.
    pub fn positions(&self) -> &[DVec3] {
        &self.mesh().positions
    }

    /// Where the mesh was read from.
    pub fn source(&self) -> &Place {
        &self.spec.source.place
    }

    /// The mesh that was read; after a cut or a repair, its kept part.
    pub fn first(&self) -> &Arc<Loaded> {
        &self.kept_input
    }

    /// The HTML page of the mesh in full precision; it shows `command_line`. It shows faces that were cut out only if the job asks for
    /// drawings.
    ///
    /// # Errors
    /// If a copied mesh cannot be inspected.
    pub fn page(&self, command_line: &str) -> Result<String, JobError> {
        match self.extent {
            OperationReport::Copied => self.unchanged(|drawn| Ok(drawn.page(command_line))),
            _ => {
                let (nowhere, notes) = (nowhere(), &self.kept_input.notes);
                let drawn = self.drawing(&self.made, &nowhere, notes, self.filed_facts(None, None));
                Ok(drawn.page(command_line))
            }
        }
    }

    /// The PNG picture of the mesh in full precision. It shows faces that were cut out only if the job asks for drawings.
    ///
    /// # Errors
    /// As [`Mended::page`], and if memory runs out.
    pub fn picture(&self) -> Result<Vec<u8>, JobError> {
        match self.extent {
            OperationReport::Copied => self.unchanged(|drawn| drawn.picture()),
            _ => Ok((self.drawing(&self.made, &nowhere(), &[], Vec::new())).picture()?),
        }
    }

    /// Calls `draw` with the drawing of a copied mesh.
    fn unchanged<R>(
        &self,
        draw: impl FnOnce(&Unchanged<'_>) -> Result<R, JobError>,
    ) -> Result<R, JobError> {
        let bodies = self.kept_input.bodies();
        let found = Inspection::of_bodies(&self.kept_input.mesh, bodies.as_ref())?;
        draw(&Unchanged {
            place: &self.spec.source.place,
            loaded: &self.kept_input,
            found: &found,
            crease_ends: &[],
            verdict: None,
            unit: self.spec.deliverables.unit,
        })
    }

    /// The content of the drawings. `after` is the mesh as it is shown, `output` its place.
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
            kept_input: &self.kept_input.mesh,
            after,
            kept: self.kept_size()[1],
            errors: &self.expected_error,
            notes,
            filed,
            report: &self.report,
            verdict: match &self.extent {
                OperationReport::Repaired(repair) => repair.after.as_ref(),
                _ => None,
            },
        }
    }

    /// Writes the mesh, the deliverables and the drawings: rounds new positions to the format, transfers attributes, and after a repair
    /// checks the written bytes.
    ///
    /// # Errors
    /// If there is no output, or a file cannot be written.
    pub fn write(mut self) -> Result<JobResult<'s>, JobError> {
        let output = self.spec.output.clone().ok_or_else(|| JobError::Places {
            what: "the job has no output; set one with `Mended::to`".to_owned(),
        })?;
        self.spec.deliverables.check(&self.spec)?;
        let components = self.components();
        let mut delivered = Delivered {
            invented: self.invented(&components),
            ..Delivered::default()
        };
        let regions: &mut [RegionReport] = &mut self.report.regions;
        let (own, mut staging) = (std::mem::take(&mut self.made), Staging::default());
        let wanted = &self.spec.deliverables;
        let (mesh, notes, bytes, sha256) = match &self.extent {
            OperationReport::Copied => {
                let stored = output.write_copy(&self.kept_input, wanted.unit, &mut staging)?;
                (None, stored.notes, stored.bytes, stored.sha256)
            }
            _ => {
                // Copies the mesh only if it is shared, as with a step of the interactive view.
                let own = Arc::unwrap_or_clone(own);
                let saving = Saving {
                    input: &self.kept_input,
                    whole: self.whole,
                    replaced: &self.replaced,
                    expected_error: &self.expected_error,
                    judges: self.extent.judged_by(),
                    components: &components,
                    mark: wanted.mark,
                    unit: wanted.unit,
                    source: &self.spec.source.place,
                    unwanted: &self.spec.work.painted(),
                    plain_patches: wanted.has_plain_patches(),
                    continues_paint: wanted.continue_paint,
                    cancel: &self.cancel,
                };
                let mut saved = output.write_mended(own, &saving, regions, &mut staging)?;
                let notes = self.notes_on_work(&saved.mesh, output.format);
                saved.notes.extend(notes);
                self.deliver(&saved, &components, &mut delivered, &mut staging)?;
                self.extent.judge(&saved.mesh, saved.verdict)?;
                (Some(saved.mesh), saved.notes, saved.bytes, saved.sha256)
            }
        };
        let notes_read = self.kept_input.notes.len();
        let notes = [&self.kept_input.notes[..], &notes, &delivered.notes].concat();
        let filed = (&delivered, &sha256[..]);
        self.stage_drawings(mesh.as_ref(), &notes, filed, &mut staging)?;
        staging.finish(&self.cancel)?;
        Ok(JobResult {
            spec: self.spec,
            format: self.kept_input.format,
            size: self.size,
            extent: self.extent,
            report: self.report,
            mesh: mesh.unwrap_or_else(|| Arc::unwrap_or_clone(self.kept_input).mesh),
            bytes,
            notes,
            notes_read,
            sha256: [self.sha256, Some(sha256)],
            delivered,
        })
    }
}

impl Mended<'_> {
    /// Remarks on the work: objects that were mended as one mesh or not faired, components that are inside out, a flat base that was not made, and
    /// vertices that keep the colour of the mask.
    fn notes_on_work(&self, mesh: &Mesh, format: Format) -> Vec<String> {
        let one_mesh = |count| one_mesh_note(count, format);
        let painted = match self.whole {
            true => None,
            false => painted::note(mesh, &self.kept_input, &self.spec.work.painted()),
        };
        let inside_out = match self.spec.work {
            Work::Fill(_) if !self.whole => {
                inside_out::note(mesh, self.kept_input.mesh.faces.len())
            }
            _ => None,
        };
        let no_base = match &self.spec.work {
            Work::Fill(fill) | Work::Repair(RepairParams { fill, .. }) if fill.flat_base => {
                no_base::note(&self.report.holes)
            }
            _ => None,
        };
        let kept: &[_] = match &self.extent {
            OperationReport::Faired(report) => &report.kept_objects,
            _ => &[],
        };
        self.bodies_as_one
            .map(one_mesh)
            .into_iter()
            .chain(kept.iter().map(kept_object))
            .chain(inside_out)
            .chain(no_base)
            .chain(painted)
            .collect()
    }

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
