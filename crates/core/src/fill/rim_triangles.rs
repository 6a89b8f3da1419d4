//! Candidate: triangles between the vertices of each rim, without new vertices.

use super::closure::{Closure, HoleOutcome};
use super::problem::RegionProblem;
use super::reasons::{AttemptFailure, NotSmooth, OpenReason};
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::so_far::{Made, SoFar};
use super::stitching::{local_rim, renumber};
use crate::mesh::Mesh;
use crate::mesh::triangulate::triangulate_loop_with_neighbours;
use crate::stitch::count_intersecting;

/// Triangles between the vertices of each rim.
pub(super) fn make(problem: &RegionProblem<'_>, so_far: &SoFar<'_>) -> Made {
    let (why, report) = match problem.decided {
        Some(Closure::Flat) => (NotSmooth::Flat, problem.flat_report()),
        Some(_) => (NotSmooth::FewEdges, RegionReport::default()),
        None => {
            let (why, report) = so_far.without_level_set();
            let why = why.unwrap_or(AttemptFailure::Stopped);
            (NotSmooth::NoSurface(why), report)
        }
    };
    Made::Region(problem.triangulate(why, report))
}

impl RegionProblem<'_> {
    /// Triangulates each loop separately; no diagonal repeats an edge of an earlier loop's triangles.
    fn triangulate(&self, why: NotSmooth, mut report: RegionReport) -> RegionPatch {
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
                    HoleOutcome::Closed(Closure::RimTriangles(why.clone()))
                }
                Err(error) => HoleOutcome::Open(OpenReason::NoTriangulation {
                    after: why.clone(),
                    error,
                }),
            });
        }
        let all_closed = outcomes.iter().all(|o| o.closure().is_some());
        report.new_faces = faces.len();
        report.intersecting_faces = count_intersecting(&part.mesh, &[], &faces);
        report.components = outcomes.len();
        report.closure = all_closed.then_some(Closure::RimTriangles(why));
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
