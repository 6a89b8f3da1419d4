//! The steps of a job.

use super::draw::{Before, Drawn};
use super::output::Saved;
use super::{JobError, JobSpec, MaskSpec, Work};
use crate::check::{CheckParams, Verdict};
use crate::io::{Format, Loaded};
use crate::mend::{
    Carried, Control, FairError, FairParams, FairReport, FillReport, Inspection, RegionReport,
    RepairParams, RepairReport, RestoreError, RestoreReport, SurfaceKind, repair,
};
use crate::mesh::cut::Remainder;
use crate::mesh::{FaceOrigin, Mesh};

/// A job whose mesh was read.
pub struct Read<'s> {
    spec: &'s JobSpec,
    /// What was read.
    pub loaded: Loaded,
}

/// A job whose mesh was mended.
pub struct Mended<'s> {
    spec: &'s JobSpec,
    /// The mesh whose vertices and faces come first.
    first: Loaded,
    /// Vertices and faces of the mesh that was read.
    size: [usize; 2],
    /// The mesh before, where something was cut out and it is to be drawn.
    before: Option<Before>,
    /// The mesh after.
    mesh: Mesh,
    /// For each vertex of a patch its expected error.
    sigma: Vec<Option<f64>>,
    /// Whether nothing of the input is in it.
    whole: bool,
    /// What was done beside filling.
    pub extent: Extent,
    /// What was found and done.
    pub report: FillReport,
}

/// What of the mesh was replaced, beside its holes; in a plan, what would be.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Extent {
    /// Nothing.
    Holes,
    /// A marked region. The report of its fill is [`JobResult::report`], and empty here.
    Region(RestoreReport),
    /// The surface or a region of it, faired. The report of its regions is [`JobResult::report`], and empty here.
    Faired(FairReport),
    /// What was wrong. The report of its fills is [`JobResult::report`], and empty here.
    Repaired(Box<RepairReport>),
}

/// What came of a job.
#[derive(Debug)]
pub struct JobResult<'s> {
    /// The job.
    pub spec: &'s JobSpec,
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
        Ok(Read {
            spec: self,
            loaded: self.source.read()?,
        })
    }

    /// Whether vertices that no face uses any more are kept: a glTF document goes through as it is, and so do its numbers.
    fn keeps_vertices(&self, loaded: &Loaded) -> bool {
        let to_gltf = self.output.as_ref().is_some_and(|o| o.is_gltf());
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
        let found = Inspection::new(&loaded.mesh)?;
        let (extent, report) = match &spec.work {
            Work::Fill(params) => (Extent::Holes, found.plan(params)?),
            Work::Repair(params) => {
                let plan = RepairReport {
                    before: Some(found.check(&CheckParams::default())),
                    ..RepairReport::default()
                };
                (Extent::Repaired(Box::new(plan)), found.plan(&params.fill)?)
            }
            Work::Restore(mask, params) => {
                let marked = marks(mask, &loaded)?;
                let mut plan = found.plan_restore(&marked, params)?;
                let fill = std::mem::take(&mut plan.fill);
                (Extent::Region(plan), fill)
            }
            Work::Fair(mask, params) => {
                let marked = mask.as_ref().map(|mask| marks(mask, &loaded)).transpose()?;
                let mut plan = found.plan_fair(marked.as_deref(), params)?;
                let fill = std::mem::take(&mut plan.fill);
                (Extent::Faired(plan), fill)
            }
        };
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
        let Self { spec, loaded } = self;
        let size = [loaded.mesh.positions.len(), loaded.mesh.faces.len()];
        let keep_vertices = spec.keeps_vertices(&loaded);
        let (mesh, sigma, kept, extent, report) = match &spec.work {
            Work::Fill(params) => {
                let filled = Inspection::new(&loaded.mesh)?.fill(params, control)?;
                (
                    filled.mesh,
                    filled.sigma,
                    None,
                    Extent::Holes,
                    filled.report,
                )
            }
            Work::Restore(mask, params) => {
                let marked = marks(mask, &loaded)?;
                let mut params = params.clone();
                params.keep_vertices |= keep_vertices;
                let found = Inspection::new(&loaded.mesh).map_err(RestoreError::from)?;
                let mut restored = found.restore(&marked, &params, control)?;
                let fill = std::mem::take(&mut restored.report.fill);
                let extent = Extent::Region(restored.report);
                (
                    restored.mesh,
                    restored.sigma,
                    Some(restored.kept),
                    extent,
                    fill,
                )
            }
            Work::Repair(params) => return repaired(spec, loaded, params, control),
            Work::Fair(mask, params) => {
                let marked = mask.as_ref().map(|mask| marks(mask, &loaded)).transpose()?;
                faired(&loaded, marked, params, keep_vertices, control)?
            }
        };
        let whole = match (&spec.work, &extent) {
            (Work::Fill(params), _) => params.surface == SurfaceKind::Whole,
            (_, Extent::Faired(_)) => kept.is_none(),
            _ => false,
        };
        let (first, before) = cut(loaded, kept.as_ref(), spec.drawings.is_wanted());
        Ok(Mended {
            spec,
            first,
            size,
            before,
            mesh,
            sigma,
            whole,
            extent,
            report,
        })
    }
}

/// What a work makes of a mesh: the mesh, expected errors, what is kept of the input, what was done beside filling, and the fill.
type Changed = (
    Mesh,
    Vec<Option<f64>>,
    Option<Remainder>,
    Extent,
    FillReport,
);

/// A mesh faired, all of it or the marked faces.
fn faired(
    loaded: &Loaded,
    marked: Option<Vec<bool>>,
    params: &FairParams,
    keep_vertices: bool,
    control: &Control,
) -> Result<Changed, JobError> {
    let mut params = params.clone();
    params.keep_vertices |= keep_vertices;
    let found = Inspection::new(&loaded.mesh).map_err(FairError::from)?;
    let mut faired = found.fair(marked.as_deref(), &params, control)?;
    let fill = std::mem::take(&mut faired.report.fill);
    let extent = Extent::Faired(faired.report);
    Ok((faired.mesh, Vec::new(), faired.kept, extent, fill))
}

/// A mesh repaired, with what its faces and vertices carried.
fn repaired<'s>(
    spec: &'s JobSpec,
    loaded: Loaded,
    params: &RepairParams,
    control: &Control,
) -> Result<Mended<'s>, JobError> {
    let size = [loaded.mesh.positions.len(), loaded.mesh.faces.len()];
    let in_place = spec.keeps_vertices(&loaded);
    let alike = |a, b| !in_place && loaded.attributes.are_alike(a, b);
    let carried = Carried {
        alike: &alike,
        in_place,
    };
    let mut done = repair(&loaded.mesh, params, &carried, control)?;
    let (vertices, faces) = (done.origins.vertices.len(), done.origins.faces.len());
    let first = Mesh::new(
        done.mesh.positions[..vertices].to_vec(),
        done.mesh.faces[..faces].to_vec(),
    );
    let mut kept = vec![false; size[1]];
    for (face, origin) in first.faces.iter().zip(&done.origins.faces) {
        let old = origin.face as usize;
        kept[old] |= *origin == FaceOrigin::same(origin.face) && *face == loaded.mesh.faces[old];
    }
    let living = done.origins.living(size[1]);
    let before = spec.drawings.is_wanted().then(|| Before {
        mesh: loaded.mesh.clone(),
        gone: living.iter().map(|lives| !lives).collect(),
    });
    let report = std::mem::take(&mut done.report.fill);
    Ok(Mended {
        spec,
        first: loaded.derived(first, &done.origins, &kept),
        size,
        before,
        mesh: done.mesh,
        sigma: done.sigma,
        whole: false,
        extent: Extent::Repaired(Box::new(done.report)),
        report,
    })
}

/// The marks of a mask, which must mark something.
fn marks(mask: &MaskSpec, loaded: &Loaded) -> Result<Vec<bool>, JobError> {
    mask.marked(loaded)?.some()
}

/// What is left of a mesh after a cut; and the mesh as it was, where it is wanted.
fn cut(loaded: Loaded, kept: Option<&Remainder>, wanted: bool) -> (Loaded, Option<Before>) {
    let Some(kept) = kept else {
        return (loaded, None);
    };
    let before = wanted.then(|| Before {
        mesh: loaded.mesh.clone(),
        gone: kept.faces.iter().map(|kept| !kept).collect(),
    });
    (loaded.restricted(kept), before)
}

impl<'s> Mended<'s> {
    /// Rounds, carries attributes over, checks what is written, writes and draws it.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(mut self) -> Result<JobResult<'s>, JobError> {
        let spec = self.spec;
        let output = spec.output.as_ref().ok_or_else(|| JobError::Places {
            what: "there is no output to write to".to_owned(),
        })?;
        let regions: &mut [RegionReport] = &mut self.report.regions;
        let saved =
            output.write_mended(self.mesh, &self.first, self.whole, &self.sigma, regions)?;
        let Saved { mesh, notes, bytes } = saved;
        let notes_read = self.first.notes.len();
        let notes = [self.first.notes, notes].concat();
        if let Extent::Repaired(report) = &mut self.extent {
            report.after = Some(Inspection::new(&mesh)?.check(&CheckParams::default()));
        }
        spec.drawings.write(&Drawn {
            command: spec.work.name(),
            places: [&spec.source.place, &output.place],
            before: self.before.as_ref(),
            first: &self.first.mesh,
            after: &mesh,
            kept: if self.whole {
                0
            } else {
                self.first.mesh.faces.len()
            },
            notes: &notes,
            report: &self.report,
        })?;
        Ok(JobResult {
            spec,
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
        match &self.extent {
            Extent::Faired(_) => true,
            Extent::Repaired(report) => report.after.as_ref().is_none_or(Verdict::is_sound),
            _ => !self.report.incomplete(),
        }
    }
}
