//! How good an answer is, for its colour in terminals and reports.

use isomend_core::check::Verdict;
use isomend_core::fill::{HoleOutcome, LeftReason};
use isomend_core::mend::FillReport;

/// How good an answer is.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// Nothing is left to be done.
    Yes,
    /// Something is left open or doubtful.
    InPart,
    /// Something is wrong.
    No,
}

impl Standing {
    /// Yes if all holes are closed without intersections, no if one could not be closed, else in part. Holes outside the marked region of a
    /// restoration do not count.
    pub fn of_fill(report: &FillReport) -> Self {
        let tally = report.tally();
        let not_marked = HoleOutcome::Left(LeftReason::NotMarked);
        let outside = report.holes.iter().filter(|h| h.outcome == not_marked);
        let is_whole = tally.left == outside.count()
            && tally.intersecting_patches == 0
            && tally.open_chains == 0;
        match tally.open {
            0 if is_whole => Self::Yes,
            0 => Self::InPart,
            _ => Self::No,
        }
    }

    /// Yes, no, or in part where only the shape is doubtful.
    pub fn of_verdict(verdict: &Verdict) -> Self {
        match verdict.is_sound() {
            true => Self::Yes,
            false if verdict.is_doubtful() => Self::InPart,
            false => Self::No,
        }
    }

    /// Its class in the style sheets.
    pub fn class(self) -> &'static str {
        match self {
            Self::Yes => "good",
            Self::InPart => "fair",
            Self::No => "bad",
        }
    }
}
