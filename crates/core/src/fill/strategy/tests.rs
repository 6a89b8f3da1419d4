//! Tests of the strategy: which candidates it asks for and takes, given their results.

use super::super::reasons::NotSmooth;
use super::*;
use super::{BENT, CHEAP};

const SOUND: Quality = Quality {
    open_rims: 0,
    intersections: 0,
    is_plain: false,
    folds: 0,
    is_unconverged: false,
    expected_error: None,
    energy: 1.0,
};
const INTERSECTING: Quality = Quality {
    intersections: 3,
    ..SOUND
};

fn region() -> RetryContext {
    RetryContext {
        may_refine: true,
        diameter: 1.0,
        finishes: true,
        one_rim: true,
        faired_cost: CHEAP.get(),
        budget: 1,
        ..RetryContext::default()
    }
}

/// The candidate that is taken and the number of candidates made, if `end` gives the result of each.
fn searched(
    decided: Option<Closure>,
    region: &RetryContext,
    end: impl Fn(Candidate, usize) -> (Option<Quality>, Option<AttemptFailure>, bool),
) -> (Candidate, usize) {
    let first = Attempt::first(Energy::Willmore);
    let mut made: Vec<Ending> = Vec::new();
    loop {
        match next_step(decided.as_ref(), &first, &made, region) {
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
fn many_rims_get_no_level_set() {
    let many = RetryContext {
        one_rim: false,
        many_rims: true,
        ..region()
    };
    let plain = Quality {
        is_plain: true,
        ..SOUND
    };
    let (taken, made) = searched(None, &many, |candidate, _| match candidate {
        Candidate::RimTriangles => (Some(plain), None, false),
        Candidate::EachFaired => (None, None, false),
        other => panic!("{other:?}"),
    });
    assert_eq!((taken, made), (Candidate::RimTriangles, 2));
}

#[test]
fn a_sound_level_set_is_finished_and_taken() {
    let all_sound = |_: Candidate, _: usize| (Some(SOUND), None, true);
    let taken = searched(None, &region(), all_sound);
    assert_eq!(taken, (Candidate::Finished, 2));
    for (decided, only) in [
        (
            Some(Closure::RimTriangles(NotSmooth::FewEdges)),
            Candidate::RimTriangles,
        ),
        (Some(Closure::Seam), Candidate::Seam),
        (Some(Closure::Base), Candidate::Base),
        (Some(Closure::Flat), Candidate::PlanarCap),
        (Some(Closure::Base), Candidate::Base),
    ] {
        assert_eq!(searched(decided.clone(), &region(), all_sound), (only, 1));
    }
}

#[test]
fn a_rim_of_few_edges_is_faired_first_and_needs_a_level_set_only_where_that_fails() {
    let short = RetryContext {
        faired_first: true,
        ..region()
    };
    let all_sound = |_: Candidate, _: usize| (Some(SOUND), None, true);
    let taken = searched(None, &short, all_sound);
    assert_eq!(taken, (Candidate::Faired, 1));
    // A triangulation that intersects something or has not converged is replaced by the level set.
    for (quality, is_at_minimum) in [(INTERSECTING, true), (SOUND, false)] {
        let end = |candidate: Candidate, _: usize| match candidate {
            Candidate::Faired => (Some(quality), None, is_at_minimum),
            _ => (Some(SOUND), None, true),
        };
        let taken = searched(None, &short, end);
        assert_eq!(taken, (Candidate::Finished, 3));
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
        let region = RetryContext {
            faired_cost: if is_cheap {
                CHEAP.get()
            } else {
                2.0 * CHEAP.get()
            },
            ..region()
        };
        searched(None, &region, end).0
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
fn a_wide_bent_patch_that_has_not_converged_is_compared_with_a_faired_triangulation() {
    let wide = |one_rim| RetryContext {
        faired_cost: 10.0 * CHEAP.get(),
        one_rim,
        ..region()
    };
    let bent = Quality {
        energy: 2.0 * BENT.get(),
        ..SOUND
    };
    let taken = |region: RetryContext, is_unconverged: bool, faired: Quality| {
        let end = |candidate: Candidate, _: usize| {
            let quality = match candidate {
                Candidate::Faired => faired,
                Candidate::Finished => Quality {
                    is_unconverged,
                    ..bent
                },
                _ => SOUND,
            };
            (Some(quality), None, false)
        };
        searched(None, &region, end).0
    };
    assert_eq!(taken(wide(true), true, SOUND), Candidate::Faired);
    assert_eq!(taken(wide(true), false, SOUND), Candidate::Finished);
    assert_eq!(taken(wide(false), true, SOUND), Candidate::Finished);
    assert_eq!(taken(wide(true), true, INTERSECTING), Candidate::Finished);
}

#[test]
fn a_faired_triangulation_at_its_minimum_saves_further_level_sets() {
    let taken = |is_at_minimum: bool, failure: AttemptFailure, is_wide: bool| {
        let end = |candidate: Candidate, made: usize| match candidate {
            Candidate::LevelSet(_) if made == 0 => (None, Some(failure.clone()), false),
            Candidate::Faired => (Some(SOUND), None, is_at_minimum),
            _ => (Some(SOUND), None, true),
        };
        let region = RetryContext {
            is_wide,
            ..region()
        };
        searched(None, &region, end)
    };
    let lost = AttemptFailure::NotConverged;
    assert_eq!(taken(true, lost.clone(), false), (Candidate::Faired, 2));
    assert_eq!(taken(false, lost, false), (Candidate::Finished, 4));
    let reached = AttemptFailure::ReachedBox;
    assert_eq!(taken(true, reached.clone(), true), (Candidate::Finished, 3));
    assert_eq!(taken(true, reached, false), (Candidate::Faired, 2));
}

#[test]
fn without_a_level_set_the_better_of_what_needs_none_is_taken() {
    let taken = |plain: Quality, faired: Option<Quality>| {
        let end = |candidate: Candidate, _: usize| match candidate {
            Candidate::EachFaired => (faired, None, false),
            Candidate::RimTriangles => (Some(plain), None, false),
            _ => (None, Some(AttemptFailure::Diverged), false),
        };
        searched(None, &region(), end).0
    };
    let plain = Quality {
        is_plain: true,
        ..SOUND
    };
    assert_eq!(taken(plain, Some(SOUND)), Candidate::EachFaired);
    assert_eq!(taken(plain, Some(INTERSECTING)), Candidate::RimTriangles);
    assert_eq!(taken(plain, None), Candidate::RimTriangles);
    let open = Quality {
        open_rims: 1,
        ..plain
    };
    assert_eq!(taken(open, Some(INTERSECTING)), Candidate::EachFaired);
}

/// For every combination of results of the first five candidates, repeated, the search ends and takes a candidate with a patch.
#[test]
fn it_always_ends_with_a_patch() {
    let failures = [
        AttemptFailure::NotConverged,
        AttemptFailure::ReachedBox,
        AttemptFailure::Diverged,
        AttemptFailure::Intersects(3),
    ];
    for code in 0..6usize.pow(5) {
        let end = |candidate: Candidate, made: usize| {
            let digit = code / 6usize.pow(made as u32 % 5) % 6;
            let quality = [Some(SOUND), Some(INTERSECTING), None][digit % 3];
            match candidate {
                // These always have a patch, possibly with open rims.
                Candidate::RimTriangles | Candidate::Seam => (Some(INTERSECTING), None, false),
                Candidate::LevelSet(_) => match failures.get(digit) {
                    Some(AttemptFailure::Intersects(n)) => (
                        Some(INTERSECTING),
                        Some(AttemptFailure::Intersects(*n)),
                        false,
                    ),
                    Some(failure) => (None, Some(failure.clone()), false),
                    None => (Some(SOUND), None, false),
                },
                Candidate::Finished => (Some(quality.unwrap_or(INTERSECTING)), None, false),
                _ => (quality, None, digit.is_multiple_of(2)),
            }
        };
        for decided in [
            Some(Closure::RimTriangles(NotSmooth::FewEdges)),
            Some(Closure::Flat),
            Some(Closure::Seam),
            None,
        ] {
            searched(decided.clone(), &region(), end);
            let long_rim = RetryContext {
                faired_cost: 2.0 * CHEAP.get(),
                ..region()
            };
            searched(decided.clone(), &long_rim, end);
        }
    }
}

#[test]
fn of_two_level_sets_of_a_bent_surface_the_better_one_counts() {
    let first = Attempt::first(Energy::Willmore);
    let long_rim = RetryContext {
        faired_cost: 2.0 * CHEAP.get(),
        ..region()
    };
    let ending = |own: Attempt,
                  quality: Option<Quality>,
                  failure: Option<AttemptFailure>,
                  energy: f64| Ending {
        candidate: Candidate::LevelSet(own),
        quality,
        failure,
        level_energy: Some(energy),
        is_at_minimum: false,
    };
    let next = |made: &[Ending], region: &RetryContext| next_step(None, &first, made, region);
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
    // The failure of the worse attempt leads to no retry.
    let lost = || Some(AttemptFailure::NotConverged);
    let made = [bent.clone(), ending(second, None, lost(), 9.0)];
    assert_eq!(next(&made, &long_rim), finish);
    let made = [
        ending(first, None, lost(), 21.0),
        ending(second, Some(SOUND), None, 30.0),
    ];
    assert_eq!(next(&made, &long_rim), finish);
    assert_eq!(history(&made), [(first, None)]);
    // If neither has a patch, the failure of the attempt with lower energy counts for both.
    let reached = || Some(AttemptFailure::ReachedBox);
    let made = [
        ending(first, None, lost(), 21.0),
        ending(second, None, reached(), 20.5),
    ];
    assert_eq!(history(&made), [(first, reached())]);
    assert_eq!(next(&made, &long_rim), Step::Make(Candidate::Faired));
}

#[test]
fn a_counterpart_comes_first_and_is_taken_where_it_is_sound() {
    let with = RetryContext {
        has_counterpart: true,
        may_be_sharp: true,
        ..region()
    };
    let all_sound = |_: Candidate, _: usize| (Some(SOUND), None, true);
    let taken = searched(None, &with, all_sound);
    assert_eq!(taken, (Candidate::Counterpart, 1));
    // Without one, or where it is not sound, the search is as it would be without.
    let without = RetryContext {
        has_counterpart: false,
        ..with
    };
    for flawed in [None, Some(INTERSECTING)] {
        let end = |candidate: Candidate, _: usize| match candidate {
            Candidate::Counterpart => (flawed, None, false),
            Candidate::Sides | Candidate::Rounded => (None, None, false),
            _ => (Some(SOUND), None, true),
        };
        let (taken, made) = searched(None, &with, end);
        let (other, fewer) = searched(None, &without, end);
        assert_eq!((taken, made), (other, fewer + 1));
    }
}

#[test]
fn an_edge_that_predicts_nothing_replaces_flawed_surfaces_and_bulbs_only() {
    let sharp = RetryContext {
        may_be_sharp: true,
        ..region()
    };
    let bulb = Quality {
        is_unconverged: true,
        energy: 30.0,
        ..SOUND
    };
    let plain = Quality {
        is_plain: true,
        ..SOUND
    };
    let bent = Quality {
        energy: 30.0,
        ..SOUND
    };
    let slow = Quality {
        is_unconverged: true,
        ..SOUND
    };
    let taken = |surface: Quality, edge: Option<Quality>, region: &RetryContext| {
        let end = |candidate: Candidate, _: usize| match candidate {
            Candidate::Sides | Candidate::Rounded | Candidate::Lip => (None, None, false),
            Candidate::UnsureLip => (edge, None, false),
            _ => (Some(surface), None, false),
        };
        searched(None, region, end).0
    };
    for poor in [INTERSECTING, bulb, plain] {
        assert_eq!(taken(poor, Some(SOUND), &sharp), Candidate::UnsureLip);
        for flawed in [None, Some(INTERSECTING)] {
            assert_ne!(taken(poor, flawed, &sharp), Candidate::UnsureLip);
        }
        assert_ne!(taken(poor, Some(SOUND), &region()), Candidate::UnsureLip);
    }
    for good in [SOUND, bent, slow] {
        assert_ne!(taken(good, Some(SOUND), &sharp), Candidate::UnsureLip);
    }
}
