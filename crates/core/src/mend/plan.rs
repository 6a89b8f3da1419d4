//! Plans of fills, restorations and fairings: holes, regions and grids, known before any region is solved.

use serde::{Deserialize, Serialize};

use super::report::{InputReport, KeptObject, RestoreReport};
use crate::fill::HoleOutcome;
use crate::mesh::{Hole, HoleId};

/// Plan of a fill. The result may differ: a hole with inconsistent surroundings may end with triangles between its own vertices,
/// and some holes need several grids.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FillPlan {
    /// Size and defects of the input.
    pub input: InputReport,
    /// The holes.
    pub holes: Vec<PlannedHole>,
    /// The regions: holes that would be filled together.
    pub regions: Vec<PlannedRegion>,
}

/// A hole and the plan for it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PlannedHole {
    /// The hole.
    pub hole: Hole,
    /// Its outcome, where it is known before the fill; none for a new surface, whose kind the fill finds.
    pub outcome: Option<HoleOutcome>,
    /// Number of its region, from 1; 0 where there is none.
    pub region: usize,
}

/// A region of holes that are filled together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PlannedRegion {
    /// Number, from 1.
    pub id: usize,
    /// Numbers of its holes.
    pub holes: Vec<HoleId>,
    /// Whether its holes are grouped because the caller asked for a bridge.
    pub bridge: bool,
    /// Diameter of the widest hole, in the mesh's units.
    pub diameter: f64,
    /// Voxel size of the finest level of the first attempt, in the mesh's units; none where no grid is needed.
    pub voxel: Option<f64>,
    /// Nodes of the box of that level along each axis. Memory and time depend only on the nodes near the surface.
    pub dims: Option<[usize; 3]>,
}

/// Plan of a restoration.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RestorePlan {
    /// What would be cut out.
    pub cut: RestoreReport,
    /// The plan of the fill. Holes are numbered as after the cut.
    pub fill: FillPlan,
}

/// Plan of a fairing.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FairPlan {
    /// Width below which features would be removed, in the mesh's units.
    pub strength: f64,
    /// Time of the flow, in length⁴.
    pub time: f64,
    /// Voxel size, in the mesh's units.
    pub voxel: f64,
    /// Whether the whole surface would be replaced.
    pub whole: bool,
    /// Number of faces to fair.
    pub marked_faces: usize,
    /// Number of faces that would be removed.
    pub removed_faces: usize,
    /// Number of vertices that would be removed with them.
    pub removed_vertices: usize,
    /// Closed components that would stay unchanged: of an open mesh only the open components are faired, between their borders.
    pub components_left: usize,
    /// Objects of a 3MF file that cannot be faired and would stay unchanged.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kept_objects: Vec<KeptObject>,
}
