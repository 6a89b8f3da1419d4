//! What a run would do, known before any region is solved: the holes it would close, how, together with which others, on which grid.

use serde::{Deserialize, Serialize};

use crate::fill::{LeftReason, TriangulatedReason};
use crate::mesh::{Defects, Hole, HoleId, OpenChain};

/// What a fill would do. What comes out is not known before: a hole whose surroundings contradict each other may still end in
/// triangles between its own vertices, and some take several grids.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FillPlan {
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
    /// The holes.
    pub holes: Vec<PlannedHole>,
    /// The regions: holes that would be filled together.
    pub regions: Vec<PlannedRegion>,
}

/// A hole and what would become of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PlannedHole {
    /// The hole.
    pub hole: Hole,
    /// What would become of it.
    pub plan: HolePlan,
    /// Number of its region, from 1; 0 where there is none.
    pub region: usize,
}

/// What would become of a hole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum HolePlan {
    /// A new surface would fill it: that of a level set, or a faired triangulation where its rim has few edges.
    Fill,
    /// It would get a flat cap, as was asked.
    Flat,
    /// The outer border of a sheet that would stand on a flat base.
    Base,
    /// It would be closed by triangles between its own vertices.
    Triangulate(TriangulatedReason),
    /// It would stay as it is.
    Leave(LeftReason),
}

/// A region that would be filled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PlannedRegion {
    /// Number, from 1.
    pub id: usize,
    /// Numbers of its holes.
    pub holes: Vec<HoleId>,
    /// Whether its holes are put together because the caller asked for a bridge.
    pub bridge: bool,
    /// Diameter of the widest hole, in the mesh's units.
    pub diameter: f64,
    /// Voxel size of the finest level of the first attempt, in the mesh's units; none where no grid is needed.
    pub voxel: Option<f64>,
    /// Nodes of the box of that level along the axes. Memory and time go with those near the surface only.
    pub dims: Option<[usize; 3]>,
}

/// What a restoration would do.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RestorePlan {
    /// Faces that are marked.
    pub marked_faces: usize,
    /// Faces that would be taken out: the marked ones, and those without which there would be no clean rim.
    pub removed_faces: usize,
    /// Vertices that would go with them.
    pub removed_vertices: usize,
    /// The part of the shape that is to be kept.
    pub keep_shape: f64,
    /// The fill. Holes are numbered as they are after the cut.
    pub fill: FillPlan,
}

/// What a fairing would do.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FairPlan {
    /// Features narrower than this would go, in the mesh's units.
    pub strength: f64,
    /// Time of the flow, in length⁴.
    pub time: f64,
    /// Voxel size.
    pub voxel: f64,
    /// Whether all of the surface would be replaced.
    pub whole: bool,
    /// Faces that are to be faired.
    pub marked_faces: usize,
    /// Faces that would be taken out.
    pub removed_faces: usize,
    /// Vertices that would go with them.
    pub removed_vertices: usize,
    /// Closed pieces that would stay as they are, since only the open ones can be faired between borders.
    pub pieces_left: usize,
}
