//! The parameters of a fill, with their defaults and units.

use serde::{Deserialize, Serialize};

use super::like::Like;
use crate::flow::Energy;
use crate::mesh::{Hole, HoleId};
use crate::region::VoxelSize;
use crate::tuning::{Tunable, tunable};

/// Edge length of a finished patch over the edge length around the hole. On 12 holes of scans 0.5 made patches 9 % worse,
/// 1 made them 6 % worse.
const FINISHED_EDGE_RATIO: Tunable<f64> = tunable("fill.finished_edge_ratio", 0.7);

/// How patches are finished on their own triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Finish {
    /// By Newton steps of the Willmore energy, blended with what the surroundings predict as far as the prediction is accurate on
    /// known vertices near the hole.
    #[default]
    Auto,
    /// By Newton steps of the Willmore energy.
    Willmore,
    /// Not at all: the level set's surface as it is, on finer grids.
    None,
}

/// Whether sharp edges are continued across holes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Sharp {
    /// Where continued edges predict the faces around the hole clearly better than a smooth patch.
    #[default]
    Auto,
    /// Never: all patches are smooth.
    Off,
}

/// Parameters of a fill. Start from [`FillParams::default`] and change what differs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct FillParams {
    /// Voxel size of the finest grid.
    pub voxel: VoxelSize,
    /// Numbers of the holes to fill, from 1. Without any, all holes are filled but outer borders of open sheets.
    pub holes: Option<Vec<HoleId>>,
    /// Holes wider than this stay open, in the mesh's units.
    pub max_diameter: Option<f64>,
    /// Numbers of the holes to keep open.
    pub keep_open: Vec<HoleId>,
    /// Groups of holes that are filled together, in one region, whatever their distance.
    pub bridge: Vec<Vec<HoleId>>,
    /// Numbers of the holes to close by nearly flat caps, surfaces of least area, instead of a continued surface: necks, bases,
    /// mouths of vessels.
    pub flat: Vec<HoleId>,
    /// Whether only rims that `bridge` names are joined, so that each side of a wall gets a patch of its own instead of the edge of an
    /// opening. Borders of islands stay open. Wide patches are weighed with the mirror image of the mesh, if it has a plane of symmetry.
    pub apart: bool,
    /// Pairs of crease ends, by the numbers of [`Inspection::crease_ends`](crate::mend::Inspection::crease_ends). A sharp edge is
    /// continued between the two ends across their hole, whatever the surrounding faces predict.
    pub crease: Vec<[usize; 2]>,
    /// Whether open sheets get a flat base with straight walls down from their outer borders, so that a terrain can be printed;
    /// otherwise these borders stay open.
    pub flat_base: bool,
    /// Distance of the base below the lowest vertex of its sheet, in the mesh's units; by default the mean edge length of the
    /// border.
    pub base_offset: Option<f64>,
    /// After what holes are filled, where that predicts the faces round them: the mirrored mesh, or a template.
    pub like: Option<Like>,
    /// Whether patches get the roughness of their surroundings, which is invented.
    pub grain: bool,
    /// How patches are finished. Patches of the curvature-variation energy are not finished.
    pub finish: Finish,
    /// Whether sharp edges that end at a rim are continued. Only where patches are finished.
    pub sharp: Sharp,
    /// The energy that the flow minimises.
    pub energy: Energy,
    /// Edge length of the patch over the edge length around the hole, between 0.05 and 20; by default 0.7 where patches are
    /// finished, otherwise 0.8, with the curvature-variation energy 0.45.
    pub edge_ratio: Option<f64>,
}

impl FillParams {
    /// Edge length of the patch over the edge length around the hole.
    pub fn edge_ratio(&self) -> f64 {
        let usual = || match self.finishes() {
            true => FINISHED_EDGE_RATIO.get(),
            false => self.energy.needs().edge_ratio,
        };
        self.edge_ratio.unwrap_or_else(usual)
    }

    /// The same parameters for these holes, or for all, without what the caller chose for single holes and ends of creases.
    pub(crate) fn of_holes(&self, holes: Option<Vec<HoleId>>) -> Self {
        Self {
            holes,
            max_diameter: None,
            keep_open: Vec::new(),
            bridge: Vec::new(),
            flat: Vec::new(),
            crease: Vec::new(),
            ..self.clone()
        }
    }

    /// Whether a hole gets a flat cap.
    pub fn is_flat(&self, hole: HoleId) -> bool {
        self.flat.contains(&hole)
    }

    /// Whether a hole is the outer border of a sheet that gets a base.
    pub(crate) fn is_on_base(&self, hole: &Hole) -> bool {
        self.flat_base && hole.outer_boundary && !self.is_flat(hole.id)
    }

    /// Whether the caller asks to fill any of these holes together with others.
    pub(crate) fn bridges(&self, holes: &[HoleId]) -> bool {
        self.bridge.iter().flatten().any(|id| holes.contains(id))
    }

    /// Whether openings may be closed by straight edges, and not only by continued surfaces.
    pub(crate) fn closes_straight(&self) -> bool {
        self.sharp == Sharp::Auto && self.voxel == VoxelSize::Auto && self.finishes()
    }

    /// Whether patches are finished on their own triangles. Not so with an energy that the finish does not minimise.
    pub(crate) fn finishes(&self) -> bool {
        self.finish != Finish::None && self.energy == Energy::Willmore
    }
}
