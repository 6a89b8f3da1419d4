//! The way of the data, from a mesh with holes to a mesh without.

mod attempt;
mod damaged;
mod error;
mod fair;
mod join;
mod opening;
mod plan;
mod progress;
mod restore;
mod sources;
pub mod volume;

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::{Hole, LARGEST, Mesh, OpenChain, SMALLEST, Topology, bounds, find_holes, welded};
use crate::params::{FillParams, SurfaceKind, VoxelSize};
use crate::region::{Region, group_holes};
use crate::report::{FillReport, HoleOutcome, HoleReport};
use attempt::{RegionPatch, Work};
use damaged::Damaged;
pub use error::{FillError, RestoreError};
pub use fair::{
    FairError, FairExtent, FairParams, FairPlan, FairReport, Faired, fair, fair_with_progress,
    plan_fair,
};
pub use plan::plan;
use progress::Watch;
pub use progress::{Event, Progress, Step};
pub use restore::{
    RestoreParams, RestorePlan, RestoreReport, Restored, plan_restore, restore,
    restore_with_progress,
};
use sources::Sources;

/// Loops of at most this many edges are triangulated without new vertices.
const TRIVIAL_EDGES: usize = 4;

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
    pub open_chains: Vec<OpenChain>,
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
    fill_with_progress(mesh, params, &|_| true)
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
    check_params(params)?;
    fill_found(mesh, &inspect(mesh)?, params, None, progress)
}

/// Fills the holes that were found in a mesh.
fn fill_found(
    mesh: &Mesh,
    found: &Inspection,
    params: &FillParams,
    damaged: Option<&Damaged>,
    progress: &Progress,
) -> Result<Filled, FillError> {
    let clock = Instant::now();
    let (mut outcomes, chosen) = choose(found, params)?;
    let groups = groups(found, &chosen, &mut outcomes, &bridges(found, params)?);
    check_voxel(found, &groups, params, damaged)?;
    let asked = |group: &[usize]| !attempt::is_trivial(found, params, group);
    let work = |group: &Vec<usize>| match asked(group) {
        true => attempt::expected_work(found, params, group),
        false => 0.0,
    };
    let watch = Watch::new(progress, groups.iter().map(work).collect());
    let patches = if groups.is_empty() {
        Vec::new()
    } else {
        fill_groups(found, params, damaged, &groups, &watch)
    };
    if watch.stopped() {
        return Err(FillError::Cancelled);
    }
    let mut report = FillReport {
        vertices: mesh.positions.len(),
        faces: mesh.faces.len(),
        pieces: found.topology.piece_faces.len(),
        defects: found.topology.defects,
        open_chains: found.open_chains.clone(),
        all_holes: params.holes.is_none(),
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
        .iter()
        .cloned()
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

/// The patches of all regions, each computed on its own.
fn fill_groups(
    found: &Inspection,
    params: &FillParams,
    damaged: Option<&Damaged>,
    groups: &[Vec<usize>],
    watch: &Watch,
) -> Vec<RegionPatch> {
    let asked = |group: &[usize]| !attempt::is_trivial(found, params, group);
    let sources = Sources::new(found, groups, &asked);
    let work = Work {
        found,
        sources: &sources,
        params,
        damaged,
        keep_going: &|| watch.keep_going(),
    };
    let fill = |(i, group): (usize, &Vec<usize>)| {
        let ids: Vec<usize> = group.iter().map(|&h| found.holes[h].id).collect();
        watch.begin(&ids);
        let patch = work.fill_region(i, group);
        watch.end(i, &patch.report);
        patch
    };
    groups.par_iter().enumerate().map(fill).collect()
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
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(FillError::NotFinite { vertex });
    }
    let size = |p: &DVec3| p.abs().max_element();
    if let Some(vertex) = mesh.positions.iter().position(|p| size(p) > LARGEST) {
        let size = size(&mesh.positions[vertex]);
        return Err(FillError::TooLarge { vertex, size });
    }
    let (low, high) = bounds(mesh.positions.iter().copied());
    let extent = (high - low).max_element();
    if 0.0 < extent && extent < SMALLEST {
        return Err(FillError::TooSmall { extent });
    }
    Ok(())
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
    let ratio = params.edge_ratio();
    if !(ratio.is_finite() && ratio > 0.05 && ratio < 20.0) {
        return bad("the edge ratio must lie between 0.05 and 20");
    }
    if params.time_step.is_some_and(|t| t.is_nan() || t <= 0.0) {
        return bad("the time step must be positive");
    }
    Ok(())
}

/// Refuses a voxel that is too small for the widest region. That of a fairing goes by the area, and is checked there.
fn check_voxel(
    found: &Inspection,
    groups: &[Vec<usize>],
    params: &FillParams,
    damaged: Option<&Damaged>,
) -> Result<(), FillError> {
    let VoxelSize::Length(voxel) = params.voxel else {
        return Ok(());
    };
    if damaged.is_some_and(|d| d.time().is_some()) {
        return Ok(());
    }
    let mut widest: f64 = 0.0;
    for group in groups
        .iter()
        .filter(|g| !attempt::is_trivial(found, params, g))
    {
        let part = damaged.and_then(|d| d.extent(group));
        let part = part.map_or(0.0, |(low, high)| (high - low).max_element());
        let holes = group.iter().map(|&h| found.holes[h].diameter);
        widest = holes.fold(widest.max(part), f64::max);
    }
    let fits = Region::finest(widest);
    if voxel < fits {
        return Err(FillError::TooFine { voxel, fits });
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
        } else if hole.outer_border && !is_small(found, i) && !facing[i] {
            Some(
                "the outer border of an open sheet, which is filled only when it is named"
                    .to_owned(),
            )
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
    let is_crumb = |h: usize| is_small(found, h);
    let is_trivial = |h: usize| found.holes[h].edges <= TRIVIAL_EDGES && !is_crumb(h);
    let (trivial, others): (Vec<usize>, Vec<usize>) = chosen.iter().partition(|&&h| is_trivial(h));
    let mut groups = group_holes(&found.mesh, &found.holes, &others, bridges, &is_crumb);
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

/// Whether a hole bounds a component of one or two triangles.
fn is_small(found: &Inspection, hole: usize) -> bool {
    found.topology.piece_faces[found.holes[hole].piece as usize] <= 2
}

/// Outer borders that face another rim: islands in holes, sides of a gap.
fn facing_borders(found: &Inspection) -> Vec<bool> {
    let mut facing = vec![false; found.holes.len()];
    if !found.holes.iter().any(|h| h.outer_border) {
        return facing;
    }
    let all: Vec<usize> = (0..found.holes.len()).collect();
    let groups = group_holes(&found.mesh, &found.holes, &all, &[], &|h| {
        is_small(found, h)
    });
    for group in groups.iter().filter(|group| group.len() > 1) {
        group.iter().for_each(|&h| facing[h] = true);
    }
    facing
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
