//! Selects the next candidate to compute for a region, or the candidate to accept: a pure function of the candidates computed so far and
//! their results.

use super::closure::Closure;
use super::grids::{Attempt, RetryContext, next_attempt};
use super::quality::Quality;
use super::reasons::AttemptFailure;
use crate::flow::Energy;
use crate::region::Start;
use crate::tuning::{Tunable, tunable};

/// Unknowns times steps. A faired triangulation with at most this expected cost (a rim of 60 edges, 93 ms) is computed
/// beside the level set where it may help. More costly rims get a second level set, initialised from a triangulation.
const CHEAP: Tunable<f64> = tunable("fill.cheap", 15_480.0);

/// ½∫h². If a finished patch has more energy than this, a faired triangulation is computed beside it: a surface bent as
/// much as a spherical cap of 140° may be one of several minima.
const BENT: Tunable<f64> = tunable("fill.bent", 8.0);

/// ½∫h². If a zero set has more energy than this, a second level set is computed from a triangulation: nearly the energy
/// of a sphere (8π).
const LEVEL_SET_BENT: Tunable<f64> = tunable("fill.level_set_bent", 20.0);

/// Ratio of energies above which one patch is clearly worse. Triangulations of the same surface differ by smaller ratios.
const CLEARLY_HIGHER: Tunable<f64> = tunable("fill.clearly_higher", 1.1);

/// Ratio of energies above which one kind of surface replaces another. On 143 holes of scans patches with lower energies,
/// down to 1/1.5, were farther from the true surface than the first patch.
const MUCH_HIGHER: Tunable<f64> = tunable("fill.much_higher", 2.0);

/// Which candidate of a continued surface is taken: 0 the one that the rules below choose, 1 the level set, 2 the faired triangulation
/// where it can be made. Another value than 0 is for `scripts/sweep.py --oracle`.
const ALWAYS: Tunable<usize> = tunable("fill.always", 0);

/// A way to close a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Candidate {
    /// The part of a counterpart that lies at the only rim.
    Counterpart,
    /// The smooth sides around the only rim, continued until they meet in sharp edges.
    Sides,
    /// Flat sides with rounded edges between them.
    Rounded,
    /// The edge of a wall that the only rim crosses twice, and its two sides.
    Lip,
    /// The same with an edge that predicts nothing.
    UnsureLip,
    /// The zero set of a level set, joined to the rims.
    LevelSet(Attempt),
    /// The unconverged level set with the smallest last update, where none converged, joined to the rims.
    Unconverged,
    /// The best patch of a level set, finished on its own triangles.
    Finished,
    /// A refined triangulation of the only rim, faired and finished.
    Faired,
    /// The same for each rim separately.
    EachFaired,
    /// The surface of least area over a refined triangulation of the only rim.
    PlanarCap,
    /// A flat base with walls under the only rim.
    Base,
    /// Triangles between two rims that coincide.
    Seam,
    /// Triangles between the rims on the two sides of a wall.
    Band,
    /// Triangles between the vertices of each rim.
    RimTriangles,
}

impl Candidate {
    /// The factor of the box's margin for this candidate.
    pub(super) fn growth(&self) -> f64 {
        match self {
            Self::LevelSet(now) => now.growth,
            _ => 1.0,
        }
    }
}

/// A candidate that was made, and its result.
#[derive(Clone, Debug)]
pub(super) struct Ending {
    pub(super) candidate: Candidate,
    /// Quality of its patch; none where it has no patch.
    pub(super) quality: Option<Quality>,
    /// Why its patch is flawed or missing.
    pub(super) failure: Option<AttemptFailure>,
    /// ½∫h² of its zero set, if it is a level set whose flow converged.
    pub(super) level_energy: Option<f64>,
    /// Whether it was finished and has converged to a minimum of the energy.
    pub(super) is_at_minimum: bool,
}

impl Ending {
    /// Whether its patch has converged to a minimum of the energy, intersects nothing and has no folds.
    fn is_at_sound_minimum(&self) -> bool {
        self.is_at_minimum && self.quality.is_some_and(|q| q.is_sound())
    }

    /// Whether it is the better of two level sets on the same grid: by quality, without patches by energy.
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

/// The next step of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    /// Make this candidate.
    Make(Candidate),
    /// Take the candidate at this index.
    Take(usize),
}

/// The next step after the candidates made so far. `decided` is the closure that was decided before, if any; `first` is the first
/// level-set attempt.
pub(super) fn next_step(
    decided: Option<&Closure>,
    first: &Attempt,
    made: &[Ending],
    region: &RetryContext,
) -> Step {
    match decided {
        Some(Closure::Flat) => match place(Candidate::PlanarCap, made) {
            Some(cap) if is_sound(&made[cap]) => Step::Take(cap),
            _ => best_of([Candidate::PlanarCap, Candidate::RimTriangles], made),
        },
        Some(Closure::Base) => only(Candidate::Base, made),
        Some(Closure::Seam) => only(Candidate::Seam, made),
        Some(_) => only(Candidate::RimTriangles, made),
        None => match preferred(made, region) {
            Some(step) => step,
            None => match next_surface(first, made, region) {
                Step::Take(place) => surface_or_unsure_lip(place, made, region),
                step => step,
            },
        },
    }
}

/// The next step among the candidates that are made only where they are preferred, or predict the faces around the hole much better than
/// a smooth patch: the first sound one is taken. None where all of them are made and none is sound.
fn preferred(made: &[Ending], region: &RetryContext) -> Option<Step> {
    let candidates = [
        (region.is_straight_opening, Candidate::Band),
        (region.has_counterpart, Candidate::Counterpart),
        (region.may_be_sharp, Candidate::Sides),
        (region.may_be_sharp, Candidate::Rounded),
        (region.may_be_sharp, Candidate::Lip),
    ];
    let possible = candidates
        .into_iter()
        .filter(|(is_possible, _)| *is_possible);
    for (_, candidate) in possible {
        match place(candidate, made) {
            None => return Some(Step::Make(candidate)),
            Some(place) if is_sound(&made[place]) => return Some(Step::Take(place)),
            Some(_) => {}
        }
    }
    None
}

fn is_sound(made: &Ending) -> bool {
    made.quality.is_some_and(|q| q.is_sound())
}

/// The next step for a continued surface. Level sets are attempted until one has a patch that intersects nothing, or no further
/// attempt is worthwhile. Then the best of them is finished, and compared with a faired triangulation where that may be better.
/// Where no level set has a patch, candidates without a level set are made.
fn next_surface(first: &Attempt, made: &[Ending], region: &RetryContext) -> Step {
    if let Some(finished) = place(Candidate::Finished, made) {
        return finished_or_faired(finished, made, region);
    }
    if let Some(next) = second_initialisation(made, region) {
        return Step::Make(Candidate::LevelSet(next));
    }
    if region.many_rims {
        return best_of([Candidate::EachFaired, Candidate::RimTriangles], made);
    }
    let history = history(made);
    let is_patch =
        |e: &Ending| matches!(e.candidate, Candidate::LevelSet(_)) && e.quality.is_some();
    let has_patch = made.iter().any(is_patch);
    let nearly = quality(Candidate::Unconverged, made);
    // A faired triangulation that has converged saves further attempts. If the surroundings continue as a sphere and the missing
    // part is wider than its rim, only the level set finds it.
    match place(Candidate::Faired, made) {
        Some(faired) if made[faired].is_at_sound_minimum() => return Step::Take(faired),
        None if history.is_empty() && region.faired_first => return Step::Make(Candidate::Faired),
        None if nearly.is_none() && !has_patch && region.finishes => {
            let reached_box = |failure| failure == &Some(AttemptFailure::ReachedBox);
            if let [(_, failure)] = &history[..]
                && !(reached_box(failure) && region.is_wide)
            {
                return Step::Make(Candidate::Faired);
            }
        }
        _ => {}
    }
    if nearly.is_none()
        && let Some(next) = next_attempt(first, &history, region)
    {
        return Step::Make(Candidate::LevelSet(next));
    }
    match (has_patch, nearly) {
        (true, _) | (_, Some(Some(_))) => Step::Make(Candidate::Finished),
        (false, None) => Step::Make(Candidate::Unconverged),
        (false, Some(None)) => best_of([Candidate::EachFaired, Candidate::RimTriangles], made),
    }
}

/// The surface that was chosen, or the edge of a wall where that surface is flawed or a bulb.
fn surface_or_unsure_lip(chosen: usize, made: &[Ending], region: &RetryContext) -> Step {
    let is_bulb = |q: Quality| q.is_unconverged && q.energy > LEVEL_SET_BENT.get();
    let is_poor = |q: Quality| !q.is_sound() || q.is_plain || is_bulb(q);
    if !region.may_be_sharp || !made[chosen].quality.is_none_or(is_poor) {
        return Step::Take(chosen);
    }
    match place(Candidate::UnsureLip, made) {
        None => Step::Make(Candidate::UnsureLip),
        Some(place) if is_sound(&made[place]) => Step::Take(place),
        Some(_) => Step::Take(chosen),
    }
}

/// A second initialisation, from a triangulation of the only rim, on the grid of the last level set, if that is bent so strongly that
/// it may be one of several minima. For rims of few edges the finish has a second initialisation instead.
fn second_initialisation(made: &[Ending], region: &RetryContext) -> Option<Attempt> {
    let last = made.last()?;
    let Candidate::LevelSet(own) = last.candidate else {
        return None;
    };
    let has_other = own.energy == Energy::Willmore && own.start == Start::Biharmonic;
    let is_bent = last.level_energy.is_some_and(|e| e > LEVEL_SET_BENT.get());
    let may = region.finishes && region.one_rim && region.faired_cost > CHEAP.get();
    (may && has_other && is_bent).then(|| own.with_triangulation())
}

/// The finished patch of a level set, or the faired triangulation. The latter is made where the former intersects something or is
/// folded, or is bent so strongly that it may be one of several minima. Making both for every hole and taking the lower energy is not
/// worthwhile: on 132 holes of scans the error fell by 0.2 %, and of two similar surfaces with much bending the one with lower
/// energy was farther from the true surface.
fn finished_or_faired(finished: usize, made: &[Ending], region: &RetryContext) -> Step {
    let own = made[finished].quality.filter(|_| region.finishes);
    let (own, factor) = match own {
        Some(own) if ALWAYS.get() == 2 && region.one_rim => (own, 0.0),
        _ if ALWAYS.get() == 1 => return Step::Take(finished),
        Some(own) if !own.is_sound() => (own, CLEARLY_HIGHER.get()),
        Some(own) if own.energy > BENT.get() && may_be_faired(&own, region) => {
            (own, MUCH_HIGHER.get())
        }
        _ => return Step::Take(finished),
    };
    let Some(faired) = place(Candidate::Faired, made) else {
        return Step::Make(Candidate::Faired);
    };
    // Triangles without new vertices are no surface that could be compared.
    let other = made[faired].quality.filter(|q| !q.is_plain);
    match other.is_some_and(|q| q.is_clearly_better_than(&own, factor)) {
        true => Step::Take(faired),
        false => Step::Take(finished),
    }
}

/// Whether a faired triangulation that can be made costs more than a level set.
pub(super) fn is_costly(faired_cost: f64) -> bool {
    faired_cost > CHEAP.get() && faired_cost.is_finite()
}

/// Whether a faired triangulation is worth its time beside a finished patch: it is cheap, or the patch of the only rim has not converged.
fn may_be_faired(own: &Quality, region: &RetryContext) -> bool {
    region.faired_cost <= CHEAP.get()
        || own.is_unconverged && region.one_rim && region.faired_cost.is_finite()
}

/// The next step where only one candidate is possible.
fn only(candidate: Candidate, made: &[Ending]) -> Step {
    match place(candidate, made) {
        Some(place) => Step::Take(place),
        None => Step::Make(candidate),
    }
}

/// The better of two candidates once both are made; the first of equal ones.
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

/// Quality of a candidate: the outer option is none if it was not made, the inner if it has no patch.
fn quality(candidate: Candidate, made: &[Ending]) -> Option<Option<Quality>> {
    place(candidate, made).map(|place| made[place].quality)
}

/// The level-set attempts and their failures; of two attempts on the same grid, the better one.
pub(super) fn history(made: &[Ending]) -> Vec<(Attempt, Option<AttemptFailure>)> {
    let mut kept: Vec<(Attempt, &Ending)> = Vec::new();
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
    let failure = |(own, ending): (Attempt, &Ending)| (own, ending.failure.clone());
    kept.into_iter().map(failure).collect()
}

#[cfg(test)]
mod tests;
