//! Selects the next candidate to compute for a region, or the candidate to accept: a pure function of the candidates computed so far and
//! their results.

use super::grids::{Prospects, Try, next_try};
use super::outcome::TryFailure;
use super::problem::RegionPlan;
use super::quality::Quality;
use crate::flow::Energy;
use crate::region::Start;
use crate::tuning::tuning;

/// A way to close a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Candidate {
    /// The smooth sides round the only rim, continued until they meet in sharp edges.
    Sides,
    /// Flat sides with rounded edges between them.
    Rounded,
    /// The zero set of a level set, joined to the rims.
    LevelSet(Try),
    /// That of the flow that came nearest to rest, where none came to it.
    NearlySteady,
    /// The best patch of a level set, finished on its own triangles.
    Finished,
    /// A refined triangulation of the only rim, filled and finished.
    Faired,
    /// The same for each of the rims by itself.
    EachFaired,
    /// The surface of least area over a refined triangulation of the only rim.
    PlanarCap,
    /// Triangles between two rims that lie on each other.
    Seam,
    /// Triangles between the vertices of each rim.
    RimTriangles,
}

impl Candidate {
    /// What the region's box grows by for it.
    pub(super) fn growth(&self) -> f64 {
        match self {
            Self::LevelSet(now) => now.growth,
            _ => 1.0,
        }
    }
}

/// A candidate that was made, and how that ended.
#[derive(Clone, Debug)]
pub(super) struct Ending {
    pub(super) candidate: Candidate,
    /// How good its patch is; none where there is none.
    pub(super) quality: Option<Quality>,
    /// What is wrong with it, or why there is none.
    pub(super) failure: Option<TryFailure>,
    /// ½∫h² of its zero set, if it is a level set whose flow converged.
    pub(super) level_energy: Option<f64>,
    /// Whether it was finished and is at a minimum of the energy.
    pub(super) is_at_minimum: bool,
}

impl Ending {
    /// Whether its patch is at a minimum of the energy, intersects nothing and is not folded.
    fn is_at_sound_minimum(&self) -> bool {
        self.is_at_minimum && self.quality.is_some_and(|q| q.is_sound())
    }

    /// Whether it is the better one of two level sets on one grid: by the order of patches, without patches by the energy.
    fn is_better_than(&self, other: &Self) -> bool {
        match (self.quality, other.quality) {
            (Some(own), Some(other)) => own < other,
            (None, None) => {
                let energy = |e: &Self| e.level_energy.unwrap_or(f64::INFINITY);
                energy(self) < energy(other)
            }
            (own, _) => own.is_some(),
        }
    }
}

/// What to do next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// Make this candidate.
    Make(Candidate),
    /// Take the one that was made at this place.
    Take(usize),
}

/// What to do after what was made of a region; `first` is its first level set.
pub(super) fn next_step(
    plan: RegionPlan,
    first: &Try,
    made: &[Ending],
    region: &Prospects,
) -> Step {
    match plan {
        RegionPlan::Trivial => only(Candidate::RimTriangles, made),
        RegionPlan::Seam => only(Candidate::Seam, made),
        RegionPlan::Planar => match quality(Candidate::PlanarCap, made) {
            Some(Some(cap)) if cap.is_sound() => Step::Take(0),
            _ => best_of([Candidate::PlanarCap, Candidate::RimTriangles], made),
        },
        RegionPlan::Solve if region.may_be_sharp => match made {
            // These are made only where they predict the faces round the hole much better than a smooth patch.
            [] => Step::Make(Candidate::Sides),
            [sides, ..] if is_sound(sides) => Step::Take(0),
            [_] => Step::Make(Candidate::Rounded),
            [_, rounded, ..] if is_sound(rounded) => Step::Take(1),
            [_, _, others @ ..] => match next_surface(first, others, region) {
                Step::Take(place) => Step::Take(place + 2),
                make => make,
            },
        },
        RegionPlan::Solve => next_surface(first, made, region),
    }
}

fn is_sound(made: &Ending) -> bool {
    made.quality.is_some_and(|q| q.is_sound())
}

/// Level sets until one has a patch that intersects nothing, or no other is worth its time; then the best of them finished, and a
/// faired triangulation beside it where that may be better. Where no level set has a patch, what needs none.
fn next_surface(first: &Try, made: &[Ending], region: &Prospects) -> Step {
    if let Some(finished) = place(Candidate::Finished, made) {
        return finished_or_faired(finished, made, region);
    }
    if let Some(next) = second_start(made, region) {
        return Step::Make(Candidate::LevelSet(next));
    }
    let history = history(made);
    let is_patch =
        |e: &Ending| matches!(e.candidate, Candidate::LevelSet(_)) && e.quality.is_some();
    let has_patch = made.iter().any(is_patch);
    let nearly = quality(Candidate::NearlySteady, made);
    // A faired triangulation at a minimum saves further tries. A part wider than its rim, which continues like a sphere, is the
    // level set's.
    match place(Candidate::Faired, made) {
        Some(faired) if made[faired].is_at_sound_minimum() => return Step::Take(faired),
        None if nearly.is_none() && !has_patch && region.finishes => {
            let reached_box = |failure| failure == &Some(TryFailure::ReachedBox);
            if let [(_, failure)] = &history[..]
                && !(reached_box(failure) && region.is_wide)
            {
                return Step::Make(Candidate::Faired);
            }
        }
        _ => {}
    }
    if nearly.is_none()
        && let Some(next) = next_try(first, &history, region)
    {
        return Step::Make(Candidate::LevelSet(next));
    }
    match (has_patch, nearly) {
        (true, _) | (_, Some(Some(_))) => Step::Make(Candidate::Finished),
        (false, None) => Step::Make(Candidate::NearlySteady),
        (false, Some(None)) => best_of([Candidate::EachFaired, Candidate::RimTriangles], made),
    }
}

/// The level set on the grid of the last one, from a triangulation of the only rim, where the last is bent so much that it may be one
/// minimum of several. Rims of few edges have the second start of the finish instead.
fn second_start(made: &[Ending], region: &Prospects) -> Option<Try> {
    let last = made.last()?;
    let Candidate::LevelSet(own) = last.candidate else {
        return None;
    };
    let has_other = own.energy == Energy::Willmore && own.start == Start::Biharmonic;
    let is_bent = last
        .level_energy
        .is_some_and(|e| e > tuning().fill.level_set_bent);
    let may = region.finishes && region.one_rim && region.faired_cost > tuning().fill.cheap;
    (may && has_other && is_bent).then(|| own.with_triangulation())
}

/// The finished patch of a level set, or the faired triangulation: that is made where the first intersects something or is folded, or is
/// bent so much that it may be one minimum of several. Both for every hole, and the lower energy, are not worth their time: on 132
/// holes of scans the error fell by 0.2 %, and where surfaces bend a lot the lower one of two alike was farther from the truth.
fn finished_or_faired(finished: usize, made: &[Ending], region: &Prospects) -> Step {
    let own = made[finished].quality.filter(|_| region.finishes);
    let (own, factor) = match own {
        Some(own) if !own.is_sound() => (own, tuning().fill.clearly_higher),
        Some(own)
            if own.energy > tuning().fill.bent && region.faired_cost <= tuning().fill.cheap =>
        {
            (own, tuning().fill.much_higher)
        }
        _ => return Step::Take(finished),
    };
    let Some(faired) = place(Candidate::Faired, made) else {
        return Step::Make(Candidate::Faired);
    };
    // A patch without vertices of its own is no surface that could be compared.
    let other = made[faired].quality.filter(|q| !q.is_plain);
    match other.is_some_and(|q| q.is_clearly_better_than(&own, factor)) {
        true => Step::Take(faired),
        false => Step::Take(finished),
    }
}

/// The only candidate there is.
fn only(candidate: Candidate, made: &[Ending]) -> Step {
    match place(candidate, made) {
        Some(place) => Step::Take(place),
        None => Step::Make(candidate),
    }
}

/// The better of two candidates once both are made; of equals the first.
fn best_of(candidates: [Candidate; 2], made: &[Ending]) -> Step {
    let missing = candidates.iter().find(|c| place(**c, made).is_none());
    if let Some(missing) = missing {
        return Step::Make(*missing);
    }
    let [first, second] = candidates.map(|c| place(c, made).unwrap_or(0));
    Step::Take(match (made[first].quality, made[second].quality) {
        (Some(a), Some(b)) if a <= b => first,
        (Some(_), None) => first,
        _ => second,
    })
}

fn place(candidate: Candidate, made: &[Ending]) -> Option<usize> {
    made.iter().position(|e| e.candidate == candidate)
}

/// How good a candidate is, if it was made and has a patch.
fn quality(candidate: Candidate, made: &[Ending]) -> Option<Option<Quality>> {
    place(candidate, made).map(|place| made[place].quality)
}

/// The level sets that were tried, and how these tries ended; of two on one grid the better one.
pub(super) fn history(made: &[Ending]) -> Vec<(Try, Option<TryFailure>)> {
    let mut kept: Vec<(Try, &Ending)> = Vec::new();
    for ending in made {
        let Candidate::LevelSet(own) = ending.candidate else {
            continue;
        };
        match kept.last_mut() {
            Some((first, best)) if own == first.with_triangulation() => {
                if ending.is_better_than(best) {
                    *best = ending;
                }
            }
            _ => kept.push((own, ending)),
        }
    }
    let failure = |(own, ending): (Try, &Ending)| (own, ending.failure.clone());
    kept.into_iter().map(failure).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOUND: Quality = Quality {
        open_rims: 0,
        intersections: 0,
        is_plain: false,
        folds: 0,
        is_unconverged: false,
        expected_error: None,
        energy: 1.0,
    };
    const CROSSING: Quality = Quality {
        intersections: 3,
        ..SOUND
    };

    fn region() -> Prospects {
        Prospects {
            may_refine: true,
            diameter: 1.0,
            finishes: true,
            one_rim: true,
            faired_cost: tuning().fill.cheap,
            budget: 1,
            ..Prospects::default()
        }
    }

    /// What is taken in the end, and how many candidates were made, where each ends as is said.
    fn searched(
        plan: RegionPlan,
        region: &Prospects,
        end: impl Fn(Candidate, usize) -> (Option<Quality>, Option<TryFailure>, bool),
    ) -> (Candidate, usize) {
        let first = Try::first(Energy::Willmore);
        let mut made: Vec<Ending> = Vec::new();
        loop {
            match next_step(plan, &first, &made, region) {
                Step::Take(place) => {
                    assert!(made[place].quality.is_some(), "{made:?}");
                    return (made[place].candidate, made.len());
                }
                Step::Make(candidate) => {
                    let (quality, failure, is_at_minimum) = end(candidate, made.len());
                    made.push(Ending {
                        candidate,
                        quality,
                        failure,
                        level_energy: matches!(candidate, Candidate::LevelSet(_))
                            .then(|| quality.map_or(30.0, |q| q.energy)),
                        is_at_minimum,
                    });
                    assert!(made.len() < 20, "{made:?}");
                }
            }
        }
    }

    #[test]
    fn a_sound_level_set_is_finished_and_taken() {
        let all_sound = |_: Candidate, _: usize| (Some(SOUND), None, true);
        let taken = searched(RegionPlan::Solve, &region(), all_sound);
        assert_eq!(taken, (Candidate::Finished, 2));
        for (plan, only) in [
            (RegionPlan::Trivial, Candidate::RimTriangles),
            (RegionPlan::Seam, Candidate::Seam),
            (RegionPlan::Planar, Candidate::PlanarCap),
        ] {
            assert_eq!(searched(plan, &region(), all_sound), (only, 1));
        }
    }

    #[test]
    fn a_bent_patch_gives_way_to_a_sound_one_of_much_lower_energy_only() {
        let taken_beside = |faired: Quality, is_cheap: bool| {
            let end = |candidate: Candidate, _: usize| match candidate {
                Candidate::Finished => (
                    Some(Quality {
                        energy: 9.7,
                        ..SOUND
                    }),
                    None,
                    true,
                ),
                Candidate::Faired => (Some(faired), None, true),
                _ => (Some(SOUND), None, false),
            };
            let region = Prospects {
                faired_cost: if is_cheap {
                    tuning().fill.cheap
                } else {
                    2.0 * tuning().fill.cheap
                },
                ..region()
            };
            searched(RegionPlan::Solve, &region, end).0
        };
        let of = |energy| Quality { energy, ..SOUND };
        assert_eq!(taken_beside(of(0.3), true), Candidate::Faired);
        assert_eq!(taken_beside(of(0.3), false), Candidate::Finished);
        assert_eq!(taken_beside(of(7.0), true), Candidate::Finished);
        let folded = Quality {
            folds: 1,
            ..of(0.3)
        };
        assert_eq!(taken_beside(folded, true), Candidate::Finished);
        assert_eq!(taken_beside(of(f64::NAN), true), Candidate::Finished);
        let plain = Quality {
            is_plain: true,
            ..of(0.3)
        };
        assert_eq!(taken_beside(plain, true), Candidate::Finished);
    }

    #[test]
    fn a_faired_triangulation_at_its_minimum_saves_further_level_sets() {
        let taken = |is_at_minimum: bool, failure: TryFailure, is_wide: bool| {
            let end = |candidate: Candidate, made: usize| match candidate {
                Candidate::LevelSet(_) if made == 0 => (None, Some(failure.clone()), false),
                Candidate::Faired => (Some(SOUND), None, is_at_minimum),
                _ => (Some(SOUND), None, true),
            };
            let region = Prospects {
                is_wide,
                ..region()
            };
            searched(RegionPlan::Solve, &region, end)
        };
        let lost = TryFailure::NotSteady;
        assert_eq!(taken(true, lost.clone(), false), (Candidate::Faired, 2));
        assert_eq!(taken(false, lost, false), (Candidate::Finished, 4));
        let reached = TryFailure::ReachedBox;
        assert_eq!(taken(true, reached.clone(), true), (Candidate::Finished, 3));
        assert_eq!(taken(true, reached, false), (Candidate::Faired, 2));
    }

    #[test]
    fn without_a_level_set_the_better_of_what_needs_none_is_taken() {
        let taken = |plain: Quality, faired: Option<Quality>| {
            let end = |candidate: Candidate, _: usize| match candidate {
                Candidate::EachFaired => (faired, None, false),
                Candidate::RimTriangles => (Some(plain), None, false),
                _ => (None, Some(TryFailure::Contradiction), false),
            };
            searched(RegionPlan::Solve, &region(), end).0
        };
        let plain = Quality {
            is_plain: true,
            ..SOUND
        };
        assert_eq!(taken(plain, Some(SOUND)), Candidate::EachFaired);
        assert_eq!(taken(plain, Some(CROSSING)), Candidate::RimTriangles);
        assert_eq!(taken(plain, None), Candidate::RimTriangles);
        let open = Quality {
            open_rims: 1,
            ..plain
        };
        assert_eq!(taken(open, Some(CROSSING)), Candidate::EachFaired);
    }

    /// Every way in which the first five candidates can end, repeated: it ends, and takes something that has a patch.
    #[test]
    fn it_always_ends_with_a_patch() {
        let failures = [
            TryFailure::NotSteady,
            TryFailure::ReachedBox,
            TryFailure::Contradiction,
            TryFailure::Crossing(3),
        ];
        for code in 0..6usize.pow(5) {
            let end = |candidate: Candidate, made: usize| {
                let digit = code / 6usize.pow(made as u32 % 5) % 6;
                let quality = [Some(SOUND), Some(CROSSING), None][digit % 3];
                match candidate {
                    // These always close the rims, or tell which stay open.
                    Candidate::RimTriangles | Candidate::Seam => (Some(CROSSING), None, false),
                    Candidate::LevelSet(_) => match failures.get(digit) {
                        Some(TryFailure::Crossing(n)) => {
                            (Some(CROSSING), Some(TryFailure::Crossing(*n)), false)
                        }
                        Some(failure) => (None, Some(failure.clone()), false),
                        None => (Some(SOUND), None, false),
                    },
                    Candidate::Finished => (Some(quality.unwrap_or(CROSSING)), None, false),
                    _ => (quality, None, digit.is_multiple_of(2)),
                }
            };
            for plan in [
                RegionPlan::Trivial,
                RegionPlan::Planar,
                RegionPlan::Seam,
                RegionPlan::Solve,
            ] {
                searched(plan, &region(), end);
                let long_rim = Prospects {
                    faired_cost: 2.0 * tuning().fill.cheap,
                    ..region()
                };
                searched(plan, &long_rim, end);
            }
        }
    }

    #[test]
    fn of_two_level_sets_of_a_bent_surface_the_better_one_counts() {
        let first = Try::first(Energy::Willmore);
        let long_rim = Prospects {
            faired_cost: 2.0 * tuning().fill.cheap,
            ..region()
        };
        let ending =
            |own: Try, quality: Option<Quality>, failure: Option<TryFailure>, energy: f64| Ending {
                candidate: Candidate::LevelSet(own),
                quality,
                failure,
                level_energy: Some(energy),
                is_at_minimum: false,
            };
        let next = |made: &[Ending], region: &Prospects| {
            next_step(RegionPlan::Solve, &first, made, region)
        };
        let second = first.with_triangulation();
        let bent = ending(first, Some(SOUND), None, 21.0);
        let calm = ending(first, Some(SOUND), None, 19.0);
        let finish = Step::Make(Candidate::Finished);
        let made = std::slice::from_ref(&bent);
        assert_eq!(
            next(made, &long_rim),
            Step::Make(Candidate::LevelSet(second))
        );
        assert_eq!(next(made, &region()), finish);
        assert_eq!(next(&[calm], &long_rim), finish);
        // The failure of the worse one calls for nothing.
        let lost = || Some(TryFailure::NotSteady);
        let made = [bent.clone(), ending(second, None, lost(), 9.0)];
        assert_eq!(next(&made, &long_rim), finish);
        let made = [
            ending(first, None, lost(), 21.0),
            ending(second, Some(SOUND), None, 30.0),
        ];
        assert_eq!(next(&made, &long_rim), finish);
        assert_eq!(history(&made), [(first, None)]);
        // Where neither has a patch the failure of the lower one stands for both.
        let reached = || Some(TryFailure::ReachedBox);
        let made = [
            ending(first, None, lost(), 21.0),
            ending(second, None, reached(), 20.5),
        ];
        assert_eq!(history(&made), [(first, reached())]);
        assert_eq!(next(&made, &long_rim), Step::Make(Candidate::Faired));
    }
}
