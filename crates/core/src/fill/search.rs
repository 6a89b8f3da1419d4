//! Closes a region: computes the candidates that the strategy asks for, until it accepts one.

use std::time::Instant;

use glam::DVec3;

use super::grids::{Attempt, RetryContext};
use super::problem::{RegionProblem, has_few_edges, refines};
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::so_far::{LevelEnd, Made, SoFar, Tried};
use super::strategy::{Candidate, Ending, Step, is_costly, next_step};
use super::{
    base, counterpart, faired, finish_step, level_set, lip, planar, rim_triangles, rounded, seam,
    sharp, straight_opening,
};
use crate::mesh::Hole;
use crate::region::{Start, VoxelSize};
use crate::tuning::{Tunable, tunable};

/// Edges. Rims of at most this many edges get one solve only: they determine little of the surface, and a finer grid adds
/// nothing.
const SMALL_EDGES: Tunable<usize> = tunable("fill.small_edges", 16);

/// Diameters. A rim is the end of a tube when its vertices are this close to a plane and `PARALLEL` holds.
const FLAT_RIM: Tunable<f64> = tunable("fill.flat_rim", 0.01);

/// Length of the mean conormal (the direction in which the surface continues) of a rim, at least, for the end of a tube:
/// 1 for a straight tube.
const PARALLEL: Tunable<f64> = tunable("fill.parallel", 0.98);

/// Rims. Where other candidates than level sets come next, as in a repair that compares plans, a region of more rims gets no level
/// set: of the slowest repairs of real parts none of 45 level sets with more than four rims had a patch, and they took a third of the
/// time of all level sets.
const MANY_RIMS: Tunable<usize> = tunable("fill.many_rims", 12);

impl RegionProblem<'_> {
    /// Fills the region.
    pub(crate) fn fill(&self) -> RegionPatch {
        let clock = Instant::now();
        let mut filled = match self.cancel.is_cancelled() {
            true => self.stopped(RegionReport::default()),
            false => self.with_grain(search(self)),
        };
        let quality = filled.quality();
        let errors = filled.expected_error.iter().flatten().copied();
        filled.report.largest_expected_error = errors.reduce(f64::max);
        let report = &mut filled.report;
        report.quality = Some(quality);
        report.id = self.id;
        report.holes = self.holes.iter().map(|h| h.id).collect();
        report.bridge = self.params.bridges(&report.holes);
        report.seconds = clock.elapsed().as_secs_f64();
        filled
    }

    /// The properties of the region that decide about retries.
    fn retry_context(&self) -> RetryContext {
        let is_end = |h: &&Hole| {
            let mean = h.conormals.iter().sum::<DVec3>() / h.conormals.len().max(1) as f64;
            h.planarity < FLAT_RIM.get() && mean.length() > PARALLEL.get()
        };
        let faired_cost = faired::cost(self);
        RetryContext {
            has_counterpart: self.has_counterpart(),
            is_straight_opening: self.is_straight_opening(),
            may_be_sharp: self.may_be_sharp(),
            may_refine: refines(self.mesh, self.holes, self.params),
            diameter: self.diameter(),
            tube_end: self.reference.is_none() && self.holes.iter().all(is_end),
            is_wide: false,
            finishes: self.is_finished(),
            one_rim: self.holes.len() == 1,
            many_rims: self.budget == 0 && self.holes.len() > MANY_RIMS.get(),
            faired_first: self.reference.is_none()
                && (has_few_edges(self.holes, self.params)
                    || self.params.finishes()
                        && self.params.voxel == VoxelSize::Auto
                        && is_costly(faired_cost)
                        && self.is_on_thin_wall()),
            faired_cost,
            budget: self.budget,
            spent: 0,
        }
    }
}

/// Makes candidates until the strategy takes one.
fn search(problem: &RegionProblem<'_>) -> RegionPatch {
    let mut so_far = begin(problem);
    loop {
        let SoFar {
            first,
            retry_context,
            ..
        } = &so_far;
        let endings = so_far.endings();
        let candidate = match next_step(problem.decided, first, &endings, retry_context) {
            Step::Take(place) => {
                let (ends, why) = (so_far.crease_ends, so_far.not_continued.clone());
                let counterpart = so_far.counterpart.take();
                let mut patch = taken(problem, so_far, place);
                patch.report.counterpart = patch.report.counterpart.or(counterpart);
                patch
                    .report
                    .set_creases_seen(ends, why, !problem.joined.is_empty());
                return patch;
            }
            Step::Make(candidate) => candidate,
        };
        if candidate.growth() > problem.most_growth {
            return problem.cramped();
        }
        if !(problem.keep_going)() {
            return problem.stopped(so_far.last);
        }
        let tried = make(problem, candidate, &mut so_far);
        if problem.cancel.is_cancelled() {
            return problem.stopped(so_far.last);
        }
        so_far.tried.push(tried);
    }
}

fn begin<'b>(problem: &RegionProblem<'_>) -> SoFar<'b> {
    SoFar {
        first: Attempt {
            accept: problem.holes.iter().all(|h| h.edges <= SMALL_EDGES.get()),
            start: match problem.reference {
                Some(_) => Start::Triangulation,
                None => Start::Biharmonic,
            },
            ..Attempt::first(problem.params.energy)
        },
        retry_context: match problem.decided {
            None => problem.retry_context(),
            Some(_) => RetryContext::default(),
        },
        tried: Vec::new(),
        best_unconverged: None,
        last: RegionReport::default(),
        crease_ends: 0,
        noise: 0.0,
        not_continued: None,
        counterpart: None,
    }
}

/// Makes a candidate, by the function of its module.
fn make<'b>(problem: &'b RegionProblem<'_>, candidate: Candidate, so_far: &mut SoFar<'b>) -> Tried {
    let mut level = LevelEnd::default();
    let clock = Instant::now();
    let made = match candidate {
        Candidate::Counterpart => counterpart::make(problem, so_far),
        Candidate::Sides => sharp::make(problem, so_far),
        Candidate::Rounded => rounded::make(problem, so_far),
        Candidate::Lip => lip::make(problem),
        Candidate::UnsureLip => lip::make_unsure(problem),
        Candidate::LevelSet(now) => {
            let made;
            (made, level) = level_set::make(problem, &now, so_far);
            made
        }
        Candidate::Unconverged => level_set::make_unconverged(problem, so_far),
        Candidate::Finished => finish_step::make(problem, so_far),
        Candidate::Faired => faired::make(problem),
        Candidate::EachFaired => faired::make_each(problem, so_far),
        Candidate::PlanarCap => planar::make(problem),
        Candidate::Base => base::make(problem),
        Candidate::Seam => seam::make(problem),
        Candidate::Band => straight_opening::make(problem),
        Candidate::RimTriangles => rim_triangles::make(problem, so_far),
    };
    let quality = made.quality();
    if problem.decided.is_none() && log::log_enabled!(log::Level::Debug) {
        let seconds = clock.elapsed().as_secs_f64();
        let expected = MS_OF_COST * cost(problem, candidate, so_far);
        log::debug!(
            "{candidate:?}: {:.0} ms, expected {expected:.0} ms; {quality:?}",
            1e3 * seconds
        );
    }
    let ending = Ending {
        candidate,
        quality,
        failure: level.failure,
        level_energy: level.energy,
        is_at_minimum: matches!(&made, Made::Finished(patch) if patch.is_at_minimum()),
    };
    Tried { ending, made }
}

/// Milliseconds of one core per unit of cost: one unknown in one step of a level set.
const MS_OF_COST: f64 = 6e-3;

/// Expected cost of a candidate before it is made, in unknowns times steps of a level set. On 278 holes of scans and models half
/// of the level sets and faired triangulations took between 0.75 and 1.4 times the expected time, half of the finishes between
/// 0.85 and 1.2 times.
fn cost(problem: &RegionProblem<'_>, candidate: Candidate, so_far: &SoFar<'_>) -> f64 {
    let joined = || {
        so_far
            .best_joined()
            .map_or(0, |(patch, _)| patch.faces.len())
    };
    match candidate {
        Candidate::Counterpart => counterpart::cost(problem),
        Candidate::Sides => sharp::cost(problem),
        Candidate::Rounded => rounded::cost(problem),
        Candidate::Lip | Candidate::UnsureLip => lip::cost(problem),
        Candidate::LevelSet(now) => level_set::cost(problem, &now),
        Candidate::Finished => finish_step::cost(joined()),
        Candidate::Faired | Candidate::EachFaired => faired::cost(problem),
        Candidate::PlanarCap => planar::cost(problem),
        Candidate::Base => base::cost(problem),
        // Triangles between existing vertices, or an already solved level set.
        Candidate::Unconverged | Candidate::Seam | Candidate::Band | Candidate::RimTriangles => 0.0,
    }
}

/// The result of the region for the candidate at `place`. A faired triangulation that replaces the finished patch of a level set
/// is reported as that patch.
fn taken(problem: &RegionProblem<'_>, mut so_far: SoFar<'_>, place: usize) -> RegionPatch {
    let beside = so_far.best_joined().map(|(_, report)| report.clone());
    match (so_far.tried.swap_remove(place).made, beside) {
        (Made::Region(region), _) => region,
        (Made::Finished(patch), beside) => {
            let (patch, image) = problem.weighed(patch);
            let mut region = match beside {
                Some(report) => problem.accept(patch, report),
                None => {
                    let (why, report) = so_far.without_level_set();
                    problem.closed_by_fairing(patch, why, report)
                }
            };
            region.report.counterpart = image;
            region
        }
        // The strategy never takes a candidate without a patch, or an unfinished one.
        (Made::Nothing | Made::Joined(..), _) => problem.stopped(so_far.last),
    }
}
