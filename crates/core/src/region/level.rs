//! One lattice of the nested grids: stored nodes, φ, free nodes, refinement and regrowth.

use glam::DVec3;
use rayon::prelude::*;

use super::distance::DistanceData;
use super::sampling::{Coarser, Known, Sampling, smooth_band};
use crate::flow::Pull;
use crate::grid::{
    BLOCK, Lattice, NodeIndex, SparseGrid, add, as_point, dilate, linear, offset,
    value_and_gradient,
};
use crate::sdf::project_on_zero_set;
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Finer voxels. Blocks farther than this from the coarse surface are not stored.
const STORED: Tunable<f64> = tunable("region.stored", 8.0);

/// Voxels. Nodes farther than this from the initial surface are not pulled.
const PULLED: Tunable<f64> = tunable("region.pulled", 8.0);

/// A lattice with φ (in voxels) and the mask of its free nodes.
#[derive(Clone, Debug)]
pub struct Level {
    /// The positions of the nodes.
    pub lattice: Lattice,
    /// The stored nodes.
    pub grid: SparseGrid,
    /// Signed distance in voxels, negative inside: one value per slot of the grid.
    pub phi: Vec<f64>,
    /// Whether a node is free: one mark per slot of the grid.
    pub mask: Vec<bool>,
}

impl Level {
    /// The coarsest level: every node of a box of `dims` nodes.
    pub fn coarsest(lattice: Lattice, dims: NodeIndex, data: &dyn DistanceData) -> Self {
        let grid = SparseGrid::new(dims, |_| true);
        let grid = match data.cancel() {
            Some(cancel) => grid.stopped_by(cancel),
            None => grid,
        };
        let (phi, mask) = Sampling {
            lattice: &lattice,
            grid: &grid,
            data,
            voxel: lattice.voxel,
            reach: smooth_band(),
        }
        .of_box();
        Self {
            lattice,
            grid,
            phi,
            mask,
        }
    }

    /// Replaces φ at the free nodes by the data's guess; returns false, without a change, where the data have none.
    pub fn initialise_from_guess(&mut self, data: &dyn DistanceData) -> bool {
        self.initialise_from_distance(&|x| data.guess(x))
    }

    /// Replaces φ at the free nodes by the distance to the sphere that continues the data; returns false, without a change, where
    /// there is none.
    pub fn initialise_from_sphere(&mut self, data: &dyn DistanceData) -> bool {
        self.initialise_from_distance(&|x| Some(data.sphere()?.signed_distance(x)))
    }

    fn initialise_from_distance(
        &mut self,
        distance: &(dyn Fn(DVec3) -> Option<f64> + Sync),
    ) -> bool {
        let guesses: Vec<Option<f64>> = (0..self.grid.len())
            .into_par_iter()
            .map(|s| {
                if !self.mask[s] || self.grid.is_cancelled() {
                    return Some(self.phi[s]);
                }
                let x = self.lattice.to_world(as_point(self.grid.node(s)));
                distance(x).map(|d| d / self.lattice.voxel)
            })
            .collect_indexed();
        match guesses.into_iter().collect() {
            Some(phi) => {
                self.phi = phi;
                true
            }
            None => false,
        }
    }

    /// Replaces φ at the free nodes by the values of another level. Nodes outside that level take the sign of their neighbours.
    pub fn initialise_from(&mut self, other: &Level) {
        let scale = other.lattice.voxel / self.lattice.voxel;
        let values: Vec<Option<f64>> = (0..self.grid.len())
            .into_par_iter()
            .map(|s| {
                if !self.mask[s] {
                    return Some(self.phi[s]);
                }
                let x = self.lattice.to_world(as_point(self.grid.node(s)));
                let x = other.lattice.to_lattice(x);
                linear(&other.grid, &other.phi, x).map(|v| scale * v)
            })
            .collect_indexed();
        let open = (0..values.len()).filter(|&s| values[s].is_none());
        let open: Vec<usize> = open.collect();
        self.phi = values.into_iter().map(|v| v.unwrap_or(0.0)).collect();
        take_signs(&self.grid, &mut self.phi, open);
    }

    /// The pull to the surface whose shape is kept, at the free nodes near the level's zero set: one target in voxels and one
    /// weight per slot of the grid. None where the data do not pull.
    pub fn pull(&self, data: &dyn DistanceData) -> Option<Pull> {
        let voxel = self.lattice.voxel;
        let weight = data.pull() * voxel.powi(4);
        if weight <= 0.0 {
            return None;
        }
        let (target, weight) = (0..self.grid.len())
            .into_par_iter()
            .map(|s| {
                let near = self.mask[s] && self.phi[s].abs() < PULLED.get();
                let wanted = near && !self.grid.is_cancelled();
                let x = self.lattice.to_world(as_point(self.grid.node(s)));
                let kept = wanted.then(|| data.kept_shape(x)).flatten();
                kept.map_or((0.0, 0.0), |d| (d / voxel, weight))
            })
            .unzip();
        Some(Pull { target, weight })
    }

    /// The level of half the voxel: it stores the blocks near both the surface and the mask; φ is prolonged where it is free.
    pub fn refined(&self, data: &dyn DistanceData) -> Self {
        let lattice = Lattice {
            origin: self.lattice.origin,
            voxel: 0.5 * self.lattice.voxel,
        };
        let coarser = Coarser::new(&self.grid, &self.phi, &self.mask);
        let near = dilate(&self.grid, coarser.near_free());
        let dims = self.grid.dims().map(|d| 2 * d - 1);
        let grid = SparseGrid::new(dims, |corner| self.wants(corner, &near))
            .stopped_by(self.grid.cancel());
        let (phi, mask) = Sampling {
            lattice: &lattice,
            grid: &grid,
            data,
            voxel: lattice.voxel,
            reach: smooth_band(),
        }
        .refining(&coarser);
        Self {
            lattice,
            grid,
            phi,
            mask,
        }
    }

    /// The same lattice with added blocks around the present zero set; none where no block has to be added.
    pub fn regrown(&self, data: &dyn DistanceData) -> Option<Self> {
        // Marks the blocks of the free nodes near the zero set and their neighbours.
        let blocks = self.grid.dims().map(|d| d / BLOCK);
        let at = |b: NodeIndex| ((b[0] * blocks[1] + b[1]) * blocks[2] + b[2]) as usize;
        let mut wanted = vec![false; blocks.iter().map(|&b| b as usize).product()];
        for s in (0..self.grid.len()).filter(|&s| self.mask[s] && self.phi[s].abs() < STORED.get())
        {
            let block = self.grid.node(s).map(|i| i / BLOCK);
            for k in 0..27 {
                let near = add(block, offset(k));
                if (0..3).all(|d| near[d] >= 0 && near[d] < blocks[d]) {
                    wanted[at(near)] = true;
                }
            }
        }
        // Stores these blocks in addition to the present ones.
        let grid = SparseGrid::new(self.grid.dims(), |corner| {
            self.grid.slot(corner).is_some() || wanted[at(corner.map(|i| i / BLOCK))]
        })
        .stopped_by(self.grid.cancel());
        if grid.len() == self.grid.len() {
            return None;
        }
        // Free nodes keep φ; fixed nodes and new ones are sampled from the data.
        let old = |n: NodeIndex| self.grid.slot(n).filter(|&s| self.mask[s]);
        let known = |n: NodeIndex| match old(n) {
            Some(s) => Known::Node(self.phi[s], true),
            None => Known::nothing(false),
        };
        let (mut phi, mask) = Sampling {
            lattice: &self.lattice,
            grid: &grid,
            data,
            voxel: self.lattice.voxel,
            reach: smooth_band(),
        }
        .except(&known);
        // At new free nodes the distance to the data means nothing: these nodes are away from the surface and take their sign
        // from their neighbours.
        let open = (0..grid.len()).filter(|&s| mask[s] && old(grid.node(s)).is_none());
        take_signs(&grid, &mut phi, open.collect());
        Some(Self {
            lattice: self.lattice,
            grid,
            phi,
            mask,
        })
    }

    /// The nearest point of the zero set to a world point, in world units, and the unit normal there; none where the projection
    /// does not converge or needs nodes that are not stored.
    pub fn project(&self, p: DVec3) -> Option<(DVec3, DVec3)> {
        let x = self.lattice.to_lattice(p);
        let foot = project_on_zero_set(&self.grid, &self.phi, x, x)?;
        let (_, g) = value_and_gradient(&self.grid, &self.phi, foot)?;
        Some((self.lattice.to_world(foot), g.normalize_or_zero()))
    }

    /// Whether a block of the next finer level is near both the surface and the mask.
    fn wants(&self, corner: NodeIndex, near: &[bool]) -> bool {
        let half = BLOCK / 2;
        let mut wanted = false;
        if self.grid.is_cancelled() {
            return false;
        }
        for i in 0..=half {
            for j in 0..=half {
                for k in 0..=half {
                    let n = [corner[0] / 2 + i, corner[1] / 2 + j, corner[2] / 2 + k];
                    match self.grid.slot(n) {
                        Some(s) => wanted |= near[s] && 2.0 * self.phi[s].abs() < STORED.get(),
                        None => return false,
                    }
                }
            }
        }
        wanted
    }
}

/// Gives the nodes in `open`, which are all away from the surface, the sign of their neighbours and a value away from zero.
fn take_signs(grid: &SparseGrid, phi: &mut [f64], mut open: Vec<usize>) {
    let mut closed = vec![true; grid.len()];
    open.iter().for_each(|&s| closed[s] = false);
    loop {
        let sign = |s: usize| {
            (0..6).find_map(|k| {
                let mut o = [0; 3];
                o[k / 2] = 1 - 2 * (k as i32 % 2);
                let near = grid.slot(add(grid.node(s), o))?;
                closed[near].then(|| STORED.get().copysign(phi[near]))
            })
        };
        if grid.is_cancelled() {
            return;
        }
        let found: Vec<(usize, f64)> = open.iter().filter_map(|&s| Some((s, sign(s)?))).collect();
        if found.is_empty() {
            return;
        }
        for &(s, v) in &found {
            phi[s] = v;
            closed[s] = true;
        }
        open.retain(|&s| !closed[s]);
    }
}
