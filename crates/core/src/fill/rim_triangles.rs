//! Candidate: triangles between the vertices of each rim, without new vertices.

use super::outcome::{AttemptFailure, ClosedBy, FailedReason, HoleOutcome, TriangulatedReason};
use super::problem::{RegionPlan, RegionProblem};
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::so_far::{Made, SoFar};
use super::stitching::{local_rim, renumber};
use crate::mesh::Mesh;
use crate::mesh::triangulate::triangulate_loop_with_neighbours;
use crate::stitch::count_intersecting;

/// Triangles between the vertices of each rim.
pub(super) fn make(problem: &RegionProblem<'_>, so_far: &SoFar<'_>) -> Made {
    let (why, report) = match problem.plan {
        RegionPlan::Planar => (TriangulatedReason::Flat, problem.flat_report()),
        RegionPlan::Solve => {
            let (why, report) = so_far.without_level_set();
            let why = why.unwrap_or(AttemptFailure::Stopped);
            (TriangulatedReason::NoSurface(why), report)
        }
        _ => (TriangulatedReason::FewEdges, RegionReport::default()),
    };
    Made::Region(problem.triangulate(why, report))
}

impl RegionProblem<'_> {
    /// Triangulates each loop separately; no diagonal repeats an edge of an earlier loop's triangles.
    fn triangulate(&self, why: TriangulatedReason, mut report: RegionReport) -> RegionPatch {
        let rims: Vec<Vec<u32>> = self.holes.iter().map(|h| h.rim.clone()).collect();
        let part = self.all.part_round(&rims);
        let mut faces = Vec::new();
        let mut outcomes = Vec::new();
        for hole in self.holes {
            report.diameter = report.diameter.max(hole.diameter);
            let made =
                triangulate_loop_with_neighbours(&part.mesh, &local_rim(&part, hole), &faces);
            outcomes.push(match made {
                Ok(new) => {
                    faces.extend(new);
                    HoleOutcome::Triangulated(why.clone())
                }
                Err(error) => HoleOutcome::Failed(FailedReason::NoTriangulation {
                    after: why.clone(),
                    error,
                }),
            });
        }
        let is_open = |o: &HoleOutcome| matches!(o, HoleOutcome::Failed(_));
        report.new_faces = faces.len();
        report.intersecting_faces = count_intersecting(&part.mesh, &[], &faces);
        report.components = outcomes.len();
        report.closed_by = Some(match outcomes.iter().any(is_open) {
            true => ClosedBy::Nothing,
            false => ClosedBy::RimTriangles,
        });
        renumber(&mut faces, &part, self.mesh.positions.len());
        RegionPatch {
            mesh: Mesh::new(Vec::new(), faces),
            expected_error: Vec::new(),
            report,
            outcomes,
            is_cramped: false,
        }
    }
}
