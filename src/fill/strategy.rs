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
    /// The part of a counterpart that lies at the only rim.
    Counterpart,
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
    /// A flat base with walls under the only rim.
    Base,
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
        // It is made only where it predicts the faces round the hole.
        RegionPlan::Solve if region.has_counterpart => match made {
            [] => Step::Make(Candidate::Counterpart),
            [counterpart, ..] if is_sound(counterpart) => Step::Take(0),
            [_, others @ ..] => {
                let region = Prospects {
                    has_counterpart: false,
                    ..*region
                };
                match next_step(plan, first, others, &region) {
                    Step::Take(place) => Step::Take(place + 1),
                    make => make,
                }
            }
        },
        RegionPlan::Trivial => only(Candidate::RimTriangles, made),
        RegionPlan::Base => only(Candidate::Base, made),
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
        None if made.is_empty() && region.few_edges => return Step::Make(Candidate::Faired),
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
mod tests;
