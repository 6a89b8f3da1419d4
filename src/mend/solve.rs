//! One region: solve, extract, stitch, and the next try where that fails.

use std::time::Instant;

use glam::DVec3;

use super::damaged::Damaged;
use super::finished::FinishedPatch;
use super::outcome::{ClosedBy, FailedReason, HoleOutcome, TriangulatedReason, TryFailure};
use super::params::{FillParams, SurfaceKind};
use super::patch::RegionPatch;
use super::report::{FEW_EDGES, RegionReport};
use super::tried::{Found, Unsteady};
use super::tries::{Prospects, Try, Verdict, cost, next_try};
use crate::cancel::Cancel;
use crate::mesh::{Hole, Mesh};
use crate::region::{BoxSize, LevelSurface, Region, Sphere, Start, VoxelSize};
use crate::sdf::Sampler;
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

/// The work on one region.
#[derive(Clone, Copy)]
pub(super) struct RegionWork<'a> {
    /// Its number, from 1.
    pub(super) id: usize,
    /// The mesh.
    pub(super) mesh: &'a Mesh,
    /// Its holes.
    pub(super) holes: &'a [&'a Hole],
    /// What of the mesh it knows: the pieces that its rims lie on.
    pub(super) known: &'a Sampler<'a>,
    /// All of the mesh, which patches must not cross.
    pub(super) all: &'a Sampler<'a>,
    /// The parameters.
    pub(super) params: &'a FillParams,
    /// The surface whose shape is kept, if any.
    pub(super) damaged: Option<&'a Damaged<'a>>,
    /// The bounding box of what was cut out there.
    pub(super) extent: Option<(DVec3, DVec3)>,
    /// Whether the run is to go on.
    pub(super) keep_going: &'a (dyn Fn() -> bool + Sync),
    /// The token that stops it, which inner loops read.
    pub(super) cancel: &'a Cancel,
}

/// Whether holes are one loop of so few edges that its triangulation needs no new vertices.
pub(super) fn is_trivial(holes: &[&Hole], params: &FillParams) -> bool {
    let stitched = params.surface == SurfaceKind::Stitched;
    stitched && holes.len() == 1 && holes[0].edges <= FEW_EDGES
}

/// The region of the first try.
pub(super) fn first_region(mesh: &Mesh, holes: &[&Hole], params: &FillParams) -> Region {
    let coarse = params.finishes();
    region(
        mesh,
        holes,
        params,
        &Try::first(params.energy),
        None,
        coarse,
    )
}

/// The lattice of a try; `extent` bounds the surface that it starts from, if any. It may be `coarse` where patches are finished
/// on their own triangles.
pub(super) fn region(
    mesh: &Mesh,
    holes: &[&Hole],
    params: &FillParams,
    next: &Try,
    extent: Option<(DVec3, DVec3)>,
    coarse: bool,
) -> Region {
    let sphere = || Some(Sphere::new(mesh, holes)?.bounds());
    let part = extent.or_else(|| (next.start == Start::Sphere).then(sphere).flatten());
    let size = |voxel| BoxSize {
        voxel,
        coarse,
        growth: next.growth,
        refine: next.refine,
    };
    let of = |voxel| Region::new(mesh, holes, &size(voxel), part);
    let region = of(params.voxel);
    let (part, most_across) = next.energy.needs().voxel;
    if part == 1.0 || params.voxel != VoxelSize::Auto {
        return region;
    }
    let finer = (part * region.voxel).max(region.diameter / most_across);
    of(VoxelSize::Length(finer.min(region.voxel)))
}

/// Whether a finer try is worth its time. The grid of a region with a small loop is as fine as it gets from the first; then another
/// start on it is only worth it where no triangulation of the rims is finished instead.
fn refines(mesh: &Mesh, holes: &[&Hole], params: &FillParams) -> bool {
    let first = Try::first(params.energy);
    let voxel = |t: &Try| region(mesh, holes, params, t, None, true).voxel;
    let is_finer = |finer: &Try| voxel(finer) < voxel(&first);
    let has_finer = || first.finer().as_ref().is_some_and(is_finer);
    params.voxel == VoxelSize::Auto && (!params.finishes() || has_finer())
}

impl RegionWork<'_> {
    /// Fills the region.
    pub(super) fn fill(&self) -> RegionPatch {
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
            start: match self.damaged {
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
            tube_end: self.damaged.is_none() && self.holes.iter().all(is_end),
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

/// Why the tries of a history failed.
pub(super) fn failures(history: &[(Try, Verdict)]) -> Vec<TryFailure> {
    let failure = |(_, verdict): &(Try, Verdict)| match verdict {
        Verdict::Failed(failure) => Some(failure.clone()),
        Verdict::Sound => None,
    };
    history.iter().filter_map(failure).collect()
}

/// The unconverged solution whose last update was smaller; the first of two alike.
fn nearer_steady<'a>(a: Option<Unsteady<'a>>, b: Option<Unsteady<'a>>) -> Option<Unsteady<'a>> {
    let movement = |u: &Unsteady| u.solved.movement();
    let both = [a, b].into_iter().flatten();
    both.min_by(|a, b| movement(a).total_cmp(&movement(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mend::Finish;
    use crate::mesh::shapes::{grid, punch};
    use crate::mesh::{Topology, find_holes};

    #[test]
    fn a_region_with_a_small_loop_has_no_finer_grid() {
        let sheet = grid(80, 80, [false, false], |u, v| DVec3::new(u, v, 0.0));
        let square = |c: DVec3, x: f64, half: f64| (c.x - x).abs().max((c.y - 0.5).abs()) < half;
        let mut mesh = punch(&sheet, |c| square(c, 0.3, 0.2) || square(c, 0.6, 0.026));
        let mut topology = Topology::new(&mut mesh);
        let (holes, _) = find_holes(&mesh, &mut topology);
        let inner: Vec<&Hole> = holes.iter().filter(|h| !h.outer_border).collect();
        let params = FillParams::default();
        assert_eq!(inner.len(), 2);
        assert!(refines(&mesh, &inner[..1], &params));
        assert!(!refines(&mesh, &inner, &params));
        let unfinished = FillParams {
            finish: Finish::None,
            ..params
        };
        assert!(refines(&mesh, &inner, &unfinished));
    }
}
