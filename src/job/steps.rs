//! The steps of a job.

use std::borrow::Cow;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::draw::{Before, Drawings, Drawn, Unchanged};
use super::output::Saved;
use super::result::{Extent, First, Kept, Made, repaired};
use super::{JobError, JobSpec, MaskSpec, Output, Place, Work};
use crate::attributes::transfer;
use crate::check::CheckParams;
use crate::fill::{RegionReport, SurfaceKind};
use crate::io::{Format, Loaded};
use crate::mend::{Control, FairError, FillReport, Filled, Inspection, RestoreError};
use crate::mesh::{Mesh, Model};
use crate::repair::RepairReport;

/// A job whose mesh was read.
pub struct Read<'s> {
    spec: Cow<'s, JobSpec>,
    /// What was read.
    pub loaded: Loaded,
}

/// A job whose mesh was mended. As a value it can be written and read again, whole: its mesh, what that carries, its report.
#[derive(Clone, Serialize, Deserialize)]
pub struct Mended<'s> {
    pub(super) spec: Cow<'s, JobSpec>,
    /// The mesh whose vertices and faces come first.
    pub(super) first: Loaded,
    /// Vertices and faces of the mesh that was read.
    pub(super) size: [usize; 2],
    /// The mesh before, where something was cut out and it is to be drawn.
    before: Option<Before>,
    /// The mesh after.
    pub(super) mesh: Mesh,
    /// For each vertex of a patch its expected error.
    sigma: Vec<Option<f64>>,
    /// Whether nothing of the input is in it.
    whole: bool,
    /// Which vertices and faces of the input are kept, where something was cut out.
    kept: Option<Kept>,
    /// For each face of `first` the face of the input that it is or was made of.
    face_origins: Vec<u32>,
    /// What was done beside filling.
    pub extent: Extent,
    /// What was found and done.
    pub report: FillReport,
}

/// What came of a job.
#[derive(Debug)]
#[non_exhaustive]
pub struct JobResult<'s> {
    /// The job.
    pub spec: Cow<'s, JobSpec>,
    /// The format that was read.
    pub format: Format,
    /// Vertices and faces of the mesh that was read.
    pub size: [usize; 2],
    /// Whether this is what would be done.
    pub planned: bool,
    /// What of the mesh was replaced.
    pub extent: Extent,
    /// What was found and done.
    pub report: FillReport,
    /// The mesh as it was written; none in a plan.
    pub mesh: Option<Mesh>,
    /// The bytes, where they are the caller's.
    pub bytes: Vec<u8>,
    /// Remarks of the reader and the writer.
    pub notes: Vec<String>,
    /// How many of them are the reader's.
    pub notes_read: usize,
}

/// Does a job: reads, mends and writes, or says what it would do where it has no output.
///
/// # Errors
/// [`JobError`]. A hole that cannot be filled is none: the report says so.
pub fn run<'s>(spec: &'s JobSpec, control: &Control) -> Result<JobResult<'s>, JobError> {
    spec.check()?;
    let read = spec.read()?;
    match spec.output {
        Some(_) => read.mend(control)?.write(),
        None => read.plan(),
    }
}

impl JobSpec {
    /// Reads the mesh.
    ///
    /// # Errors
    /// As [`super::Source::read`].
    pub fn read(&self) -> Result<Read<'_>, JobError> {
        Ok(self.with(self.source.read()?))
    }

    /// The job with a mesh that was read before, or made.
    pub fn with(&self, loaded: Loaded) -> Read<'_> {
        let spec = Cow::Borrowed(self);
        Read { spec, loaded }
    }

    /// Whether vertices that no face uses any more are kept: a glTF document goes through as it is, and so do its numbers. It may
    /// still be asked for where there is no output yet.
    fn keeps_vertices(&self, loaded: &Loaded) -> bool {
        let to_gltf = self.output.as_ref().is_none_or(|o| o.is_gltf());
        to_gltf && loaded.document.is_some()
    }
}

impl<'s> Read<'s> {
    /// What would be done, without doing it.
    ///
    /// # Errors
    /// When the mask or the parameters do not fit the mesh.
    pub fn plan(self) -> Result<JobResult<'s>, JobError> {
        let Self { spec, loaded } = self;
        let (extent, report) = planned(&spec.work, &loaded)?;
        Ok(JobResult {
            spec,
            format: loaded.format,
            size: [loaded.mesh.positions.len(), loaded.mesh.faces.len()],
            planned: true,
            extent,
            report,
            mesh: None,
            bytes: Vec::new(),
            notes_read: loaded.notes.len(),
            notes: loaded.notes,
        })
    }

    /// Does the work.
    ///
    /// # Errors
    /// When the mask or the parameters do not fit the mesh, or the run is stopped.
    pub fn mend(self, control: &Control) -> Result<Mended<'s>, JobError> {
        let made = match &self.spec.work {
            Work::Repair(params) => {
                let in_place = self.spec.keeps_vertices(&self.loaded);
                repaired(&self.loaded, in_place, params, control)?
            }
            Work::Copy => Made::copy(&self.loaded.mesh),
            work => self.make(&work.inspect(&self.loaded.mesh)?, control)?,
        };
        Ok(self.mended(made))
    }

    /// Does the work on a mesh that was inspected before: `found` is what its mesh holds.
    ///
    /// # Errors
    /// As [`Read::mend`].
    pub fn mend_found(self, found: &Inspection, control: &Control) -> Result<Mended<'s>, JobError> {
        let made = self.make(found, control)?;
        Ok(self.mended(made))
    }

    /// Takes what was filled elsewhere, such as by [`crate::Regions::assemble`].
    pub fn filled(self, filled: Filled) -> Mended<'s> {
        self.mended(filled.into())
    }

    fn make(&self, found: &Inspection, control: &Control) -> Result<Made, JobError> {
        let Self { spec, loaded } = self;
        let keep_vertices = spec.keeps_vertices(loaded);
        Ok(match &spec.work {
            Work::Fill(params) => found.fill(params, control)?.into(),
            Work::Restore(mask, params) => {
                let marked = marks(mask, loaded)?;
                let mut params = params.clone();
                params.keep_vertices |= keep_vertices;
                found.restore(&marked, &params, control)?.into()
            }
            Work::Repair(params) => repaired(loaded, keep_vertices, params, control)?,
            Work::Copy => Made::copy(&loaded.mesh),
            Work::Fair(mask, params) => {
                let marked = mask.as_ref().map(|mask| marks(mask, loaded)).transpose()?;
                let mut params = params.clone();
                params.keep_vertices |= keep_vertices;
                found.fair(marked.as_deref(), &params, control)?.into()
            }
        })
    }

    fn mended(self, made: Made) -> Mended<'s> {
        let Self { spec, loaded } = self;
        let whole = match (&spec.work, &made.extent) {
            (Work::Fill(params), _) => params.surface == SurfaceKind::Whole,
            (_, Extent::Faired(_)) => matches!(made.first, First::All),
            _ => false,
        };
        let size = [loaded.mesh.positions.len(), loaded.mesh.faces.len()];
        let wanted = spec.drawings.is_wanted() || spec.drawings.may_follow;
        let gone = wanted.then(|| made.first.gone(size[1])).flatten();
        let before = gone.map(|gone| Before {
            mesh: loaded.mesh.clone(),
            gone,
        });
        let face_origins = made.first.face_origins(size[1]);
        let (first, kept) = made.first.of(loaded);
        Mended {
            spec,
            first,
            size,
            before,
            mesh: made.mesh,
            sigma: made.sigma,
            whole,
            kept,
            face_origins,
            extent: made.extent,
            report: made.report,
        }
    }
}

impl Work {
    /// What a mesh holds, with errors in this work's words.
    fn inspect<'m>(&self, mesh: &'m Mesh) -> Result<Inspection<'m>, JobError> {
        let found = Inspection::new(mesh);
        Ok(match self {
            Self::Fill(_) | Self::Repair(_) | Self::Copy => found?,
            Self::Restore(..) => found.map_err(RestoreError::from)?,
            Self::Fair(..) => found.map_err(FairError::from)?,
        })
    }
}

/// What would be done with a mesh.
fn planned(work: &Work, loaded: &Loaded) -> Result<(Extent, FillReport), JobError> {
    let mesh = &loaded.mesh;
    Ok(match work {
        Work::Fill(params) => (Extent::Holes, Inspection::new(mesh)?.plan(params)?),
        Work::Repair(params) => {
            let found = Inspection::new(mesh)?;
            let plan = RepairReport {
                before: Some(found.check(&CheckParams::default())),
                ..RepairReport::default()
            };
            (Extent::Repaired(Box::new(plan)), found.plan(&params.fill)?)
        }
        Work::Restore(mask, params) => {
            let found = Inspection::new(mesh)?;
            let marked = marks(mask, loaded)?;
            let mut plan = found.plan_restore(&marked, params)?;
            let fill = std::mem::take(&mut plan.fill);
            (Extent::Region(plan), fill)
        }
        Work::Fair(mask, params) => {
            let found = Inspection::new(mesh)?;
            let marked = mask.as_ref().map(|mask| marks(mask, loaded)).transpose()?;
            let mut plan = found.plan_fair(marked.as_deref(), params)?;
            let fill = std::mem::take(&mut plan.fill);
            (Extent::Faired(plan), fill)
        }
        Work::Copy => {
            let copied = Made::copy(mesh);
            (copied.extent, copied.report)
        }
    })
}

/// The place of a result that is written nowhere, on its page.
fn nowhere() -> Place {
    Place::Bytes("in memory".to_owned())
}

/// The marks of a mask, which must mark something.
fn marks(mask: &MaskSpec, loaded: &Loaded) -> Result<Vec<bool>, JobError> {
    mask.marked(loaded)?.some()
}

impl<'s> Mended<'s> {
    /// Whether nothing that was to be filled is still open.
    pub fn complete(&self) -> bool {
        self.extent.is_complete(&self.report)
    }

    /// The same, after a repair with the verdict on the mesh in full precision. [`Mended::write`] gives that on what is written.
    ///
    /// # Errors
    /// When the mesh cannot be measured.
    pub fn judged(mut self) -> Result<Self, JobError> {
        self.extent.judge(&self.mesh)?;
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
            mesh: self.mesh,
            sigma: self.sigma,
            whole: self.whole,
            kept: self.kept,
            face_origins: self.face_origins,
            extent: self.extent,
            report: self.report,
        }
    }

    /// The same, to be written elsewhere.
    #[must_use]
    pub fn to(mut self, output: Output) -> Self {
        self.spec.to_mut().output = Some(output);
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
            (true, _) => self.mesh.clone().into(),
            (false, Extent::Copied) => self.first.clone().into(),
            (false, _) => transfer(&self.first.mesh, &self.first.attributes, self.mesh.clone()),
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
        let face = self.mesh.faces.get(face)?;
        Some(face.map(|v| self.mesh.positions[v as usize]))
    }

    /// For each face of the mesh the face of the input that it is or was made of, turned over or with corners moved apart; none for a
    /// new one.
    pub fn face_origins(&self) -> Vec<Option<u32>> {
        let mut origins = vec![None; self.mesh.faces.len()];
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
    pub fn sigma(&self) -> &[Option<f64>] {
        &self.sigma
    }

    /// Number of vertices that are not the input's, without copies of others that [`Mended::model`] may add.
    pub fn new_vertices(&self) -> usize {
        self.mesh.positions.len() - self.kept_size()[0]
    }

    /// The vertices, those of the input that are kept first, in full precision, without the copies that [`Mended::model`] may add.
    pub fn positions(&self) -> &[DVec3] {
        &self.mesh.positions
    }

    /// Where the mesh was read from.
    pub fn source(&self) -> &Place {
        &self.spec.source.place
    }

    /// What was read, or what is left of it where something was cut out.
    pub fn first(&self) -> &Loaded {
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
                let drawn = self.drawing(&self.mesh, &nowhere, notes);
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
            _ => Ok(self.drawing(&self.mesh, &nowhere(), &[]).picture()?),
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
            verdict: None,
        })
    }

    /// What is drawn: `after` is the mesh in the positions that are shown, `output` where it goes.
    fn drawing<'a>(&'a self, after: &'a Mesh, output: &'a Place, notes: &'a [String]) -> Drawn<'a> {
        Drawn {
            command: self.spec.work.name(),
            places: [&self.spec.source.place, output],
            before: self.before.as_ref(),
            first: &self.first.mesh,
            after,
            kept: self.kept_size()[1],
            errors: &self.sigma,
            notes,
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
        let regions: &mut [RegionReport] = &mut self.report.regions;
        let own = std::mem::take(&mut self.mesh);
        let saved = match &self.extent {
            Extent::Copied => output.write_copy(&self.first)?,
            _ => output.write_mended(own, &self.first, self.whole, &self.sigma, regions)?,
        };
        let Saved { mesh, notes, bytes } = saved;
        let notes_read = self.first.notes.len();
        let notes = [&self.first.notes[..], &notes].concat();
        self.extent.judge(&mesh)?;
        let drawings = &self.spec.drawings;
        match &self.extent {
            Extent::Copied if !drawings.is_wanted() => {}
            Extent::Copied => self.unchanged(|drawn| drawings.write_unchanged(drawn))?,
            _ => drawings.write(&self.drawing(&mesh, &output.place, &notes))?,
        }
        Ok(JobResult {
            spec: self.spec,
            format: self.first.format,
            size: self.size,
            planned: false,
            extent: self.extent,
            report: self.report,
            mesh: Some(mesh),
            bytes,
            notes,
            notes_read,
        })
    }
}

impl JobResult<'_> {
    /// The remarks of the writer.
    pub fn notes_written(&self) -> &[String] {
        &self.notes[self.notes_read..]
    }

    /// Whether nothing that was to be filled is still open.
    pub fn complete(&self) -> bool {
        self.extent.is_complete(&self.report)
    }
}
