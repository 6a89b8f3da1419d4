//! Replacing a marked region: its faces are cut out, and what is missing then is filled.

use std::time::Instant;

use super::control::{Control, Watch};
use super::cut::{CutResult, count};
use super::params::RestoreParams;
use super::plan::RestorePlan;
use super::regions::Regions;
use super::report::RestoreReport;
use super::{FillError, Filled, Inspection, RestoreError};
use crate::fill::{FillParams, ReferenceSurface};
use crate::mesh::Mesh;
use crate::mesh::cut::Remainder;
use crate::parameters::tables;

/// A mesh whose marked region was replaced.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Restored {
    /// The mesh: what is kept of the input's vertices and faces first, in order and bit-exact, then the patches.
    pub mesh: Mesh,
    /// What is kept of the input, and which vertices and faces these are.
    pub kept: Remainder,
    /// For each vertex of a patch its expected error; see [`Filled::expected_error`].
    pub expected_error: Vec<Option<f64>>,
    /// What was found and done.
    pub report: RestoreReport,
}

impl Inspection<'_> {
    /// Replaces the marked faces by patches that continue what is round them. `marked` has a mark for each face.
    ///
    /// Faces are cut out along edges. Holes inside the marked region or at its rim are filled with it; all others stay. Where
    /// faces would hang together by a vertex only, the smaller side is cut out too, and so are small components left inside.
    ///
    /// # Errors
    /// When the parameters make no sense, when nothing or the whole of a piece is marked, or when the marked region reaches
    /// the outer border of an open sheet; [`FillError::Cancelled`]. A region that cannot be filled is no error: the report
    /// says so.
    pub fn restore(
        &self,
        marked: &[bool],
        params: &RestoreParams,
        control: &Control,
    ) -> Result<Restored, RestoreError> {
        control.install(|| {
            let clock = Instant::now();
            let cut = self.cut(marked, params)?;
            let reference = (params.keep_shape > 0.0).then(|| cut.reference(params.keep_shape));
            let filled = cut.fill(&params.fill, reference.as_ref(), control)?;
            drop(reference);
            let mut report = told(&cut, marked, params);
            report.fill = filled.report;
            report.fill.seconds = clock.elapsed().as_secs_f64();
            Ok(Restored {
                mesh: filled.mesh,
                expected_error: filled.expected_error,
                kept: cut.into_kept(),
                report,
            })
        })
    }

    /// What [`Inspection::restore`] would do, without doing it. Regions are planned without the surface that is cut out.
    ///
    /// # Errors
    /// As [`Inspection::restore`].
    pub fn plan_restore(
        &self,
        marked: &[bool],
        params: &RestoreParams,
    ) -> Result<RestorePlan, RestoreError> {
        let cut = self.cut(marked, params)?;
        let fill = cut.params(&params.fill);
        let mut fill = Regions::new(&cut.found, fill, None)?.plan();
        cut.plan(&mut fill);
        let [removed_faces, removed_vertices] = cut.taken();
        Ok(RestorePlan {
            marked_faces: count(marked),
            removed_faces,
            removed_vertices,
            keep_shape: params.keep_shape,
            fill,
        })
    }

    fn cut(&self, marked: &[bool], params: &RestoreParams) -> Result<CutResult<'_>, RestoreError> {
        params.check()?;
        RestoreError::check_marks(&self.input, marked)?;
        CutResult::new(self, marked, params.keep_vertices, true)
    }
}

impl RestoreParams {
    /// Whether they make sense by themselves.
    ///
    /// # Errors
    /// [`FillError::Bounds`] and [`FillError::Parameter`].
    pub fn check(&self) -> Result<(), RestoreError> {
        self.fill.check()?;
        let part = tables::KEEP_SHAPE.check(self.keep_shape);
        Ok(part.map_err(FillError::Bounds)?)
    }
}

fn told(cut: &CutResult, marked: &[bool], params: &RestoreParams) -> RestoreReport {
    let [removed_faces, removed_vertices] = cut.taken();
    RestoreReport {
        marked_faces: count(marked),
        removed_faces,
        removed_vertices,
        keep_shape: params.keep_shape,
        ..RestoreReport::default()
    }
}

impl CutResult<'_> {
    /// Fills what the cut left open.
    pub(super) fn fill(
        &self,
        params: &FillParams,
        reference: Option<&ReferenceSurface>,
        control: &Control,
    ) -> Result<Filled, FillError> {
        let regions = Regions::new(&self.found, self.params(params), reference)?;
        let mut filled = regions.fill(&Watch::new(*control, regions.expected_work()))?;
        self.told(&mut filled.report);
        Ok(filled)
    }
}
