//! Candidate: a nearly flat cap (surface of least area), when the caller requested it or the rim bounds a missing flat side.

use glam::DVec2;

use super::candidate::FinishedPatch;
use super::closure::{Closure, HoleOutcome};
use super::faired;
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::so_far::Made;
use crate::finish::minimal_surface;
use crate::mesh::Mesh;
use crate::mesh::triangulate::constrained_between;
use crate::stitch::{Patch, count_intersecting};

/// Expected cost: as a faired triangulation.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    faired::cost(problem)
}

/// The surface of least area over a refined triangulation of the only rim, or the plane between several rims in it.
pub(super) fn make(problem: &RegionProblem<'_>) -> Made {
    match problem.holes {
        [_] => problem.planar_cap().map(|cap| problem.capped(cap)).into(),
        _ => problem.plane_between().into(),
    }
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

    /// The triangles between several rims in one plane, without new vertices; none if the rims touch, or are not one inside the
    /// other.
    fn plane_between(&self) -> Option<RegionPatch> {
        let outer = self.holes.first()?;
        let x = outer.normal.any_orthonormal_vector();
        let y = outer.normal.cross(x);
        let flat = |v: &u32| {
            let p = self.mesh.positions[*v as usize] - outer.centre;
            DVec2::new(p.dot(x), p.dot(y))
        };
        let loops: Vec<Vec<DVec2>> = (self.holes.iter())
            .map(|h| h.rim.iter().map(flat).collect())
            .collect();
        let corners: Vec<u32> = self
            .holes
            .iter()
            .flat_map(|h| h.rim.iter().copied())
            .collect();
        let faces: Vec<[u32; 3]> = (constrained_between(&loops)?.iter())
            .map(|f| f.map(|i| corners[i]))
            .collect();
        let report = RegionReport {
            new_faces: faces.len(),
            components: 1,
            intersecting_faces: count_intersecting(self.mesh, &[], &faces),
            closure: Some(Closure::Flat),
            ..self.flat_report()
        };
        Some(RegionPatch {
            mesh: Mesh::new(Vec::new(), faces),
            expected_error: Vec::new(),
            report,
            outcomes: vec![HoleOutcome::Closed(Closure::Flat); self.holes.len()],
            is_cramped: false,
        })
    }

    /// The result of a region that is closed by a flat cap.
    fn capped(&self, patch: Patch) -> RegionPatch {
        self.all_finished(
            FinishedPatch::unfinished(patch),
            self.flat_report(),
            Closure::Flat,
        )
    }

    /// The report of a region that is closed by a flat cap or base.
    pub(super) fn flat_report(&self) -> RegionReport {
        RegionReport {
            diameter: self.diameter(),
            ..RegionReport::default()
        }
    }
}
