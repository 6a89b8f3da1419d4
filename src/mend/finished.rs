//! A patch after its finish, and what the finish found.

use serde::{Deserialize, Serialize};

use crate::finish::FinishFound;
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
pub struct FinishReport {
    /// From what it was finished.
    pub start: PatchStart,
    /// Each connected piece of the patch.
    pub pieces: Vec<FinishFound>,
}

impl FinishReport {
    /// Whether another finish of the same hole, from another start, has fewer folded faces or a clearly lower energy.
    fn is_worse_than(&self, other: &Self) -> bool {
        let sum = |report: &Self| {
            let mut all = FinishFound::default();
            for piece in &report.pieces {
                all.folds_after += piece.folds_after;
                all.energy_after += piece.energy_after;
            }
            all
        };
        sum(other).is_better_than(&sum(self))
    }

    /// The largest expected error of a vertex.
    pub fn largest_sigma(&self) -> Option<f64> {
        let pieces = self.pieces.iter().filter_map(|p| p.largest_sigma);
        pieces.reduce(f64::max)
    }
}

/// A patch after its finish.
pub(super) struct FinishedPatch {
    pub(super) patch: Patch,
    /// None where it was not finished.
    pub(super) report: Option<FinishReport>,
    /// For each new vertex its expected error.
    pub(super) sigma: Vec<Option<f64>>,
}

impl FinishedPatch {
    /// A patch as it is.
    pub(super) fn unfinished(patch: Patch) -> Self {
        Self {
            sigma: vec![None; patch.positions.len()],
            patch,
            report: None,
        }
    }

    /// Whether it crosses nothing and is not folded.
    pub(super) fn is_sound(&self) -> bool {
        let folds = |report: &FinishReport| report.pieces.iter().map(|p| p.folds_after).sum();
        let folds: usize = self.report.as_ref().map_or(0, folds);
        folds == 0 && self.patch.report.intersecting_faces == 0
    }

    /// Whether it is sound, its energy found a minimum, and none of its pieces had to be kept as it was.
    pub(super) fn is_at_rest(&self) -> bool {
        let at_rest = |p: &FinishFound| p.converged && p.willmore_refused.is_none();
        let pieces = self.report.as_ref().map(|r| &r.pieces);
        self.is_sound() && pieces.is_some_and(|p| p.iter().all(at_rest))
    }

    /// The better of two: that which crosses less, then that with fewer folds, then with the lower energy.
    pub(super) fn or_better(self, other: Option<Self>) -> Self {
        // A patch without vertices of its own is no surface that could be compared.
        let Some(other) = other.filter(|o| !o.patch.positions.is_empty()) else {
            return self;
        };
        let crossing = |p: &Self| p.patch.report.intersecting_faces;
        let better = match crossing(&other).cmp(&crossing(&self)) {
            std::cmp::Ordering::Less => true,
            std::cmp::Ordering::Greater => false,
            std::cmp::Ordering::Equal => match (&self.report, &other.report) {
                (Some(own), Some(other)) => own.is_worse_than(other),
                _ => false,
            },
        };
        if better { other } else { self }
    }
}
