//! A patch after its finish, its quality, and the report of the finish.

use super::quality::Quality;
use serde::{Deserialize, Serialize};

use crate::finish::{CandidateRecord, FinishRecord};
use crate::stitch::Patch;

/// The surface that the finish of a patch started from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum PatchInitialisation {
    /// The surface of the level set.
    #[default]
    LevelSet,
    /// A refined triangulation of the rim, faired biharmonically.
    Triangulation,
}

/// Report of the finish of a region's patch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FinishReport {
    /// The surface that the finish started from.
    #[serde(alias = "start")]
    pub initialisation: PatchInitialisation,
    /// One record for each component of the patch.
    #[serde(alias = "pieces")]
    pub components: Vec<FinishRecord>,
}

impl FinishReport {
    /// The part of the quality that the finish determines.
    pub(super) fn quality(&self) -> Quality {
        let components = || self.components.iter();
        Quality {
            folds: components().map(|p| p.folds_after).sum(),
            is_unconverged: !self.is_at_minimum(),
            expected_error: components().filter_map(ring_error).reduce(f64::max),
            energy: components().map(|p| p.energy_after).sum(),
            ..Quality::default()
        }
    }

    /// Whether all components have converged to a minimum of the energy, and none of the minima was refused.
    pub(super) fn is_at_minimum(&self) -> bool {
        let at_minimum = |p: &FinishRecord| p.converged && p.willmore_refused.is_none();
        self.components.iter().all(at_minimum)
    }

    /// Records a refusal for all components.
    pub(super) fn refuse(&mut self, record: fn(&mut FinishRecord)) {
        self.components.iter_mut().for_each(record);
    }
}

/// A patch after its finish.
pub(super) struct FinishedPatch {
    pub(super) patch: Patch,
    /// None for a patch that was not finished.
    pub(super) report: Option<FinishReport>,
    /// Expected error of each new vertex.
    pub(super) expected_error: Vec<Option<f64>>,
}

impl FinishedPatch {
    /// A patch without a finish.
    pub(super) fn unfinished(patch: Patch) -> Self {
        Self {
            expected_error: vec![None; patch.positions.len()],
            patch,
            report: None,
        }
    }

    /// Quality of the patch.
    pub(super) fn quality(&self) -> Quality {
        quality(&self.patch, self.report.as_ref())
    }

    /// Whether the patch was finished and has converged to a minimum of the energy.
    pub(super) fn is_at_minimum(&self) -> bool {
        self.report
            .as_ref()
            .is_some_and(FinishReport::is_at_minimum)
    }
}

/// Quality of a joined patch, including the results of its finish.
pub(super) fn quality(patch: &Patch, finish: Option<&FinishReport>) -> Quality {
    Quality {
        intersections: patch.report.intersecting_faces,
        is_plain: patch.positions.is_empty(),
        ..finish.map(FinishReport::quality).unwrap_or_default()
    }
}

/// Error on the rings of the blend of one component: root of the weighted mean square of its candidates' errors.
fn ring_error(piece: &FinishRecord) -> Option<f64> {
    let square = |c: &CandidateRecord| Some(c.weight * c.ring_error?.powi(2));
    let squares: f64 = piece.candidates.iter().filter_map(square).sum();
    (squares > 0.0).then(|| squares.sqrt())
}
