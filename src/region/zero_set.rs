//! The zero set of a solved level.

use glam::DVec3;
use rayon::prelude::*;

use super::Level;
use crate::extract::marching_cubes;
use crate::flow::{BAND_MARGIN, HALF_WIDTH};
use crate::grid::{NodeIndex, add, dilate, offset};
use crate::mesh::Mesh;
use crate::tuning::tuning;

/// Free nodes nearer to the zero set than this, in voxels, lie beside it.
const BESIDE: f64 = HALF_WIDTH;
/// Nodes up to so many from those beside a part of the zero set that is held are held too: the energy's band reaches that far.
const HELD: usize = (HALF_WIDTH + BAND_MARGIN) as usize + 1;

impl Level {
    /// Whether the zero set, where it is free, comes within `nodes` of the side of the box.
    pub fn is_near_side(&self, nodes: i32) -> bool {
        self.any_beside(|n| (0..27).any(|k| !self.grid.is_interior(stepped(n, nodes, k), 0)))
    }

    /// Whether the zero set, where it is free, comes to the end of the stored nodes.
    pub fn touches_box(&self) -> bool {
        let ends = |n| (0..27).any(|k| self.grid.slot(stepped(n, 2, k)).is_none());
        self.is_near_side(5) || self.any_beside(ends)
    }

    /// Whether something holds for a free node within a voxel of the zero set.
    fn any_beside(&self, holds: impl Fn(NodeIndex) -> bool + Sync) -> bool {
        (0..self.grid.len()).into_par_iter().any(|s| {
            !self.grid.is_cancelled()
                && self.mask[s]
                && self.phi[s].abs() < 1.0
                && holds(self.grid.node(s))
        })
    }

    /// Fixes the free nodes beside the parts of the zero set that meet no rim: these are no part of the missing surface, and
    /// their energy would be most of what the flow sees. `rims` are the positions of the rims' vertices.
    pub fn hold_detached(&mut self, rims: &[DVec3]) {
        if rims.is_empty() {
            return;
        }
        let grid = &self.grid;
        let attached = self.attached(rims);
        let is_beside = |s: usize| self.mask[s] && self.phi[s].abs() < BESIDE;
        let detached: Vec<bool> = (0..grid.len())
            .map(|s| is_beside(s) && !attached[s])
            .collect();
        if !detached.contains(&true) {
            return;
        }
        let widened = |marks: Vec<bool>, times| (0..times).fold(marks, |m, _| dilate(grid, &m));
        let (held, evolving) = (
            widened(detached, HELD),
            widened(attached, tuning().region.evolving),
        );
        for (free, (held, evolving)) in self.mask.iter_mut().zip(held.into_iter().zip(evolving)) {
            *free &= evolving || !held;
        }
    }

    /// The free nodes beside the parts of the zero set that meet a rim.
    fn attached(&self, rims: &[DVec3]) -> Vec<bool> {
        let grid = &self.grid;
        let mut attached = vec![false; grid.len()];
        let mut open = Vec::new();
        let mut visit = |open: &mut Vec<usize>, n: NodeIndex| {
            if let Some(s) = grid.slot(n)
                && self.mask[s]
                && self.phi[s].abs() < BESIDE
                && !std::mem::replace(&mut attached[s], true)
            {
                open.push(s);
            }
        };
        let side = 2 * tuning().region.round_rims + 1;
        for &p in rims {
            let n = self.lattice.to_lattice(p).round();
            let low = [n.x, n.y, n.z].map(|x| x as i32 - tuning().region.round_rims);
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

    /// The zero set on the cells near the mask, in world coordinates.
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
            .collect();
        // A stopped extraction finds no surface in the remaining cells.
        let value = |n: NodeIndex| grid.slot(n).map_or(f64::MAX, |s| level.phi[s]);
        let iso = marching_cubes(&cells, |n| match grid.is_cancelled() {
            true => f64::MAX,
            false => value(n),
        });
        // By linear interpolation vertices are off by up to h²/8R at a radius R. They move to the zero set of the tricubic
        // interpolant, if that is nearer than a voxel.
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
            .collect();
        Mesh::new(positions, iso.faces)
    }
}

/// The node so many steps from another in the direction `k` of 27.
fn stepped(n: NodeIndex, steps: i32, k: i32) -> NodeIndex {
    add(n, offset(k).map(|o| steps * o))
}
