//! What was found in a mesh, and what was done or would be. In a plan, what only the work itself can tell is not there:
//! options are none, counts and times zero.

use serde::{Deserialize, Serialize};

use super::finished::FinishReport;
use super::outcome::{ClosedBy, HoleOutcome, Tally, TryFailure};
use crate::mesh::{Defects, Hole, OpenChain};
use crate::region::LevelReport;

/// Holes of at most so many edges are closed by triangles between their vertices without being solved.
pub(super) const FEW_EDGES: usize = 4;

/// A patch that rises higher above its rim than this, in diameters, balloons: half a sphere rises by 0.5. Caps of cut necks
/// and limbs rise by 0.4; those of holes in a surface that goes on by less than 0.2.
const BALLOON: f64 = 0.3;

/// A hole and what happened to it, or would.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct HoleReport {
    /// The hole.
    pub hole: Hole,
    /// What happened.
    pub outcome: HoleOutcome,
    /// Number of its region, from 1; 0 where there is none.
    pub region: usize,
}

/// A region and its patch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RegionReport {
    /// Number, from 1.
    pub id: usize,
    /// Numbers of its holes.
    pub holes: Vec<usize>,
    /// Whether its holes were put together because the caller asked for a bridge.
    pub bridge: bool,
    /// Diameter in the mesh's units: that of the widest hole, or of what was cut out.
    pub diameter: f64,
    /// Voxel size of the finest level in the mesh's units, in a plan that of the first try; none where no grid is needed.
    pub voxel: Option<f64>,
    /// Nodes of the box of the finest level along the axes. Memory and time go with those near the surface only.
    pub dims: Option<[usize; 3]>,
    /// The levels of the nested solve, the coarsest first.
    pub levels: Vec<LevelReport>,
    /// Whether the flow became steady.
    pub converged: bool,
    /// What closed it.
    pub closed_by: Option<ClosedBy>,
    /// Mean angle between the faces on both sides of the seam, in degrees; none where the level set did not close it.
    pub seam_angle_mean: Option<f64>,
    /// Largest angle there.
    pub seam_angle_max: Option<f64>,
    /// How far the patch of one hole rises above its rim, along the rim's normal to either side and beyond the rim's own extent,
    /// in diameters; none for other patches.
    pub rise: Option<f64>,
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
    /// How its patch was finished; none where it was not.
    pub finish: Option<FinishReport>,
    /// Why earlier tries failed.
    pub earlier_tries: Vec<TryFailure>,
    /// Whether the surface is that of the energy to fall back to because the one asked for found none.
    pub other_energy: bool,
    /// Seconds.
    pub seconds: f64,
}

/// Everything about a fill, or about what one would do.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
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

impl RegionReport {
    /// Whether a surface was made for it, and not only triangles between vertices of rims.
    pub fn has_surface(&self) -> bool {
        let by = self.closed_by;
        !self.levels.is_empty() || matches!(by, Some(ClosedBy::Flat | ClosedBy::Faired))
    }

    /// Whether its patch bulges so far that a flat cap may be what is wanted: the surface was continued across a cut neck or the
    /// mouth of a vessel.
    pub fn balloons(&self) -> bool {
        self.rise.is_some_and(|rise| rise > BALLOON)
    }
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
                    Some(ClosedBy::LevelSet) => r.converged,
                    Some(ClosedBy::Flat | ClosedBy::Seam) => true,
                    _ => false,
                };
                r.id == hole.region && whole && r.intersecting_faces == 0
            }),
        };
        !self.incomplete() && self.holes.iter().all(flawless)
    }

    /// How many holes ended in which way, or would.
    pub fn tally(&self) -> Tally {
        let mut tally = Tally {
            open_chains: self.open_chains.len(),
            ..Tally::default()
        };
        for hole in &self.holes {
            let count = match hole.outcome {
                HoleOutcome::Filled | HoleOutcome::WouldBeFilled => &mut tally.filled,
                HoleOutcome::Faired(_) => &mut tally.faired,
                HoleOutcome::Flat | HoleOutcome::WouldBeFlat => &mut tally.flat,
                HoleOutcome::Triangulated(_) | HoleOutcome::WouldBeTriangulated(_) => {
                    &mut tally.triangulated
                }
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

/// What a restoration found and did, or would do.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RestoreReport {
    /// Faces that were marked.
    pub marked_faces: usize,
    /// Faces taken out: the marked ones, and those without which there would be no clean rim.
    pub removed_faces: usize,
    /// Vertices that went with them.
    pub removed_vertices: usize,
    /// The part of the shape that was to be kept.
    pub keep_shape: f64,
    /// The fill. Holes are numbered as they are after the cut.
    pub fill: FillReport,
}

/// What a fairing did, or would do.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct FairReport {
    /// Features narrower than this went, in the mesh's units.
    pub strength: f64,
    /// Time of the flow, in length⁴.
    pub time: f64,
    /// Voxel size.
    pub voxel: f64,
    /// Whether all of the surface was replaced: nothing of the input is in the output.
    pub whole: bool,
    /// Faces that were to be faired.
    pub marked_faces: usize,
    /// Faces taken out.
    pub removed_faces: usize,
    /// Vertices that went with them.
    pub removed_vertices: usize,
    /// Closed pieces that were left as they are, since only the open ones can be faired between borders.
    pub pieces_left: usize,
    /// Volume of the input, where it is closed.
    pub volume_before: Option<f64>,
    /// Volume of the output, where it is closed.
    pub volume_after: Option<f64>,
    /// Largest distance of a new vertex from the surface that was there.
    pub moved_max: f64,
    /// Root mean square distance.
    pub moved_rms: f64,
    /// The regions. Holes are numbered as they are after the cut.
    pub fill: FillReport,
}

impl FairReport {
    /// The change of the volume, over the volume of the input.
    pub fn volume_drift(&self) -> Option<f64> {
        Some(self.volume_after? / self.volume_before? - 1.0)
    }
}
