//! Replacing a marked region: its faces are cut out, and what is missing then is filled.

use std::time::Instant;

use serde::Serialize;

use super::damaged::Damaged;
use super::opening::Opening;
use super::plan::plan_found;
use super::{FillError, Filled, Progress, RestoreError, check_params, fill_found, inspect};
use crate::mesh::Mesh;
use crate::mesh::cut::Remainder;
use crate::params::FillParams;
use crate::report::{FillReport, HoleOutcome, Plan, PlannedOutcome};

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
    restore_with_progress(mesh, marked, params, &|_| true)
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
    check(mesh, marked, params)?;
    let before = inspect(mesh)?;
    let opening = Opening::new(mesh, &before, marked, params.keep_vertices, true)?;
    let damaged = (params.keep_shape > 0.0).then(|| opening.damaged(params.keep_shape));
    let filled = fill_opening(mesh, &opening, &params.fill, damaged.as_ref(), progress)?;
    let mut fill = filled.report;
    fill.seconds = clock.elapsed().as_secs_f64();
    Ok(Restored {
        mesh: filled.mesh,
        report: RestoreReport {
            marked_faces: count(marked),
            removed_faces: count(&opening.removed),
            removed_vertices: mesh.positions.len() - opening.kept.mesh.positions.len(),
            keep_shape: params.keep_shape,
            fill,
        },
        kept: opening.kept,
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
    check(mesh, marked, params)?;
    let before = inspect(mesh)?;
    let opening = Opening::new(mesh, &before, marked, params.keep_vertices, true)?;
    let fill = plan_opening(mesh, &opening, &params.fill)?;
    Ok(RestorePlan {
        marked_faces: count(marked),
        removed_faces: count(&opening.removed),
        removed_vertices: mesh.positions.len() - opening.kept.mesh.positions.len(),
        fill,
    })
}

pub(super) fn count(marks: &[bool]) -> usize {
    marks.iter().filter(|m| **m).count()
}

fn check(mesh: &Mesh, marked: &[bool], params: &RestoreParams) -> Result<(), RestoreError> {
    check_params(&params.fill)?;
    if !(0.0..=1.0).contains(&params.keep_shape) {
        return Err(RestoreError::KeepShape(params.keep_shape));
    }
    RestoreError::check_marks(mesh, marked)
}

/// Fills what a cut left open; `mesh` is the one before it.
pub(super) fn fill_opening(
    mesh: &Mesh,
    opening: &Opening,
    params: &FillParams,
    damaged: Option<&Damaged>,
    progress: &Progress,
) -> Result<Filled, FillError> {
    let params = opening.params(params);
    let mut filled = fill_found(
        &opening.kept.mesh,
        &opening.found,
        &params,
        damaged,
        progress,
    )?;
    let report = &mut filled.report;
    (report.vertices, report.faces) = (mesh.positions.len(), mesh.faces.len());
    report.pieces = opening.before.topology.piece_faces.len();
    report.defects = opening.before.topology.defects;
    for hole in &mut report.holes {
        if let HoleOutcome::Left(why) = &mut hole.outcome {
            *why = NOT_MARKED.to_owned();
        }
    }
    for region in &mut report.regions {
        region.bridge = false;
    }
    Ok(filled)
}

/// What [`fill_opening`] would do; regions of the surface that was there are left out of account.
pub(super) fn plan_opening(
    mesh: &Mesh,
    opening: &Opening,
    params: &FillParams,
) -> Result<Plan, FillError> {
    let mut plan = plan_found(&opening.found, &opening.params(params))?;
    (plan.vertices, plan.faces) = (mesh.positions.len(), mesh.faces.len());
    plan.pieces = opening.before.topology.piece_faces.len();
    plan.defects = opening.before.topology.defects;
    for hole in &mut plan.holes {
        if let PlannedOutcome::Left(why) = &mut hole.outcome {
            *why = NOT_MARKED.to_owned();
        }
    }
    for region in &mut plan.regions {
        region.bridge = false;
    }
    Ok(plan)
}
