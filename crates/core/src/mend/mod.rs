//! Entry points of the engine: inspects a mesh, plans a run, and fills, restores or fairs it.
//!
//! [`Inspection::new`] analyses a mesh once; then [`Inspection::plan`], [`Inspection::fill`], [`Inspection::restore`] and
//! [`Inspection::fair`] may be called any number of times. `fill`, `restore` and `fair` do both steps in one call.

mod bodies;
mod bores;
mod choose;
mod coarse_rims;
mod control;
mod counterpart;
mod crease_ends;
mod crease_pairs;
mod cut;
mod error;
mod fair;
mod frame;
mod framed;
mod hole_group;
mod in_frames;
mod inspection;
mod params;
mod plan;
mod planar_rims;
mod reach;
mod reference;
mod regions;
mod report;
mod restore;
mod setters;
mod solved_patches;
mod sources;
mod task;

use crate::fill::FillParams;
use crate::flow::BendingEnergy;
use crate::mesh::Mesh;

pub use bodies::{BodyNumbers, HolesByRim};
pub(crate) use control::Watch;
pub use control::{Control, Event, Progress, Step};
pub use crease_ends::CreaseEnd;
pub use error::{FillError, RestoreError};
pub use fair::{FairError, Faired};
pub use inspection::Inspection;
pub use params::{FairExtent, FairParams, RestoreParams};
pub use plan::{FairPlan, FillPlan, PlannedHole, PlannedRegion, RestorePlan};
pub use regions::{Regions, recount_intersections};
pub use report::{
    FairObject, FairReport, FillReport, HoleReport, InputReport, KeptObject, RestoreReport,
};
pub use restore::Restored;
pub(crate) use solved_patches::SolvedPatches;
pub use task::RegionTask;

/// A filled mesh.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Filled {
    /// The mesh: every vertex and face of the input first, in order and bit-exact, then the patches.
    pub mesh: Mesh,
    /// Expected error of each patch vertex, in order, in the mesh's units; none where it is unknown.
    pub expected_error: Vec<Option<f64>>,
    /// Report of the mesh and of the fill.
    pub report: FillReport,
}

impl Inspection<'_> {
    /// Plans a fill: which holes [`Inspection::fill`] would fill, together with which others, on which grid.
    ///
    /// # Errors
    /// As [`Inspection::fill`].
    pub fn plan(&self, params: &FillParams) -> Result<FillPlan, FillError> {
        Ok(self.regions(params)?.plan())
    }

    /// Fills holes.
    ///
    /// # Errors
    /// If the parameters are invalid, and [`FillError::Cancelled`]. A hole that cannot be filled is not an error: the report
    /// lists it.
    pub fn fill(&self, params: &FillParams, control: &Control) -> Result<Filled, FillError> {
        control.install(|| {
            let regions = self.regions(params)?;
            regions.fill(&Watch::new(*control, regions.expected_work()))
        })
    }
}

impl Inspection<'_> {
    /// Fills holes by an energy of the caller's, in place of [`FillParams::energy`].
    ///
    /// Patches are zero sets of the level set, as with the curvature-variation energy: they are not finished on their own
    /// triangles, and have no expected errors. Where the flow finds no surface, the Willmore energy is used, and
    /// [`RegionReport::other_energy`](crate::fill::RegionReport::other_energy) is set. The energy exists in this process only: the
    /// regions of this fill cannot be sent elsewhere as tasks.
    ///
    /// # Errors
    /// As [`Inspection::fill`].
    pub fn fill_with(
        &self,
        params: &FillParams,
        energy: &dyn BendingEnergy,
        control: &Control,
    ) -> Result<Filled, FillError> {
        control.install(|| {
            let regions = self.regions(params)?.by(energy);
            regions.fill(&Watch::new(*control, regions.expected_work()))
        })
    }
}

/// Finds the components, holes and defects of a mesh.
///
/// # Errors
/// As [`Inspection::new`].
pub fn inspect(mesh: &Mesh) -> Result<Inspection<'_>, FillError> {
    Inspection::new(mesh)
}

/// Fills the holes of a mesh: [`Inspection::fill`] with default control.
///
/// # Errors
/// If the mesh or the parameters are invalid. A hole that cannot be filled is not an error: the report lists it.
pub fn fill(mesh: &Mesh, params: &FillParams) -> Result<Filled, FillError> {
    params.check()?;
    inspect(mesh)?.fill(params, &Control::new())
}

/// Replaces the marked faces of a mesh: [`Inspection::restore`] with default control.
///
/// # Errors
/// As [`Inspection::new`] and [`Inspection::restore`].
pub fn restore(
    mesh: &Mesh,
    marked: &[bool],
    params: &RestoreParams,
) -> Result<Restored, RestoreError> {
    params.check()?;
    inspect(mesh)?.restore(marked, params, &Control::new())
}

/// Fairs a surface by Willmore flow, all of it or only the marked faces: [`Inspection::fair`] with default control.
///
/// # Errors
/// As [`Inspection::new`] and [`Inspection::fair`].
pub fn fair(
    mesh: &Mesh,
    marked: Option<&[bool]>,
    params: &FairParams,
) -> Result<Faired, FairError> {
    inspect(mesh)?.fair(marked, params, &Control::new())
}
