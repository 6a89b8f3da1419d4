//! What a run found and did.

pub mod html;
mod lengths;
mod missed;
pub mod picture;
mod plan;
mod text;
pub mod view;

use serde::Serialize;

use crate::mesh::{Defects, Hole, OpenChain};
use crate::region::LevelReport;

pub use lengths::{length, point};
pub use missed::missed_lines;
pub use plan::{Plan, PlannedHole, PlannedOutcome, PlannedRegion, plan_lines};
pub use text::{
    chain_lines, defect_lines, hole_table, level_lines, region_lines, summary_lines, tally_line,
};

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

/// Holes of at most so many edges are closed by triangles between their vertices without being solved.
const FEW_EDGES: usize = 4;

/// What closed a region.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ClosedBy {
    /// The surface of the level set.
    LevelSet,
    /// Thin triangles between two rims that lie on each other.
    Seam,
    /// Triangles between the vertices of each rim.
    RimTriangles,
    /// Some rim of it is still open.
    #[default]
    Nothing,
}

/// How many holes ended in which way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    /// Filled by the level set.
    pub filled: usize,
    /// Closed by triangles between the vertices of their rims.
    pub triangulated: usize,
    /// Left as they were because they were not asked for.
    pub left: usize,
    /// To be filled but still open.
    pub failed: usize,
    /// Boundary chains that do not close.
    pub open_chains: usize,
    /// Patches with faces that intersect other faces.
    pub crossing_patches: usize,
    /// Those faces.
    pub crossing_faces: usize,
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
    /// What closed it.
    pub closed_by: ClosedBy,
    /// Mean angle between the faces on both sides of the seam, in degrees; none where the level set did not close it.
    pub seam_angle_mean: Option<f64>,
    /// Largest angle there.
    pub seam_angle_max: Option<f64>,
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
    pub open_chains: Vec<OpenChain>,
    /// Whether all holes were to be filled, so that a boundary chain that does not close is one that stays open.
    pub all_holes: bool,
    /// The holes.
    pub holes: Vec<HoleReport>,
    /// The regions.
    pub regions: Vec<RegionReport>,
    /// Seconds in all.
    pub seconds: f64,
}

impl FillReport {
    /// Whether something that was to be filled is still open: a hole, or a boundary chain that does not close.
    pub fn incomplete(&self) -> bool {
        self.tally().failed > 0 || (self.all_holes && !self.open_chains.is_empty())
    }

    /// Whether every hole of more than four edges that was to be filled got a steady surface, joined to its rim, that
    /// crosses nothing, or was the side of a seam that closed.
    pub fn flawless(&self) -> bool {
        let flawless = |hole: &HoleReport| match &hole.outcome {
            HoleOutcome::Left(_) => true,
            _ if hole.hole.edges <= FEW_EDGES => true,
            _ => self.regions.iter().any(|r| {
                let whole = match r.closed_by {
                    ClosedBy::LevelSet => r.converged,
                    ClosedBy::Seam => true,
                    ClosedBy::RimTriangles | ClosedBy::Nothing => false,
                };
                r.id == hole.region && whole && r.intersecting_faces == 0
            }),
        };
        !self.incomplete() && self.holes.iter().all(flawless)
    }

    /// How many holes ended in which way.
    pub fn tally(&self) -> Tally {
        let mut tally = Tally {
            open_chains: self.open_chains.len(),
            ..Tally::default()
        };
        for hole in &self.holes {
            let count = match hole.outcome {
                HoleOutcome::Filled => &mut tally.filled,
                HoleOutcome::Triangulated(_) => &mut tally.triangulated,
                HoleOutcome::Left(_) => &mut tally.left,
                HoleOutcome::Failed(_) => &mut tally.failed,
            };
            *count += 1;
        }
        for region in self.regions.iter().filter(|r| r.intersecting_faces > 0) {
            tally.crossing_patches += 1;
            tally.crossing_faces += region.intersecting_faces;
        }
        tally
    }
}
