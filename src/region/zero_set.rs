//! The zero set of a solved level.

use glam::DVec3;
use rayon::prelude::*;

use super::Level;
use crate::extract::marching_cubes;
use crate::grid::{NodeIndex, dilate, offset};
use crate::mesh::Mesh;

impl Level {
    /// Whether the zero set, where it is free, comes to the end of the stored nodes.
    pub fn touches_box(&self) -> bool {
        let (level, grid) = (self, &self.grid);
        (0..grid.len()).into_par_iter().any(|s| {
            let n = grid.node(s);
            level.mask[s]
                && level.phi[s].abs() < 1.0
                && (0..27).any(|i: i32| {
                    let o = offset(i);
                    let far = [n[0] + 5 * o[0], n[1] + 5 * o[1], n[2] + 5 * o[2]];
                    let near = [n[0] + 2 * o[0], n[1] + 2 * o[1], n[2] + 2 * o[2]];
                    grid.slot(near).is_none() || !grid.is_interior(far, 0)
                })
        })
    }

    /// The zero set on the cells near the mask, in world coordinates.
    pub fn zero_set(&self) -> Mesh {
        let (level, grid) = (self, &self.grid);
        let near = dilate(grid, &dilate(grid, &dilate(grid, &level.mask)));
        let corner = |n: NodeIndex, a: i32| {
            grid.slot([n[0] + (a >> 2 & 1), n[1] + (a >> 1 & 1), n[2] + (a & 1)])
        };
        let cells: Vec<NodeIndex> = (0..grid.len())
            .into_par_iter()
            .filter_map(|s| {
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
        let iso = marching_cubes(&cells, |n| grid.slot(n).map_or(f64::MAX, |s| level.phi[s]));
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
