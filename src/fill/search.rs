//! The search for a closure of a region: computes the candidates that the strategy asks for, until that accepts one.

use std::time::Instant;

use glam::DVec3;

use super::candidate::{FinishedPatch, PatchStart, quality};
use super::grids::{History, Prospects, Try, cost, failures};
use super::level_set::{LevelSetSurface, Unsteady};
use super::outcome::{TriangulatedReason, TryFailure};
use super::params::SurfaceKind;
use super::problem::{RegionPlan, RegionProblem, refines};
use super::quality::Quality;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::strategy::{CHEAP_EDGES, Candidate, Ending, Step, history, next_step};
use crate::mesh::Hole;
use crate::region::{LevelSurface, Sphere, Start};
use crate::stitch::Patch;

/// Loops of at most this many edges are solved once only: their few edges say little about the surface, and a finer grid does
/// not add to that.
const SMALL_EDGES: usize = 16;
/// The next try starts from a surface that is not steady when its last step moved it by less than this: one that is farther from
/// rest has often begun to run to a worse minimum, and a triangulation is the better start.
const WORTH_A_START: f64 = 0.1;
/// What further tries at a region may cost, in unknowns times steps: about six seconds of one core.
const BUDGET: u64 = 1_000_000;
/// A rim is the end of a tube when it is planar to this part of its diameter,
const FLAT_RIM: f64 = 0.01;
/// and the mean of the directions in which the surface would continue is at least so long: those of a tube have length 1.
const PARALLEL: f64 = 0.98;

/// The candidates that were made of a region so far.
struct Search<'a, 'b> {
    problem: &'b RegionProblem<'a>,
    first: Try,
    prospects: Prospects,
    made: Vec<Ending>,
    /// For each what was made.
    patches: Vec<Made>,
    /// The surface that came nearest to rest.
    nearest: Option<Unsteady<'b>>,
    /// What the last level set without a patch found.
    last: RegionReport,
}

/// What was made.
enum Made {
    /// No patch.
    Nothing,
    /// The patch of a level set, and what was found.
    Joined(Patch, RegionReport),
    /// A finished patch.
    Finished(FinishedPatch),
    /// What becomes of the region.
    Region(RegionPatch),
}

impl RegionProblem<'_> {
    /// Fills the region.
    pub(crate) fn fill(&self) -> RegionPatch {
        let clock = Instant::now();
        let mut filled = match self.cancel.is_cancelled() {
            true => self.stopped(RegionReport::default()),
            false => Search::new(self).run(),
        };
        let report = &mut filled.report;
        report.id = self.id;
        report.holes = self.holes.iter().map(|h| h.id).collect();
        report.bridge = self.params.bridges(&report.holes);
        report.seconds = clock.elapsed().as_secs_f64();
        filled
    }

    /// What of the region bears on its tries.
    fn prospects(&self) -> Prospects {
        let is_end = |h: &&Hole| {
            let mean = h.conormals.iter().sum::<DVec3>() / h.conormals.len().max(1) as f64;
            h.planarity < FLAT_RIM && mean.length() > PARALLEL
        };
        Prospects {
            may_refine: refines(self.mesh, self.holes, self.params),
            diameter: self.diameter(),
            tube_end: self.reference.is_none() && self.holes.iter().all(is_end),
            is_wide: false,
            finishes: self.is_finished(),
            one_rim: self.holes.len() == 1,
            few_edges: self.holes.iter().all(|h| h.edges <= CHEAP_EDGES),
            budget: BUDGET,
            spent: 0,
        }
    }

    /// The patch of a surface that is nearly steady, if it crosses nothing.
    fn patch_of(&self, nearest: Unsteady, history: &History) -> Option<(Patch, RegionReport)> {
        let surface = LevelSurface {
            level: &nearest.solved.level,
            data: &nearest.data,
        };
        let extracted = nearest.solved.level.zero_set();
        let patch = self.stitch(&nearest.region, &surface, &extracted).ok()?;
        let report = RegionReport {
            earlier_tries: failures(history),
            ..nearest.report
        };
        (patch.report.intersecting_faces == 0).then_some((patch, report))
    }
}

impl<'a, 'b> Search<'a, 'b> {
    fn new(problem: &'b RegionProblem<'a>) -> Self {
        let first = Try {
            accept: problem.holes.iter().all(|h| h.edges <= SMALL_EDGES),
            start: match problem.reference {
                Some(_) => Start::Triangulation,
                None => Start::Biharmonic,
            },
            ..Try::first(problem.params.energy)
        };
        Self {
            problem,
            first,
            prospects: match problem.plan {
                RegionPlan::Solve => problem.prospects(),
                _ => Prospects::default(),
            },
            made: Vec::new(),
            patches: Vec::new(),
            nearest: None,
            last: RegionReport::default(),
        }
    }

    /// Makes candidates until the strategy takes one.
    fn run(mut self) -> RegionPatch {
        loop {
            let candidate =
                match next_step(self.problem.plan, &self.first, &self.made, &self.prospects) {
                    Step::Take(place) => return self.taken(place),
                    Step::Make(candidate) => candidate,
                };
            if candidate.growth() > self.problem.most_growth {
                return self.problem.cramped();
            }
            if !(self.problem.keep_going)() {
                return self.problem.stopped(self.last);
            }
            let (ending, made) = self.make(candidate);
            if self.problem.cancel.is_cancelled() {
                return self.problem.stopped(self.last);
            }
            let is_whole = self.problem.params.surface == SurfaceKind::Whole;
            let made = match made {
                Made::Region(whole) if is_whole => return whole,
                made => made,
            };
            self.made.push(ending);
            self.patches.push(made);
        }
    }

    fn make(&mut self, candidate: Candidate) -> (Ending, Made) {
        let problem = self.problem;
        let made = match candidate {
            Candidate::LevelSet(now) => return self.make_level_set(now),
            Candidate::NearlySteady => self.make_nearly_steady(),
            Candidate::Finished => Made::Finished(self.make_finished()),
            Candidate::Faired => problem.faired().map_or(Made::Nothing, Made::Finished),
            Candidate::EachFaired => {
                let (why, report) = self.without_level_set();
                let made = problem.each_faired(why, report);
                made.map_or(Made::Nothing, Made::Region)
            }
            Candidate::PlanarCap => {
                let cap = problem.planar_cap();
                cap.map_or(Made::Nothing, |cap| Made::Region(problem.capped(cap)))
            }
            Candidate::Seam => problem.close_seam().map_or(Made::Nothing, Made::Region),
            Candidate::RimTriangles => {
                let (why, report) = match problem.plan {
                    RegionPlan::Planar => (TriangulatedReason::Flat, problem.flat_report()),
                    RegionPlan::Solve => {
                        let (why, report) = self.without_level_set();
                        (TriangulatedReason::NoSurface(why), report)
                    }
                    _ => (TriangulatedReason::FewEdges, RegionReport::default()),
                };
                Made::Region(problem.triangulate(why, report))
            }
        };
        let ending = Ending {
            candidate,
            quality: made.quality(),
            failure: None,
            level_energy: None,
            is_at_minimum: matches!(&made, Made::Finished(patch) if patch.is_at_minimum()),
        };
        (ending, made)
    }

    fn make_level_set(&mut self, now: Try) -> (Ending, Made) {
        let tried = history(&self.made);
        if tried.last().is_some_and(|(t, _)| t.energy != now.energy) {
            // Another energy begins anew, with a budget of its own and without the surfaces of the first.
            self.nearest = None;
            self.prospects.spent = 0;
        }
        let is_worth_it = |k: &&Unsteady| now.refine > 1.0 && k.solved.movement() < WORTH_A_START;
        let from = self.nearest.as_ref().filter(is_worth_it);
        let mut done = self
            .problem
            .solve_and_join(&now, from.map(|k| &k.solved.level));
        self.prospects.spent += cost(&done.report.levels);
        done.report.earlier_tries = failures(&tried);
        // The second of two initialisations on one grid counts only if it converged.
        let is_second = tried
            .last()
            .is_some_and(|(t, _)| now == t.from_triangulation());
        let unsteady = done.unsteady.filter(|_| !is_second);
        self.nearest = nearer_steady(self.nearest.take(), unsteady);
        if done.failure == Some(TryFailure::ReachedBox) {
            self.prospects.is_wide = Sphere::new(self.problem.mesh, self.problem.holes).is_some();
        }
        let last = done.report.levels.last();
        let level_energy = last.filter(|l| l.flow.converged).map(|l| l.flow.willmore());
        let made = match done.patch {
            Some(LevelSetSurface::Whole(mesh)) => {
                Made::Region(self.problem.whole(mesh, done.report))
            }
            Some(LevelSetSurface::Patch(patch)) => Made::Joined(patch, done.report),
            None => {
                self.last = done.report;
                Made::Nothing
            }
        };
        let ending = Ending {
            candidate: Candidate::LevelSet(now),
            quality: made.quality(),
            failure: done.failure,
            level_energy,
            is_at_minimum: false,
        };
        (ending, made)
    }

    /// The patch of the surface that came nearest to rest, if it intersects nothing.
    fn make_nearly_steady(&mut self) -> Made {
        let tried = history(&self.made);
        let patch = self
            .nearest
            .take()
            .and_then(|n| self.problem.patch_of(n, &tried));
        patch.map_or(Made::Nothing, |(patch, report)| Made::Joined(patch, report))
    }

    fn make_finished(&self) -> FinishedPatch {
        let Some((patch, _)) = self.best_joined() else {
            return FinishedPatch::unfinished(Patch::default());
        };
        match self.problem.is_finished() {
            true => self.problem.finished(patch.clone(), PatchStart::LevelSet),
            false => FinishedPatch::unfinished(patch.clone()),
        }
    }

    /// The best patch of a level set; of equals the first.
    fn best_joined(&self) -> Option<(&Patch, &RegionReport)> {
        let all = self.made.iter().zip(&self.patches);
        let joined = all.filter_map(|(ending, made)| match made {
            Made::Joined(patch, report) => Some((ending.quality, patch, report)),
            _ => None,
        });
        let best = joined.min_by_key(|(quality, ..)| *quality);
        best.map(|(_, patch, report)| (patch, report))
    }

    /// Why no level set closed the region, and what is reported then.
    fn without_level_set(&self) -> (TryFailure, RegionReport) {
        let report = RegionReport {
            earlier_tries: failures(&history(&self.made)),
            ..self.last.clone()
        };
        let why = report.earlier_tries.last().cloned();
        (why.unwrap_or(TryFailure::Stopped), report)
    }

    /// What becomes of the region by the candidate that is taken. A faired triangulation that is better than the finished patch of a
    /// level set stands in its place.
    fn taken(mut self, place: usize) -> RegionPatch {
        let beside = self.best_joined().map(|(_, report)| report.clone());
        match (self.patches.swap_remove(place), beside) {
            (Made::Region(region), _) => region,
            (Made::Finished(patch), Some(report)) => self.problem.accept(patch, report),
            (Made::Finished(patch), None) => {
                let (why, report) = self.without_level_set();
                self.problem.closed_by_fairing(patch, why, report)
            }
            // No strategy takes what has no patch, or was not finished.
            (Made::Nothing | Made::Joined(..), _) => self.problem.stopped(self.last),
        }
    }
}

impl Made {
    fn quality(&self) -> Option<Quality> {
        match self {
            Self::Nothing => None,
            Self::Joined(patch, report) => Some(joined_quality(patch, report)),
            Self::Finished(patch) => Some(patch.quality()),
            Self::Region(region) => Some(region.quality()),
        }
    }
}

/// How good a patch is that is not finished yet: its energy is that of the level set.
fn joined_quality(patch: &Patch, report: &RegionReport) -> Quality {
    Quality {
        is_unconverged: !report.converged,
        energy: report.levels.last().map_or(0.0, |l| l.flow.willmore()),
        ..quality(patch, None)
    }
}

/// The unconverged solution whose last update was smaller; the first of two alike.
fn nearer_steady<'a>(a: Option<Unsteady<'a>>, b: Option<Unsteady<'a>>) -> Option<Unsteady<'a>> {
    let movement = |u: &Unsteady| u.solved.movement();
    let both = [a, b].into_iter().flatten();
    both.min_by(|a, b| movement(a).total_cmp(&movement(b)))
}
