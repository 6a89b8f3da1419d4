//! What the strategy asks for and takes, for candidates with given results.

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
        (RegionPlan::Base, Candidate::Base),
        (RegionPlan::Planar, Candidate::PlanarCap),
        (RegionPlan::Base, Candidate::Base),
    ] {
        assert_eq!(searched(plan, &region(), all_sound), (only, 1));
    }
}

#[test]
fn a_rim_of_few_edges_is_faired_first_and_needs_a_level_set_only_where_that_fails() {
    let short = Prospects {
        few_edges: true,
        ..region()
    };
    let all_sound = |_: Candidate, _: usize| (Some(SOUND), None, true);
    let taken = searched(RegionPlan::Solve, &short, all_sound);
    assert_eq!(taken, (Candidate::Faired, 1));
    // One that intersects something, or is at no minimum, gives way to the level set.
    for (quality, is_at_minimum) in [(CROSSING, true), (SOUND, false)] {
        let end = |candidate: Candidate, _: usize| match candidate {
            Candidate::Faired => (Some(quality), None, is_at_minimum),
            _ => (Some(SOUND), None, true),
        };
        let taken = searched(RegionPlan::Solve, &short, end);
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
    let next =
        |made: &[Ending], region: &Prospects| next_step(RegionPlan::Solve, &first, made, region);
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

#[test]
fn a_counterpart_comes_first_and_is_taken_where_it_is_sound() {
    let with = Prospects {
        has_counterpart: true,
        may_be_sharp: true,
        ..region()
    };
    let all_sound = |_: Candidate, _: usize| (Some(SOUND), None, true);
    let taken = searched(RegionPlan::Solve, &with, all_sound);
    assert_eq!(taken, (Candidate::Counterpart, 1));
    // Without one, or where it is not sound, the search is as it would be without.
    let without = Prospects {
        has_counterpart: false,
        ..with
    };
    for flawed in [None, Some(CROSSING)] {
        let end = |candidate: Candidate, _: usize| match candidate {
            Candidate::Counterpart => (flawed, None, false),
            Candidate::Sides | Candidate::Rounded => (None, None, false),
            _ => (Some(SOUND), None, true),
        };
        let (taken, made) = searched(RegionPlan::Solve, &with, end);
        let (other, fewer) = searched(RegionPlan::Solve, &without, end);
        assert_eq!((taken, made), (other, fewer + 1));
    }
}
