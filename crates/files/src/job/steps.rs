//! The steps of a job: read the mesh, plan the work or do it.

use std::borrow::Cow;
use std::sync::Arc;

use glam::{DMat4, DVec3};

use super::bodies::mended_as_one;
use super::deliver::clear_run_times;
use super::draw::Before;
use super::mended::Mended;
use super::outcome::{JobPlan, JobResult, WorkPlan};
use super::painted;
use super::result::{KeptInput, Made, repaired};
use super::template::with_template;
use super::{JobError, JobSpec, Looked, MaskSpec, PaintedColour, Work, check, inspect};
use crate::io::Loaded;
use isomend_core::attributes::UnwantedColour;
use isomend_core::cancel::Cancel;
use isomend_core::mend::{Control, FairError, FillError, Filled, Inspection, RestoreError};
use isomend_core::mesh::{Bodies, Mesh, significant};
use isomend_core::repair::RepairParams;

/// A job whose mesh has been read.
pub struct Read<'s> {
    pub(super) spec: Cow<'s, JobSpec>,
    /// SHA-256 of the file or the bytes; `None` for a mesh in memory.
    sha256: Option<String>,
    /// The mesh that was read; shared, not copied.
    pub loaded: Arc<Loaded>,
}

/// Runs a job: reads, mends and writes.
///
/// # Errors
/// [`JobError`]; [`JobError::Places`] if the job has no output. A hole that cannot be filled is not an error; the report lists it.
pub fn run<'s>(spec: &'s JobSpec, control: &Control) -> Result<JobResult<'s>, JobError> {
    spec.check()?;
    if spec.output.is_none() {
        let what = "the job has no output; set one, or use `Read::plan` for a plan".to_owned();
        return Err(JobError::Places { what });
    }
    spec.read()?.mend(control)?.write()
}

impl JobSpec {
    /// Reads the mesh.
    ///
    /// # Errors
    /// As [`super::Source::read`].
    pub fn read(&self) -> Result<Read<'_>, JobError> {
        let (loaded, sha256) = self.source.read_hashed()?;
        Ok(Read {
            sha256,
            ..self.with(loaded)
        })
    }

    /// Reads the mesh and plans the job; an output is not needed.
    ///
    /// # Errors
    /// The errors of [`run`] that are known before the work.
    pub fn preview(&self) -> Result<JobPlan<'_>, JobError> {
        self.check()?;
        self.read()?.plan()
    }

    /// The job with a mesh in memory instead of its source.
    pub fn with(&self, loaded: impl Into<Arc<Loaded>>) -> Read<'_> {
        Read {
            spec: Cow::Borrowed(self),
            sha256: None,
            loaded: loaded.into(),
        }
    }

    /// Whether vertices stay that no face uses after the work. They stay if a glTF document is written as glTF: the document is passed
    /// through unchanged, so vertices must keep their numbers. Without an output yet, glTF output is assumed.
    fn keeps_vertices(&self, loaded: &Loaded) -> bool {
        let to_gltf = self.output.as_ref().is_none_or(|o| o.is_gltf());
        to_gltf && loaded.document.as_ref().is_some_and(|d| d.gltf().is_some())
    }

    /// A remark on how far the positions of the input were rounded, if a repair works on 32-bit floats because its output stores them.
    fn rounding_note(&self, loaded: &Loaded) -> Option<String> {
        let is_repair = matches!(self.work, Work::Repair(_)) && !loaded.f32_exact;
        if !is_repair || self.carried(loaded) != (false, Some(DMat4::IDENTITY)) {
            return None;
        }
        let shift = |p: &DVec3| (p.as_vec3().as_dvec3() - p).abs().max_element();
        let largest = loaded.mesh.positions.iter().map(shift).fold(0.0, f64::max);
        let note = format!(
            "positions were rounded to 32-bit floats before the repair, by up to {}",
            significant(largest, 2)
        );
        Some(note)
    }

    /// The properties of the output that a repair needs: whether vertices keep their numbers, and [`Carried::stored`], the coordinates in
    /// which the output stores 32-bit floats.
    ///
    /// [`Carried::stored`]: isomend_core::repair::Carried::stored
    pub(super) fn carried(&self, loaded: &Loaded) -> (bool, Option<DMat4>) {
        let stored = match &self.output {
            Some(output) => output.stored(loaded),
            None => loaded.f32_exact.then_some(DMat4::IDENTITY),
        };
        (self.keeps_vertices(loaded), stored)
    }
}

impl<'s> Read<'s> {
    /// Plans the work without doing it.
    ///
    /// # Errors
    /// If the mask or the parameters do not fit the mesh.
    pub fn plan(self) -> Result<JobPlan<'s>, JobError> {
        check_base(&self.spec.work, &self.loaded.mesh)?;
        let plan = match self.bodies() {
            Some(bodies) => {
                let found = self.spec.work.inspect(&self.loaded.mesh, Some(&bodies))?;
                self.plan_each(&bodies, &found)?
            }
            None => planned(&self.spec.work, &self.loaded)?,
        };
        let Self { spec, loaded, .. } = self;
        Ok(JobPlan {
            plan,
            spec,
            format: loaded.format,
            size: [loaded.mesh.positions.len(), loaded.mesh.faces.len()],
            notes: loaded.notes.clone(),
        })
    }

    /// Looks at the mesh, for work that [only looks](Work::only_looks); other work is taken as an inspection. Makes the drawings.
    ///
    /// # Errors
    /// As [`inspect`] and [`check`](super::check).
    pub fn look(&self, control: &Control) -> Result<Looked<'_>, JobError> {
        let Self { spec, loaded, .. } = self;
        let (source, drawings) = (&spec.source, &spec.drawings);
        let unit = spec.deliverables.unit;
        Ok(match &spec.work {
            Work::Check(params) => {
                Looked::Checked(check(source, loaded, params, unit, drawings, control)?)
            }
            work => {
                let mask = work.mask();
                Looked::Inspected(inspect(source, loaded, mask, unit, drawings, control)?)
            }
        })
    }

    /// Does the work.
    ///
    /// # Errors
    /// If the mask or the parameters do not fit the mesh, or if the run is cancelled.
    pub fn mend(self, control: &Control) -> Result<Mended<'s>, JobError> {
        check_base(&self.spec.work, &self.loaded.mesh)?;
        let made = match (&self.spec.work, self.bodies()) {
            (Work::Copy | Work::Inspect(_) | Work::Check(_), _) => Made::copy(&self.loaded.mesh),
            (work, Some(bodies)) => {
                let found = work.inspect(&self.loaded.mesh, Some(&bodies))?;
                self.make_each(&bodies, &found, control)?
            }
            (Work::Repair(params), None) => self.repaired(params, control)?,
            (work, None) => self.make(&work.inspect(&self.loaded.mesh, None)?, control)?,
        };
        Ok(self.mended(made).stopped_by(control))
    }

    /// Does the work on a mesh that has been inspected; `found` is the inspection.
    ///
    /// # Errors
    /// As [`Read::mend`].
    pub fn mend_found(self, found: &Inspection, control: &Control) -> Result<Mended<'s>, JobError> {
        let made = match self.bodies() {
            Some(bodies) => self.make_each(&bodies, found, control)?,
            None => self.make(found, control)?,
        };
        Ok(self.mended(made).stopped_by(control))
    }

    /// Takes a mesh that was filled elsewhere, for example by [`isomend_core::mend::Regions::assemble`].
    pub fn filled(self, filled: Filled) -> Mended<'s> {
        self.mended(filled.into())
    }

    /// Does the work.
    fn make(&self, found: &Inspection, control: &Control) -> Result<Made, JobError> {
        let Self { spec, loaded, .. } = self;
        let keep_vertices = spec.keeps_vertices(loaded);
        Ok(match &spec.work {
            Work::Fill(params) => found.fill(&*with_template(params)?, control)?.into(),
            Work::Restore(mask, params) => {
                let marked = marks(mask, loaded)?;
                let mut params = params.clone();
                params.fill = with_template(&params.fill)?.into_owned();
                params.keep_vertices |= keep_vertices;
                found.restore(&marked, &params, control)?.into()
            }
            Work::Repair(params) => self.repaired(params, control)?,
            Work::Copy | Work::Inspect(_) | Work::Check(_) => Made::copy(&loaded.mesh),
            Work::Fair(mask, params) => {
                let marked = mask.as_ref().map(|mask| marks(mask, loaded)).transpose()?;
                let mut params = params.clone();
                params.keep_vertices |= keep_vertices;
                found.fair(marked.as_deref(), &params, control)?.into()
            }
        })
    }

    /// Repairs the mesh as a whole.
    fn repaired(&self, params: &RepairParams, control: &Control) -> Result<Made, JobError> {
        let Self { spec, loaded, .. } = self;
        let alike = |a, b| loaded.attributes.are_alike(a, b);
        let (params, carried) = (repair_template(params)?, spec.carried(loaded));
        repaired(&loaded.mesh, &alike, carried, &params, control)
    }

    /// Combines the job, the input and the result of the work.
    fn mended(self, mut made: Made) -> Mended<'s> {
        let Self {
            spec,
            sha256,
            loaded,
        } = self;
        if spec.deliverables.is_filed() {
            clear_run_times(&mut made.report);
        }
        let whole = matches!(made.kept_input, KeptInput::Nothing);
        let size = [loaded.mesh.positions.len(), loaded.mesh.faces.len()];
        let drawn = spec.drawings.is_wanted() || spec.drawings.may_follow;
        let wanted = drawn || spec.deliverables.piece.is_some();
        let gone = wanted.then(|| made.kept_input.gone(size[1])).flatten();
        let before = gone.map(|gone| Before {
            loaded: loaded.clone(),
            gone,
        });
        let bodies_as_one = mended_as_one(&made.extent, &loaded);
        let face_origins = made.kept_input.face_origins(size[1]);
        let note = spec.rounding_note(&loaded);
        let (mut kept_input, kept) = made.kept_input.of(loaded);
        if let Some(note) = note {
            Arc::make_mut(&mut kept_input).notes.push(note);
        }
        if !whole {
            painted::divide(
                &mut made.mesh,
                &mut made.expected_error,
                &mut made.report,
                &kept_input,
                &spec.work.painted(),
            );
        }
        Mended {
            spec,
            kept_input,
            size,
            before,
            made: Arc::new(made.mesh),
            expected_error: made.expected_error,
            whole,
            kept,
            face_origins,
            bodies_as_one,
            replaced: made.replaced,
            sha256,
            cancel: Cancel::default(),
            extent: made.extent,
            report: made.report,
        }
    }
}

impl Mended<'_> {
    /// The same, whose writing is stopped by the token of a run.
    fn stopped_by(mut self, control: &Control) -> Self {
        self.cancel = control.token();
        self
    }
}

impl Work {
    /// The colours by which faces were marked to be replaced. The patches must not be marked again.
    pub(super) fn painted(&self) -> Vec<UnwantedColour> {
        let colours = self.mask().map_or(&[][..], |mask| &mask.colours);
        let unwanted = |c: &PaintedColour| UnwantedColour {
            rgb: c.rgb,
            tolerance: c.tolerance,
        };
        colours.iter().map(unwanted).collect()
    }

    /// Inspects a mesh; errors get the type of this work's errors.
    pub(super) fn inspect<'m>(
        &self,
        mesh: &'m Mesh,
        bodies: Option<&Bodies>,
    ) -> Result<Inspection<'m>, JobError> {
        let found = Inspection::of_bodies(mesh, bodies);
        Ok(match self {
            Self::Restore(..) => found.map_err(RestoreError::from)?,
            Self::Fair(..) => found.map_err(FairError::from)?,
            _ => found?,
        })
    }
}

/// Refuses a distance of a flat base that is out of proportion to the mesh: its walls would have no area beside it.
fn check_base(work: &Work, mesh: &Mesh) -> Result<(), JobError> {
    // In diagonals of the mesh.
    const FARTHEST: f64 = 1e3;
    let offset = match work {
        Work::Fill(fill) => fill.base_offset,
        Work::Repair(params) => params.fill.base_offset,
        _ => None,
    };
    let [low, high] = mesh.bounds();
    match offset.is_some_and(|offset| offset > FARTHEST * low.distance(high)) {
        true => Err(JobError::Fill(FillError::Parameter {
            what: "`base_offset` is more than a thousand times the size of the mesh: take a shorter one",
        })),
        false => Ok(()),
    }
}

/// Plans the work on a mesh.
fn planned(work: &Work, loaded: &Loaded) -> Result<WorkPlan, JobError> {
    let mesh = &loaded.mesh;
    Ok(match work {
        Work::Fill(params) => {
            let found = Inspection::new(mesh)?;
            WorkPlan::Fill(found.plan(&*with_template(params)?)?)
        }
        Work::Repair(params) => {
            let found = Inspection::new(mesh)?;
            WorkPlan::Repair {
                before: Box::new(found.check(&params.checked())),
                fill: found.plan(&*with_template(&params.fill)?)?,
            }
        }
        Work::Restore(mask, params) => {
            let found = Inspection::new(mesh)?;
            let mut params = params.clone();
            params.fill = with_template(&params.fill)?.into_owned();
            WorkPlan::Restore(found.plan_restore(&marks(mask, loaded)?, &params)?)
        }
        Work::Fair(mask, params) => {
            let found = Inspection::new(mesh)?;
            let marked = mask.as_ref().map(|mask| marks(mask, loaded)).transpose()?;
            WorkPlan::Fair(found.plan_fair(marked.as_deref(), params)?)
        }
        Work::Copy | Work::Inspect(_) | Work::Check(_) => WorkPlan::Copy,
    })
}

/// The parameters of a repair with their template.
pub(super) fn repair_template(params: &RepairParams) -> Result<RepairParams, JobError> {
    let mut params = params.clone();
    params.fill = with_template(&params.fill)?.into_owned();
    Ok(params)
}

/// The marked faces of a mask; an error if there are none.
pub(super) fn marks(mask: &MaskSpec, loaded: &Loaded) -> Result<Vec<bool>, JobError> {
    mask.marked(loaded)?.some()
}
