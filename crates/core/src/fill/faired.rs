//! Candidates: refined triangulations of the rims, faired biharmonically and finished. They need no level set.

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::candidate::{FinishReport, FinishedPatch, PatchInitialisation};
use super::closure::Closure;
use super::finish_step::Local;
use super::problem::RegionProblem;
use super::reasons::AttemptFailure;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::so_far::{Made, SoFar};
use crate::finish::{Refusal, Surroundings, biharmonic};
use crate::mesh::Hole;
use crate::stitch::{Patch, flipped, refined_triangulation};
use crate::tuning::{Tunable, tunable};

/// Edges. Rims with more edges get no faired triangulation: its time grows with the cube of their number, and the rim
/// alone seldom determines the shape of so wide a hole.
const MOST_FAIRED_EDGES: Tunable<usize> = tunable("fill.most_faired_edges", 400);

/// Rounds. A triangulation is faired and its edges are flipped this many times before it is faired for the last time.
const FAIRINGS: Tunable<usize> = tunable("fill.fairings", 2);

/// Fraction of the faces. Faired triangulations of several rims of which more intersect are not finished, since the finish
/// moves vertices little.
const MOST_CROSSING: Tunable<f64> = tunable("fill.most_crossing", 0.02);

/// Unknowns times steps, per square of a rim's number of edges. Expected cost of a faired triangulation, mostly of its
/// finish: 26 µs on 28 holes of scans and models.
const FAIRED_COST: Tunable<f64> = tunable("fill.faired_cost", 4.3);

/// Expected cost in unknowns times steps; infinite where a rim has too many edges.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    problem.holes.iter().map(|h| cost_of_rim(h.edges)).sum()
}

/// Expected cost for one rim with this number of edges.
pub(super) fn cost_of_rim(edges: usize) -> f64 {
    match edges <= MOST_FAIRED_EDGES.get() {
        true => FAIRED_COST.get() * (edges as f64).powi(2),
        false => f64::INFINITY,
    }
}

/// The faired triangulation of the only rim, finished.
pub(super) fn make(problem: &RegionProblem<'_>) -> Made {
    problem.faired().into()
}

/// Closes each rim of the region by its own faired triangulation.
pub(super) fn make_each(problem: &RegionProblem<'_>, so_far: &SoFar<'_>) -> Made {
    let (why, report) = so_far.without_level_set();
    let why = why.unwrap_or(AttemptFailure::Stopped);
    problem.each_faired(why, report).into()
}

/// Computes new positions of a patch's vertices from its triangles alone.
pub(super) type LinearFill = fn(&Surroundings<'_>, &[u32]) -> Result<Vec<(u32, DVec3)>, Refusal>;

/// Moves the patch's vertices to the positions that a linear fill computes; if it fails they stay.
fn fill(local: &mut Local, patch: &mut Patch, linear: LinearFill) {
    local.set_patch(&patch.positions, &patch.faces);
    let own = local.part.mesh.positions.len();
    let moved = linear(&local.around(), &local.new_vertices());
    for (v, p) in moved.into_iter().flatten() {
        patch.positions[v as usize - own] = p;
    }
    local.set_patch(&patch.positions, &patch.faces);
}

/// Adds a patch to another one; both number new vertices from `count` on.
pub(super) fn join(all: &mut Patch, one: &Patch, count: u32) {
    let base = all.positions.len() as u32;
    let moved = |v: u32| if v < count { v } else { v + base };
    all.positions.extend(&one.positions);
    all.faces.extend(one.faces.iter().map(|f| f.map(moved)));
}

impl RegionProblem<'_> {
    /// The faired and finished triangulation of the only rim; none where the region has several rims, or the triangulation fails.
    pub(super) fn faired(&self) -> Option<FinishedPatch> {
        let [hole] = self.holes else {
            return None;
        };
        if self.cancel.is_cancelled() || !self.is_finished() {
            return None;
        }
        let (local, patch) = self.spanned(hole, biharmonic)?;
        Some(self.finished_triangulation(local, patch))
    }

    fn finished_triangulation(&self, local: Local, patch: Patch) -> FinishedPatch {
        self.finished(local.to_whole(patch), PatchInitialisation::Triangulation)
    }

    /// The faired triangulation of each rim; none where one fails, or where many of their faces intersect: finishing them, which
    /// moves them little, would be in vain.
    fn spanned_each(&self) -> Option<Vec<(Local, Patch)>> {
        let is_too_long = |h: &&Hole| h.edges > MOST_FAIRED_EDGES.get();
        if self.cancel.is_cancelled() || !self.is_finished() || self.holes.iter().any(is_too_long) {
            return None;
        }
        let mut all = Patch::default();
        let mut spanned = Vec::new();
        let count = self.mesh.positions.len() as u32;
        for hole in self.holes {
            let one = RegionProblem {
                holes: &[*hole],
                ..*self
            };
            let (local, patch) = one.spanned(hole, biharmonic)?;
            join(&mut all, &local.to_whole(patch.clone()), count);
            spanned.push((local, patch));
        }
        let most = MOST_CROSSING.get() * all.faces.len() as f64;
        (self.count_intersecting(&all) as f64 <= most).then_some(spanned)
    }

    /// The faces of a patch of the whole mesh that intersect others.
    fn count_intersecting(&self, patch: &Patch) -> usize {
        let (count, part) = (self.mesh.positions.len(), self.wide_part(patch));
        Local::new(part, count, patch, self.cancel).count_intersecting(&patch.positions)
    }

    /// A refined triangulation of a rim, alternately faired and flipped. Its vertices are numbered as in the returned part of the
    /// mesh.
    pub(super) fn spanned(&self, hole: &Hole, linear: LinearFill) -> Option<(Local, Patch)> {
        (hole.edges <= MOST_FAIRED_EDGES.get()).then_some(())?;
        let (mut local, rim, mut patch) = self.refined(hole)?;
        for _ in 0..FAIRINGS.get() {
            fill(&mut local, &mut patch, linear);
            patch = flipped(&local.part.mesh, &rim, &patch);
        }
        fill(&mut local, &mut patch, linear);
        patch.report.intersecting_faces = local.count_intersecting(&patch.positions);
        Some((local, patch))
    }

    /// The part of the mesh around a hole, the hole's rim, and a refined triangulation of the rim, all in the part's numbers.
    fn refined(&self, hole: &Hole) -> Option<(Local, Vec<u32>, Patch)> {
        let part = self.wide_part(&Patch::default());
        let rim: Vec<u32> = hole.rim.iter().map(|&v| part.local(v)).collect();
        let patch = refined_triangulation(&part.mesh, &rim, self.params.edge_ratio()).ok()?;
        let count = self.mesh.positions.len();
        let shape = (&patch.positions[..], &patch.faces[..]);
        let local = Local::of_part(part, count, shape, self.cancel);
        Some((local, rim, patch))
    }

    /// Closes each hole by its own faired triangulation; none where one fails, or two rims touch.
    fn each_faired(&self, why: AttemptFailure, report: RegionReport) -> Option<RegionPatch> {
        // Rims that share a vertex cannot be filled separately: two patches could use the same edge.
        let mut seen = FxHashSet::default();
        if !self
            .holes
            .iter()
            .flat_map(|h| &h.rim)
            .all(|v| seen.insert(*v))
        {
            return None;
        }
        // One patch for the region. Its new vertices are numbered after the mesh's, hole by hole.
        let count = self.mesh.positions.len() as u32;
        let mut all = FinishedPatch::unfinished(Patch::default());
        let mut components = Vec::new();
        let (mut angles, mut shapes) = (0.0, 0.0);
        // If one hole fails, the whole region is left to other candidates.
        for (hole, (local, patch)) in self.holes.iter().zip(self.spanned_each()?) {
            let one = RegionProblem {
                holes: &[*hole],
                ..*self
            };
            let finished = one.finished_triangulation(local, patch);
            // Mean seam angles are weighted by rim edges, mean triangle quality by faces.
            let (own, sum) = (&finished.patch.report, &mut all.patch.report);
            sum.components += own.components;
            sum.seam_angle_max = sum.seam_angle_max.max(own.seam_angle_max);
            angles += own.seam_angle_mean * hole.edges as f64;
            shapes += own.quality_mean * finished.patch.faces.len() as f64;
            join(&mut all.patch, &finished.patch, count);
            all.expected_error.extend(finished.expected_error);
            components.extend(finished.report.into_iter().flat_map(|r| r.components));
        }
        let edges: usize = self.holes.iter().map(|h| h.edges).sum();
        all.patch.report.seam_angle_mean = angles / edges as f64;
        all.patch.report.quality_mean = shapes / all.patch.faces.len().max(1) as f64;
        all.report = Some(FinishReport {
            initialisation: PatchInitialisation::Triangulation,
            components,
        });
        // Self-intersections are counted for all patches together: they may intersect one another.
        all.patch.report.intersecting_faces = self.count_intersecting(&all.patch);
        Some(self.closed_by_fairing(all, Some(why), report))
    }

    /// The result of a region that was closed by faired triangulations, with the reason why its level sets failed; no reason
    /// where no level set was needed.
    pub(super) fn closed_by_fairing(
        &self,
        patch: FinishedPatch,
        why: Option<AttemptFailure>,
        mut report: RegionReport,
    ) -> RegionPatch {
        report.diameter = self.diameter();
        self.all_finished(patch, report, Closure::Faired(why))
    }
}
