//! Candidate: thin triangles between two rims that coincide.

use super::closure::{Closure, HoleOutcome};
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::so_far::Made;
use crate::mesh::Mesh;
use crate::stitch::close_seam;

/// Closes a seam: thin triangles between two rims that coincide.
pub(super) fn make(problem: &RegionProblem<'_>) -> Made {
    problem.close_seam().into()
}

impl RegionProblem<'_> {
    /// Closes the gap between two rims that coincide.
    fn close_seam(&self) -> Option<RegionPatch> {
        let &[a, b] = self.holes else {
            return None;
        };
        let faces = close_seam(self.mesh, &a.rim, &b.rim)?;
        let report = RegionReport {
            diameter: a.diameter,
            components: 1,
            ..RegionReport::default()
        };
        let outcome = HoleOutcome::Closed(Closure::Seam);
        Some(self.all(Mesh::new(Vec::new(), faces), report, outcome))
    }
}
