//! Rounds of offset shells in a repair: each shell adds surface along which further holes can be closed. A round that increases
//! the faults is undone.

use std::collections::HashSet;

use super::faults::Faults;
use super::shell_search::{Blocked, Budget, Wanted};
use super::{Run, offset_shells, report};
use crate::fill::{HoleOutcome, LeftReason, OpenReason};
use crate::mend::{FillError, HoleReport};
use crate::mesh::Hole;
use crate::tuning::{Tunable, tunable};

/// Rounds: each shell adds surface along which further holes can be closed.
const SHELL_PASSES: Tunable<usize> = tunable("repair.shell_passes", 4);

/// Times that faces are cut out of surfaces for which no shell can be made, at most.
const SHELL_CUTS: Tunable<usize> = tunable("repair.shell_cuts", 30);

impl Run<'_> {
    fn walls_wanted(&self) -> Wanted {
        Wanted {
            wall: self.params.wall,
            sheets: self.params.borders,
        }
    }

    /// Closes holes that are still open by offset shells, if that reduces the faults. First without cutting, then after cutting
    /// out faces that block a shell.
    pub(super) fn add_offset_shells(
        &mut self,
        was_border: &dyn Fn(&Hole, &[u32]) -> bool,
    ) -> Result<(), FillError> {
        let borders = self.params.borders;
        let wanted = |hole: &HoleReport| match &hole.outcome {
            HoleOutcome::Open(why) => *why != OpenReason::NotReached,
            HoleOutcome::Left(LeftReason::OuterBoundary | LeftReason::SmallComponent) => borders,
            _ => false,
        };
        let walls = self.walls_wanted();
        let mut budget = Budget::new(borders);
        let mut blocked = Vec::new();
        for _ in 0..SHELL_PASSES.get() {
            self.go_on()?;
            let before = self.judged_state()?;
            let done = offset_shells::add(
                &mut self.draft,
                &mut self.report.fill,
                &wanted,
                (false, walls),
                &mut budget,
            )?;
            blocked = done.blocked;
            self.report.walls.extend(done.walls);
            if done.count == 0 {
                break;
            }
            self.separate_again()?;
            if !self.keep_better(before)? {
                break;
            }
        }
        let mut faults = None;
        for blocked in blocked.into_iter().take(SHELL_CUTS.get()) {
            self.go_on()?;
            self.cut_and_offset(blocked, &wanted, was_border, (&mut budget, &mut faults))?;
        }
        for hole in self.report.fill.holes.iter_mut().filter(|_| borders) {
            if hole.outcome == HoleOutcome::Left(LeftReason::OuterBoundary) {
                hole.outcome = HoleOutcome::Open(OpenReason::EveryTriangulationIntersects);
            }
        }
        Ok(())
    }

    /// Cuts out faces that block an offset shell and closes the holes by shells then, if that reduces the faults. `faults` caches
    /// the faults of the present draft; they are computed only if needed, since most faces cannot be cut out.
    fn cut_and_offset(
        &mut self,
        mut blocked: Blocked,
        wanted: &dyn Fn(&HoleReport) -> bool,
        was_border: &dyn Fn(&Hole, &[u32]) -> bool,
        (budget, faults): (&mut Budget, &mut Option<Faults>),
    ) -> Result<(), FillError> {
        let near = |hole: &HoleReport, rims: &HashSet<u32>| {
            wanted(hole) && hole.hole.rim.iter().any(|v| rims.contains(v))
        };
        let holes = &self.report.fill.holes;
        if !holes.iter().any(|h| near(h, &blocked.rims)) {
            return Ok(());
        }
        let mut before = (self.draft.clone(), self.report.clone(), self.lost);
        let walls = self.walls_wanted();
        let mut was_cut = false;
        for _ in 0..SHELL_PASSES.get() {
            let most = self.most_lost();
            let Some(own) = offset_shells::cut(&mut self.draft, &mut blocked, most)? else {
                break;
            };
            was_cut = true;
            let before_cut = match *faults {
                Some(known) => known,
                None => *faults.insert(before.0.faults()?),
            };
            self.lost += own;
            let origin = self.draft.origins.vertices.clone();
            let open = |hole: &Hole| was_border(hole, &origin);
            report::open(&self.draft, &mut self.report.fill, &open)?;
            let near = |hole: &HoleReport| near(hole, &blocked.rims);
            let whole = blocked.whole;
            let fill = &mut self.report.fill;
            let kind = (whole, walls);
            let done = offset_shells::add(&mut self.draft, fill, &near, kind, budget)?;
            self.report.walls.extend(done.walls);
            if done.count > 0 {
                self.separate_again()?;
            }
            let after_cut = self.draft.faults()?;
            if after_cut < before_cut {
                *faults = Some(after_cut);
                let fill = &mut self.report.fill;
                return offset_shells::record_gone(&self.draft, fill, &near);
            }
            let Some(next) = done.blocked.into_iter().next() else {
                break;
            };
            blocked.faces = next.faces;
        }
        if was_cut {
            (self.draft, self.report, self.lost) = before;
        }
        Ok(())
    }
}
