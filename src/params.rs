//! The public parameters, with their defaults and units.

use crate::flow::{Energy, Variant};

/// The voxel size of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VoxelSize {
    /// 32 voxels across the hole, up to 64 where its rim is finer or it is a slot, up to 96 where a region holds a small loop;
    /// 2.5 times as many, at most 128, with the variation of curvature.
    Auto,
    /// A length in the mesh's units; at least 1/1024 of the widest hole.
    Length(f64),
}

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// The input with the patches stitched in; its own vertices and faces are kept bit-exact and in order.
    Stitched,
    /// The zero set of the level set round each hole, as marching cubes gives it.
    Whole,
}

/// Parameters of [`crate::fill`].
#[derive(Clone, Debug, PartialEq)]
pub struct FillParams {
    /// Voxel size.
    pub voxel: VoxelSize,
    /// Numbers of the holes to fill, from 1; all when none are given.
    pub holes: Option<Vec<usize>>,
    /// Holes wider than this stay open, in the mesh's units.
    pub max_diameter: Option<f64>,
    /// Numbers of the holes to keep open.
    pub keep_open: Vec<usize>,
    /// Groups of holes to fill in one region whatever their distance.
    pub bridge: Vec<Vec<usize>>,
    /// What to return.
    pub surface: SurfaceKind,
    /// What the flow makes small.
    pub energy: Energy,
    /// The metric of the flow's steps; the variation of curvature takes Gauss-Newton whatever is asked here.
    pub variant: Variant,
    /// Most steps of the flow on each level; none for the default of the variant.
    pub steps: Option<usize>,
    /// Time step in units of h⁴; none goes for the steady state at once.
    pub time_step: Option<f64>,
    /// Length of the patch's edges over that of the edges round the hole; none for that of the energy, see
    /// [`Energy::edge_ratio`].
    pub edge_ratio: Option<f64>,
}

impl FillParams {
    /// Length of the patch's edges over that of the edges round the hole.
    pub fn edge_ratio(&self) -> f64 {
        self.edge_ratio.unwrap_or_else(|| self.energy.edge_ratio())
    }
}

impl Default for FillParams {
    fn default() -> Self {
        Self {
            voxel: VoxelSize::Auto,
            holes: None,
            max_diameter: None,
            keep_open: Vec::new(),
            bridge: Vec::new(),
            surface: SurfaceKind::Stitched,
            energy: Energy::Willmore,
            variant: Variant::GaussNewton,
            steps: None,
            time_step: None,
            edge_ratio: None,
        }
    }
}
