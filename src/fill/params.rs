//! The parameters of a fill, with their defaults and units.

use serde::{Deserialize, Serialize};

use super::like::Like;
use crate::flow::{Energy, Variant};
use crate::mesh::{Hole, HoleId};
use crate::region::VoxelSize;
use crate::tuning::tuning;

/// What a fill returns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SurfaceKind {
    /// The input with the patches stitched in; its own vertices and faces are kept bit-exact and in order.
    #[default]
    Stitched,
    /// The zero set of the level set round each hole, as marching cubes gives it.
    Whole,
}

/// How patches are finished on their own triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Finish {
    /// By Newton steps of the Willmore energy, and by what the surroundings foretell as far as that proves itself next to the
    /// hole.
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
    /// Where that predicts the faces round the hole clearly better than a smooth patch.
    #[default]
    Auto,
    /// Never: all patches are smooth.
    Off,
}

/// Parameters of a fill. Make one by [`FillParams::default`] and set what is to differ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct FillParams {
    /// Voxel size.
    pub voxel: VoxelSize,
    /// Numbers of the holes to fill, from 1; all when none are given.
    pub holes: Option<Vec<HoleId>>,
    /// Holes wider than this stay open, in the mesh's units.
    pub max_diameter: Option<f64>,
    /// Numbers of the holes to keep open.
    pub keep_open: Vec<HoleId>,
    /// Groups of holes to fill in one region whatever their distance.
    pub bridge: Vec<Vec<HoleId>>,
    /// Numbers of the holes to close by nearly flat caps, surfaces of least area, instead of continuing the surface: necks, bases,
    /// mouths of vessels.
    pub flat: Vec<HoleId>,
    /// Pairs of crease ends, by the numbers of [`Inspection::crease_ends`](crate::Inspection::crease_ends), between which sharp edges are
    /// continued across their holes, whatever the faces round these say.
    pub crease: Vec<[usize; 2]>,
    /// Whether open sheets get a flat base with straight walls down from their outer borders, so that a terrain can be printed; else these
    /// borders stay open.
    pub flat_base: bool,
    /// How far the base lies below the lowest vertex of its sheet, in the mesh's units; none for the mean edge of the border.
    pub base_offset: Option<f64>,
    /// After what holes are filled, where that predicts the faces round them: the mirrored mesh, or a template.
    pub like: Option<Like>,
    /// Whether a template may be scaled to fit.
    pub like_scale: bool,
    /// Whether patches get the roughness of their surroundings, which is invented.
    pub grain: bool,
    /// What to return.
    pub surface: SurfaceKind,
    /// How patches are finished. Those of the variation of curvature, of level sets by themselves and of flows in time are not.
    pub finish: Finish,
    /// Whether sharp edges that end at a rim are continued. Only where patches are finished.
    pub sharp: Sharp,
    /// What the flow makes small.
    pub energy: Energy,
    /// The metric of the flow's steps; the variation of curvature takes Gauss-Newton whatever is asked here.
    pub variant: Variant,
    /// Most steps of the flow on each level; none for the default of the variant.
    pub steps: Option<usize>,
    /// Time step in units of h⁴; none goes for the steady state at once.
    pub time_step: Option<f64>,
    /// Length of the patch's edges over that of the edges round the hole, between 0.05 and 20; none for 0.7
    /// where patches are finished, else 0.8, with the variation of curvature 0.45.
    pub edge_ratio: Option<f64>,
}

impl FillParams {
    /// The largest number of steps on a grid: each is kept in the report.
    pub const MOST_STEPS: usize = crate::parameters::solve::MOST_STEPS;

    /// Length of the patch's edges over that of the edges round the hole.
    pub fn edge_ratio(&self) -> f64 {
        let usual = || match self.finishes() {
            true => tuning().fill.finished_edge_ratio,
            false => self.energy.needs().edge_ratio,
        };
        self.edge_ratio.unwrap_or_else(usual)
    }

    /// Whether a hole is to get a flat cap.
    pub(crate) fn is_flat(&self, hole: HoleId) -> bool {
        self.flat.contains(&hole)
    }

    /// Whether a hole is the outer border of a sheet that gets a base.
    pub(crate) fn is_on_base(&self, hole: &Hole) -> bool {
        self.flat_base && hole.outer_border && !self.is_flat(hole.id)
    }

    /// Whether one of these holes is to be put together with others.
    pub(crate) fn bridges(&self, holes: &[HoleId]) -> bool {
        self.bridge.iter().flatten().any(|id| holes.contains(id))
    }

    /// Whether patches are finished on their own triangles. A flow in time, with given steps or with another energy than the
    /// finish minimises has its own end.
    pub(crate) fn finishes(&self) -> bool {
        self.finish != Finish::None
            && self.surface == SurfaceKind::Stitched
            && self.energy == Energy::Willmore
            && self.steps.is_none()
            && self.time_step.is_none()
    }
}
