//! The narrow band of grid nodes and cells on which the energy is computed.

use std::sync::Arc;

use rayon::prelude::*;

use super::layout::Layout;
use crate::cancel::Cancel;
use crate::grid::{ABSENT, NodeIndex, SparseGrid, add, dilate};
use crate::threads::CollectFiltered;

/// b, the half width of the weight χ, in voxels.
pub const WIDTH: f64 = 2.5;
/// How far residual nodes extend beyond the weight's support, in voxels.
pub const MARGIN: f64 = 1.0;
/// Number that stands for "no node" and "no cell".
pub const NONE: u32 = u32::MAX;

/// A cell's corners with last coordinate 0: their node numbers. The opposite corner with last coordinate 1 has the next number,
/// because nodes are numbered in lexicographic order.
pub type Cell = [u32; 4];

/// The numbers of a cell's eight corners.
#[inline]
pub fn corner_numbers(cell: &Cell) -> [usize; 8] {
    std::array::from_fn(|a| cell[a / 2] as usize + a % 2)
}

/// A narrow band: residual nodes R = {|φ| < b + 1} ∩ (mask dilated a given number of times), the cells that touch R, and the
/// unknowns U = mask ∩ (R dilated once). Nodes are numbered compactly in lexicographic order.
pub struct Band {
    /// Slot of each node in the grid.
    pub slots: Vec<u32>,
    /// Memory layout of vectors over the nodes.
    pub layout: Arc<Layout>,
    /// Corner nodes of each cell; cells are sorted by their first corner.
    pub cells: Vec<Cell>,
    /// The cells around each node, packed by pair of corners along the last axis. The node can be the second corner of one cell
    /// and the first of the next; those two cells have consecutive numbers. Entry: 4 × the lower cell number, + 1 if the node is
    /// the second corner of a cell, + 2 if it is the first corner of one.
    node_cells: Vec<[u32; 4]>,
    /// Whether a node carries a residual.
    pub residual: Vec<bool>,
    /// Whether a node is within one step of the mask.
    pub near: Vec<bool>,
    /// Whether a node is an unknown.
    pub unknown: Vec<bool>,
    /// Number of unknowns.
    pub unknowns: usize,
    /// Token that cancels computations on the band.
    pub cancel: Cancel,
}

fn corner(a: usize) -> NodeIndex {
    [((a >> 2) & 1) as i32, ((a >> 1) & 1) as i32, (a & 1) as i32]
}

impl Band {
    /// The band of `phi` around its zero set where `mask` leaves it free. R extends `dilations` steps (at least one) beyond the
    /// mask.
    pub fn new(grid: &SparseGrid, phi: &[f64], mask: &[bool], dilations: usize) -> Self {
        // R: nodes nearer than b + 1 voxels to the zero set and within `dilations` steps of the mask, with all 26
        // neighbours stored.
        let near = dilate(grid, mask);
        let wide = (1..dilations).fold(near.clone(), |set, _| dilate(grid, &set));
        let residual: Vec<bool> = (0..grid.len())
            .map(|s| wide[s] && phi[s].abs() < WIDTH + MARGIN && Self::whole(grid, s))
            .collect();
        // The band: R dilated once, numbered in the lexicographic order of the nodes.
        let reach = dilate(grid, &residual);
        let mut slots: Vec<u32> = (0..grid.len() as u32)
            .filter(|&s| reach[s as usize] && !grid.is_cancelled())
            .collect();
        slots.par_sort_unstable_by_key(|&s| grid.node(s as usize));
        let mut number = vec![NONE; grid.len()];
        for (i, &s) in slots.iter().enumerate() {
            number[s as usize] = i as u32;
        }
        let nodes: Vec<NodeIndex> = slots.iter().map(|&s| grid.node(s as usize)).collect();
        let lookup = |n: NodeIndex| grid.slot(n).map_or(NONE, |s| number[s]);
        // Cells with eight corners in the band, at least one of them in R. Corners 1, 3, 5, 7 are the numbers after 0, 2, 4, 6.
        let cells: Vec<Cell> = nodes
            .par_iter()
            .filter_map(|&n| {
                if grid.is_cancelled() {
                    return None;
                }
                let c: [u32; 8] = std::array::from_fn(|a| lookup(add(n, corner(a))));
                let whole = c.iter().all(|&v| v != NONE);
                let touches = || c.iter().any(|&v| residual[slots[v as usize] as usize]);
                (whole && touches()).then(|| [c[0], c[2], c[4], c[6]])
            })
            .collect_filtered();
        // The cells around each node: sums over cells are gathered row by row in a fixed order, so results do not depend on
        // threads.
        let mut node_cells = vec![[0; 4]; slots.len()];
        for (c, cell) in cells.iter().enumerate() {
            for (k, &v) in cell.iter().enumerate() {
                let first = &mut node_cells[v as usize][k];
                *first = if *first == 0 { (c as u32) << 2 } else { *first } | 2;
                node_cells[v as usize + 1][k] = (c as u32) << 2 | 1;
            }
        }
        // Flags by node number instead of by slot.
        let unknown: Vec<bool> = slots.iter().map(|&s| mask[s as usize]).collect();
        let residual: Vec<bool> = slots.iter().map(|&s| residual[s as usize]).collect();
        let near: Vec<bool> = slots.iter().map(|&s| near[s as usize]).collect();
        let numbered = |s: u32| {
            if s == ABSENT {
                NONE
            } else {
                number[s as usize]
            }
        };
        let around = |i: usize| grid.around(slots[i] as usize).map(numbered);
        let layout = Arc::new(Layout::new(&nodes, |i| unknown[i] || residual[i], around));
        Self {
            residual,
            near,
            unknowns: unknown.iter().filter(|&&u| u).count(),
            unknown,
            slots,
            layout,
            cells,
            node_cells,
            cancel: grid.cancel().clone(),
        }
    }

    /// Calls `run` with each cell around a node and the node's corner index in that cell.
    #[inline]
    pub fn each_cell(&self, node: usize, mut run: impl FnMut(usize, usize)) {
        for (k, &pair) in self.node_cells[node].iter().enumerate() {
            let low = (pair >> 2) as usize;
            if pair & 2 != 0 {
                run(low + (pair & 1) as usize, 2 * k);
            }
            if pair & 1 != 0 {
                run(low, 2 * k + 1);
            }
        }
    }

    /// Whether all 26 neighbours are stored.
    fn whole(grid: &SparseGrid, slot: usize) -> bool {
        grid.around(slot).iter().all(|&s| s != ABSENT)
    }

    /// Gathers the values at the band's nodes from a field with one value for each slot of the grid.
    pub fn gather(&self, field: &[f64]) -> Vec<f64> {
        self.slots.iter().map(|&s| field[s as usize]).collect()
    }

    /// Writes values at the band's nodes back to a field with one value for each slot of the grid.
    pub fn scatter(&self, values: &[f64], field: &mut [f64]) {
        for (&s, &v) in self.slots.iter().zip(values) {
            field[s as usize] = v;
        }
    }
}
