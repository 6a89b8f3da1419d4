//! Candidates: the level set of a region, solved on one grid and joined to the rims; and the best unconverged level set.

use std::f64::consts::PI;
use std::time::Instant;

use super::grids::{Attempt, failures, spent};
use super::problem::RegionProblem;
use super::reasons::AttemptFailure;
use super::reference::ReferenceSurface;
use super::report::RegionReport;
use super::so_far::{LevelEnd, Made, SoFar, Unconverged};
use crate::flow::{FlowSettings, HALF_WIDTH};
use crate::region::{
    Level, LevelSurface, MeshData, NestedSettings, Region, Solved, Sphere, Start, VoxelSize,
    solve_nested,
};
use crate::stitch::Patch;
use crate::tuning::{Tunable, tunable};

/// Voxels. An unconverged level set initialises the next one only if its last update was below this: larger updates
/// usually lead to a worse minimum, and a triangulation is the better initialisation.
const INITIALISING_UPDATE: Tunable<f64> = tunable("fill.initialising_update", 0.1);

/// Voxels. An unconverged surface may be taken, if there is no better one, when its last update was below this.
const USABLE_UPDATE: Tunable<f64> = tunable("fill.usable_update", 1.0);

/// Nodes. An unconverged surface this close to the side of its box may need a wider box.
const NEAR_SIDE: Tunable<i32> = tunable("fill.near_side", 9);

/// Voxels. A level set that is followed by a finish counts as converged when its update is below this; the finish
/// continues from there. On 143 holes of scans a tenth of it gave no better patches and took two steps more.
const BEFORE_FINISH: Tunable<f64> = tunable("fill.before_finish", 0.2);

/// Expected steps of the flow on each grid, including the time for the distances: measured on 290 level sets of scans and
/// models.
const EXPECTED_STEPS: Tunable<f64> = tunable("fill.expected_steps", 11.0);

/// Result of one level-set solve.
struct LevelSetResult<'a> {
    failure: Option<AttemptFailure>,
    report: RegionReport,
    /// The patch, if the surface was joined to the rims.
    surface: Option<Patch>,
    /// The solution, kept for later attempts, if its surface was not joined because the flow did not converge.
    unconverged: Option<Unconverged<'a>>,
}

/// Expected cost in unknowns times steps. The unknowns fill the band around a disc as wide as the region; coarser grids add a
/// third.
pub(super) fn cost(problem: &RegionProblem<'_>, now: &Attempt) -> f64 {
    let region = problem.region(now);
    let across = now.growth * region.diameter / region.voxel;
    let unknowns = PI / 4.0 * across * across * 2.0 * HALF_WIDTH;
    4.0 / 3.0 * unknowns * EXPECTED_STEPS.get()
}

/// Solves the level set and joins its surface to the rims.
pub(super) fn make<'b>(
    problem: &'b RegionProblem<'_>,
    now: &Attempt,
    so_far: &mut SoFar<'b>,
) -> (Made, LevelEnd) {
    let attempts = so_far.history();
    if attempts.last().is_some_and(|(t, _)| t.energy != now.energy) {
        // Another energy starts with its own budget and without the surfaces of the first.
        so_far.best_unconverged = None;
        so_far.retry_context.spent = 0;
    }
    let is_worth_it =
        |k: &&Unconverged| now.refine > 1.0 && k.solved.last_update() < INITIALISING_UPDATE.get();
    let from = so_far.best_unconverged.as_ref().filter(is_worth_it);
    let mut done = problem.solve_and_join(now, from.map(|k| &k.solved.level));
    so_far.retry_context.spent += spent(&done.report.levels);
    done.report.failed_attempts = failures(&attempts);
    // An unconverged result of the second of two initialisations on one grid is not kept.
    let is_second = attempts
        .last()
        .is_some_and(|(t, _)| *now == t.with_triangulation());
    let unconverged = done.unconverged.filter(|_| !is_second);
    so_far.best_unconverged = better_converged(so_far.best_unconverged.take(), unconverged);
    if done.failure == Some(AttemptFailure::ReachedBox) {
        so_far.retry_context.is_wide = Sphere::new(problem.mesh, problem.holes).is_some();
    }
    let last = done.report.levels.last();
    let end = LevelEnd {
        energy: last.filter(|l| l.flow.converged).map(|l| l.flow.willmore()),
        failure: done.failure,
    };
    let made = match done.surface {
        Some(patch) => Made::Joined(patch, done.report),
        None => {
            so_far.last = done.report;
            Made::Nothing
        }
    };
    (made, end)
}

/// The patch of the unconverged level set whose last update was the smallest, if it intersects nothing.
pub(super) fn make_unconverged(problem: &RegionProblem<'_>, so_far: &mut SoFar<'_>) -> Made {
    let attempts = so_far.history();
    let patch_of = |unconverged: Unconverged| {
        let surface = LevelSurface {
            level: &unconverged.solved.level,
            data: &unconverged.data,
        };
        let extracted = unconverged.solved.level.zero_set();
        let patch = problem
            .stitch(&unconverged.region, &surface, &extracted)
            .ok()?;
        let report = RegionReport {
            failed_attempts: failures(&attempts),
            ..unconverged.report
        };
        (patch.report.intersecting_faces == 0).then_some(Made::Joined(patch, report))
    };
    let unconverged = so_far.best_unconverged.take();
    unconverged.and_then(patch_of).unwrap_or(Made::Nothing)
}

/// The unconverged level set with the smaller last update; the first of two equal ones.
fn better_converged<'a>(
    a: Option<Unconverged<'a>>,
    b: Option<Unconverged<'a>>,
) -> Option<Unconverged<'a>> {
    let update = |u: &Unconverged| u.solved.last_update();
    let both = [a, b].into_iter().flatten();
    both.min_by(|a, b| update(a).total_cmp(&update(b)))
}

impl RegionProblem<'_> {
    /// Solves a level set and joins its surface to the rims.
    fn solve_and_join(&self, now: &Attempt, from: Option<&Level>) -> LevelSetResult<'_> {
        // Solves on nested grids, from the surface of an earlier attempt where there is one.
        let clock = Instant::now();
        let (solved, region, data) = self.solve(now, from);
        self.log_attempt(now, &region, &solved, clock);
        let report = RegionReport {
            // The box of a retry may be made for a wider initial surface.
            diameter: match self.extent {
                Some(_) => region.diameter,
                None => self.diameter(),
            },
            voxel: Some(region.voxel),
            dims: Some(region.finest_dims()),
            converged: solved.converged(),
            levels: solved.reports.clone(),
            other_energy: now.energy != self.params.energy,
            ..RegionReport::default()
        };
        // An unusable surface may still initialise later attempts if its last update was small and it stays inside its box.
        if let Some(failure) = self.unusable(&solved, now) {
            let nearly = solved.last_update() < USABLE_UPDATE.get() && !solved.level.touches_box();
            return LevelSetResult {
                failure: Some(failure),
                report: report.clone(),
                surface: None,
                unconverged: nearly.then_some(Unconverged {
                    solved,
                    region,
                    data,
                    report,
                }),
            };
        }
        // The part of the zero set that fills the hole, joined to the rims. A joined patch that intersects faces counts as a failure,
        // but is kept as a candidate.
        let (failure, surface) = {
            let surface = LevelSurface {
                level: &solved.level,
                data: &data,
            };
            let extracted = solved.level.zero_set();
            match self.stitch(&region, &surface, &extracted) {
                Ok(patch) => {
                    let failure = match patch.report.intersecting_faces {
                        0 => None,
                        faces => Some(AttemptFailure::Intersects(faces)),
                    };
                    (failure, Some(patch))
                }
                Err(error) => (Some(AttemptFailure::NotJoined(error)), None),
            }
        };
        LevelSetResult {
            failure,
            report,
            surface,
            unconverged: None,
        }
    }

    /// Why the surface of a solve is unusable and another attempt may find a better one; none if it is usable.
    fn unusable(&self, solved: &Solved, now: &Attempt) -> Option<AttemptFailure> {
        let is_unconverged = solved.is_far_from_converged();
        let may_grow = || now.may_widen() && solved.level.is_near_side(NEAR_SIDE.get());
        if solved.has_diverged() {
            // A solve that diverged this far never converged on another grid, except while growing towards a sphere.
            let on_its_way = now.start != Start::Sphere
                && Sphere::new(self.mesh, self.holes).is_some()
                && may_grow();
            return Some(match on_its_way {
                true => AttemptFailure::ReachedBox,
                false => AttemptFailure::Diverged,
            });
        }
        if is_unconverged && may_grow() {
            return Some(AttemptFailure::ReachedBox);
        }
        let may_refine = self.params.voxel == VoxelSize::Auto;
        if is_unconverged && now.refine == 1.0 && !now.accept {
            return may_refine.then_some(AttemptFailure::NotConverged);
        }
        let cramped = !is_unconverged && now.may_widen() && solved.level.touches_box();
        cramped.then_some(AttemptFailure::ReachedBox)
    }

    /// Logs the grids, steps and times of an attempt.
    fn log_attempt(&self, now: &Attempt, region: &Region, solved: &Solved, clock: Instant) {
        let ids: Vec<usize> = self.holes.iter().map(|h| h.id.get()).collect();
        let levels: Vec<String> = solved
            .reports
            .iter()
            .map(|l| {
                let last = l.flow.update;
                let (nodes, unknowns, steps) = (l.nodes, l.flow.unknowns, l.flow.steps.len());
                let [sampling, flow] = l.seconds;
                format!("{nodes} nodes, {unknowns} unknown, {steps} steps to {last:.1e}, {sampling:.2} + {flow:.2} s")
            })
            .collect();
        log::debug!(
            "holes {ids:?}, {:.0} voxels across, {:?} start, {:.2} s: {}",
            region.diameter / region.voxel,
            now.start,
            clock.elapsed().as_secs_f64(),
            levels.join("; ")
        );
    }

    /// Runs the nested solve of an attempt; `from` is an earlier surface that initialises it.
    fn solve(&self, next: &Attempt, from: Option<&Level>) -> (Solved, Region, MeshData<'_>) {
        let region = self.region(next);
        let kept = self
            .reference
            .map(|d| d.kept(region.diameter, region.voxel));
        let data = MeshData::new(self.known, self.mesh, self.holes)
            .keeping(kept)
            .stopped_by(self.cancel);
        let may_refine = self.params.voxel == VoxelSize::Auto;
        let settings = NestedSettings {
            own: self.own,
            lattice: region.lattice,
            dims: region.dims,
            refinements: region.refinements,
            start: next.start,
            from,
            stop_if_unconverged: next.refine == 1.0 && !next.accept && may_refine,
            flow: self
                .flow_settings(next)
                .across(region.diameter / region.voxel),
            time: self.reference.and_then(ReferenceSurface::time),
        };
        let solved = solve_nested(&data, &settings, self.keep_going);
        (solved, region, data)
    }

    /// Settings of the flow. Before a finish a looser tolerance suffices.
    fn flow_settings(&self, next: &Attempt) -> FlowSettings {
        let usual = FlowSettings::default();
        let (tolerance, largest_update_factor) = match self.is_finished() {
            true => (BEFORE_FINISH.get(), 1.0),
            false => (usual.tolerance, usual.largest_update_factor),
        };
        FlowSettings {
            energy: next.energy,
            tolerance,
            largest_update_factor,
            ..usual
        }
    }
}
