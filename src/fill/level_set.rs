//! The level set of a region: its solve, and what its surface is good for.

use std::time::Instant;

use super::grids::Try;
use super::outcome::TryFailure;
use super::params::SurfaceKind;
use super::problem::{RegionProblem, region};
use super::reference::ReferenceSurface;
use super::report::RegionReport;
use crate::flow::{FlowSettings, Variant};
use crate::mesh::Mesh;
use crate::region::{
    Level, LevelSurface, MeshData, NestedSettings, Region, Solved, Sphere, Start, VoxelSize,
    solve_nested,
};
use crate::stitch::Patch;

/// A surface that is not steady is kept for want of a better one when the step that led to it moved it by less than this, in
/// voxels.
const NEARLY_STEADY: f64 = 1.0;
/// A surface that finds no rest within so many nodes of the side of its box may want a wider one.
const NEAR_SIDE: i32 = 9;
/// Before a finish the flow is steady enough when no node moves by more than this, in voxels: the finish goes on from there. On 143
/// holes of scans a tenth of it made patches no better, and took two steps more.
const BEFORE_FINISH: f64 = 0.2;
/// Most steps on a grid with the paper's variants, which converge linearly.
const MOST_STEPS: usize = 200;

/// What the solve of a level set came to.
pub(super) struct LevelSetResult<'a> {
    pub(super) failure: Option<TryFailure>,
    pub(super) report: RegionReport,
    /// The surface, where it was joined or is all that was asked for.
    pub(super) patch: Option<LevelSetSurface>,
    /// What it was extracted from, where it was not joined for want of rest.
    pub(super) unsteady: Option<Unsteady<'a>>,
}

/// A surface that is nearly steady.
pub(super) struct Unsteady<'a> {
    pub(super) solved: Solved,
    pub(super) region: Region,
    pub(super) data: MeshData<'a>,
    pub(super) report: RegionReport,
}

/// The surface of a level set.
pub(super) enum LevelSetSurface {
    /// A patch.
    Patch(Patch),
    /// The zero set by itself.
    Whole(Mesh),
}

impl RegionProblem<'_> {
    /// Solves a level set and joins its surface to the rims.
    pub(super) fn solve_and_join(&self, now: &Try, from: Option<&Level>) -> LevelSetResult<'_> {
        // Solves on nested grids, from the surface of an earlier attempt where there is one.
        let begun = Instant::now();
        let (solved, region, data) = self.solve(now, from);
        self.log_try(now, &region, &solved, begun);
        let report = RegionReport {
            diameter: region.diameter,
            voxel: Some(region.voxel),
            dims: Some(region.finest_dims()),
            converged: solved.converged(),
            levels: solved.reports.clone(),
            other_energy: now.energy != self.params.energy,
            ..RegionReport::default()
        };
        // An unusable surface may still initialise later attempts if its last update was small and it stays inside its box.
        if let Some(failure) = self.unusable(&solved, now) {
            let nearly = solved.movement() < NEARLY_STEADY && !solved.level.touches_box();
            let keep = nearly && self.params.surface == SurfaceKind::Stitched;
            return LevelSetResult {
                failure: Some(failure),
                report: report.clone(),
                patch: None,
                unsteady: keep.then_some(Unsteady {
                    solved,
                    region,
                    data,
                    report,
                }),
            };
        }
        // The zero set as it is, or cut to the hole and joined to the rims. A joined patch that intersects faces counts as
        // a failure, but is kept as a candidate.
        let (failure, patch) = {
            let surface = LevelSurface {
                level: &solved.level,
                data: &data,
            };
            let extracted = solved.level.zero_set();
            match self.params.surface {
                SurfaceKind::Whole => (None, Some(LevelSetSurface::Whole(extracted))),
                SurfaceKind::Stitched => match self.stitch(&region, &surface, &extracted) {
                    Ok(patch) => {
                        let failure = match patch.report.intersecting_faces {
                            0 => None,
                            faces => Some(TryFailure::Crossing(faces)),
                        };
                        (failure, Some(LevelSetSurface::Patch(patch)))
                    }
                    Err(error) => (Some(TryFailure::NotJoined(error)), None),
                },
            }
        };
        LevelSetResult {
            failure,
            report,
            patch,
            unsteady: None,
        }
    }

    /// Why the surface of a solve is of no use, while another try may find a better one.
    fn unusable(&self, solved: &Solved, now: &Try) -> Option<TryFailure> {
        let to_rest = self.params.variant == Variant::GaussNewton && self.params.steps.is_none();
        let lost = solved.is_far_from_steady() && to_rest;
        let may_grow = || now.may_widen() && solved.level.is_near_side(NEAR_SIDE);
        if solved.has_diverged() && to_rest {
            // None that came so far from rest has been known to find it on another grid, unless it was on its way to a sphere.
            let on_its_way = now.start != Start::Sphere
                && Sphere::new(self.mesh, self.holes).is_some()
                && may_grow();
            return Some(match on_its_way {
                true => TryFailure::ReachedBox,
                false => TryFailure::Contradiction,
            });
        }
        if lost && may_grow() {
            return Some(TryFailure::ReachedBox);
        }
        let may_refine = self.params.voxel == VoxelSize::Auto;
        if lost && now.refine == 1.0 && !now.accept {
            return may_refine.then_some(TryFailure::NotSteady);
        }
        let cramped = !lost && now.may_widen() && solved.level.touches_box();
        cramped.then_some(TryFailure::ReachedBox)
    }

    fn log_try(&self, now: &Try, region: &Region, solved: &Solved, begun: Instant) {
        let ids: Vec<usize> = self.holes.iter().map(|h| h.id.get()).collect();
        let levels: Vec<String> = solved
            .reports
            .iter()
            .map(|l| {
                let last = l.flow.movement;
                let (nodes, unknowns, steps) = (l.nodes, l.flow.unknowns, l.flow.steps.len());
                let [sampling, flow] = l.seconds;
                format!("{nodes} nodes, {unknowns} unknown, {steps} steps to {last:.1e}, {sampling:.2} + {flow:.2} s")
            })
            .collect();
        log::debug!(
            "holes {ids:?}, {:.0} voxels across, {:?} start, {:.2} s: {}",
            region.diameter / region.voxel,
            now.start,
            begun.elapsed().as_secs_f64(),
            levels.join("; ")
        );
    }

    fn solve(&self, next: &Try, from: Option<&Level>) -> (Solved, Region, MeshData<'_>) {
        let coarse = self.is_finished();
        let region = region(
            self.mesh,
            self.holes,
            self.params,
            next,
            self.extent,
            coarse,
        );
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
            give_up_early: next.refine == 1.0 && !next.accept && may_refine,
            flow: self
                .flow_settings(next)
                .across(region.diameter / region.voxel),
            time: self.reference.and_then(ReferenceSurface::time),
        };
        let solved = solve_nested(&data, &settings, self.keep_going);
        (solved, region, data)
    }

    fn flow_settings(&self, next: &Try) -> FlowSettings {
        let usual = FlowSettings::default();
        let most = match self.params.variant {
            Variant::GaussNewton => usual.max_steps,
            Variant::I | Variant::II => MOST_STEPS,
        };
        let (tolerance, rough) = match self.is_finished() {
            true => (BEFORE_FINISH, 1.0),
            false => (usual.tolerance, usual.rough),
        };
        FlowSettings {
            energy: next.energy,
            tolerance,
            rough,
            variant: self.params.variant,
            time_step: self.params.time_step.unwrap_or(f64::INFINITY),
            max_steps: self.params.steps.unwrap_or(most),
            ..usual
        }
    }
}
