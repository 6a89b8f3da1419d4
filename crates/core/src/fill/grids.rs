//! Retries of the level set of a region: grid, initialisation and energy of the next attempt, from the earlier attempts and their
//! failures.

use super::reasons::AttemptFailure;
use crate::flow::Energy;
use crate::region::{LevelReport, Start};
use crate::stitch::StitchError;
use crate::tuning::{Tunable, tunable};

/// Attempts. Upper bound of the level-set solves of a region with one energy, and again with the fallback energy.
const MOST_ATTEMPTS: Tunable<usize> = tunable("fill.most_attempts", 6);

/// Upper bound of the factor that divides the automatic voxel in a retry: finer grids gave the same result.
const MOST_REFINED: Tunable<f64> = tunable("fill.most_refined", 2.0);

/// Factor by which the margin of the box around the rims grows when the surface reaches its side.
const BOX_GROWTH: Tunable<f64> = tunable("fill.box_growth", 1.8);

/// Upper bound of the growth of the box's margin: two steps.
pub(crate) fn widest_growth() -> f64 {
    BOX_GROWTH.get() * BOX_GROWTH.get()
}

/// Margins of the first box. The box grows while its margin is narrower than this, which allows two steps. A missing part
/// much wider than its rim, such as a sphere of which only a cap of 30° remains, needs both.
const BOX_WIDE: Tunable<f64> = tunable("fill.box_wide", 3.0);

/// Diameters of the region. Two failures to join a surface at places closer than this count as the same failure.
const SAME_PLACE: Tunable<f64> = tunable("fill.same_place", 0.05);

/// Settings of one level-set solve of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Attempt {
    /// Factor of the box's margin.
    pub(super) growth: f64,
    /// Divisor of the voxel.
    pub(super) refine: f64,
    pub(super) start: Start,
    /// Whether the surface is taken even if the flow has not converged.
    pub(super) accept: bool,
    pub(super) energy: Energy,
}

impl Attempt {
    /// The first attempt with an energy.
    pub(super) fn first(energy: Energy) -> Self {
        Self {
            growth: 1.0,
            refine: 1.0,
            start: Start::Biharmonic,
            accept: false,
            energy,
        }
    }

    /// The same grid, initialised from a triangulation of the only rim.
    pub(super) fn with_triangulation(&self) -> Self {
        Self {
            start: Start::Triangulation,
            ..*self
        }
    }

    /// Half the voxel, initialised from a triangulation of the rims; none where the voxel is at its least.
    pub(super) fn finer(&self) -> Option<Self> {
        (self.refine < MOST_REFINED.get()).then_some(Self {
            refine: 2.0 * self.refine,
            ..self.with_triangulation()
        })
    }

    /// Whether the box may grow.
    pub(super) fn may_widen(&self) -> bool {
        self.growth < BOX_WIDE.get()
    }

    /// A wider box, initialised from the sphere that continues the surroundings: a wide surface is far from an initialisation
    /// that hardly bulges. None where the box has its largest size.
    fn wider(&self) -> Option<Self> {
        self.may_widen().then_some(Self {
            growth: BOX_GROWTH.get() * self.growth,
            start: Start::Sphere,
            ..*self
        })
    }
}

/// The attempts at a region so far, in order, and why each failed. An attempt with [`AttemptFailure::Intersects`] still has a patch.
/// Two attempts on the same grid count as one.
pub(super) type History = [(Attempt, Option<AttemptFailure>)];

/// The properties of a region that decide about retries.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RetryContext {
    /// Whether there is a counterpart after which it may be filled.
    pub(super) has_counterpart: bool,
    /// Whether it is an opening in a wall, whose edge is straight.
    pub(super) is_straight_opening: bool,
    /// Whether sharp edges are continued.
    pub(super) may_be_sharp: bool,
    /// Whether the voxel is automatic, so that it may be refined.
    pub(super) may_refine: bool,
    /// The region's diameter.
    pub(super) diameter: f64,
    /// Whether its rim is the end of a tube: a finer grid does not determine how a tube continues.
    pub(super) tube_end: bool,
    /// Whether the surroundings continue as a sphere, and the missing part of it is wider than its rim.
    pub(super) is_wide: bool,
    /// Whether patches are finished.
    pub(super) finishes: bool,
    /// Whether the region has a single rim.
    pub(super) one_rim: bool,
    /// Whether it has more rims than level sets close, and other candidates come next: no level set is attempted.
    pub(super) many_rims: bool,
    /// Whether a faired triangulation is made before any level set: its only rim has few edges, or many on a thin wall.
    pub(super) faired_first: bool,
    /// Expected cost of a faired triangulation, in unknowns times steps.
    pub(super) faired_cost: f64,
    /// Upper bound of the cost of all retries, and their cost so far, in unknowns times steps; see [`spent`].
    pub(super) budget: u64,
    pub(super) spent: u64,
}

/// Cost of level-set solves: the sum over levels of unknowns times steps, about 6 µs each.
pub(super) fn spent(levels: &[LevelReport]) -> u64 {
    let of = |l: &LevelReport| (l.flow.unknowns * l.flow.steps.len()) as u64;
    levels.iter().map(of).sum()
}

/// The attempt after the given ones; none where no other is worthwhile. The history starts with an attempt like `first`.
///
/// Each attempt responds to the failure of the last: a finer grid where the flow did not converge or the patch could not be
/// joined, a wider box where the surface reached its side. Where an energy finds no patch at all, its fallback energy starts
/// again with the first settings.
pub(super) fn next_attempt(
    first: &Attempt,
    history: &History,
    region: &RetryContext,
) -> Option<Attempt> {
    let Some((last, failure)) = history.last() else {
        return Some(*first);
    };
    // The attempts with the same energy as the last; they are contiguous.
    let before = history.iter().rposition(|(t, _)| t.energy != last.energy);
    let own = &history[before.map_or(0, |i| i + 1)..];
    let failure = failure.as_ref()?;
    // The next attempt with half the voxel, where refinement may help; it does not at the end of a tube.
    let finest = own.iter().map(|(t, _)| t.refine).fold(1.0, f64::max);
    let finer = || {
        last.finer()
            .filter(|_| region.may_refine && !region.tube_end)
    };
    // Response to each failure: a finer grid, a wider box, the first grid again with its surface accepted, or nothing.
    let next = match failure {
        AttemptFailure::Diverged | AttemptFailure::Stopped => None,
        AttemptFailure::NotConverged => finer(),
        AttemptFailure::ReachedBox => last.wider(),
        AttemptFailure::Intersects(_) => finer().filter(|next| next.refine > finest),
        AttemptFailure::NotJoined(error) if is_known(error, &own[..own.len() - 1], region) => None,
        // The surface has diverged: take the result of the first grid.
        AttemptFailure::NotJoined(StitchError::OpenBoundary { .. }) if last.refine > 1.0 => {
            Some(Attempt {
                refine: 1.0,
                start: Start::Triangulation,
                accept: true,
                ..*last
            })
        }
        AttemptFailure::NotJoined(
            StitchError::TooManyFaces { .. } | StitchError::Folded { .. },
        ) => None,
        AttemptFailure::NotJoined(_) if last.accept => None,
        AttemptFailure::NotJoined(_) => finer(),
    };
    // The budget limits the cost of the attempts with one energy, `most_attempts` their number.
    let next = next.filter(|_| region.spent < region.budget);
    if next.is_some() {
        return next.filter(|_| own.len() < MOST_ATTEMPTS.get());
    }
    // Without a next attempt the fallback energy starts again with the first settings, unless a patch exists that merely
    // intersects faces.
    let has_patch = |(_, v): &(Attempt, Option<AttemptFailure>)| {
        matches!(v, Some(AttemptFailure::Intersects(_)))
    };
    let fallback = first.energy.needs().fallback?;
    let anew = last.energy == first.energy && !history.iter().any(has_patch);
    anew.then_some(Attempt {
        energy: fallback,
        ..*first
    })
}

/// Reasons for the failures, in order.
pub(super) fn failures(history: &History) -> Vec<AttemptFailure> {
    let failures = history.iter().filter_map(|(_, failure)| failure.as_ref());
    failures.cloned().collect()
}

/// Whether an earlier attempt failed with the same error near the same place.
fn is_known(error: &StitchError, earlier: &History, region: &RetryContext) -> bool {
    earlier.iter().any(|(_, failure)| match failure {
        Some(AttemptFailure::NotJoined(other)) => {
            error.is_like(other, SAME_PLACE.get() * region.diameter)
        }
        _ => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A region that is refined if `may_refine`.
    fn region(may_refine: bool) -> RetryContext {
        RetryContext {
            has_counterpart: false,
            is_straight_opening: false,
            may_be_sharp: false,
            may_refine,
            diameter: 1.0,
            tube_end: false,
            is_wide: false,
            finishes: true,
            one_rim: true,
            many_rims: false,
            faired_first: false,
            faired_cost: 0.0,
            budget: 1,
            spent: 0,
        }
    }

    const LOST: AttemptFailure = AttemptFailure::NotConverged;

    fn open_border() -> AttemptFailure {
        AttemptFailure::NotJoined(StitchError::OpenBoundary {
            position: DVec3::ZERO,
            distance: 1.0,
        })
    }

    /// The attempts that follow from these outcomes, in order.
    fn attempts_for(
        energy: Energy,
        may_refine: bool,
        ends: &[Option<AttemptFailure>],
    ) -> Vec<Attempt> {
        let first = Attempt::first(energy);
        let mut history: Vec<(Attempt, Option<AttemptFailure>)> = Vec::new();
        for end in ends {
            match next_attempt(&first, &history, &region(may_refine)) {
                Some(next) => history.push((next, end.clone())),
                None => break,
            }
        }
        history.into_iter().map(|(t, _)| t).collect()
    }

    #[test]
    fn grids_get_finer_once_and_no_more() {
        let ends = vec![Some(LOST); 9];
        let refined: Vec<f64> = attempts_for(Energy::Willmore, true, &ends)
            .iter()
            .map(|t| t.refine)
            .collect();
        assert_eq!(refined, [1.0, 2.0]);
        assert_eq!(attempts_for(Energy::Willmore, false, &ends).len(), 1);
    }

    #[test]
    fn a_sound_patch_ends_it() {
        let ends = [Some(LOST), None, None];
        assert_eq!(attempts_for(Energy::Willmore, true, &ends).len(), 2);
    }

    #[test]
    fn a_surface_that_ran_away_is_taken_from_the_first_grid() {
        let ends = [LOST, open_border(), open_border(), open_border()].map(Some);
        let attempts = attempts_for(Energy::Willmore, true, &ends);
        assert_eq!(attempts.len(), 3);
        assert!(attempts[2].accept && attempts[2].refine == 1.0);
    }

    #[test]
    fn the_box_grows_twice() {
        let ends = vec![Some(AttemptFailure::ReachedBox); 4];
        let attempts = attempts_for(Energy::Willmore, true, &ends);
        let growths: Vec<f64> = attempts.iter().map(|t| t.growth).collect();
        assert_eq!(growths, [1.0, BOX_GROWTH.get(), widest_growth()]);
    }

    #[test]
    fn an_error_that_comes_again_at_the_same_place_ends_it() {
        let at = |x| {
            Some(AttemptFailure::NotJoined(StitchError::OpenBoundary {
                position: DVec3::new(x, 0.0, 0.0),
                distance: 1.0,
            }))
        };
        let again = [at(0.0), at(0.01), at(0.02)];
        assert_eq!(attempts_for(Energy::Willmore, true, &again).len(), 2);
        let elsewhere = [at(0.0), at(0.5), at(1.0)];
        assert_eq!(attempts_for(Energy::Willmore, true, &elsewhere).len(), 3);
    }

    #[test]
    fn ends_of_tubes_are_not_refined_and_what_is_spent_is_not_spent_again() {
        let first = Attempt::first(Energy::Willmore);
        let history = [(first, Some(LOST))];
        let next = |region: &RetryContext| next_attempt(&first, &history, region);
        assert!(next(&region(true)).is_some());
        let tube = RetryContext {
            tube_end: true,
            ..region(true)
        };
        let poor = RetryContext {
            spent: 1,
            ..region(true)
        };
        assert!(next(&tube).is_none() && next(&poor).is_none());
    }

    #[test]
    fn intersecting_patches_are_refined_beyond_the_finest_only() {
        let intersecting = |n| Some(AttemptFailure::Intersects(n));
        let ends = [
            Some(LOST),
            Some(open_border()),
            intersecting(3),
            intersecting(1),
        ];
        // Finer, then back on the first grid: a patch with intersecting faces there is not refined again.
        assert_eq!(attempts_for(Energy::Willmore, true, &ends).len(), 3);
        assert_eq!(
            attempts_for(
                Energy::Willmore,
                true,
                &[
                    intersecting(3),
                    intersecting(1),
                    intersecting(1),
                    intersecting(1)
                ]
            )
            .len(),
            2
        );
    }

    #[test]
    fn another_energy_begins_anew_unless_there_is_a_patch() {
        let gone = Some(AttemptFailure::Diverged);
        let attempts = attempts_for(
            Energy::CurvatureVariation,
            true,
            &[gone.clone(), gone.clone(), gone.clone()],
        );
        let energies: Vec<Energy> = attempts.iter().map(|t| t.energy).collect();
        assert_eq!(energies, [Energy::CurvatureVariation, Energy::Willmore]);
        let intersecting = Some(AttemptFailure::Intersects(2));
        let ends = [
            intersecting.clone(),
            intersecting.clone(),
            intersecting,
            gone.clone(),
            gone,
        ];
        assert_eq!(
            attempts_for(Energy::CurvatureVariation, true, &ends).len(),
            2
        );
    }

    #[test]
    fn an_energy_whose_budget_is_spent_makes_room_for_the_other() {
        let first = Attempt::first(Energy::CurvatureVariation);
        let spent = RetryContext {
            spent: 2,
            ..region(true)
        };
        let history = [(first, Some(LOST))];
        let next = next_attempt(&first, &history, &spent);
        assert_eq!(next.map(|t| t.energy), Some(Energy::Willmore));
        let first = Attempt::first(Energy::Willmore);
        let history = [(first, Some(LOST))];
        assert_eq!(next_attempt(&first, &history, &spent), None);
    }

    #[test]
    fn it_always_ends() {
        let failures = [
            LOST,
            AttemptFailure::ReachedBox,
            open_border(),
            AttemptFailure::Intersects(1),
            AttemptFailure::Diverged,
        ];
        let energies = [Energy::Willmore, Energy::CurvatureVariation];
        // Every sequence of five failures, repeated.
        for code in 0..3125usize {
            let digit = |i: u32| failures[code / 5usize.pow(i % 5) % 5].clone();
            let ends: Vec<Option<AttemptFailure>> = (0..20).map(|i| Some(digit(i))).collect();
            for energy in energies {
                assert!(attempts_for(energy, true, &ends).len() <= 2 * MOST_ATTEMPTS.get());
            }
        }
    }
}
