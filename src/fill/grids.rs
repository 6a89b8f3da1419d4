//! On which grid, from which start and with which energy the next level set is solved, from what was tried and how that ended.

use super::outcome::TryFailure;
use crate::flow::Energy;
use crate::region::{LevelReport, Start};
use crate::stitch::StitchError;
use crate::tuning::tuning;

/// One try at a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Try {
    /// Widens the box.
    pub(super) growth: f64,
    /// Divides the voxel.
    pub(super) refine: f64,
    pub(super) start: Start,
    /// Take the surface though the flow is not steady.
    pub(super) accept: bool,
    pub(super) energy: Energy,
}

impl Try {
    /// The first try with an energy.
    pub(super) fn first(energy: Energy) -> Self {
        Self {
            growth: 1.0,
            refine: 1.0,
            start: Start::Biharmonic,
            accept: false,
            energy,
        }
    }

    /// The same grid, from a triangulation of the only rim.
    pub(super) fn with_triangulation(&self) -> Self {
        Self {
            start: Start::Triangulation,
            ..*self
        }
    }

    /// Half the voxel, from a triangulation of the rims.
    pub(super) fn finer(&self) -> Option<Self> {
        (self.refine < tuning().fill.most_refined).then_some(Self {
            refine: 2.0 * self.refine,
            ..self.with_triangulation()
        })
    }

    /// Whether the box may grow.
    pub(super) fn may_widen(&self) -> bool {
        self.growth < tuning().fill.box_wide
    }

    /// A wider box, if it is not as wide as may be, from the sphere that continues the surroundings: such a surface has far
    /// to go from a start that hardly bulges.
    fn wider(&self) -> Option<Self> {
        self.may_widen().then_some(Self {
            growth: tuning().fill.box_growth * self.growth,
            start: Start::Sphere,
            ..*self
        })
    }
}

/// The tries at a region so far, in order, and how each failed; [`TryFailure::Crossing`] has a patch all the same. Two tries on one
/// grid count as one.
pub(super) type History = [(Try, Option<TryFailure>)];

/// What of a region bears on its tries.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Prospects {
    /// Whether there is a counterpart after which it may be filled.
    pub(super) has_counterpart: bool,
    /// Whether sharp edges are looked for.
    pub(super) may_be_sharp: bool,
    /// Whether the voxel is isomend's to choose.
    pub(super) may_refine: bool,
    /// The region's diameter.
    pub(super) diameter: f64,
    /// Whether its rim is the end of a tube, of which no finer grid tells how it goes on.
    pub(super) tube_end: bool,
    /// Whether the surroundings continue like a sphere on which the missing part is wider than its rim.
    pub(super) is_wide: bool,
    /// Whether patches are finished.
    pub(super) finishes: bool,
    /// Whether it has one rim only.
    pub(super) one_rim: bool,
    /// Whether that rim has so few edges that a faired triangulation is made before any level set.
    pub(super) few_edges: bool,
    /// Expected cost of a faired triangulation.
    pub(super) faired_cost: f64,
    /// What the tries after the first may cost in all, and what they have cost so far; see [`spent`].
    pub(super) budget: u64,
    pub(super) spent: u64,
}

/// What solves of a level set cost: the unknowns of each level times its steps, about 6 µs each.
pub(super) fn spent(levels: &[LevelReport]) -> u64 {
    let of = |l: &LevelReport| (l.flow.unknowns * l.flow.steps.len()) as u64;
    levels.iter().map(of).sum()
}

/// The try after those of a history, which begins with one like `first`; none where no other is worth its time.
///
/// Each try answers the failure of the last: a finer grid where the flow found no rest or the patch could not be joined, a
/// wider box where the surface came to its side. Where an energy finds no patch at all, the one to fall back to begins anew.
pub(super) fn next_try(first: &Try, history: &History, region: &Prospects) -> Option<Try> {
    let Some((last, failure)) = history.last() else {
        return Some(*first);
    };
    // The tries with the same energy as the last, which are the last ones.
    let begun = history.iter().rposition(|(t, _)| t.energy != last.energy);
    let own = &history[begun.map_or(0, |i| i + 1)..];
    let failure = failure.as_ref()?;
    // The next attempt on half the voxel, where refining may help; it does not at the end of a tube.
    let finest = own.iter().map(|(t, _)| t.refine).fold(1.0, f64::max);
    let finer = || {
        last.finer()
            .filter(|_| region.may_refine && !region.tube_end)
    };
    // What each failure calls for: a finer grid, a wider box, the first grid again with its surface accepted, or nothing.
    let next = match failure {
        TryFailure::Contradiction | TryFailure::Stopped => None,
        TryFailure::NotSteady => finer(),
        TryFailure::ReachedBox => last.wider(),
        TryFailure::Crossing(_) => finer().filter(|next| next.refine > finest),
        TryFailure::NotJoined(error) if is_known(error, &own[..own.len() - 1], region) => None,
        // The surface has run away: take it as it comes out of the first grid.
        TryFailure::NotJoined(StitchError::OpenBorder { .. }) if last.refine > 1.0 => Some(Try {
            refine: 1.0,
            start: Start::Triangulation,
            accept: true,
            ..*last
        }),
        TryFailure::NotJoined(StitchError::TooManyFaces { .. } | StitchError::Folded { .. }) => {
            None
        }
        TryFailure::NotJoined(_) if last.accept => None,
        TryFailure::NotJoined(_) => finer(),
    };
    // The budget bounds the cost of the attempts with one energy, another threshold their number.
    let next = next.filter(|_| region.spent < region.budget);
    if next.is_some() {
        return next.filter(|_| own.len() < tuning().fill.most_tries);
    }
    // Without a next attempt a less robust energy gives way to its fallback, from the first settings on, unless there is a
    // patch already that merely intersects faces.
    let has_patch = |(_, v): &(Try, Option<TryFailure>)| matches!(v, Some(TryFailure::Crossing(_)));
    let fallback = first.energy.needs().fallback?;
    let anew = last.energy == first.energy && !history.iter().any(has_patch);
    anew.then_some(Try {
        energy: fallback,
        ..*first
    })
}

/// Why the tries of a history failed.
pub(super) fn failures(history: &History) -> Vec<TryFailure> {
    let failures = history.iter().filter_map(|(_, failure)| failure.as_ref());
    failures.cloned().collect()
}

/// Whether an earlier try failed with the same error near the same place.
fn is_known(error: &StitchError, earlier: &History, region: &Prospects) -> bool {
    earlier.iter().any(|(_, failure)| match failure {
        Some(TryFailure::NotJoined(other)) => {
            error.is_like(other, tuning().fill.same_place * region.diameter)
        }
        _ => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A region that is refined if `may_refine`.
    fn region(may_refine: bool) -> Prospects {
        Prospects {
            has_counterpart: false,
            may_be_sharp: false,
            may_refine,
            diameter: 1.0,
            tube_end: false,
            is_wide: false,
            finishes: true,
            one_rim: true,
            few_edges: false,
            faired_cost: 0.0,
            budget: 1,
            spent: 0,
        }
    }

    const LOST: TryFailure = TryFailure::NotSteady;

    fn open_border() -> TryFailure {
        TryFailure::NotJoined(StitchError::OpenBorder {
            position: DVec3::ZERO,
            distance: 1.0,
        })
    }

    /// The tries that are made when they end so, one after another.
    fn tried(energy: Energy, may_refine: bool, ends: &[Option<TryFailure>]) -> Vec<Try> {
        let first = Try::first(energy);
        let mut history: Vec<(Try, Option<TryFailure>)> = Vec::new();
        for end in ends {
            match next_try(&first, &history, &region(may_refine)) {
                Some(next) => history.push((next, end.clone())),
                None => break,
            }
        }
        history.into_iter().map(|(t, _)| t).collect()
    }

    #[test]
    fn grids_get_finer_once_and_no_more() {
        let ends = vec![Some(LOST); 9];
        let refined: Vec<f64> = tried(Energy::Willmore, true, &ends)
            .iter()
            .map(|t| t.refine)
            .collect();
        assert_eq!(refined, [1.0, 2.0]);
        assert_eq!(tried(Energy::Willmore, false, &ends).len(), 1);
    }

    #[test]
    fn a_sound_patch_ends_it() {
        let ends = [Some(LOST), None, None];
        assert_eq!(tried(Energy::Willmore, true, &ends).len(), 2);
    }

    #[test]
    fn a_surface_that_ran_away_is_taken_from_the_first_grid() {
        let ends = [LOST, open_border(), open_border(), open_border()].map(Some);
        let tries = tried(Energy::Willmore, true, &ends);
        assert_eq!(tries.len(), 3);
        assert!(tries[2].accept && tries[2].refine == 1.0);
    }

    #[test]
    fn the_box_grows_twice() {
        let ends = vec![Some(TryFailure::ReachedBox); 4];
        let tries = tried(Energy::Willmore, true, &ends);
        let growths: Vec<f64> = tries.iter().map(|t| t.growth).collect();
        assert_eq!(
            growths,
            [1.0, tuning().fill.box_growth, tuning().fill.widest()]
        );
    }

    #[test]
    fn an_error_that_comes_again_at_the_same_place_ends_it() {
        let at = |x| {
            Some(TryFailure::NotJoined(StitchError::OpenBorder {
                position: DVec3::new(x, 0.0, 0.0),
                distance: 1.0,
            }))
        };
        let again = [at(0.0), at(0.01), at(0.02)];
        assert_eq!(tried(Energy::Willmore, true, &again).len(), 2);
        let elsewhere = [at(0.0), at(0.5), at(1.0)];
        assert_eq!(tried(Energy::Willmore, true, &elsewhere).len(), 3);
    }

    #[test]
    fn ends_of_tubes_are_not_refined_and_what_is_spent_is_not_spent_again() {
        let first = Try::first(Energy::Willmore);
        let history = [(first, Some(LOST))];
        let next = |region: &Prospects| next_try(&first, &history, region);
        assert!(next(&region(true)).is_some());
        let tube = Prospects {
            tube_end: true,
            ..region(true)
        };
        let poor = Prospects {
            spent: 1,
            ..region(true)
        };
        assert!(next(&tube).is_none() && next(&poor).is_none());
    }

    #[test]
    fn crossing_patches_are_refined_beyond_the_finest_only() {
        let crossing = |n| Some(TryFailure::Crossing(n));
        let ends = [Some(LOST), Some(open_border()), crossing(3), crossing(1)];
        // Finer, back on the first grid: a patch that crosses there is not refined again.
        assert_eq!(tried(Energy::Willmore, true, &ends).len(), 3);
        assert_eq!(
            tried(
                Energy::Willmore,
                true,
                &[crossing(3), crossing(1), crossing(1), crossing(1)]
            )
            .len(),
            2
        );
    }

    #[test]
    fn another_energy_begins_anew_unless_there_is_a_patch() {
        let gone = Some(TryFailure::Contradiction);
        let tries = tried(
            Energy::CurvatureVariation,
            true,
            &[gone.clone(), gone.clone(), gone.clone()],
        );
        let energies: Vec<Energy> = tries.iter().map(|t| t.energy).collect();
        assert_eq!(energies, [Energy::CurvatureVariation, Energy::Willmore]);
        let crossing = Some(TryFailure::Crossing(2));
        let ends = [
            crossing.clone(),
            crossing.clone(),
            crossing,
            gone.clone(),
            gone,
        ];
        assert_eq!(tried(Energy::CurvatureVariation, true, &ends).len(), 2);
    }

    #[test]
    fn an_energy_whose_budget_is_spent_makes_room_for_the_other() {
        let first = Try::first(Energy::CurvatureVariation);
        let spent = Prospects {
            spent: 2,
            ..region(true)
        };
        let history = [(first, Some(LOST))];
        let next = next_try(&first, &history, &spent);
        assert_eq!(next.map(|t| t.energy), Some(Energy::Willmore));
        let first = Try::first(Energy::Willmore);
        let history = [(first, Some(LOST))];
        assert_eq!(next_try(&first, &history, &spent), None);
    }

    #[test]
    fn it_always_ends() {
        let failures = [
            LOST,
            TryFailure::ReachedBox,
            open_border(),
            TryFailure::Crossing(1),
            TryFailure::Contradiction,
        ];
        let energies = [Energy::Willmore, Energy::CurvatureVariation];
        // Every sequence of five failures, repeated.
        for code in 0..3125usize {
            let digit = |i: u32| failures[code / 5usize.pow(i % 5) % 5].clone();
            let ends: Vec<Option<TryFailure>> = (0..20).map(|i| Some(digit(i))).collect();
            for energy in energies {
                assert!(tried(energy, true, &ends).len() <= 2 * tuning().fill.most_tries);
            }
        }
    }
}
