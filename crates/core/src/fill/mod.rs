//! Closes one region: tries the candidates (level set, faired triangulation, sharp edges, caps) in turn and takes the best patch.

use crate::tuning::{Tunable, tunable};

mod base;
mod base_plane;
mod candidate;
mod closure;
mod counterpart;
mod faired;
mod finish_step;
mod grain;
mod grids;
mod invented;
mod level_set;
mod like;
mod lip;
mod params;
mod planar;
mod problem;
mod quality;
mod reasons;
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
mod straight_opening;
mod strategy;

pub(crate) use base_plane::BasePlane;
pub use candidate::{FinishReport, PatchInitialisation};
pub use closure::{Closure, HoleOutcome, Tally};
pub(crate) use counterpart::weighed::is_weighed;
pub(crate) use counterpart::{Counterpart, PlacedPart};
pub(crate) use grids::widest_growth;
pub use invented::{CounterpartKind, CounterpartReport, GrainReport, NotLike};
pub use like::Like;
pub(crate) use like::unit_normal;
pub use params::{FillParams, Finish, Sharp};
pub(crate) use problem::{RegionProblem, first_region, has_few_edges};
pub use quality::Quality;
pub use reasons::{AttemptFailure, LeftReason, NotContinued, NotSmooth, OpenReason};
pub(crate) use reference::{Keeping, ReferenceSurface};
pub use region_patch::RegionPatch;
pub use report::{CreaseReport, RegionReport};
pub(crate) use returned::WayBack;
pub(crate) use sharp::may_have_crease_ends;

/// Edges. Rims of at most this many edges are closed by triangles between their own vertices.
pub(crate) const FEW_EDGES: Tunable<usize> = tunable("fill.few_edges", 4);

/// Diagonals of the rims' bounding box. The mesh is given to the finish this far around the rims; the finish uses it up
/// to 0.68 of a hole's diameter along the surface.
pub(crate) const RIM_REACH: Tunable<f64> = tunable("fill.rim_reach", 0.8);
