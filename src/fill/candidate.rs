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
    /// Folds and energy of all pieces.
    fn sum(&self) -> FinishFound {
        let mut all = FinishFound::default();
        for piece in &self.pieces {
            all.folds_after += piece.folds_after;
            all.energy_after += piece.energy_after;
        }
        all
    }

    /// Whether another finish of the same hole, from another start, has fewer folded faces or a clearly lower energy.
    fn is_worse_than(&self, other: &Self) -> bool {
        other.sum().is_better_than(&self.sum())
    }

    /// The largest expected error of a vertex.
    pub fn largest_sigma(&self) -> Option<f64> {
        let pieces = self.pieces.iter().filter_map(|p| p.largest_sigma);
        pieces.reduce(f64::max)
    }
}

/// An energy below this part of another is that of another kind of surface, not of another triangulation. On 143 holes of scans
/// those above it, down to two thirds, were farther from the truth than the first.
const MUCH_LOWER: f64 = 0.5;

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
        let folds = self.report.as_ref().map_or(0, |r| r.sum().folds_after);
        folds == 0 && self.patch.report.intersecting_faces == 0
    }

    /// ½∫h² of its surface of least energy; 0 where it was not finished.
    pub(super) fn energy(&self) -> f64 {
        self.report.as_ref().map_or(0.0, |r| r.sum().energy_after)
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

    /// This one, unless another one from another start is sound and bends much less.
    pub(super) fn or_much_lower(self, other: Option<Self>) -> Self {
        let is_lower = |other: &Self| {
            let has_vertices = !other.patch.positions.is_empty();
            has_vertices && other.is_sound() && other.energy() < MUCH_LOWER * self.energy()
        };
        other.filter(is_lower).unwrap_or(self)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn finished(start: PatchStart, folds_after: usize, energy_after: f64) -> FinishedPatch {
        let piece = FinishFound {
            folds_after,
            energy_after,
            ..FinishFound::default()
        };
        let patch = Patch {
            positions: vec![DVec3::ZERO],
            ..Patch::default()
        };
        FinishedPatch {
            report: Some(FinishReport {
                start,
                pieces: vec![piece],
            }),
            ..FinishedPatch::unfinished(patch)
        }
    }

    #[test]
    fn a_bent_patch_gives_way_to_a_sound_one_of_much_lower_energy_only() {
        let start_of_taken = |folds, energy| {
            let first = finished(PatchStart::LevelSet, 0, 9.7);
            let second = finished(PatchStart::Triangulation, folds, energy);
            first.or_much_lower(Some(second)).report.unwrap().start
        };
        assert_eq!(start_of_taken(0, 0.3), PatchStart::Triangulation);
        assert_eq!(start_of_taken(0, 7.0), PatchStart::LevelSet);
        assert_eq!(start_of_taken(1, 0.3), PatchStart::LevelSet);
        assert_eq!(start_of_taken(0, f64::NAN), PatchStart::LevelSet);
    }
}
