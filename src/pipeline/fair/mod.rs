//! Fairing: a surface, or a marked region of it, evolves by Willmore flow for a time.

mod plan;

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use super::opening::Opening;
use super::restore::count;
use super::{FillError, Inspection, Progress, RestoreError, check_params, inspect};
use crate::flow::Variant;
use crate::mesh::Mesh;
use crate::mesh::cut::Remainder;
use crate::params::{FillParams, VoxelSize};
use crate::report::{FillReport, length};
use crate::spatial::Bvh;
use plan::Plan;

/// How far a surface is faired.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FairExtent {
    /// For a time of the Willmore flow, in length⁴.
    Time(f64),
    /// Until features narrower than this length are gone: waves of that length lose all but e⁻¹ of their height, those of
    /// half of it all but e⁻¹⁶.
    Strength(f64),
    /// Features narrower than eight mean edges.
    Auto,
}

/// Parameters of [`fair`].
#[derive(Clone, Debug, PartialEq)]
pub struct FairParams {
    /// How far.
    pub extent: FairExtent,
    /// Voxel size; `Auto` is an eighth of the features that go.
    pub voxel: VoxelSize,
    /// The scheme of the flow's steps.
    pub variant: Variant,
    /// Length of the new edges over that of the mesh's edges: those round a marked region, or the mean of all.
    pub edge_ratio: f64,
    /// Keeps vertices that no face uses any more, so that those of the input keep their numbers.
    pub keep_vertices: bool,
}

impl Default for FairParams {
    fn default() -> Self {
        let fill = FillParams::default();
        Self {
            extent: FairExtent::Auto,
            voxel: VoxelSize::Auto,
            variant: fill.variant,
            edge_ratio: 1.0,
            keep_vertices: false,
        }
    }
}

/// Why nothing could be faired.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FairError {
    /// The mesh, the mask or the parameters make no sense.
    #[error(transparent)]
    Restore(#[from] RestoreError),
    /// All faces are degenerate.
    #[error("all faces are degenerate; there is no surface to fair")]
    NoSurface,
    /// The model would need too many voxels.
    #[error(
        "a voxel of {} is too small for a surface of this area; the smallest that fits is about {fits:.4e}",
        length(*voxel)
    )]
    TooFine {
        /// The voxel asked for.
        voxel: f64,
        /// One that fits.
        fits: f64,
    },
    /// A length is larger than what is faired.
    #[error(
        "{what} of {} is too large for what is faired, whose diagonal is {diagonal:.4e}; the largest that makes sense is \
         about {fits:.4e}",
        length(*given)
    )]
    TooCoarse {
        /// Which length, such as `a voxel`.
        what: &'static str,
        /// The length.
        given: f64,
        /// The diagonal of what is faired.
        diagonal: f64,
        /// A length that fits.
        fits: f64,
    },
    /// There is no surface left.
    #[error("no surface is left after the flow; fair less, or take a smaller voxel")]
    Vanished,
    /// Nothing is left between the strips along the borders.
    #[error(
        "the mesh is open, and its borders are everywhere nearer than the strip of {strip:.4e} that stays as it is along \
         them; fair less (a smaller --strength), or fill its holes first"
    )]
    OnlyBorder {
        /// Width of the strip.
        strip: f64,
    },
    /// The flow came to no end.
    #[error(
        "the flow could not be continued beyond the time {reached:.3e} of {wanted:.3e}; fair less, or take a smaller voxel"
    )]
    Stuck {
        /// Time reached.
        reached: f64,
        /// Time wanted.
        wanted: f64,
    },
    /// What a region evolved to could not be joined to the rest.
    #[error(
        "the faired region at {x:.6}, {y:.6}, {z:.6} could not be joined to the rest: {why}; mark a smaller one, fair less, \
         or, if the mesh is open, fill its holes first"
    )]
    NotJoined {
        /// Where its rim is.
        x: f64,
        /// Where its rim is.
        y: f64,
        /// Where its rim is.
        z: f64,
        /// Why.
        why: String,
    },
    /// The surface could not be remeshed.
    #[error("the faired surface could not be meshed")]
    Mesh(#[from] crate::stitch::StitchError),
}

impl From<FillError> for FairError {
    fn from(error: FillError) -> Self {
        Self::Restore(RestoreError::Fill(error))
    }
}

/// What a fairing did.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FairReport {
    /// Features narrower than this went, in the mesh's units.
    pub strength: f64,
    /// Time of the flow, in length⁴.
    pub time: f64,
    /// Voxel size.
    pub voxel: f64,
    /// Whether all of the surface was replaced: nothing of the input is in the output.
    pub whole: bool,
    /// Faces that were to be faired.
    pub marked_faces: usize,
    /// Faces taken out.
    pub removed_faces: usize,
    /// Vertices that went with them.
    pub removed_vertices: usize,
    /// Closed pieces that were left as they are, since only the open ones can be faired between borders.
    pub pieces_left: usize,
    /// Volume of the input, where it is closed.
    pub volume_before: Option<f64>,
    /// Volume of the output, where it is closed.
    pub volume_after: Option<f64>,
    /// Largest distance of a new vertex from the surface that was there.
    pub moved_max: f64,
    /// Root mean square distance.
    pub moved_rms: f64,
    /// The regions. Holes are numbered as they are after the cut.
    #[serde(flatten)]
    pub fill: FillReport,
}

impl FairReport {
    /// The change of the volume, over the volume of the input.
    pub fn volume_drift(&self) -> Option<f64> {
        Some(self.volume_after? / self.volume_before? - 1.0)
    }
}

/// A mesh that was faired.
#[derive(Clone, Debug)]
pub struct Faired {
    /// The mesh: what is kept of the input's vertices and faces first, in order and bit-exact, then what is new.
    pub mesh: Mesh,
    /// What is kept of the input; none where the whole surface was replaced.
    pub kept: Option<Remainder>,
    /// What was done.
    pub report: FairReport,
}

/// Lets a surface evolve by Willmore flow: all of it, or the marked faces only.
///
/// A closed mesh without marks is replaced by the level set, remeshed. Marked faces are cut out and replaced by what they
/// evolve to, joined to the rest, whose position and normal are held. An open mesh without marks keeps a strip along its
/// borders.
///
/// # Errors
/// When the mesh, the marks or the parameters make no sense, or the flow does not reach its end.
pub fn fair(
    mesh: &Mesh,
    marked: Option<&[bool]>,
    params: &FairParams,
) -> Result<Faired, FairError> {
    fair_with_progress(mesh, marked, params, &|_| true)
}

/// [`fair`] with a callback that is told of progress and may stop it.
///
/// # Errors
/// As [`fair`], and [`FillError::Cancelled`] when the callback returned false.
pub fn fair_with_progress(
    mesh: &Mesh,
    marked: Option<&[bool]>,
    params: &FairParams,
    progress: &Progress,
) -> Result<Faired, FairError> {
    let clock = Instant::now();
    let (found, plan, target) = prepare(mesh, marked, params)?;
    let mut faired = match target {
        Target::Whole => plan.whole(mesh, &found, params, progress)?,
        Target::Part(marked, left) => {
            let mut faired = plan.part(mesh, &found, &marked, params, progress)?;
            faired.report.pieces_left = left;
            faired
        }
    };
    let report = &mut faired.report;
    (report.strength, report.time, report.voxel) = (plan.strength, plan.span.time, plan.voxel);
    report.volume_before = volume(&found);
    report.volume_after = inspect(&faired.mesh).ok().as_ref().and_then(volume);
    let kept = faired.kept.as_ref().map_or(0, |k| k.mesh.positions.len());
    (report.moved_max, report.moved_rms) = moved(&found, &faired.mesh.positions[kept..]);
    report.fill.seconds = clock.elapsed().as_secs_f64();
    Ok(faired)
}

/// What [`fair`] would do.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FairPlan {
    /// Features narrower than this would go, in the mesh's units.
    pub strength: f64,
    /// Time of the flow, in length⁴.
    pub time: f64,
    /// Voxel size.
    pub voxel: f64,
    /// Whether all of the surface would be replaced.
    pub whole: bool,
    /// Faces that would be faired.
    pub marked_faces: usize,
    /// Faces that would be taken out.
    pub removed_faces: usize,
    /// Closed pieces that would be left as they are.
    pub pieces_left: usize,
}

/// What [`fair`] would do, without doing it.
///
/// # Errors
/// As [`fair`], as far as they are known before the flow.
pub fn plan_fair(
    mesh: &Mesh,
    marked: Option<&[bool]>,
    params: &FairParams,
) -> Result<FairPlan, FairError> {
    let (found, plan, target) = prepare(mesh, marked, params)?;
    let mut out = FairPlan {
        strength: plan.strength,
        time: plan.span.time,
        voxel: plan.voxel,
        ..FairPlan::default()
    };
    match target {
        Target::Whole => {
            out.whole = true;
            (out.marked_faces, out.removed_faces) = (mesh.faces.len(), mesh.faces.len());
        }
        Target::Part(marked, left) => {
            let opening = Opening::new(mesh, &found, &marked, params.keep_vertices, false)?;
            out.pieces_left = left;
            (out.marked_faces, out.removed_faces) = (count(&marked), count(&opening.removed));
        }
    }
    Ok(out)
}

/// What of a mesh is faired.
enum Target {
    /// All of a closed one.
    Whole,
    /// Marked faces; beside them so many closed pieces stay.
    Part(Vec<bool>, usize),
}

fn prepare(
    mesh: &Mesh,
    marked: Option<&[bool]>,
    params: &FairParams,
) -> Result<(Inspection, Plan, Target), FairError> {
    let found = inspect(mesh)?;
    if let Some(marked) = marked {
        RestoreError::check_marks(mesh, marked)?;
    }
    let plan = Plan::new(&found, marked, params)?;
    check_params(&plan.fill_params(params))?;
    let target = match marked {
        Some(marked) => Target::Part(marked.to_vec(), 0),
        None if found.holes.is_empty() && found.open_chains.is_empty() => Target::Whole,
        None => {
            let (marked, left) = plan.between_borders(&found)?;
            Target::Part(marked, left)
        }
    };
    Ok((found, plan, target))
}

/// The volume inside a closed mesh.
fn volume(found: &Inspection) -> Option<f64> {
    if !found.holes.is_empty() || !found.open_chains.is_empty() {
        return None;
    }
    let mesh = &found.mesh;
    let centre = mesh.positions[mesh.faces[0][0] as usize];
    let six = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| mesh.positions[v as usize] - centre);
        a.dot(b.cross(c))
    };
    Some(mesh.faces.iter().map(six).sum::<f64>() / 6.0)
}

/// Largest and root mean square distance of points from a mesh.
fn moved(found: &Inspection, points: &[DVec3]) -> (f64, f64) {
    let bvh = Bvh::new(&found.mesh, found.topology.faces());
    let distances: Vec<f64> = points
        .par_iter()
        .map(|&p| bvh.closest(p, f64::INFINITY).map_or(0.0, |c| c.distance))
        .collect();
    let square: f64 = distances.iter().map(|d| d * d).sum();
    (
        distances.iter().copied().fold(0.0, f64::max),
        (square / distances.len().max(1) as f64).sqrt(),
    )
}
