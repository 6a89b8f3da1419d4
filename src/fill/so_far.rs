//! What the search of a region came to so far: the candidates that were made, and what later ones use of them.

use super::candidate::{FinishedPatch, quality};
use super::grids::{Prospects, Try, failures};
use super::invented::CounterpartReport;
use super::outcome::{NotContinued, TryFailure};
use super::quality::Quality;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::strategy::{Ending, history};
use crate::region::{MeshData, Region, Solved};
use crate::stitch::Patch;

/// The candidates that were made of a region, and what they found.
pub(super) struct SoFar<'b> {
    /// The level set that is tried first.
    pub(super) first: Try,
    pub(super) prospects: Prospects,
    /// How each candidate ended, in the order in which they were made,
    pub(super) endings: Vec<Ending>,
    /// and what was made.
    pub(super) made: Vec<Made>,
    /// The level set that did not converge whose last update was the smallest.
    pub(super) nearest: Option<Unconverged<'b>>,
    /// What the last level set without a patch found.
    pub(super) last: RegionReport,
    /// Number of sharp edges that end at the rim.
    pub(super) crease_ends: usize,
    /// Why they were not continued.
    pub(super) not_continued: Option<NotContinued>,
    /// How the counterpart fits, if there is one.
    pub(super) counterpart: Option<CounterpartReport>,
}

/// What a candidate came to.
pub(super) enum Made {
    /// No patch.
    Nothing,
    /// The patch of a level set, and what was found.
    Joined(Patch, RegionReport),
    /// A finished patch.
    Finished(FinishedPatch),
    /// What becomes of the region.
    Region(RegionPatch),
}

/// How a level set ended, beside what was made.
#[derive(Default)]
pub(super) struct LevelEnd {
    pub(super) failure: Option<TryFailure>,
    /// See [`Ending::level_energy`].
    pub(super) energy: Option<f64>,
}

/// A level set that did not converge, but whose last update was small.
pub(super) struct Unconverged<'a> {
    pub(super) solved: Solved,
    pub(super) region: Region,
    pub(super) data: MeshData<'a>,
    pub(super) report: RegionReport,
}

impl SoFar<'_> {
    /// The grids that were tried.
    pub(super) fn history(&self) -> Vec<(Try, Option<TryFailure>)> {
        history(&self.endings)
    }

    /// The best patch of a level set; of equals the first.
    pub(super) fn best_joined(&self) -> Option<(&Patch, &RegionReport)> {
        let all = self.endings.iter().zip(&self.made);
        let joined = all.filter_map(|(ending, made)| match made {
            Made::Joined(patch, report) => Some((ending.quality, patch, report)),
            _ => None,
        });
        let best = joined.min_by_key(|(quality, ..)| *quality);
        best.map(|(_, patch, report)| (patch, report))
    }

    /// Why no level set closed the region, none where none was made, and what is reported then.
    pub(super) fn without_level_set(&self) -> (Option<TryFailure>, RegionReport) {
        let report = RegionReport {
            earlier_tries: failures(&self.history()),
            ..self.last.clone()
        };
        (report.earlier_tries.last().cloned(), report)
    }
}

impl Made {
    pub(super) fn quality(&self) -> Option<Quality> {
        match self {
            Self::Nothing => None,
            Self::Joined(patch, report) => Some(joined_quality(patch, report)),
            Self::Finished(patch) => Some(patch.quality()),
            Self::Region(region) => Some(region.quality()),
        }
    }
}

impl From<Option<FinishedPatch>> for Made {
    fn from(patch: Option<FinishedPatch>) -> Self {
        patch.map_or(Self::Nothing, Self::Finished)
    }
}

impl From<Option<RegionPatch>> for Made {
    fn from(region: Option<RegionPatch>) -> Self {
        region.map_or(Self::Nothing, Self::Region)
    }
}

/// How good a patch is that is not finished yet: its energy is that of the level set.
fn joined_quality(patch: &Patch, report: &RegionReport) -> Quality {
    Quality {
        is_unconverged: !report.converged,
        energy: report.levels.last().map_or(0.0, |l| l.flow.willmore()),
        ..quality(patch, None)
    }
}
