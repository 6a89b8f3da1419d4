//! Replacing a marked region: its faces are cut out, and what is missing then is filled.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::time::Instant;

use serde::Serialize;
use thiserror::Error;

use super::plan::plan_found;
use super::{FillError, Inspection, Progress, check_params, fill_found, inspect};
use crate::mesh::cut::{Remainder, settled};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{Mesh, weld_map};
use crate::params::{FillParams, SurfaceKind};
use crate::region::KeptShape;
use crate::report::{FillReport, HoleOutcome, Plan, PlannedOutcome};
use crate::sdf::{RimSet, Sampler};

/// Marked pieces of at most this many faces go without being replaced.
const CRUMB_FACES: usize = 2;

/// Why a hole is left.
const NOT_MARKED: &str = "not in the marked region";

/// Parameters of [`restore`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RestoreParams {
    /// The parameters of the fill. The mask decides which holes are filled and the result is always stitched, so the fields
    /// on these do not matter.
    pub fill: FillParams,
    /// From 0 to 1: how much of the damaged shape is kept. Features narrower than about (1 − W) / W times the diameter of
    /// the region go; 0 keeps nothing, 1 all that the grid can hold.
    pub keep_shape: f64,
    /// Keeps vertices that no face uses any more, so that those of the input keep their numbers.
    pub keep_vertices: bool,
}

/// Why nothing could be restored.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RestoreError {
    /// The mesh or the parameters of the fill make no sense.
    #[error(transparent)]
    Fill(#[from] FillError),
    /// There are not as many marks as faces.
    #[error("there are {marks} marks for {faces} faces; one for each is needed")]
    Marks {
        /// Number of marks.
        marks: usize,
        /// Number of faces.
        faces: usize,
    },
    /// No face is marked.
    #[error("the mask marks no face; `isomend inspect` with the same mask shows what it marks")]
    NothingMarked,
    /// Nothing of a piece is left to continue.
    #[error(
        "the mask covers the whole of a piece of {faces} faces, so that nothing is left to continue; mark less, or take the \
         piece away"
    )]
    WholePiece {
        /// Its faces.
        faces: usize,
    },
    /// The region is open to one side.
    #[error(
        "the mask reaches the outer border of an open sheet near {x:.6}, {y:.6}, {z:.6}, where there is nothing to continue; \
         leave a strip of faces along the border"
    )]
    Border {
        /// Where.
        x: f64,
        /// Where.
        y: f64,
        /// Where.
        z: f64,
    },
    /// The part of the shape to be kept is no such part.
    #[error("the part of the shape to keep must lie between 0 and 1, but is {0}")]
    KeepShape(f64),
}

/// What a restoration found and did.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RestoreReport {
    /// Faces that were marked.
    pub marked_faces: usize,
    /// Faces taken out: the marked ones, and those without which there would be no clean rim.
    pub removed_faces: usize,
    /// Vertices that went with them.
    pub removed_vertices: usize,
    /// The part of the shape that was to be kept.
    pub keep_shape: f64,
    /// The fill. Holes are numbered as they are after the cut.
    #[serde(flatten)]
    pub fill: FillReport,
}

/// What a restoration would do.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RestorePlan {
    /// Faces that are marked.
    pub marked_faces: usize,
    /// Faces that would be taken out.
    pub removed_faces: usize,
    /// Vertices that would go with them.
    pub removed_vertices: usize,
    /// What would be filled. Holes are numbered as they are after the cut.
    #[serde(flatten)]
    pub fill: Plan,
}

/// A mesh whose marked region was replaced.
#[derive(Clone, Debug)]
pub struct Restored {
    /// The mesh: what is kept of the input's vertices and faces first, in order and bit-exact, then the patches.
    pub mesh: Mesh,
    /// What is kept of the input, and which vertices and faces these are.
    pub kept: Remainder,
    /// What was found and done.
    pub report: RestoreReport,
}

/// Replaces the marked faces of a mesh by patches that continue what is round them.
///
/// Faces are cut out along edges. Holes inside the marked region or at its rim are filled with it; all others stay. Where
/// faces would hang together by a vertex only, the smaller side is cut out too, and so are crumbs left inside.
///
/// # Errors
/// When the mesh or the parameters make no sense, when nothing or the whole of a piece is marked, or when the marked
/// region reaches the outer border of an open sheet. A region that cannot be filled is no error: the report says so.
pub fn restore(
    mesh: &Mesh,
    marked: &[bool],
    params: &RestoreParams,
) -> Result<Restored, RestoreError> {
    restore_with_progress(mesh, marked, params, &|_, _| true)
}

/// [`restore`] with a callback that is told of progress and may stop it.
///
/// # Errors
/// As [`restore`], and [`FillError::Cancelled`] when the callback returned false.
pub fn restore_with_progress(
    mesh: &Mesh,
    marked: &[bool],
    params: &RestoreParams,
    progress: &Progress,
) -> Result<Restored, RestoreError> {
    let clock = Instant::now();
    let CutOut {
        before,
        removed,
        kept,
        found,
        fill,
    } = CutOut::new(mesh, marked, params)?;
    let damaged = (params.keep_shape > 0.0).then(|| Damaged::new(&before, params.keep_shape));
    let filled = fill_found(&kept.mesh, found, &fill, damaged.as_ref(), progress)?;
    let mut fill = filled.report;
    (fill.vertices, fill.faces) = (mesh.positions.len(), mesh.faces.len());
    fill.pieces = before.topology.piece_faces.len();
    fill.defects = before.topology.defects;
    fill.seconds = clock.elapsed().as_secs_f64();
    for hole in &mut fill.holes {
        if let HoleOutcome::Left(why) = &mut hole.outcome {
            *why = NOT_MARKED.to_owned();
        }
    }
    Ok(Restored {
        mesh: filled.mesh,
        report: RestoreReport {
            marked_faces: count(marked),
            removed_faces: count(&removed),
            removed_vertices: mesh.positions.len() - kept.mesh.positions.len(),
            keep_shape: params.keep_shape,
            fill,
        },
        kept,
    })
}

/// What [`restore`] would do, without doing it.
///
/// # Errors
/// As [`restore`].
pub fn plan_restore(
    mesh: &Mesh,
    marked: &[bool],
    params: &RestoreParams,
) -> Result<RestorePlan, RestoreError> {
    let cut = CutOut::new(mesh, marked, params)?;
    let mut fill = plan_found(&cut.found, &cut.fill)?;
    (fill.vertices, fill.faces) = (mesh.positions.len(), mesh.faces.len());
    fill.pieces = cut.before.topology.piece_faces.len();
    fill.defects = cut.before.topology.defects;
    for hole in &mut fill.holes {
        if let PlannedOutcome::Left(why) = &mut hole.outcome {
            *why = NOT_MARKED.to_owned();
        }
    }
    Ok(RestorePlan {
        marked_faces: count(marked),
        removed_faces: count(&cut.removed),
        removed_vertices: mesh.positions.len() - cut.kept.mesh.positions.len(),
        fill,
    })
}

fn count(marks: &[bool]) -> usize {
    marks.iter().filter(|m| **m).count()
}

/// A mesh with the marked region cut out, and how the rest is to be filled.
struct CutOut {
    before: Inspection,
    removed: Vec<bool>,
    kept: Remainder,
    found: Inspection,
    fill: FillParams,
}

impl CutOut {
    fn new(mesh: &Mesh, marked: &[bool], params: &RestoreParams) -> Result<Self, RestoreError> {
        check(mesh, marked, params)?;
        let before = inspect(mesh)?;
        let removed = settled(&before.mesh, &before.topology, marked);
        refuse_whole_pieces(&before, &removed)?;
        let kept = Remainder::new(mesh, &removed, params.keep_vertices);
        let found = inspect(&kept.mesh)?;
        let fill = FillParams {
            holes: Some(made(mesh, &before, &kept, &found)?),
            max_diameter: None,
            keep_open: Vec::new(),
            bridge: Vec::new(),
            surface: SurfaceKind::Stitched,
            ..params.fill.clone()
        };
        Ok(Self {
            before,
            removed,
            kept,
            found,
            fill,
        })
    }
}

fn check(mesh: &Mesh, marked: &[bool], params: &RestoreParams) -> Result<(), RestoreError> {
    check_params(&params.fill)?;
    if !(0.0..=1.0).contains(&params.keep_shape) {
        return Err(RestoreError::KeepShape(params.keep_shape));
    }
    if marked.len() != mesh.faces.len() {
        return Err(RestoreError::Marks {
            marks: marked.len(),
            faces: mesh.faces.len(),
        });
    }
    if !marked.contains(&true) {
        return Err(RestoreError::NothingMarked);
    }
    Ok(())
}

/// Pieces but crumbs must keep some faces.
fn refuse_whole_pieces(before: &Inspection, removed: &[bool]) -> Result<(), RestoreError> {
    let mut left = before.topology.piece_faces.clone();
    for (&piece, _) in before
        .topology
        .piece
        .iter()
        .zip(removed)
        .filter(|(_, r)| **r)
    {
        if piece != NONE {
            left[piece as usize] -= 1;
        }
    }
    let sizes = before.topology.piece_faces.iter().zip(&left);
    let whole = sizes.filter(|(all, left)| **left == 0 && **all > CRUMB_FACES);
    match whole.map(|(all, _)| *all).max() {
        Some(faces) => Err(RestoreError::WholePiece { faces }),
        None if left.iter().all(|l| *l == 0) => Err(RestoreError::WholePiece {
            faces: removed.len(),
        }),
        None => Ok(()),
    }
}

/// The numbers of the holes that the cut made or changed.
fn made(
    mesh: &Mesh,
    before: &Inspection,
    kept: &Remainder,
    found: &Inspection,
) -> Result<Vec<usize>, RestoreError> {
    let weld = weld_map(mesh);
    let origin: Vec<u32> = (0..weld.len())
        .filter(|&v| kept.vertices[v])
        .map(|v| weld[v])
        .collect();
    let key = |v: u32, w: u32| (v.min(w), v.max(w));
    let old: BTreeSet<(u32, u32)> = (0..before.topology.boundary.len() as u32)
        .filter(|&h| before.topology.boundary[h as usize])
        .map(|h| key(start(&before.mesh, h), end(&before.mesh, h)))
        .collect();
    let edges = |rim: &[u32]| -> Vec<(u32, u32)> {
        let next = rim.iter().cycle().skip(1);
        rim.iter().zip(next).map(|(v, w)| (*v, *w)).collect()
    };
    let outer: BTreeSet<(u32, u32)> = before
        .holes
        .iter()
        .filter(|h| h.outer_border)
        .flat_map(|h| edges(&h.rim))
        .map(|(v, w)| key(v, w))
        .collect();
    let mut ids = Vec::new();
    for hole in &found.holes {
        let rim = edges(&hole.rim).into_iter();
        let rim: Vec<(u32, u32)> = rim
            .map(|(v, w)| key(origin[v as usize], origin[w as usize]))
            .collect();
        if rim.iter().all(|e| old.contains(e)) {
            continue;
        }
        if let Some(edge) = rim.iter().find(|e| outer.contains(e)) {
            let p = mesh.positions[edge.0 as usize];
            return Err(RestoreError::Border {
                x: p.x,
                y: p.y,
                z: p.z,
            });
        }
        ids.push(hole.id);
    }
    Ok(ids)
}

/// The surface before the cut, where some of its shape is to be kept.
pub(super) struct Damaged<'a> {
    sampler: Sampler<'a>,
    rims: RimSet,
    part: f64,
}

impl<'a> Damaged<'a> {
    fn new(before: &'a Inspection, part: f64) -> Self {
        let closed = !before.holes.iter().any(|h| h.outer_border);
        Self {
            sampler: Sampler::new(&before.mesh, &before.topology),
            rims: RimSet::new(before.holes.iter(), closed),
            part,
        }
    }

    /// The pull to it in a region: ½ λ d² balances ½ h² at waves of the width below which features are to go.
    pub(super) fn kept(&self, diameter: f64, voxel: f64) -> KeptShape<'_> {
        let width = (diameter * (1.0 - self.part) / self.part).max(voxel);
        KeptShape {
            sampler: &self.sampler,
            rims: &self.rims,
            weight: (TAU / width).powi(4),
        }
    }
}
