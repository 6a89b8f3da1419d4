//! State of the search for a region's patch: the candidates made so far, and the results that later candidates use.

use super::candidate::{FinishedPatch, quality};
use super::grids::{Attempt, RetryContext, failures};
use super::invented::CounterpartReport;
use super::quality::Quality;
use super::reasons::{AttemptFailure, NotContinued};
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::strategy::{Ending, history};
use crate::region::{MeshData, Region, Solved};
use crate::stitch::Patch;

/// The candidates of a region made so far, and their results.
pub(super) struct SoFar<'b> {
    /// The first level-set attempt.
    pub(super) first: Attempt,
    pub(super) retry_context: RetryContext,
    /// The candidates, in the order in which they were made.
    pub(super) tried: Vec<Tried>,
    /// The unconverged level set with the smallest last update.
    pub(super) best_unconverged: Option<Unconverged<'b>>,
    /// The report of the last level set without a patch.
    pub(super) last: RegionReport,
    /// Number of sharp edges that end at the rim.
    pub(super) crease_ends: usize,
    /// Median residual of the smooth sides around the rim, in edges; 0 where there are none.
    pub(super) noise: f64,
    /// Why they were not continued.
    pub(super) not_continued: Option<NotContinued>,
    /// How the counterpart fits, if there is one.
    pub(super) counterpart: Option<CounterpartReport>,
}

/// A candidate that was made.
pub(super) struct Tried {
    /// The candidate and its result, as the strategy sees them.
    pub(super) ending: Ending,
    /// What it produced.
    pub(super) made: Made,
}

/// What a candidate produced.
pub(super) enum Made {
    /// No patch.
    Nothing,
    /// The joined, unfinished patch of a level set, and its report.
    Joined(Patch, RegionReport),
    /// A finished patch.
    Finished(FinishedPatch),
    /// The complete result of the region.
    Region(RegionPatch),
}

/// The result of a level set, in addition to what it produced.
#[derive(Default)]
pub(super) struct LevelEnd {
    pub(super) failure: Option<AttemptFailure>,
    /// See [`Ending::level_energy`].
    pub(super) energy: Option<f64>,
}

/// An unconverged level set whose last update was small.
pub(super) struct Unconverged<'a> {
    pub(super) solved: Solved,
    pub(super) region: Region,
    pub(super) data: MeshData<'a>,
    pub(super) report: RegionReport,
}

impl SoFar<'_> {
    /// The level-set attempts made so far.
    pub(super) fn history(&self) -> Vec<(Attempt, Option<AttemptFailure>)> {
        history(&self.endings())
    }

    /// The results of the candidates made so far.
    pub(super) fn endings(&self) -> Vec<Ending> {
        self.tried.iter().map(|t| t.ending.clone()).collect()
    }

    /// The best patch of a level set; the first of equal ones.
    pub(super) fn best_joined(&self) -> Option<(&Patch, &RegionReport)> {
        let joined = self.tried.iter().filter_map(|t| match &t.made {
            Made::Joined(patch, report) => Some((t.ending.quality, patch, report)),
            _ => None,
        });
        let best = joined.min_by_key(|(quality, ..)| *quality);
        best.map(|(_, patch, report)| (patch, report))
    }

    /// The failure of the last level set, if one was attempted, and a report for a region that no level set closed.
    pub(super) fn without_level_set(&self) -> (Option<AttemptFailure>, RegionReport) {
        let report = RegionReport {
            failed_attempts: failures(&self.history()),
            ..self.last.clone()
        };
        (report.failed_attempts.last().cloned(), report)
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

/// Quality of a joined, unfinished patch, with the energy of its level set.
fn joined_quality(patch: &Patch, report: &RegionReport) -> Quality {
    Quality {
        is_unconverged: !report.converged,
        energy: report.levels.last().map_or(0.0, |l| l.flow.willmore()),
        ..quality(patch, None)
    }
}
