//! The nodes and cells the energy lives on.

use rayon::prelude::*;

use super::layout::Layout;
use crate::grid::{NodeIndex, SparseGrid, add};

/// Half width of the weight χ, in voxels.
pub const WIDTH: f64 = 2.5;
/// Margin of residual nodes beyond the weight.
pub const MARGIN: f64 = 1.0;
/// Summands that are added up in one go.
const CHUNK: usize = 1024;
/// No node or cell.
pub const NONE: u32 = u32::MAX;

/// A narrow band: residual nodes R = {|φ| < b + 1} ∩ (mask dilated once), the cells that touch R, the unknowns
/// U = mask ∩ (R dilated once), all with compact numbers in the lexicographic order of the nodes.
pub struct Band {
    /// Slot of each node in the grid.
    pub slots: Vec<u32>,
    /// The nodes' coordinates.
    pub nodes: Vec<NodeIndex>,
    /// Where vectors keep the nodes.
    pub layout: Layout,
    /// Corner nodes of each cell.
    pub cells: Vec<[u32; 8]>,
    /// For each node the cell of which it is corner `a`, or `u32::MAX`.
    pub node_cells: Vec<[u32; 8]>,
    /// Whether a node carries a residual.
    pub residual: Vec<bool>,
    /// Whether a node is an unknown.
    pub unknown: Vec<bool>,
    /// Number of unknowns.
    pub unknowns: usize,
}

fn offset(i: usize) -> NodeIndex {
    [
        (i / 9) as i32 - 1,
        ((i / 3) % 3) as i32 - 1,
        (i % 3) as i32 - 1,
    ]
}

fn corner(a: usize) -> NodeIndex {
    [((a >> 2) & 1) as i32, ((a >> 1) & 1) as i32, (a & 1) as i32]
}

/// Marks the nodes within one step (26 neighbours) of a marked one.
pub fn dilate(grid: &SparseGrid, marked: &[bool]) -> Vec<bool> {
    (0..grid.len())
        .into_par_iter()
        .map(|s| {
            marked[s]
                || (0..27).any(|i| {
                    grid.slot(add(grid.node(s), offset(i)))
                        .is_some_and(|t| marked[t])
                })
        })
        .collect()
}

/// Sums in chunks of fixed size, so that rounding does not depend on the threads.
pub(super) fn chunked_sum<T: Sync>(items: &[T], f: impl Fn(usize, &T) -> f64 + Sync) -> f64 {
    let partial: Vec<f64> = items
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(c, chunk)| {
            let first = c * CHUNK;
            chunk.iter().enumerate().map(|(i, x)| f(first + i, x)).sum()
        })
        .collect();
    partial.iter().sum()
}

impl Band {
    /// The band of `phi` round its zero set where `mask` leaves it free.
    pub fn new(grid: &SparseGrid, phi: &[f64], mask: &[bool]) -> Self {
        let near = dilate(grid, mask);
        let residual: Vec<bool> = (0..grid.len())
            .map(|s| near[s] && phi[s].abs() < WIDTH + MARGIN && Self::whole(grid, s))
            .collect();
        let reach = dilate(grid, &residual);
        let mut slots: Vec<u32> = (0..grid.len() as u32)
            .filter(|&s| reach[s as usize])
            .collect();
        slots.par_sort_unstable_by_key(|&s| grid.node(s as usize));
        let mut number = vec![NONE; grid.len()];
        for (i, &s) in slots.iter().enumerate() {
            number[s as usize] = i as u32;
        }
        let nodes: Vec<NodeIndex> = slots.iter().map(|&s| grid.node(s as usize)).collect();
        let lookup = |n: NodeIndex| grid.slot(n).map_or(NONE, |s| number[s]);
        let cells: Vec<[u32; 8]> = nodes
            .par_iter()
            .filter_map(|&n| {
                let c: [u32; 8] = std::array::from_fn(|a| lookup(add(n, corner(a))));
                let whole = c.iter().all(|&v| v != NONE);
                (whole && c.iter().any(|&v| residual[slots[v as usize] as usize])).then_some(c)
            })
            .collect();
        let mut node_cells = vec![[NONE; 8]; slots.len()];
        for (c, cell) in cells.iter().enumerate() {
            for (a, &v) in cell.iter().enumerate() {
                node_cells[v as usize][a] = c as u32;
            }
        }
        let unknown: Vec<bool> = slots.iter().map(|&s| mask[s as usize]).collect();
        let residual: Vec<bool> = slots.iter().map(|&s| residual[s as usize]).collect();
        let around = |i: usize| std::array::from_fn(|k| lookup(add(nodes[i], offset(k))));
        let layout = Layout::new(&nodes, |i| unknown[i] || residual[i], around);
        Self {
            residual,
            unknowns: unknown.iter().filter(|&&u| u).count(),
            unknown,
            slots,
            nodes,
            layout,
            cells,
            node_cells,
        }
    }

    /// Whether all 26 neighbours are stored.
    fn whole(grid: &SparseGrid, slot: usize) -> bool {
        let n = grid.node(slot);
        (0..27).all(|i| grid.slot(add(n, offset(i))).is_some())
    }

    /// The values of a field at the band's nodes.
    pub fn gather(&self, field: &[f64]) -> Vec<f64> {
        self.slots.iter().map(|&s| field[s as usize]).collect()
    }

    /// Writes values of the band's nodes back to a field.
    pub fn scatter(&self, values: &[f64], field: &mut [f64]) {
        for (&s, &v) in self.slots.iter().zip(values) {
            field[s as usize] = v;
        }
    }
}
