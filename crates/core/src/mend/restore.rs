//! Restoration: cuts a marked region out of a mesh and fills the holes that this makes.

use std::time::Instant;

use super::control::{Control, Watch};
use super::cut::{CutResult, count};
use super::params::RestoreParams;
use super::plan::RestorePlan;
use super::regions::Regions;
use super::report::{FillReport, RestoreReport};
use super::{FillError, Filled, Inspection, RestoreError};
use crate::fill::{FillParams, ReferenceSurface};
use crate::mesh::Mesh;
use crate::mesh::cut::Remainder;
use crate::parameters::tables;

/// A mesh with a replaced region.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Restored {
    /// The mesh: the kept vertices and faces of the input first, in order and bit-exact, then the patches.
    pub mesh: Mesh,
    /// The kept part of the input, with its vertices and faces.
    pub kept: Remainder,
    /// Expected error of each patch vertex; see [`Filled::expected_error`].
    pub expected_error: Vec<Option<f64>>,
    /// Report of the restoration.
    pub report: RestoreReport,
    /// Report of the fill. Holes are numbered as after the cut.
    pub fill: FillReport,
}

impl Inspection<'_> {
    /// Replaces the marked faces by patches that continue their surroundings. `marked` has one mark for each face.
    ///
    /// Faces are cut out along edges. Holes inside the marked region or at its rim are filled with it; all others stay open.
    /// Where the remaining faces would be connected only by a vertex, the smaller side is removed too, and so are small
    /// components that would remain inside.
    ///
    /// # Errors
    /// If the parameters are invalid, if no face or a whole component is marked, or if the marked region reaches the outer border
    /// of an open sheet; [`FillError::Cancelled`]. A region that cannot be filled is not an error: the report lists it.
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
            let fill = FillReport {
                seconds: clock.elapsed().as_secs_f64(),
                ..filled.report
            };
            Ok(Restored {
                mesh: filled.mesh,
                expected_error: filled.expected_error,
                report: restore_report(&cut, marked, params),
                kept: cut.into_kept(),
                fill,
            })
        })
    }

    /// Plans a restoration. Regions are planned without the reference surface that is cut out.
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
        cut.adapt_plan(&mut fill);
        Ok(RestorePlan {
            cut: restore_report(&cut, marked, params),
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
    /// Checks the parameters on their own.
    ///
    /// # Errors
    /// [`FillError::Bounds`] and [`FillError::Parameter`].
    pub fn check(&self) -> Result<(), RestoreError> {
        self.fill.check()?;
        let part = tables::KEEP_SHAPE.check(self.keep_shape);
        Ok(part.map_err(FillError::Bounds)?)
    }
}

fn restore_report(cut: &CutResult, marked: &[bool], params: &RestoreParams) -> RestoreReport {
    let [removed_faces, removed_vertices] = cut.removed_counts();
    RestoreReport {
        marked_faces: count(marked),
        removed_faces,
        removed_vertices,
        joined_holes: cut.joined_holes.clone(),
        keep_shape: params.keep_shape,
    }
}

impl CutResult<'_> {
    /// Fills the holes that the cut made.
    pub(super) fn fill(
        &self,
        params: &FillParams,
        reference: Option<&ReferenceSurface>,
        control: &Control,
    ) -> Result<Filled, FillError> {
        let regions = Regions::new(&self.found, self.params(params), reference)?;
        let mut filled = regions.fill(&Watch::new(*control, regions.expected_work()))?;
        self.adapt_report(&mut filled.report);
        Ok(filled)
    }
}
