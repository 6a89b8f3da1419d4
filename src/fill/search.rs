//! One region: solve, extract, stitch, and the next try where that fails.

use std::time::Instant;

use glam::DVec3;

use super::candidate::FinishedPatch;
use super::level_set::{Found, Unsteady};
use super::outcome::{ClosedBy, FailedReason, HoleOutcome, TriangulatedReason, TryFailure};
use super::params::SurfaceKind;
use super::problem::{RegionProblem, is_trivial, refines};
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::strategy::{Prospects, Try, Verdict, cost, failures, next_try};
use crate::mesh::{Hole, Mesh};
use crate::region::{LevelSurface, Start};
use crate::stitch::{Patch, close_seam};

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

impl RegionProblem<'_> {
    /// Fills the region.
    pub(crate) fn fill(&self) -> RegionPatch {
        let clock = Instant::now();
        let mut filled = if self.cancel.is_cancelled() {
            self.stopped(RegionReport::default())
        } else if is_trivial(self.holes, self.params) {
            self.triangulate(TriangulatedReason::FewEdges, RegionReport::default())
        } else if self.holes.iter().all(|h| self.params.is_flat(h.id)) {
            self.close_flat()
        } else if let Some(closed) = self.close_seam() {
            closed
        } else {
            self.evolve()
        };
        let report = &mut filled.report;
        report.id = self.id;
        report.holes = self.holes.iter().map(|h| h.id).collect();
        report.bridge = self.params.bridges(&report.holes);
        report.seconds = clock.elapsed().as_secs_f64();
        filled
    }

    /// Solves and stitches, with a wider box or a finer grid where a try fails. The patch that crosses least is taken.
    fn evolve(&self) -> RegionPatch {
        let first = Try {
            accept: self.holes.iter().all(|h| h.edges <= SMALL_EDGES),
            start: match self.previous {
                Some(_) => Start::Triangulation,
                None => Start::Biharmonic,
            },
            ..Try::first(self.params.energy)
        };
        let mut prospects = self.prospects();
        let mut history: Vec<(Try, Verdict)> = Vec::new();
        let mut best: Option<(Patch, RegionReport)> = None;
        let mut kept: Option<Unsteady> = None;
        let mut last = RegionReport::default();
        while let Some(now) = next_try(&first, &history, &prospects) {
            if !(self.keep_going)() {
                break;
            }
            if history.last().is_some_and(|(t, _)| t.energy != now.energy) {
                // Another energy begins anew, with a budget of its own and without the surfaces of the first.
                kept = None;
                prospects.spent = 0;
            }
            let is_worth_it =
                |k: &&Unsteady| now.refine > 1.0 && k.solved.movement() < WORTH_A_START;
            let from = kept.as_ref().filter(is_worth_it);
            let mut tried = self.try_once(&now, from.map(|k| &k.solved.level));
            if self.cancel.is_cancelled() {
                last = tried.report;
                break;
            }
            prospects.spent += cost(&tried.report.levels);
            tried.report.earlier_tries = failures(&history);
            match tried.patch {
                Some(Found::Whole(mesh)) => return self.whole(mesh, tried.report),
                Some(Found::Patch(patch)) => {
                    let crossing = |p: &Patch| p.report.intersecting_faces;
                    if best
                        .as_ref()
                        .is_none_or(|b| crossing(&patch) < crossing(&b.0))
                    {
                        best = Some((patch, tried.report));
                    }
                }
                None => last = tried.report,
            }
            kept = nearer_steady(kept, tried.unsteady);
            history.push((now, tried.verdict));
            if history.len() == 1
                && best.is_none()
                && let Some(instead) = self.instead_of_retries(&history, &last)
            {
                return instead;
            }
        }
        if self.cancel.is_cancelled() {
            return self.stopped(last);
        }
        let best = best.or_else(|| self.patch_of(kept?, &history));
        self.concluded(best, &history, last)
    }

    /// The finished patch of the best attempt; where there is none, what closes the region without a level set.
    fn concluded(
        &self,
        best: Option<(Patch, RegionReport)>,
        history: &[(Try, Verdict)],
        mut last: RegionReport,
    ) -> RegionPatch {
        if let Some((patch, report)) = best {
            return match self.finish(Some(patch.clone())) {
                Some(finished) => self.accept(finished, report),
                None => self.accept(FinishedPatch::unfinished(patch), report),
            };
        }
        last.earlier_tries = failures(history);
        let why = last.earlier_tries.last().cloned();
        self.without_level_set(why.unwrap_or(TryFailure::Stopped), last)
    }

    /// A region that was stopped: its holes stay open, and the run ends with an error.
    fn stopped(&self, mut report: RegionReport) -> RegionPatch {
        report.closed_by = Some(ClosedBy::Nothing);
        let outcome = HoleOutcome::Failed(FailedReason::NotReached);
        self.all(Mesh::default(), report, outcome)
    }

    /// What of the region bears on its tries.
    fn prospects(&self) -> Prospects {
        let is_end = |h: &&Hole| {
            let mean = h.conormals.iter().sum::<DVec3>() / h.conormals.len().max(1) as f64;
            h.planarity < FLAT_RIM && mean.length() > PARALLEL
        };
        Prospects {
            may_refine: refines(self.mesh, self.holes, self.params),
            diameter: self.holes.iter().map(|h| h.diameter).fold(0.0, f64::max),
            tube_end: self.previous.is_none() && self.holes.iter().all(is_end),
            budget: BUDGET,
            spent: 0,
        }
    }

    /// The patch of a surface that is nearly steady, if it crosses nothing.
    fn patch_of(
        &self,
        kept: Unsteady,
        history: &[(Try, Verdict)],
    ) -> Option<(Patch, RegionReport)> {
        let surface = LevelSurface {
            level: &kept.solved.level,
            data: &kept.data,
        };
        let extracted = kept.solved.level.zero_set();
        let patch = self.stitch(&kept.region, &surface, &extracted).ok()?;
        let report = RegionReport {
            earlier_tries: failures(history),
            ..kept.report
        };
        (patch.report.intersecting_faces == 0).then_some((patch, report))
    }

    fn accept(&self, finished: FinishedPatch, mut report: RegionReport) -> RegionPatch {
        report.closed_by = Some(ClosedBy::LevelSet);
        self.all_finished(finished, report, HoleOutcome::Filled)
    }

    /// A finished patch that closes all of its holes in one way.
    pub(super) fn all_finished(
        &self,
        finished: FinishedPatch,
        mut report: RegionReport,
        outcome: HoleOutcome,
    ) -> RegionPatch {
        let FinishedPatch {
            patch,
            report: finish,
            sigma,
        } = finished;
        report.finish = finish;
        report.seam_angle_mean = Some(patch.report.seam_angle_mean);
        report.seam_angle_max = Some(patch.report.seam_angle_max);
        report.quality_mean = patch.report.quality_mean;
        report.intersecting_faces = patch.report.intersecting_faces;
        report.components = patch.report.components;
        report.rise = self.rise(&patch.positions);
        let mesh = Mesh::new(patch.positions, patch.faces);
        RegionPatch {
            sigma,
            ..self.all(mesh, report, outcome)
        }
    }

    fn whole(&self, mesh: Mesh, mut report: RegionReport) -> RegionPatch {
        report.closed_by = Some(ClosedBy::LevelSet);
        self.all(mesh, report, HoleOutcome::Filled)
    }

    /// A patch that closes all of its holes in one way.
    fn all(&self, mesh: Mesh, mut report: RegionReport, outcome: HoleOutcome) -> RegionPatch {
        report.new_vertices = mesh.positions.len();
        report.new_faces = mesh.faces.len();
        RegionPatch {
            sigma: vec![None; mesh.positions.len()],
            mesh,
            report,
            outcomes: vec![outcome; self.holes.len()],
        }
    }

    /// Closes the gap between two rims that lie on each other.
    fn close_seam(&self) -> Option<RegionPatch> {
        let (&[a, b], SurfaceKind::Stitched) = (self.holes, self.params.surface) else {
            return None;
        };
        let faces = close_seam(self.mesh, &a.rim, &b.rim)?;
        let report = RegionReport {
            diameter: a.diameter,
            closed_by: Some(ClosedBy::Seam),
            components: 1,
            ..RegionReport::default()
        };
        let outcome = HoleOutcome::Triangulated(TriangulatedReason::Seam);
        Some(self.all(Mesh::new(Vec::new(), faces), report, outcome))
    }
}

/// The unconverged solution whose last update was smaller; the first of two alike.
fn nearer_steady<'a>(a: Option<Unsteady<'a>>, b: Option<Unsteady<'a>>) -> Option<Unsteady<'a>> {
    let movement = |u: &Unsteady| u.solved.movement();
    let both = [a, b].into_iter().flatten();
    both.min_by(|a, b| movement(a).total_cmp(&movement(b)))
}
