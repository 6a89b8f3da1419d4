//! One region closed: from its data to the patch that is taken.

mod candidate;
mod finish_step;
mod level_set;
mod outcome;
mod params;
mod previous;
mod problem;
mod region_patch;
mod report;
mod search;
mod stitching;
mod strategy;

pub use candidate::{FinishReport, PatchStart};
pub use outcome::{
    ClosedBy, FailedReason, HoleOutcome, LeftReason, Tally, TriangulatedReason, TryFailure,
};
pub use params::{FillParams, Finish, SurfaceKind};
pub(crate) use previous::{Keeping, PreviousSurface};
pub(crate) use problem::{RegionProblem, first_region, is_trivial};
pub use region_patch::RegionPatch;
pub(crate) use report::FEW_EDGES;
pub use report::RegionReport;
pub(crate) use strategy::WIDEST;
