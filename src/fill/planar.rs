//! Candidate: a nearly flat cap (surface of least area), when the caller requested it.

use super::candidate::FinishedPatch;
use super::faired;
use super::outcome::{ClosedBy, HoleOutcome};
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::so_far::Made;
use crate::finish::minimal_surface;
use crate::stitch::Patch;

/// Expected cost: as a faired triangulation.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    faired::cost(problem)
}

/// The surface of least area over a refined triangulation of the only rim.
pub(super) fn make(problem: &RegionProblem<'_>) -> Made {
    problem.planar_cap().map(|cap| problem.capped(cap)).into()
}

impl RegionProblem<'_> {
    /// The surface of least area over a refined triangulation of the only rim; none where the region has several rims, or the
    /// triangulation fails.
    fn planar_cap(&self) -> Option<Patch> {
        let [hole] = self.holes else {
            return None;
        };
        let (local, patch) = self.spanned(hole, minimal_surface)?;
        let mut patch = local.to_whole(patch);
        patch.report.components = 1;
        let whole = |f: &[u32; 3]| f.map(|v| local.part.original(v, local.count));
        patch.measure(self.mesh, local.part.mesh.faces.iter().map(whole));
        Some(patch)
    }

    /// The result of a region that is closed by a flat cap.
    fn capped(&self, patch: Patch) -> RegionPatch {
        let mut report = self.flat_report();
        report.closed_by = Some(ClosedBy::Flat);
        self.all_finished(FinishedPatch::unfinished(patch), report, HoleOutcome::Flat)
    }

    /// The report of a region that is closed by a flat cap or base.
    pub(super) fn flat_report(&self) -> RegionReport {
        RegionReport {
            diameter: self.diameter(),
            ..RegionReport::default()
        }
    }
}
