//! The way of the data, from a mesh with holes to a mesh without.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;
use thiserror::Error;

use crate::extract::marching_cubes;
use crate::flow::{FlowSettings, Variant, dilate};
use crate::grid::NodeIndex;
use crate::mesh::{Hole, Mesh, Topology, find_holes, welded};
use crate::params::{FillParams, SurfaceKind, VoxelSize};
use crate::region::{
    Level, LevelSurface, MeshData, NestedSettings, Region, Solved, Start, group_holes, solve_nested,
};
use crate::report::{FillReport, HoleOutcome, HoleReport, RegionReport};
use crate::sdf::Sampler;
use crate::stitch::{
    Patch, StitchError, StitchInput, StitchParams, count_intersecting, stitch, triangulate_loop,
};

/// Loops of at most this many edges are triangulated without new vertices.
const TRIVIAL_EDGES: usize = 4;
/// Loops of at most this many edges are solved once only.
const SMALL_EDGES: usize = 16;
/// Most tries at a region.
const MOST_TRIES: usize = 6;

/// Why nothing could be filled.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FillError {
    /// The mesh has no faces.
    #[error("the mesh has no faces; there is nothing to fill")]
    Empty,
    /// A face refers to a vertex that is not there.
    #[error("face {face} refers to vertex {vertex}, but there are only {count} vertices")]
    Index {
        /// The face, from 0.
        face: usize,
        /// The vertex.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A position is not finite.
    #[error("vertex {vertex} has a coordinate that is not a finite number; repair the file first")]
    NotFinite {
        /// The vertex, from 0.
        vertex: usize,
    },
    /// A hole number that does not exist.
    #[error("there is no hole {id}; the mesh has {count} (`isomend inspect` lists them)")]
    NoSuchHole {
        /// The number asked for.
        id: usize,
        /// Number of holes.
        count: usize,
    },
    /// A parameter makes no sense.
    #[error("{what}")]
    Parameter {
        /// What is wrong and what would be right.
        what: String,
    },
    /// The caller asked to stop.
    #[error("stopped before it was done; nothing was written")]
    Cancelled,
}

/// Progress of a fill: regions done of all. It is called often, from several threads; return false to stop.
pub type Progress<'a> = dyn Fn(usize, usize) -> bool + Sync + 'a;

/// A filled mesh.
#[derive(Clone, Debug)]
pub struct Filled {
    /// The mesh: every vertex and face of the input first, in order and bit-exact, then the patches. With
    /// [`SurfaceKind::Whole`] the zero sets alone.
    pub mesh: Mesh,
    /// What was found and done.
    pub report: FillReport,
}

/// What a mesh holds, without changing it.
pub struct Inspection {
    /// Its holes, the longest first.
    pub holes: Vec<Hole>,
    /// The welded mesh with faces turned to agree.
    pub mesh: Mesh,
    /// Its connectivity.
    pub topology: Topology,
    /// Boundary chains that do not close.
    pub open_chains: usize,
}

/// Finds the pieces, holes and defects of a mesh.
///
/// # Errors
/// When the mesh is empty, an index is out of range or a coordinate is not finite.
pub fn inspect(mesh: &Mesh) -> Result<Inspection, FillError> {
    validate(mesh)?;
    let (mut mesh, duplicates) = welded(mesh);
    let mut topology = Topology::new(&mut mesh);
    topology.defects.duplicate_vertices = duplicates;
    let (holes, open_chains) = find_holes(&mesh, &mut topology);
    Ok(Inspection {
        holes,
        mesh,
        topology,
        open_chains,
    })
}

/// Fills the holes of a mesh.
///
/// # Errors
/// When the mesh or the parameters make no sense. A hole that cannot be filled is no error: the report says so.
pub fn fill(mesh: &Mesh, params: &FillParams) -> Result<Filled, FillError> {
    fill_with_progress(mesh, params, &|_, _| true)
}

/// [`fill`] with a callback that is told of progress and may stop it.
///
/// # Errors
/// As [`fill`], and [`FillError::Cancelled`] when the callback returned false.
pub fn fill_with_progress(
    mesh: &Mesh,
    params: &FillParams,
    progress: &Progress,
) -> Result<Filled, FillError> {
    let clock = Instant::now();
    check_params(params)?;
    let found = inspect(mesh)?;
    let (mut outcomes, chosen) = choose(&found, params)?;
    let sampler = Sampler::new(&found.mesh, &found.topology);
    let groups = groups(&found, &chosen, &mut outcomes, &bridges(&found, params)?);
    let stop = AtomicBool::new(false);
    let done = std::sync::atomic::AtomicUsize::new(0);
    let keep_going = || {
        if !progress(done.load(Ordering::Relaxed), groups.len()) {
            stop.store(true, Ordering::Relaxed);
        }
        !stop.load(Ordering::Relaxed)
    };
    keep_going();
    let work = Work {
        found: &found,
        sampler: &sampler,
        params,
        keep_going: &keep_going,
    };
    let patches: Vec<RegionPatch> = groups
        .par_iter()
        .map(|group| {
            let patch = work.fill_region(group);
            done.fetch_add(1, Ordering::Relaxed);
            keep_going();
            patch
        })
        .collect();
    if stop.load(Ordering::Relaxed) {
        return Err(FillError::Cancelled);
    }
    let mut report = FillReport {
        vertices: mesh.positions.len(),
        faces: mesh.faces.len(),
        pieces: found.topology.piece_faces.len(),
        defects: found.topology.defects,
        open_chains: found.open_chains,
        ..FillReport::default()
    };
    let mut out = match params.surface {
        SurfaceKind::Stitched => mesh.clone(),
        SurfaceKind::Whole => Mesh::default(),
    };
    let mut regions = vec![0; found.holes.len()];
    for (i, mut patch) in patches.into_iter().enumerate() {
        patch.report.id = i + 1;
        for (h, outcome) in patch.outcomes {
            outcomes[h] = outcome;
            regions[h] = i + 1;
        }
        append(&mut out, mesh.positions.len(), &patch.patch, params.surface);
        report.regions.push(patch.report);
    }
    report.holes = found
        .holes
        .into_iter()
        .zip(outcomes)
        .zip(regions)
        .map(|((hole, outcome), region)| HoleReport {
            hole,
            outcome,
            region,
        })
        .collect();
    report.seconds = clock.elapsed().as_secs_f64();
    Ok(Filled { mesh: out, report })
}

fn validate(mesh: &Mesh) -> Result<(), FillError> {
    if mesh.faces.is_empty() {
        return Err(FillError::Empty);
    }
    let count = mesh.positions.len();
    for (face, f) in mesh.faces.iter().enumerate() {
        if let Some(&vertex) = f.iter().find(|&&v| v as usize >= count) {
            return Err(FillError::Index {
                face,
                vertex,
                count,
            });
        }
    }
    match mesh.positions.iter().position(|p| !p.is_finite()) {
        Some(vertex) => Err(FillError::NotFinite { vertex }),
        None => Ok(()),
    }
}

fn check_params(params: &FillParams) -> Result<(), FillError> {
    let bad = |what: &str| {
        Err(FillError::Parameter {
            what: what.to_owned(),
        })
    };
    if let VoxelSize::Length(v) = params.voxel
        && !(v.is_finite() && v > 0.0)
    {
        return bad("the voxel size must be a positive length, or `auto`");
    }
    if !(params.edge_ratio.is_finite() && params.edge_ratio > 0.05 && params.edge_ratio < 20.0) {
        return bad("the edge ratio must lie between 0.05 and 20");
    }
    if params.time_step.is_some_and(|t| t.is_nan() || t <= 0.0) {
        return bad("the time step must be positive");
    }
    Ok(())
}

fn lookup(found: &Inspection, id: usize) -> Result<usize, FillError> {
    let count = found.holes.len();
    if id == 0 || id > count {
        return Err(FillError::NoSuchHole { id, count });
    }
    Ok(id - 1)
}

fn bridges(found: &Inspection, params: &FillParams) -> Result<Vec<Vec<usize>>, FillError> {
    params
        .bridge
        .iter()
        .map(|group| group.iter().map(|&id| lookup(found, id)).collect())
        .collect()
}

/// What becomes of each hole, and which are to be filled.
fn choose(
    found: &Inspection,
    params: &FillParams,
) -> Result<(Vec<HoleOutcome>, Vec<usize>), FillError> {
    let listed = |ids: &[usize]| -> Result<Vec<usize>, FillError> {
        ids.iter().map(|&id| lookup(found, id)).collect()
    };
    let asked = params.holes.as_deref().map(listed).transpose()?;
    let kept = listed(&params.keep_open)?;
    let bridged: Vec<usize> = bridges(found, params)?.concat();
    let facing = facing_borders(found);
    let (mut outcomes, mut chosen) = (Vec::new(), Vec::new());
    for (i, hole) in found.holes.iter().enumerate() {
        let wanted = asked.as_ref().is_some_and(|a| a.contains(&i)) || bridged.contains(&i);
        let reason = if kept.contains(&i) {
            Some("asked to keep it open".to_owned())
        } else if wanted {
            None
        } else if asked.is_some() {
            Some("not asked for".to_owned())
        } else if params.max_diameter.is_some_and(|d| hole.diameter > d) {
            Some("wider than the largest diameter asked for".to_owned())
        } else if hole.outer_border && !facing.contains(&i) {
            Some(format!(
                "the outer border of an open sheet (fill it with --holes {})",
                hole.id
            ))
        } else {
            None
        };
        outcomes.push(match reason {
            Some(reason) => HoleOutcome::Left(reason),
            None => {
                chosen.push(i);
                HoleOutcome::Failed("not reached".to_owned())
            }
        });
    }
    Ok((outcomes, chosen))
}

/// Groups of holes for the regions. Trivial holes stand alone; crumbs go with the hole they lie in, or are left.
fn groups(
    found: &Inspection,
    chosen: &[usize],
    outcomes: &mut [HoleOutcome],
    bridges: &[Vec<usize>],
) -> Vec<Vec<usize>> {
    let is_crumb = |h: usize| found.topology.piece_faces[found.holes[h].piece as usize] <= 2;
    let is_trivial = |h: usize| found.holes[h].edges <= TRIVIAL_EDGES && !is_crumb(h);
    let (trivial, others): (Vec<usize>, Vec<usize>) = chosen.iter().partition(|&&h| is_trivial(h));
    let mut groups = group_holes(&found.mesh, &found.holes, &others, bridges);
    groups.retain(|group| {
        let crumbs_only = group.iter().all(|&h| is_crumb(h));
        if crumbs_only {
            for &h in group {
                outcomes[h] =
                    HoleOutcome::Left("the border of a crumb of one or two triangles".to_owned());
            }
        }
        !crumbs_only
    });
    groups.extend(trivial.into_iter().map(|h| vec![h]));
    groups
}

/// Outer borders that face another rim: islands in holes, sides of a gap.
fn facing_borders(found: &Inspection) -> Vec<usize> {
    let all: Vec<usize> = (0..found.holes.len()).collect();
    if !found.holes.iter().any(|h| h.outer_border) {
        return Vec::new();
    }
    group_holes(&found.mesh, &found.holes, &all, &[])
        .into_iter()
        .filter(|g| g.len() > 1)
        .flatten()
        .collect()
}

fn append(out: &mut Mesh, original: usize, patch: &Mesh, kind: SurfaceKind) {
    let base = out.positions.len();
    let shift = match kind {
        SurfaceKind::Stitched => original,
        SurfaceKind::Whole => 0,
    };
    out.positions.extend_from_slice(&patch.positions);
    out.faces.extend(patch.faces.iter().map(|f| {
        f.map(|v| {
            if (v as usize) < shift {
                v
            } else {
                (v as usize - shift + base) as u32
            }
        })
    }));
}

/// The patch of a region: indices below the input's number of vertices are the input's.
struct RegionPatch {
    patch: Mesh,
    report: RegionReport,
    outcomes: Vec<(usize, HoleOutcome)>,
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
}

impl Default for Try {
    fn default() -> Self {
        Self {
            growth: 1.0,
            refine: 1.0,
            start: Start::Biharmonic,
            accept: false,
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
            _ if self.accept => None,
            _ => self.finer(params),
        }
    }
}

struct Work<'a> {
    found: &'a Inspection,
    sampler: &'a Sampler<'a>,
    params: &'a FillParams,
    /// Tells of progress; false when the caller asked to stop.
    keep_going: &'a (dyn Fn() -> bool + Sync),
}

impl Work<'_> {
    fn fill_region(&self, group: &[usize]) -> RegionPatch {
        let clock = Instant::now();
        let mut filled = if self.is_trivial(group) {
            self.triangulate(
                group,
                "it has no more than four edges",
                RegionReport::default(),
            )
        } else {
            self.evolve(group)
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

    fn is_trivial(&self, group: &[usize]) -> bool {
        group.len() == 1
            && self.found.holes[group[0]].edges <= TRIVIAL_EDGES
            && self.params.surface == SurfaceKind::Stitched
    }

    /// Solves and stitches, with a wider box or a finer grid where the first try fails.
    fn evolve(&self, group: &[usize]) -> RegionPatch {
        let mut tries: Vec<String> = Vec::new();
        // A small rough hole is not worth a finer grid: its few edges say little about the surface.
        let small = group
            .iter()
            .all(|&h| self.found.holes[h].edges <= SMALL_EDGES);
        let mut next = Some(Try {
            accept: small,
            ..Try::default()
        });
        let mut best: Option<(Patch, RegionReport)> = None;
        let mut last = RegionReport::default();
        while let Some(now) = next.take() {
            if !(self.keep_going)() || tries.len() >= MOST_TRIES {
                break;
            }
            let (solved, region, data) = self.solve(group, &now);
            let mut report = RegionReport {
                diameter: region.diameter,
                voxel: region.voxel,
                converged: solved.converged(),
                levels: solved.reports.clone(),
                earlier_tries: tries.clone(),
                ..RegionReport::default()
            };
            if let Some((why, then)) = self.reconsider(&solved, &now) {
                tries.push(why);
                next = Some(then);
                last = report;
                continue;
            }
            let surface = LevelSurface {
                level: &solved.level,
                data: &data,
            };
            let extracted = extract(&surface);
            if self.params.surface == SurfaceKind::Whole {
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
                        next = now.finer(self.params);
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

    /// Whether a solve has to be done again, why and how.
    fn reconsider(&self, solved: &Solved, now: &Try) -> Option<(String, Try)> {
        let expected = self.params.variant == Variant::GaussNewton && self.params.steps.is_none();
        let lost = solved.lost() && expected;
        if lost && now.refine == 1.0 && !now.accept {
            let why = "the flow did not become steady on this grid".to_owned();
            return now.finer(self.params).map(|finer| (why, finer));
        }
        if !lost && touches_box(&solved.level) && now.growth < 1.5 {
            let wider = Try {
                growth: 1.8 * now.growth,
                ..*now
            };
            return Some(("the surface reached the side of its box".to_owned(), wider));
        }
        None
    }

    fn solve(&self, group: &[usize], next: &Try) -> (Solved, Region, MeshData<'_>) {
        let found = self.found;
        let region = Region::new(
            &found.mesh,
            &found.holes,
            group,
            self.params.voxel,
            next.growth,
            next.refine,
        );
        let holes: Vec<&Hole> = group.iter().map(|&h| &found.holes[h]).collect();
        let closed = !found.holes.iter().enumerate().any(|(i, h)| {
            h.outer_border && !group.contains(&i) && holes.iter().any(|g| g.piece == h.piece)
        });
        let data = MeshData::new(self.sampler, &found.mesh, &holes, closed);
        let settings = NestedSettings {
            lattice: region.lattice,
            dims: region.dims,
            refinements: region.refinements,
            start: next.start,
            stop_when_lost: next.refine == 1.0
                && !next.accept
                && self.params.voxel == VoxelSize::Auto,
            flow: self.flow_settings(),
        };
        let solved = solve_nested(&data, &settings, self.keep_going);
        (solved, region, data)
    }

    fn flow_settings(&self) -> FlowSettings {
        let usual = FlowSettings::default();
        let most = match self.params.variant {
            Variant::GaussNewton => usual.max_steps,
            Variant::I | Variant::II => 200,
        };
        FlowSettings {
            variant: self.params.variant,
            time_step: self.params.time_step.unwrap_or(f64::INFINITY),
            max_steps: self.params.steps.unwrap_or(most),
            ..usual
        }
    }

    fn stitch(
        &self,
        group: &[usize],
        region: &Region,
        surface: &LevelSurface,
        extracted: &Mesh,
    ) -> Result<Patch, StitchError> {
        let loops: Vec<Vec<u32>> = group
            .iter()
            .map(|&h| self.found.holes[h].rim.clone())
            .collect();
        stitch(&StitchInput {
            mesh: &self.found.mesh,
            loops: &loops,
            surface,
            extracted,
            voxel: region.voxel,
            params: StitchParams {
                edge_factor: self.params.edge_ratio,
                ..StitchParams::default()
            },
        })
    }

    fn accept(&self, group: &[usize], patch: Patch, mut report: RegionReport) -> RegionPatch {
        report.seam_angle_mean = patch.report.seam_angle_mean;
        report.seam_angle_max = patch.report.seam_angle_max;
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

    /// Triangulates each loop on its own.
    fn triangulate(&self, group: &[usize], why: &str, mut report: RegionReport) -> RegionPatch {
        let mut patch = Mesh::default();
        let mut outcomes = Vec::new();
        for &h in group {
            let hole = &self.found.holes[h];
            report.diameter = report.diameter.max(hole.diameter);
            let outcome = match triangulate_loop(&self.found.mesh, &hole.rim) {
                Ok(faces) => {
                    patch.faces.extend(faces);
                    HoleOutcome::Triangulated(why.to_owned())
                }
                Err(e) => HoleOutcome::Failed(format!("{why}; {e}")),
            };
            outcomes.push((h, outcome));
        }
        report.new_faces = patch.faces.len();
        report.intersecting_faces = count_intersecting(&self.found.mesh, &[], &patch.faces);
        report.components = outcomes.len();
        RegionPatch {
            patch,
            report,
            outcomes,
        }
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
                let o = [i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1];
                let far = [n[0] + 5 * o[0], n[1] + 5 * o[1], n[2] + 5 * o[2]];
                let near = [n[0] + 2 * o[0], n[1] + 2 * o[1], n[2] + 2 * o[2]];
                grid.slot(near).is_none() || !grid.is_interior(far, 0)
            })
    })
}

/// The zero set on the cells near the mask, in world coordinates.
fn extract(surface: &LevelSurface) -> Mesh {
    let level = surface.level;
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
            match crate::stitch::Surface::project(surface, linear) {
                Some((q, _)) if q.distance(linear) < level.lattice.voxel => q,
                _ => linear,
            }
        })
        .collect();
    Mesh::new(positions, iso.faces)
}
