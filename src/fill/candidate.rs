//! A patch after its finish, and what the finish found.

use super::quality::Quality;
use serde::{Deserialize, Serialize};

use crate::finish::{CandidateFound, FinishFound};
use crate::stitch::Patch;

/// From what a patch was finished.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum PatchStart {
    /// The surface of the level set.
    #[default]
    LevelSet,
    /// A refined triangulation of the rim, filled biharmonically.
    Triangulation,
}

/// What the finish of a region's patch found and did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FinishReport {
    /// From what it was finished.
    pub start: PatchStart,
    /// Each connected piece of the patch.
    pub pieces: Vec<FinishFound>,
}

impl FinishReport {
    /// What of a quality the finish tells.
    pub(super) fn quality(&self) -> Quality {
        let pieces = || self.pieces.iter();
        Quality {
            folds: pieces().map(|p| p.folds_after).sum(),
            is_unconverged: !self.is_at_minimum(),
            expected_error: pieces().filter_map(ring_error).reduce(f64::max),
            energy: pieces().map(|p| p.energy_after).sum(),
            ..Quality::default()
        }
    }

    /// Whether all pieces are at a minimum of the energy, and none had to be kept as it was.
    pub(super) fn is_at_minimum(&self) -> bool {
        let at_minimum = |p: &FinishFound| p.converged && p.willmore_refused.is_none();
        self.pieces.iter().all(at_minimum)
    }

    /// The largest expected error of a vertex.
    pub fn largest_expected_error(&self) -> Option<f64> {
        let pieces = self.pieces.iter().filter_map(|p| p.largest_expected_error);
        pieces.reduce(f64::max)
    }
}

/// A patch after its finish.
pub(super) struct FinishedPatch {
    pub(super) patch: Patch,
    /// None where it was not finished.
    pub(super) report: Option<FinishReport>,
    /// For each new vertex its expected error.
    pub(super) expected_error: Vec<Option<f64>>,
}

impl FinishedPatch {
    /// A patch as it is.
    pub(super) fn unfinished(patch: Patch) -> Self {
        Self {
            expected_error: vec![None; patch.positions.len()],
            patch,
            report: None,
        }
    }

    /// How good it is.
    pub(super) fn quality(&self) -> Quality {
        quality(&self.patch, self.report.as_ref())
    }

    /// Whether it was finished and is at a minimum of the energy.
    pub(super) fn is_at_minimum(&self) -> bool {
        self.report
            .as_ref()
            .is_some_and(FinishReport::is_at_minimum)
    }
}

/// How good a joined patch is, and what its finish found of it.
pub(super) fn quality(patch: &Patch, finish: Option<&FinishReport>) -> Quality {
    Quality {
        intersections: patch.report.intersecting_faces,
        is_plain: patch.positions.is_empty(),
        ..finish.map(FinishReport::quality).unwrap_or_default()
    }
}

/// Error on the rings of what was blended for a piece, by the weights.
fn ring_error(piece: &FinishFound) -> Option<f64> {
    let square = |c: &CandidateFound| Some(c.weight * c.ring_error?.powi(2));
    let squares: f64 = piece.candidates.iter().filter_map(square).sum();
    (squares > 0.0).then(|| squares.sqrt())
}
