//! The zero set of a solved level: its distance from the box, its components at rims, and its extraction as a mesh.

use glam::DVec3;
use rayon::prelude::*;

use super::Level;
use crate::extract::marching_cubes;
use crate::flow::{BAND_MARGIN, HALF_WIDTH};
use crate::grid::{NodeIndex, add, dilate, offset};
use crate::mesh::Mesh;
use crate::threads::{CollectFiltered, CollectIndexed};
use crate::tuning::{Tunable, tunable};

/// Nodes along each axis. The zero set that meets a rim is searched within this distance of the rim's vertices.
const ROUND_RIMS: Tunable<i32> = tunable("region.round_rims", 3);

/// Nodes. No node is held fixed within this distance of a component of the zero set that touches a rim.
const EVOLVING: Tunable<usize> = tunable("region.evolving", 3);

/// Voxels. Half-width of the band of free nodes around the zero set that belong to it.
const ZERO_SET_BAND_VOXELS: f64 = HALF_WIDTH;
/// Nodes. Around the band of a component that is held fixed, nodes within this distance are held too: the band of the energy
/// reaches that far.
const HELD_BAND_NODES: usize = (HALF_WIDTH + BAND_MARGIN) as usize + 1;

impl Level {
    /// Whether the free part of the zero set comes within `nodes` of the side of the box.
    pub fn is_near_side(&self, nodes: i32) -> bool {
        self.any_near_zero_set(|n| (0..27).any(|k| !self.grid.is_interior(stepped(n, nodes, k), 0)))
    }

    /// Whether the free part of the zero set reaches the end of the stored nodes.
    pub fn touches_box(&self) -> bool {
        let ends = |n| (0..27).any(|k| self.grid.slot(stepped(n, 2, k)).is_none());
        self.is_near_side(5) || self.any_near_zero_set(ends)
    }

    /// Whether a condition holds for any free node within a voxel of the zero set.
    fn any_near_zero_set(&self, holds: impl Fn(NodeIndex) -> bool + Sync) -> bool {
        (0..self.grid.len()).into_par_iter().any(|s| {
            !self.grid.is_cancelled()
                && self.mask[s]
                && self.phi[s].abs() < 1.0
                && holds(self.grid.node(s))
        })
    }

    /// Fixes the free nodes near components of the zero set that touch no rim. Such components do not belong to the missing
    /// surface, and their energy would dominate. `rims` are the positions of the rims' vertices. Free nodes near components that
    /// touch a rim stay free.
    pub fn hold_detached(&mut self, rims: &[DVec3]) {
        if rims.is_empty() {
            return;
        }
        let grid = &self.grid;
        let attached = self.attached(rims);
        let is_near_zero_set = |s: usize| self.mask[s] && self.phi[s].abs() < ZERO_SET_BAND_VOXELS;
        let detached: Vec<bool> = (0..grid.len())
            .map(|s| is_near_zero_set(s) && !attached[s])
            .collect();
        if !detached.contains(&true) {
            return;
        }
        let widened = |marks: Vec<bool>, times| (0..times).fold(marks, |m, _| dilate(grid, &m));
        let (held, evolving) = (
            widened(detached, HELD_BAND_NODES),
            widened(attached, EVOLVING.get()),
        );
        for (free, (held, evolving)) in self.mask.iter_mut().zip(held.into_iter().zip(evolving)) {
            *free &= evolving || !held;
        }
    }

    /// Marks the free nodes near components of the zero set that touch a rim.
    fn attached(&self, rims: &[DVec3]) -> Vec<bool> {
        let grid = &self.grid;
        let mut attached = vec![false; grid.len()];
        let mut open = Vec::new();
        let mut visit = |open: &mut Vec<usize>, n: NodeIndex| {
            if let Some(s) = grid.slot(n)
                && self.mask[s]
                && self.phi[s].abs() < ZERO_SET_BAND_VOXELS
                && !std::mem::replace(&mut attached[s], true)
            {
                open.push(s);
            }
        };
        let side = 2 * ROUND_RIMS.get() + 1;
        for &p in rims {
            let n = self.lattice.to_lattice(p).round();
            let low = [n.x, n.y, n.z].map(|x| x as i32 - ROUND_RIMS.get());
            for i in 0..side.pow(3) {
                let o = [i / (side * side), i / side % side, i % side];
                visit(&mut open, add(low, o));
            }
        }
        while let Some(s) = open.pop() {
            if grid.is_cancelled() {
                break;
            }
            (0..27).for_each(|k| visit(&mut open, add(grid.node(s), offset(k))));
        }
        attached
    }

    /// Extracts the zero set on the cells near the mask, in world coordinates.
    pub fn zero_set(&self) -> Mesh {
        let (level, grid) = (self, &self.grid);
        // Cells with corners of both signs, all within three steps of the mask.
        let near = dilate(grid, &dilate(grid, &dilate(grid, &level.mask)));
        let corner = |n: NodeIndex, a: i32| {
            grid.slot([n[0] + (a >> 2 & 1), n[1] + (a >> 1 & 1), n[2] + (a & 1)])
        };
        let cells: Vec<NodeIndex> = (0..grid.len())
            .into_par_iter()
            .filter_map(|s| {
                if grid.is_cancelled() {
                    return None;
                }
                let n = grid.node(s);
                let mut signs = [false; 2];
                for a in 0..8 {
                    let t = corner(n, a)?;
                    if !near[t] {
                        return None;
                    }
                    signs[usize::from(level.phi[t] < 0.0)] = true;
                }
                (signs[0] && signs[1]).then_some(n)
            })
            .collect_filtered();
        // After a cancellation the remaining cells contain no surface.
        let value = |n: NodeIndex| grid.slot(n).map_or(f64::MAX, |s| level.phi[s]);
        let iso = marching_cubes(&cells, |n| match grid.is_cancelled() {
            true => f64::MAX,
            false => value(n),
        });
        // Vertices from linear interpolation are off by up to h²/8R, where R is the radius of curvature. They are projected to
        // the zero set of the tricubic interpolant, if it is nearer than a voxel.
        let positions: Vec<DVec3> = iso
            .positions
            .par_iter()
            .map(|&p| {
                let linear = level.lattice.to_world(p);
                match level.project(linear) {
                    Some((q, _)) if q.distance(linear) < level.lattice.voxel => q,
                    _ => linear,
                }
            })
            .collect_indexed();
        Mesh::new(positions, iso.faces)
    }
}

/// The node `steps` steps from another one, in the direction `k` of 27.
fn stepped(n: NodeIndex, steps: i32, k: i32) -> NodeIndex {
    add(n, offset(k).map(|o| steps * o))
}
