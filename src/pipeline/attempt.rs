//! One region: solve, extract, stitch, and what to try next where that fails.

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use super::damaged::Damaged;
use super::sources::Sources;
use super::{Inspection, TRIVIAL_EDGES};
use crate::extract::marching_cubes;
use crate::flow::{Energy, FlowSettings, Variant};
use crate::grid::{NodeIndex, dilate, offset};
use crate::mesh::{Hole, Mesh};
use crate::params::{FillParams, SurfaceKind, VoxelSize};
use crate::region::{
    Level, LevelSurface, MeshData, NestedSettings, Region, Solved, Start, solve_nested,
};
use crate::report::{ClosedBy, HoleOutcome, RegionReport};
use crate::sdf::Sampler;
use crate::stitch::{Patch, StitchError, close_seam};

/// Loops of at most this many edges are solved once only.
const SMALL_EDGES: usize = 16;
/// The voxel for the variation of curvature over the usual one, up to so many across.
const FINER: f64 = 0.4;
const MOST_FINER: f64 = 128.0;
/// Most tries at a region.
const MOST_TRIES: usize = 6;

/// The patch of a region: indices below the input's number of vertices are the input's.
pub(super) struct RegionPatch {
    pub(super) patch: Mesh,
    pub(super) report: RegionReport,
    pub(super) outcomes: Vec<(usize, HoleOutcome)>,
}

/// One try at a region.
#[derive(Clone, Copy)]
struct Try {
    /// Widens the box.
    growth: f64,
    /// Divides the voxel.
    refine: f64,
    start: Start,
    /// Take the surface though the flow is not steady.
    accept: bool,
    energy: Energy,
}

impl Default for Try {
    fn default() -> Self {
        Self {
            growth: 1.0,
            refine: 1.0,
            start: Start::Biharmonic,
            accept: false,
            energy: Energy::Willmore,
        }
    }
}

impl Try {
    /// What to try next if the voxel may be chosen: half the voxel from a triangulation of the rims, then a quarter.
    fn finer(&self, params: &FillParams) -> Option<Self> {
        if params.voxel != VoxelSize::Auto || self.refine >= 4.0 {
            return None;
        }
        Some(Self {
            refine: 2.0 * self.refine,
            start: Start::Triangulation,
            ..*self
        })
    }

    /// What to try after a patch could not be joined.
    fn after(&self, error: &StitchError, params: &FillParams) -> Option<Self> {
        match error {
            // The surface has run away: take it as it comes out of the first grid.
            StitchError::OpenBorder { .. } if self.refine > 1.0 => Some(Self {
                refine: 1.0,
                start: Start::Triangulation,
                accept: true,
                ..*self
            }),
            StitchError::TooManyFaces { .. } | StitchError::Folded { .. } => None,
            _ if self.accept => None,
            _ => self.finer(params),
        }
    }
}

pub(super) struct Work<'a> {
    pub(super) found: &'a Inspection,
    pub(super) sources: &'a Sources<'a>,
    pub(super) params: &'a FillParams,
    /// The surface whose shape is kept, if any.
    pub(super) damaged: Option<&'a Damaged<'a>>,
    /// Tells of progress; false when the caller asked to stop.
    pub(super) keep_going: &'a (dyn Fn() -> bool + Sync),
}

/// Whether a group is one loop of so few edges that its triangulation needs no new vertices.
pub(super) fn is_trivial(found: &Inspection, params: &FillParams, group: &[usize]) -> bool {
    group.len() == 1
        && found.holes[group[0]].edges <= TRIVIAL_EDGES
        && params.surface == SurfaceKind::Stitched
}

/// The region of the first try at a group.
pub(super) fn first_region(found: &Inspection, params: &FillParams, group: &[usize]) -> Region {
    let first = Try {
        energy: params.energy,
        ..Try::default()
    };
    region(found, params, group, &first, None)
}

/// About how much work a group is: the squares of voxels across its first grid.
pub(super) fn expected_work(found: &Inspection, params: &FillParams, group: &[usize]) -> f64 {
    let region = first_region(found, params, group);
    (region.diameter / region.voxel).powi(2)
}

/// The lattice of a try; `damaged` is the surface that it starts from, if any. Where the voxel may be chosen the variation of
/// curvature gets 0.4 of it: its surface is closer to smooth data than the band's width of the usual voxel lets it come out.
fn region(
    found: &Inspection,
    params: &FillParams,
    group: &[usize],
    next: &Try,
    damaged: Option<&Damaged>,
) -> Region {
    let part = damaged.and_then(|d| d.extent(group));
    let (mesh, holes) = (&found.mesh, &found.holes);
    let of = |voxel| Region::new(mesh, holes, group, voxel, next.growth, next.refine, part);
    let region = of(params.voxel);
    if next.energy == Energy::Willmore || params.voxel != VoxelSize::Auto {
        return region;
    }
    let finer = (FINER * region.voxel).max(region.diameter / MOST_FINER);
    of(VoxelSize::Length(finer.min(region.voxel)))
}

impl Work<'_> {
    pub(super) fn fill_region(&self, number: usize, group: &[usize]) -> RegionPatch {
        let clock = Instant::now();
        let mut filled = if is_trivial(self.found, self.params, group) {
            self.triangulate(
                group,
                "it has no more than four edges",
                RegionReport::default(),
            )
        } else if let Some(closed) = self.close_seam(group) {
            closed
        } else {
            self.evolve(group, self.sources.of(number))
        };
        filled.report.holes = group.iter().map(|&h| self.found.holes[h].id).collect();
        filled.report.bridge = self
            .params
            .bridge
            .iter()
            .any(|asked| asked.iter().any(|id| filled.report.holes.contains(id)));
        filled.report.seconds = clock.elapsed().as_secs_f64();
        filled
    }

    /// Solves and stitches, with a wider box or a finer grid where the first try fails.
    fn evolve(&self, group: &[usize], sampler: &Sampler) -> RegionPatch {
        let mut tries: Vec<String> = Vec::new();
        // A small rough hole is not worth a finer grid: its few edges say little about the surface.
        let small = group
            .iter()
            .all(|&h| self.found.holes[h].edges <= SMALL_EDGES);
        let first = Try {
            accept: small,
            start: match self.damaged {
                Some(_) => Start::Triangulation,
                None => Start::Biharmonic,
            },
            energy: self.params.energy,
            ..Try::default()
        };
        let mut next = Some(first);
        let mut robust = self.robust(&first);
        let mut most_tries = MOST_TRIES;
        let mut best: Option<(Patch, RegionReport)> = None;
        let mut last = RegionReport::default();
        let mut finest = 1.0;
        loop {
            let now = match next.take() {
                Some(now) => now,
                None if best.is_some() => break,
                None => {
                    let Some(again) = robust.take() else {
                        break;
                    };
                    most_tries = tries.len() + MOST_TRIES;
                    finest = again.refine;
                    again
                }
            };
            if !(self.keep_going)() || tries.len() >= most_tries {
                break;
            }
            finest = now.refine.max(finest);
            let begun = Instant::now();
            let (solved, region, data) = self.solve(group, sampler, &now);
            self.log_try(group, &now, &region, &solved, begun);
            let mut report = RegionReport {
                diameter: region.diameter,
                voxel: region.voxel,
                converged: solved.converged(),
                levels: solved.reports.clone(),
                earlier_tries: tries.clone(),
                other_energy: now.energy != self.params.energy,
                ..RegionReport::default()
            };
            if let Some((why, then)) = self.reconsider(&solved, &now) {
                tries.push(why);
                next = then;
                last = report;
                continue;
            }
            let surface = LevelSurface {
                level: &solved.level,
                data: &data,
            };
            let extracted = extract(&solved.level);
            if self.params.surface == SurfaceKind::Whole {
                report.closed_by = ClosedBy::LevelSet;
                report.new_faces = extracted.faces.len();
                report.new_vertices = extracted.positions.len();
                return self.all(group, extracted, report, HoleOutcome::Filled);
            }
            match self.stitch(group, &region, &surface, &extracted) {
                Ok(patch) => {
                    let crossing = patch.report.intersecting_faces;
                    let better = best
                        .as_ref()
                        .is_none_or(|b| crossing < b.0.report.intersecting_faces);
                    if better {
                        best = Some((patch, report));
                    }
                    if crossing > 0 {
                        tries.push(format!("{crossing} faces of the patch intersected others"));
                        next = now.finer(self.params).filter(|n| n.refine > finest);
                    }
                }
                Err(e) => {
                    last = report;
                    tries.push(e.to_string());
                    next = now.after(&e, self.params);
                }
            }
        }
        match best {
            Some((patch, report)) => self.accept(group, patch, report),
            None => {
                let why = tries.last().cloned().unwrap_or_default();
                last.earlier_tries = tries;
                self.triangulate(group, &why, last)
            }
        }
    }

    /// What to begin again with where the energy that is asked for finds no surface: Willmore's is the more robust.
    fn robust(&self, first: &Try) -> Option<Try> {
        (first.energy != Energy::Willmore).then_some(Try {
            energy: Energy::Willmore,
            ..*first
        })
    }

    fn log_try(
        &self,
        group: &[usize],
        now: &Try,
        region: &Region,
        solved: &Solved,
        begun: Instant,
    ) {
        let ids: Vec<usize> = group.iter().map(|&h| self.found.holes[h].id).collect();
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

    /// Whether a solve has to be done again, why and how.
    fn reconsider(&self, solved: &Solved, now: &Try) -> Option<(String, Option<Try>)> {
        let expected = self.params.variant == Variant::GaussNewton && self.params.steps.is_none();
        let lost = solved.lost() && expected;
        if solved.hopeless() && expected && (now.refine > 1.0 || now.accept) {
            return Some((
                "the data round it contradict each other; no steady surface was found".to_owned(),
                None,
            ));
        }
        if lost && now.refine == 1.0 && !now.accept {
            let why = "the flow did not become steady on this grid".to_owned();
            return now.finer(self.params).map(|finer| (why, Some(finer)));
        }
        if !lost && touches_box(&solved.level) && now.growth < 1.5 {
            let wider = Try {
                growth: 1.8 * now.growth,
                ..*now
            };
            return Some((
                "the surface reached the side of its box".to_owned(),
                Some(wider),
            ));
        }
        None
    }

    fn solve<'s>(
        &'s self,
        group: &[usize],
        sampler: &'s Sampler<'s>,
        next: &Try,
    ) -> (Solved, Region, MeshData<'s>) {
        let found = self.found;
        let region = region(found, self.params, group, next, self.damaged);
        let holes: Vec<&Hole> = group.iter().map(|&h| &found.holes[h]).collect();
        let closed = !found.holes.iter().enumerate().any(|(i, h)| {
            h.outer_border && !group.contains(&i) && holes.iter().any(|g| g.piece == h.piece)
        });
        let damaged = self.damaged;
        let data = MeshData::new(sampler, &found.mesh, &holes, closed)
            .keeping(damaged.map(|d| d.kept(region.diameter, region.voxel)));
        let settings = NestedSettings {
            lattice: region.lattice,
            dims: region.dims,
            refinements: region.refinements,
            start: next.start,
            stop_when_lost: next.refine == 1.0
                && !next.accept
                && self.params.voxel == VoxelSize::Auto,
            flow: self
                .flow_settings(next.energy)
                .across(region.diameter / region.voxel),
            time: damaged.and_then(Damaged::time),
        };
        let solved = solve_nested(&data, &settings, self.keep_going);
        (solved, region, data)
    }

    fn flow_settings(&self, energy: Energy) -> FlowSettings {
        let usual = FlowSettings::default();
        let most = match self.params.variant {
            Variant::GaussNewton => usual.max_steps,
            Variant::I | Variant::II => 200,
        };
        FlowSettings {
            energy,
            variant: self.params.variant,
            time_step: self.params.time_step.unwrap_or(f64::INFINITY),
            max_steps: self.params.steps.unwrap_or(most),
            ..usual
        }
    }

    fn accept(&self, group: &[usize], patch: Patch, mut report: RegionReport) -> RegionPatch {
        report.closed_by = ClosedBy::LevelSet;
        report.seam_angle_mean = Some(patch.report.seam_angle_mean);
        report.seam_angle_max = Some(patch.report.seam_angle_max);
        report.quality_mean = patch.report.quality_mean;
        report.intersecting_faces = patch.report.intersecting_faces;
        report.components = patch.report.components;
        report.new_vertices = patch.positions.len();
        report.new_faces = patch.faces.len();
        let mesh = Mesh::new(patch.positions, patch.faces);
        self.all(group, mesh, report, HoleOutcome::Filled)
    }

    fn all(
        &self,
        group: &[usize],
        patch: Mesh,
        report: RegionReport,
        outcome: HoleOutcome,
    ) -> RegionPatch {
        RegionPatch {
            patch,
            report,
            outcomes: group.iter().map(|&h| (h, outcome.clone())).collect(),
        }
    }

    /// Closes the gap between two rims that lie on each other.
    fn close_seam(&self, group: &[usize]) -> Option<RegionPatch> {
        let (&[a, b], SurfaceKind::Stitched) = (group, self.params.surface) else {
            return None;
        };
        let [a, b] = [a, b].map(|h| &self.found.holes[h]);
        let faces = close_seam(&self.found.mesh, &a.rim, &b.rim)?;
        let report = RegionReport {
            diameter: a.diameter,
            closed_by: ClosedBy::Seam,
            new_faces: faces.len(),
            components: 1,
            ..RegionReport::default()
        };
        let why = "it is one side of a seam, which was closed with thin triangles".to_owned();
        let patch = Mesh::new(Vec::new(), faces);
        Some(self.all(group, patch, report, HoleOutcome::Triangulated(why)))
    }
}

/// Whether the zero set, where it is free, comes to the end of the stored nodes.
fn touches_box(level: &Level) -> bool {
    let grid = &level.grid;
    (0..grid.len()).into_par_iter().any(|s| {
        let n = grid.node(s);
        level.mask[s]
            && level.phi[s].abs() < 1.0
            && (0..27).any(|i: i32| {
                let o = offset(i);
                let far = [n[0] + 5 * o[0], n[1] + 5 * o[1], n[2] + 5 * o[2]];
                let near = [n[0] + 2 * o[0], n[1] + 2 * o[1], n[2] + 2 * o[2]];
                grid.slot(near).is_none() || !grid.is_interior(far, 0)
            })
    })
}

/// The zero set on the cells near the mask, in world coordinates.
pub(super) fn extract(level: &Level) -> Mesh {
    let grid = &level.grid;
    let near = dilate(grid, &dilate(grid, &dilate(grid, &level.mask)));
    let corner = |n: NodeIndex, a: i32| {
        grid.slot([n[0] + (a >> 2 & 1), n[1] + (a >> 1 & 1), n[2] + (a & 1)])
    };
    let cells: Vec<NodeIndex> = (0..grid.len())
        .into_par_iter()
        .filter_map(|s| {
            let n = grid.node(s);
            let mut signs = [false; 2];
            for a in 0..8 {
                let t = corner(n, a)?;
                if !near[t] {
                    return None;
                }
                signs[usize::from(level.phi[t] < 0.0)] = true;
            }
            (signs[0] && signs[1]).then_some(n)
        })
        .collect();
    let iso = marching_cubes(&cells, |n| grid.slot(n).map_or(f64::MAX, |s| level.phi[s]));
    let positions: Vec<DVec3> = iso
        .positions
        .par_iter()
        .map(|&p| {
            let linear = level.lattice.to_world(p);
            match level.project(linear) {
                Some((q, _)) if q.distance(linear) < level.lattice.voxel => q,
                _ => linear,
            }
        })
        .collect();
    Mesh::new(positions, iso.faces)
}
