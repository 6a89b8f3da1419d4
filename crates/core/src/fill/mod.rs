//! Closes one region: tries the candidates (level set, faired triangulation, sharp edges, caps) in turn and takes the best patch.

mod base;
mod base_plane;
mod candidate;
mod counterpart;
mod faired;
mod finish_step;
mod grain;
mod grids;
mod invented;
mod level_set;
mod like;
mod outcome;
mod params;
mod planar;
mod problem;
mod quality;
mod reference;
mod region_patch;
mod report;
mod returned;
mod rim_triangles;
mod rounded;
mod seam;
mod search;
mod setters;
mod sharp;
mod sides_error;
mod so_far;
mod stitching;
mod strategy;

pub(crate) use base_plane::BasePlane;
pub use candidate::{FinishReport, PatchInitialisation};
pub(crate) use counterpart::{Counterpart, PlacedPart};
pub use invented::{CounterpartKind, CounterpartReport, GrainReport, NotLike};
pub use like::Like;
pub(crate) use like::unit_normal;
pub use outcome::{
    AttemptFailure, ClosedBy, FailedReason, HoleOutcome, LeftReason, NotContinued, Tally,
    TriangulatedReason,
};
pub use params::{FillParams, Finish, Sharp};
pub(crate) use problem::{RegionPlan, RegionProblem, first_region, has_few_edges};
pub use quality::Quality;
pub(crate) use reference::{Keeping, ReferenceSurface};
pub use region_patch::RegionPatch;
pub use report::{CreaseReport, RegionReport};
pub(crate) use returned::WayBack;
pub(crate) use sharp::may_have_crease_ends;
