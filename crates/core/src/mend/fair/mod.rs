//! Fairing: smooths a surface, or a marked region of it, by Willmore flow over a given time.

mod plan;

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;
use thiserror::Error;

use super::control::Control;
use super::cut::{CutResult, count};
use super::params::FairParams;
use super::plan::FairPlan;
use super::report::{FairReport, FillReport};
use super::{FillError, Inspection, RestoreError, inspect};
use crate::fill::NotSmooth;
use crate::mesh::cut::Remainder;
use crate::mesh::{Mesh, at_least, bounds, length};
use crate::spatial::Bvh;
use crate::stitch::StitchError;
use crate::threads::CollectIndexed;
use plan::Plan;

/// Cubes of the bounding box's diagonal. A closed mesh that encloses less has no volume beside rounding errors.
const LEAST_INSIDE: f64 = 1e-9;

/// Mean lengths of the longest edges. In longer faces distances are measured inside too.
const LONG_FACE: f64 = 2.0;

/// Parts of a long face's edges, at most, at whose ends distances are measured.
const MOST_PARTS: usize = 32;

/// Part of the input's volume. Lower bound of the volume after a fairing: the flow rounds a closed surface and keeps spheres, so that
/// less is left only where parts vanish.
const LEAST_VOLUME: f64 = 0.2;

/// Why a fairing was refused or failed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FairError {
    /// The mesh, the mask or the parameters are invalid, or the run was stopped.
    #[error(transparent)]
    Restore(#[from] RestoreError),
    /// All faces are degenerate.
    #[error("all faces are degenerate; there is no surface to fair")]
    NoSurface,
    /// The voxel needs too many voxels.
    #[error(
        "a voxel of {} is too small for a surface of this area; the smallest that fits is about {}",
        length(*voxel),
        at_least(*fits)
    )]
    TooFine {
        /// The voxel asked for.
        voxel: f64,
        /// A voxel that fits.
        fits: f64,
    },
    /// The features to remove are narrower than the mesh and its grid resolve.
    #[error(
        "a strength of {} is too small: a grid for features of this width would be finer than the mesh, or take more than about a \
         minute; the smallest strength for this surface is about {}. Use at least that, mark a smaller region, or give a \
         voxel size",
        length(*strength),
        at_least(*fits)
    )]
    TooWeak {
        /// The requested strength, or the strength that corresponds to the requested time.
        strength: f64,
        /// The smallest possible strength.
        fits: f64,
    },
    /// A length exceeds the faired surface.
    #[error(
        "{what} of {} is too large for a surface with a diagonal of {}; the largest useful value is about {}",
        length(*given),
        length(*diagonal),
        length(*fits)
    )]
    TooCoarse {
        /// The name of the length, such as `a voxel`.
        what: &'static str,
        /// Its value.
        given: f64,
        /// The diagonal of the faired surface's bounding box.
        diagonal: f64,
        /// A value that fits.
        fits: f64,
    },
    /// No surface is left.
    #[error(
        "no surface is left after the flow; reduce the strength or the time, or use a smaller voxel"
    )]
    Vanished,
    /// Most of the volume is lost.
    #[error(
        "only {:.1} % of the volume is left after the flow: the model is narrower than the strength; reduce the strength or the time, \
         or use a smaller voxel",
        100.0 * part
    )]
    Collapsed {
        /// The part of the volume that is left.
        part: f64,
    },
    /// No face is left between the strips along the borders.
    #[error(
        "the mesh is open, and all of it is within {} of a border, a strip that stays unchanged; reduce the strength or the \
         time, or fill the holes first",
        length(*strip)
    )]
    OnlyBorder {
        /// Width of the strips.
        strip: f64,
    },
    /// The flow did not reach its end.
    #[error(
        "the flow stopped at the time {} of {}; reduce the strength or the time, or use a smaller voxel",
        length(*reached),
        length(*wanted)
    )]
    Stuck {
        /// Time reached, in length⁴.
        reached: f64,
        /// Time requested, in length⁴.
        wanted: f64,
    },
    /// An evolved region could not be joined to the rest.
    #[error(
        "the faired region at {x:.6}, {y:.6}, {z:.6} could not be joined to the rest: {why}; mark a smaller region, reduce the \
         strength or the time, or, if the mesh is open, fill its holes first"
    )]
    NotJoined {
        /// x coordinate of the centre of its rim.
        x: f64,
        /// y coordinate of the centre of its rim.
        y: f64,
        /// z coordinate of the centre of its rim.
        z: f64,
        /// Why.
        why: Box<NotSmooth>,
    },
    /// The mesh does not bound a solid, so that its signed distance is undefined.
    #[error(
        "the mesh has no inside and outside near {x:.6}, {y:.6}, {z:.6}: an edge there has more than two faces, or the surface is \
         one-sided; repair the mesh first"
    )]
    NoSides {
        /// x coordinate of a place where the faired surface ends.
        x: f64,
        /// y coordinate of the place.
        y: f64,
        /// z coordinate of the place.
        z: f64,
    },
    /// The evolved surface could not be remeshed.
    #[error("the faired surface could not be meshed: {0}")]
    Mesh(StitchError),
}

impl FairError {
    /// Whether the reason lies in the surface that was to be faired. Other objects of the same file can be faired then.
    pub fn is_of_surface(&self) -> bool {
        match self {
            Self::Restore(error) => matches!(
                error,
                RestoreError::WholeComponent { .. }
                    | RestoreError::Border { .. }
                    | RestoreError::OpenRim { .. }
            ),
            // The voxel was given for all objects.
            Self::TooFine { .. } => false,
            _ => true,
        }
    }
}

impl From<StitchError> for FairError {
    fn from(error: StitchError) -> Self {
        match error {
            StitchError::NotManifold { position } => {
                let [x, y, z] = position.to_array();
                Self::NoSides { x, y, z }
            }
            error => Self::Mesh(error),
        }
    }
}

impl From<FillError> for FairError {
    fn from(error: FillError) -> Self {
        Self::Restore(RestoreError::Fill(error))
    }
}

/// A faired mesh.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Faired {
    /// The mesh: the kept vertices and faces of the input first, in order and bit-exact, then the new ones.
    pub mesh: Mesh,
    /// The kept part of the input; none where the whole surface was replaced.
    pub kept: Option<Remainder>,
    /// Report of the fairing.
    pub report: FairReport,
    /// Report of the regions. Holes are numbered as after the cut.
    pub fill: FillReport,
}

impl Inspection<'_> {
    /// Smooths the surface by Willmore flow: all of it, or only the marked faces.
    ///
    /// A closed mesh without marks is replaced by its remeshed level set. Marked faces are cut out, evolve, and are joined to the
    /// rest again, whose position and normal are held fixed. An open mesh without marks keeps a strip along its borders.
    ///
    /// # Errors
    /// If the marks or the parameters are invalid, or the flow does not reach its end; [`FillError::Cancelled`].
    pub fn fair(
        &self,
        marked: Option<&[bool]>,
        params: &FairParams,
        control: &Control,
    ) -> Result<Faired, FairError> {
        control.install(|| {
            let clock = Instant::now();
            let (plan, target) = prepare(self, marked, params)?;
            let mut faired = match target {
                Target::Whole => plan.whole(self, params, control)?,
                Target::Part(marked, left) => {
                    let mut faired = plan.part(self, &marked, params, control)?;
                    faired.report.components_left = left;
                    faired
                }
            };
            let report = &mut faired.report;
            (report.strength, report.time, report.voxel) =
                (plan.strength, plan.span.time, plan.voxel);
            report.volume_before = volume(self);
            let after = inspect(&faired.mesh)?;
            report.volume_after = volume(&after);
            refuse_collapse(report)?;
            let both = [self, &after].map(|s| Bvh::new(&s.mesh, s.topology.faces()));
            let distances = moved([self, &after], &both, faired.kept.as_ref());
            report.moved_points = distances.len();
            let within = moved_within([self, &after], &both, faired.kept.as_ref());
            report.moved_max = distances.iter().copied().fold(within, f64::max);
            let square: f64 = distances.iter().map(|d| d * d).sum();
            report.moved_rms = (square / distances.len().max(1) as f64).sqrt();
            faired.fill.seconds = clock.elapsed().as_secs_f64();
            Ok(faired)
        })
    }

    /// Plans a fairing.
    ///
    /// # Errors
    /// As [`Inspection::fair`], as far as they are known before the flow.
    pub fn plan_fair(
        &self,
        marked: Option<&[bool]>,
        params: &FairParams,
    ) -> Result<FairPlan, FairError> {
        let (plan, target) = prepare(self, marked, params)?;
        let mut out = FairPlan {
            strength: plan.strength,
            time: plan.span.time,
            voxel: plan.voxel,
            whole: true,
            marked_faces: self.input.faces.len(),
            removed_faces: self.input.faces.len(),
            removed_vertices: self.input.positions.len(),
            components_left: 0,
            kept_objects: Vec::new(),
        };
        if let Target::Part(marked, left) = target {
            let cut = CutResult::new(self, &marked, params.keep_vertices, false)?;
            out.whole = false;
            out.marked_faces = count(&marked);
            [out.removed_faces, out.removed_vertices] = cut.removed_counts();
            out.components_left = left;
        }
        Ok(out)
    }
}

impl FairReport {
    /// Records that the whole surface is replaced.
    fn take_all(&mut self, found: &Inspection) {
        let faces = found.input.faces.len();
        self.whole = true;
        (self.marked_faces, self.removed_faces) = (faces, faces);
        self.removed_vertices = found.input.positions.len();
    }
}

/// The part of a mesh that is faired.
enum Target {
    /// All of a closed mesh.
    Whole,
    /// The marked faces, and the number of closed components that stay unchanged.
    Part(Vec<bool>, usize),
}

fn prepare(
    found: &Inspection,
    marked: Option<&[bool]>,
    params: &FairParams,
) -> Result<(Plan, Target), FairError> {
    if let Some(marked) = marked {
        RestoreError::check_marks(&found.input, marked)?;
    }
    params.check()?;
    let plan = Plan::new(found, marked, params)?;
    let target = match marked {
        Some(marked) => Target::Part(marked.to_vec(), 0),
        None if found.holes.is_empty() && found.open_chains.is_empty() => Target::Whole,
        None => {
            let (marked, left) = plan.between_borders(found)?;
            Target::Part(marked, left)
        }
    };
    Ok((plan, target))
}

/// The volume enclosed by a closed mesh: the sum of the signed volumes of the tetrahedra between its faces and one of its
/// vertices.
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
    let volume = mesh.faces.iter().map(six).sum::<f64>() / 6.0;
    let (low, high) = bounds(mesh.positions.iter().copied());
    // A closed mesh without an inside has only rounding errors.
    (volume.abs() > LEAST_INSIDE * low.distance(high).powi(3)).then_some(volume)
}

/// Refuses a result that lost most of the volume: parts of the model that are narrower than the strength vanished.
fn refuse_collapse(report: &FairReport) -> Result<(), FairError> {
    match (report.volume_before, report.volume_after) {
        (Some(before), Some(after)) if after.abs() < LEAST_VOLUME * before.abs() => {
            Err(FairError::Collapsed {
                part: after.abs() / before.abs(),
            })
        }
        _ => Ok(()),
    }
}

/// Distances between the surfaces before and after a fairing, from the new vertices to the input and from the removed vertices of the
/// input to the result. `kept` marks the faces that are not removed; none if all are.
fn moved(
    [before, after]: [&Inspection; 2],
    [old, result]: &[Bvh; 2],
    kept: Option<&Remainder>,
) -> Vec<f64> {
    let distances = |points: Vec<DVec3>, surface: &Bvh| -> Vec<f64> {
        points
            .into_par_iter()
            .map(|p| distance(surface, p))
            .collect_indexed()
    };
    let first_new = kept.map_or(0, |k| k.mesh.positions.len());
    let new = after.input.positions[first_new..].to_vec();
    // The removed vertices belong to removed faces only; kept faces use the rim too.
    let mut is_gone = vec![false; before.mesh.positions.len()];
    let stays = |f: u32| kept.is_some_and(|k| k.faces[f as usize]);
    for of_kept in [false, true] {
        for f in before.topology.faces().filter(|f| stays(*f) == of_kept) {
            let corners = before.mesh.faces[f as usize];
            corners.iter().for_each(|&v| is_gone[v as usize] = !of_kept);
        }
    }
    let gone = (0..is_gone.len()).filter(|v| is_gone[*v]);
    let gone: Vec<DVec3> = gone.map(|v| before.mesh.positions[v]).collect();
    [distances(new, old), distances(gone, result)].concat()
}

fn distance(surface: &Bvh, p: DVec3) -> f64 {
    surface
        .closest(p, f64::INFINITY)
        .map_or(0.0, |c| c.distance)
}

/// The largest distance between the surfaces before and after, from points in long faces that are removed or new: the tip of a spike may
/// be nearer to the other surface than its flanks.
fn moved_within(
    [before, after]: [&Inspection; 2],
    [old, result]: &[Bvh; 2],
    kept: Option<&Remainder>,
) -> f64 {
    let is_gone = |f: &u32| kept.is_none_or(|k| !k.faces[*f as usize]);
    let gone: Vec<u32> = before.topology.faces().filter(is_gone).collect();
    let first_new = kept.map_or(0, |k| k.mesh.faces.len() as u32);
    let new: Vec<u32> = (after.topology.faces())
        .filter(|f| *f >= first_new)
        .collect();
    let farthest = |from: &Inspection, faces: Vec<u32>, to: &Bvh| {
        let longest = |f: &u32| {
            let [a, b, c] = from.mesh.corners(*f);
            a.distance(b).max(b.distance(c)).max(c.distance(a))
        };
        let mean = faces.iter().map(longest).sum::<f64>() / faces.len().max(1) as f64;
        let is_long = |f: &u32| longest(f) > LONG_FACE * mean;
        let long: Vec<u32> = faces.into_iter().filter(is_long).collect();
        let of_face = |f: &u32| {
            let [a, b, c] = from.mesh.corners(*f);
            let count = ((longest(f) / mean).ceil() as usize).min(MOST_PARTS);
            let mut farthest = 0.0;
            for i in 0..=count {
                for j in 0..=count - i {
                    let [u, v] = [i, j].map(|k| k as f64 / count as f64);
                    farthest = f64::max(farthest, distance(to, a + u * (b - a) + v * (c - a)));
                }
            }
            farthest
        };
        long.par_iter().map(of_face).reduce(|| 0.0, f64::max)
    };
    farthest(before, gone, result).max(farthest(after, new, old))
}
