//! What was done in a region.

use serde::{Deserialize, Serialize};

use super::candidate::FinishReport;
use super::invented::{CounterpartReport, GrainReport};
use super::outcome::{ClosedBy, NotContinued, TryFailure};
use super::quality::Quality;
use crate::mesh::HoleId;
use crate::region::LevelReport;
use crate::tuning::tuning;

/// A region and its patch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RegionReport {
    /// Number, from 1.
    pub id: usize,
    /// Numbers of its holes.
    pub holes: Vec<HoleId>,
    /// Whether its holes were put together because the caller asked for a bridge.
    pub bridge: bool,
    /// Diameter in the mesh's units: that of the widest hole, or of what was cut out.
    pub diameter: f64,
    /// Voxel size of the finest level in the mesh's units; none where no grid is needed.
    pub voxel: Option<f64>,
    /// Nodes of the box of the finest level along the axes. Memory and time go with those near the surface only.
    pub dims: Option<[usize; 3]>,
    /// The levels of the nested solve, the coarsest first.
    pub levels: Vec<LevelReport>,
    /// Whether the flow became steady.
    pub converged: bool,
    /// What closed it.
    pub closed_by: Option<ClosedBy>,
    /// Mean angle between the faces on both sides of the seam, in degrees; none where the level set did not close it.
    pub seam_angle_mean: Option<f64>,
    /// Largest angle there.
    pub seam_angle_max: Option<f64>,
    /// How far the patch of one hole rises above its rim, along the rim's normal to either side and beyond the rim's own extent,
    /// in diameters; none for other patches.
    pub rise: Option<f64>,
    /// New vertices.
    pub new_vertices: usize,
    /// New faces.
    pub new_faces: usize,
    /// Mean of 2 r_in / R_out over the new faces.
    pub quality_mean: f64,
    /// New faces that intersect another face.
    pub intersecting_faces: usize,
    /// Connected pieces of the patch.
    pub components: usize,
    /// How good its patch is: the value by which patches are chosen. None in a plan, and for offset shells of a repair.
    pub quality: Option<Quality>,
    /// How its patch was finished; none where it was not.
    pub finish: Option<FinishReport>,
    /// Sharp edges that were continued.
    pub creases: Vec<CreaseReport>,
    /// Number of sharp edges of the mesh that end at its rim; 0 where none are looked for: at several rims, at a flat cap, where patches
    /// are not finished, and with [`Sharp::Off`](crate::Sharp::Off).
    pub crease_ends: usize,
    /// Why these were not continued, or those that were asked for; none where they were, or there are none.
    pub not_continued: Option<NotContinued>,
    /// How the counterpart after which it was to be filled fits; none where it was to be filled after none.
    pub counterpart: Option<CounterpartReport>,
    /// The roughness that was invented for its patch; none where none was asked for, or too little is known.
    pub grain: Option<GrainReport>,
    /// Why earlier tries failed.
    pub earlier_tries: Vec<TryFailure>,
    /// Whether the surface is that of the energy to fall back to because the one asked for found none.
    pub other_energy: bool,
    /// Seconds.
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
    /// Counts the new faces that intersect another face anew.
    pub(crate) fn set_intersecting(&mut self, faces: usize) {
        self.intersecting_faces = faces;
        if let Some(quality) = &mut self.quality {
            quality.intersections = faces;
        }
    }

    /// Takes how many sharp edges end at the rim, and why they were not continued. Rounded edges that close the hole instead are what is there,
    /// unless certain edges were asked for, or sharp ones were right but for what they intersect.
    pub(super) fn set_creases_seen(
        &mut self,
        ends: usize,
        why: Option<NotContinued>,
        asked_for: bool,
    ) {
        let is_by_sides = self.closed_by == Some(ClosedBy::Sides);
        let is_lost = |why: &NotContinued| matches!(why, NotContinued::Intersects(_));
        self.crease_ends = ends;
        self.not_continued = why.filter(|why| asked_for || !is_by_sides || is_lost(why));
    }

    /// Whether a surface was made for it, and not only triangles between vertices of rims.
    pub fn has_surface(&self) -> bool {
        let by = self.closed_by;
        !self.levels.is_empty()
            || matches!(
                by,
                Some(
                    ClosedBy::Flat
                        | ClosedBy::Base
                        | ClosedBy::Faired
                        | ClosedBy::Sides
                        | ClosedBy::Counterpart
                        | ClosedBy::Lining
                )
            )
    }

    /// Whether its patch bulges so far that a flat cap may be what is wanted: the surface was continued across a cut neck or the
    /// mouth of a vessel. The corner of a solid, which rises as far, does not count.
    pub fn balloons(&self) -> bool {
        // What a counterpart has is no corner either, but a part of the shape.
        let is_corner = matches!(
            self.closed_by,
            Some(ClosedBy::Sides | ClosedBy::Counterpart)
        );
        !is_corner && self.rise.is_some_and(|rise| rise > tuning().fill.balloon)
    }
}
