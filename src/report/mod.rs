//! What a run found and did.

pub mod html;
mod lengths;
mod missed;
pub mod picture;
mod plan;
mod text;
pub mod view;

use serde::Serialize;

use crate::mesh::{Defects, Hole};
use crate::region::LevelReport;

pub use lengths::{length, point};
pub use missed::missed_lines;
pub use plan::{Plan, PlannedHole, PlannedOutcome, PlannedRegion, plan_lines};
pub use text::{defect_lines, hole_table, level_lines, region_lines, summary_lines};

/// What happened to a hole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "outcome", content = "reason")]
pub enum HoleOutcome {
    /// Filled by the level set.
    Filled,
    /// Triangulated on its own, without new vertices; says why.
    Triangulated(String),
    /// Left as it was because it was not asked for; says why.
    Left(String),
    /// It was to be filled but could not be; says why.
    Failed(String),
}

/// A hole and what happened to it.
#[derive(Clone, Debug, Serialize)]
pub struct HoleReport {
    /// The hole.
    #[serde(flatten)]
    pub hole: Hole,
    /// What happened.
    #[serde(flatten)]
    pub outcome: HoleOutcome,
    /// Number of its region, from 1; 0 where there is none.
    pub region: usize,
}

/// A region and its patch.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RegionReport {
    /// Number, from 1.
    pub id: usize,
    /// Numbers of its holes.
    pub holes: Vec<usize>,
    /// Whether its holes were put together because the caller asked for a bridge.
    pub bridge: bool,
    /// Diameter in the mesh's units.
    pub diameter: f64,
    /// Voxel size of the finest level in the mesh's units.
    pub voxel: f64,
    /// The levels of the nested solve, the coarsest first.
    pub levels: Vec<LevelReport>,
    /// Whether the flow became steady.
    pub converged: bool,
    /// Mean angle between the faces on both sides of the seam, in degrees.
    pub seam_angle_mean: f64,
    /// Largest angle there.
    pub seam_angle_max: f64,
    /// New vertices.
    pub new_vertices: usize,
    /// New faces.
    pub new_faces: usize,
    /// Mean of 2 r_in / R_out over the new faces.
    pub quality_mean: f64,
    /// New faces that intersect another face.
    pub intersecting_faces: usize,
    /// Connected pieces of the patch.
    pub components: usize,
    /// Tries that were needed, and why the earlier ones failed.
    pub earlier_tries: Vec<String>,
    /// Whether the surface is that of the Willmore energy because the one asked for found none.
    pub other_energy: bool,
    /// Seconds.
    pub seconds: f64,
}

/// Everything about a fill.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FillReport {
    /// Vertices of the input.
    pub vertices: usize,
    /// Faces of the input.
    pub faces: usize,
    /// Connected pieces of the input.
    pub pieces: usize,
    /// What is wrong with the input.
    pub defects: Defects,
    /// Boundary chains that do not close.
    pub open_chains: usize,
    /// The holes.
    pub holes: Vec<HoleReport>,
    /// The regions.
    pub regions: Vec<RegionReport>,
    /// Seconds in all.
    pub seconds: f64,
}

impl FillReport {
    /// Whether some hole that was to be filled is still open.
    pub fn incomplete(&self) -> bool {
        self.holes
            .iter()
            .any(|h| matches!(h.outcome, HoleOutcome::Failed(_)))
    }
}
