//! The result of one region: its patch, expected errors, report and outcomes, as a value that can be stored and merged.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::candidate::{FinishReport, FinishedPatch};
use super::closure::{Closure, HoleOutcome};
use super::problem::RegionProblem;
use super::quality::Quality;
use super::reasons::OpenReason;
use super::report::RegionReport;
use crate::mesh::Mesh;

/// The result of one region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RegionPatch {
    /// The patch. Vertex numbers below the input's number of vertices are the input's; larger ones number the new vertices.
    pub mesh: Mesh,
    /// Expected error of each new vertex in the mesh's units; none where it is unknown.
    pub expected_error: Vec<Option<f64>>,
    /// The report of the region.
    pub report: RegionReport,
    /// The outcome of each hole, in the order of the report's holes.
    pub outcomes: Vec<HoleOutcome>,
    /// Whether its box would have to grow beyond the part of the mesh at hand.
    pub(super) is_cramped: bool,
}

impl RegionPatch {
    /// Whether the region needs a larger part of the mesh than its task holds. Its wide task holds the largest part that any
    /// region uses; without the wide task the region is computed when patches are merged.
    pub fn is_cramped(&self) -> bool {
        self.is_cramped
    }

    /// Quality of the result.
    pub(super) fn quality(&self) -> Quality {
        let is_open = |o: &&HoleOutcome| matches!(o, HoleOutcome::Open(_));
        let finish = self.report.finish.as_ref().map(FinishReport::quality);
        Quality {
            open_rims: self.outcomes.iter().filter(is_open).count(),
            intersections: self.report.intersecting_faces,
            is_plain: self.mesh.positions.is_empty(),
            ..finish.unwrap_or_default()
        }
    }
}

impl RegionProblem<'_> {
    /// The result of a region that was stopped: its holes stay open, and the run ends with an error.
    pub(super) fn stopped(&self, report: RegionReport) -> RegionPatch {
        let outcome = HoleOutcome::Open(OpenReason::NotReached);
        self.all(Mesh::default(), report, outcome)
    }

    /// The result of a region that is closed by a finished patch of a level set.
    pub(super) fn accept(&self, finished: FinishedPatch, report: RegionReport) -> RegionPatch {
        self.all_finished(finished, report, Closure::LevelSet)
    }

    /// The result of a region whose box would have to grow beyond the part of the mesh at hand.
    pub(super) fn cramped(&self) -> RegionPatch {
        RegionPatch {
            is_cramped: true,
            ..self.stopped(RegionReport::default())
        }
    }

    /// The result of a region that is closed by a finished patch.
    pub(super) fn all_finished(
        &self,
        finished: FinishedPatch,
        mut report: RegionReport,
        closure: Closure,
    ) -> RegionPatch {
        let FinishedPatch {
            patch,
            report: finish,
            expected_error,
        } = finished;
        report.finish = finish;
        report.seam_angle_mean = Some(patch.report.seam_angle_mean);
        report.seam_angle_max = Some(patch.report.seam_angle_max);
        report.quality_mean = patch.report.quality_mean;
        report.intersecting_faces = patch.report.intersecting_faces;
        report.components = patch.report.components;
        report.rise = self.rise(&patch.positions);
        let mesh = Mesh::new(patch.positions, patch.faces);
        RegionPatch {
            expected_error,
            ..self.all(mesh, report, HoleOutcome::Closed(closure))
        }
    }

    /// The result of a region with this patch; all holes have the same outcome.
    pub(super) fn all(
        &self,
        mesh: Mesh,
        mut report: RegionReport,
        outcome: HoleOutcome,
    ) -> RegionPatch {
        report.closure = outcome.closure().cloned();
        report.new_vertices = mesh.positions.len();
        report.new_faces = mesh.faces.len();
        RegionPatch {
            expected_error: vec![None; mesh.positions.len()],
            mesh,
            report,
            outcomes: vec![outcome; self.holes.len()],
            is_cramped: false,
        }
    }

    /// How far the vertices of the patch of a single hole rise along the rim's normal beyond half of the rim's own extent there, in
    /// diameters; 0 if they do not rise beyond all of it.
    pub(super) fn rise(&self, positions: &[DVec3]) -> Option<f64> {
        let ([hole], None) = (self.holes, self.reference) else {
            return None;
        };
        let height = |p: &DVec3| (*p - hole.centre).dot(hole.normal);
        let of_rim = hole
            .rim
            .iter()
            .map(|&v| height(&self.mesh.positions[v as usize]));
        let extent = |heights: &mut dyn Iterator<Item = f64>| {
            heights.fold((0.0f64, 0.0f64), |(low, high), h| (low.min(h), high.max(h)))
        };
        let (lowest, highest) = extent(&mut of_rim.into_iter());
        let (low, high) = extent(&mut positions.iter().map(height));
        let beyond = |reached: f64, own: f64| match reached > own {
            true => (reached - 0.5 * own) / hole.diameter,
            false => 0.0,
        };
        let rise = f64::max(beyond(high, highest), beyond(-low, -lowest));
        rise.is_finite().then_some(rise)
    }
}
