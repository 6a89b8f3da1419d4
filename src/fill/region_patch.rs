//! What became of a region, as a value.

use serde::{Deserialize, Serialize};

use super::outcome::HoleOutcome;
use super::report::RegionReport;
use crate::mesh::Mesh;

/// What became of a region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RegionPatch {
    /// The patch: vertex numbers below the input's number of vertices are the input's, the others those of its own vertices.
    pub mesh: Mesh,
    /// For each of its own vertices its expected error in the mesh's units; none where nothing can be said.
    pub sigma: Vec<Option<f64>>,
    /// What was done.
    pub report: RegionReport,
    /// What became of each of its holes, in the order of the report's.
    pub outcomes: Vec<HoleOutcome>,
}
