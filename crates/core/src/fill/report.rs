//! The report of a region: grid, flow, closure, quality, finish, sharp edges.

use serde::{Deserialize, Serialize};

use super::candidate::FinishReport;
use super::closure::Closure;
use super::invented::{CounterpartReport, GrainReport};
use super::quality::Quality;
use super::reasons::{AttemptFailure, NotContinued, NotSmooth};
use crate::mesh::HoleId;
use crate::region::LevelReport;
use crate::tuning::{Tunable, tunable};

/// Diameters. A patch whose expected error is larger somewhere is unsure.
const UNSURE: Tunable<f64> = tunable("fill.unsure", 1.0 / 6.0);

/// Diameters. A patch that rises higher than this above its rim balloons. Hemispheres rise by 0.5, caps of cut necks and
/// limbs by 0.4, patches of holes in a smoothly continued surface by less than 0.2.
const BALLOON: Tunable<f64> = tunable("fill.balloon", 0.3);

/// Report of a region and its patch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RegionReport {
    /// Number, from 1.
    pub id: usize,
    /// Numbers of its holes.
    pub holes: Vec<HoleId>,
    /// Whether its holes were grouped because the caller asked for a bridge.
    pub bridge: bool,
    /// Diameter in the mesh's units, of the widest hole or of the faces that were cut out.
    pub diameter: f64,
    /// Voxel size of the finest level in the mesh's units; none where no grid was needed.
    pub voxel: Option<f64>,
    /// Nodes of the box of the finest level along each axis. Memory and time depend only on the nodes near the surface.
    pub dims: Option<[usize; 3]>,
    /// The levels of the nested solve, the coarsest first.
    pub levels: Vec<LevelReport>,
    /// Whether the flow converged.
    pub converged: bool,
    /// How it was closed; none where a rim is open.
    pub closure: Option<Closure>,
    /// Mean angle between the faces on both sides of the seam with the mesh, in degrees; none where the patch is not joined along
    /// one.
    pub seam_angle_mean: Option<f64>,
    /// Largest angle at the seam, in degrees.
    pub seam_angle_max: Option<f64>,
    /// How far the patch of a single hole rises above its rim, along the rim's normal to either side and beyond half of the rim's own
    /// extent, in diameters; 0 within that extent, none for other patches.
    pub rise: Option<f64>,
    /// New vertices.
    pub new_vertices: usize,
    /// New faces.
    pub new_faces: usize,
    /// Mean of 2 r_in / R_out over the new faces.
    pub quality_mean: f64,
    /// New faces that intersect another face.
    pub intersecting_faces: usize,
    /// Connected components of the patch.
    pub components: usize,
    /// The quality by which its patch was chosen. None in a plan, and for offset shells of a repair.
    pub quality: Option<Quality>,
    /// The finish of its patch; none where it was not finished.
    pub finish: Option<FinishReport>,
    /// The largest expected error of its new vertices, in the mesh's units; none where none is known.
    pub largest_expected_error: Option<f64>,
    /// Sharp edges that were continued.
    pub creases: Vec<CreaseReport>,
    /// Number of sharp edges of the mesh that end at its rim. 0 where none are searched: at several rims, at a flat cap, where
    /// patches are not finished, and with [`Sharp::Off`](crate::fill::Sharp::Off).
    pub crease_ends: usize,
    /// Why these edges, or the ones that the caller asked for, were not continued; none where they were, or there are none.
    pub not_continued: Option<NotContinued>,
    /// How the counterpart fits; none if none was asked for.
    pub counterpart: Option<CounterpartReport>,
    /// The roughness that was invented for its patch; none where none was asked for, or too little is known.
    pub grain: Option<GrainReport>,
    /// Why earlier attempts failed.
    pub failed_attempts: Vec<AttemptFailure>,
    /// Whether the surface belongs to the fallback energy, because the requested one found none.
    pub other_energy: bool,
    /// Computing time in seconds.
    pub seconds: f64,
}

/// A sharp edge that was continued across a hole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CreaseReport {
    /// Its length in the mesh's units.
    pub length: f64,
    /// Mean angle between the faces on both sides, in degrees.
    pub angle: f64,
}

impl RegionReport {
    /// Sets the number of new faces that intersect another face, also in the quality.
    pub(crate) fn set_intersecting(&mut self, faces: usize) {
        self.intersecting_faces = faces;
        if let Some(quality) = &mut self.quality {
            quality.intersections = faces;
        }
    }

    /// Sets how many sharp edges end at the rim, and why they were not continued. If rounded edges closed the hole instead, there
    /// is no reason to report, unless the caller asked for certain edges, or the sharp continuation failed only because it
    /// intersects faces.
    pub(super) fn set_creases_seen(
        &mut self,
        ends: usize,
        why: Option<NotContinued>,
        asked_for: bool,
    ) {
        let is_by_sides = self.closure == Some(Closure::Sides);
        let is_lost = |why: &NotContinued| matches!(why, NotContinued::Intersects(_));
        self.crease_ends = ends;
        self.not_continued = why.filter(|why| asked_for || !is_by_sides || is_lost(why));
    }

    /// Whether it has a surface of its own, not only triangles between the rims' vertices; or the straight edge of an opening.
    pub fn has_surface(&self) -> bool {
        let is_plain = match &self.closure {
            None | Some(Closure::Seam) => true,
            Some(Closure::RimTriangles(why)) => *why != NotSmooth::StraightEdge,
            Some(_) => false,
        };
        !self.levels.is_empty() || !is_plain && self.closure != Some(Closure::LevelSet)
    }

    /// Whether its patch may be off by a large part of its diameter.
    pub fn is_unsure(&self) -> bool {
        let most = UNSURE.get() * self.diameter;
        self.largest_expected_error.is_some_and(|e| e > most)
    }

    /// Whether its patch bulges so far that a flat cap may be wanted: the surface was continued across a cut neck or the mouth of
    /// a vessel. The corner of a solid, which rises as far, does not count.
    pub fn balloons(&self) -> bool {
        // What a counterpart has is no corner either, but a part of the shape.
        let is_corner = matches!(self.closure, Some(Closure::Sides | Closure::Counterpart));
        !is_corner && self.rise.is_some_and(|rise| rise > BALLOON.get())
    }
}
