//! Coarse multigrid levels for the system of a step: functions that are constant along the normal.
//!
//! Smooth displacements of the surface are nearly constant along the normal through the band. So the first coarse level
//! interpolates trilinearly at each node's closest point on the surface, on a lattice of twice the voxel size. The nodes of
//! coarser lattices are placed between the nodes of the finer one: the eight weights of trilinear interpolation then equal the
//! refinement weights of quadratic splines (Chaikin 1974), and smooth functions keep their bending energy from level to level.
//! With linear refinement the energy grows on each level. All matrices are Galerkin products.

use rayon::prelude::*;

use super::band::Band;
use super::system::System;
use crate::cancel::Cancel;
use crate::grid::{BLOCK, NodeIndex, SparseGrid, add};
use crate::linalg::{Csr, Multigrid};
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Unknowns. Coarse levels are added until at most this many unknowns remain, which are solved directly.
const FEW_UNKNOWNS: Tunable<usize> = tunable("flow.few_unknowns", 400);

/// Interpolation weights up to this count as rounding errors of zero.
const LEAST: f64 = 1e-12;
const ABSENT: u32 = u32::MAX;

/// The nodes of one coarse lattice, numbered.
struct CoarseNodes {
    /// Coarse-lattice coordinates of the first node of `grid`.
    low: NodeIndex,
    grid: SparseGrid,
    /// Number of each stored node, or `ABSENT`.
    number: Vec<u32>,
    nodes: Vec<NodeIndex>,
}

impl CoarseNodes {
    /// The nodes that have weight for at least one of the points and for which `exists` is true.
    fn new(
        points: &[Option<[f64; 3]>],
        exists: impl Fn(NodeIndex) -> bool,
        cancel: &Cancel,
    ) -> Self {
        // The bounding box of the points, in nodes of the coarse lattice, and the blocks of nodes in it.
        let (mut low, mut high) = ([i32::MAX; 3], [i32::MIN; 3]);
        for p in points.iter().flatten() {
            for d in 0..3 {
                low[d] = low[d].min(p[d].floor() as i32);
                high[d] = high[d].max(p[d].floor() as i32 + 1);
            }
        }
        if low[0] > high[0] {
            (low, high) = ([0; 3], [-1; 3]);
        }
        let blocks: [i32; 3] = std::array::from_fn(|d| (high[d] - low[d]) / BLOCK + 1);
        let mut touched = vec![false; blocks.iter().map(|&b| b as usize).product()];
        // The nodes with weight for a point, relative to the lowest corner of the box; only blocks that contain one are stored.
        let used = || {
            let points = points
                .iter()
                .take_while(|_| !cancel.is_cancelled())
                .flatten();
            let weights = points.flat_map(|&p| trilinear(p));
            weights
                .filter(|w| w.1 > LEAST)
                .map(|(n, _)| std::array::from_fn(|d| n[d] - low[d]))
        };
        for n in used() {
            let b: [i32; 3] = NodeIndex::map(n, |i| i / BLOCK);
            touched[((b[0] * blocks[1] + b[1]) * blocks[2] + b[2]) as usize] = true;
        }
        let mut at = touched.into_iter();
        let grid = SparseGrid::new(blocks.map(|b| b * BLOCK), |_| at.next().unwrap_or(false));
        // Marks these nodes, then numbers those for which `exists` is true, in the order of their slots.
        let mut number = vec![ABSENT; grid.len()];
        used().for_each(|n| {
            if let Some(slot) = grid.slot(n) {
                number[slot] = 0;
            }
        });
        let mut nodes = Vec::new();
        for (slot, number) in number.iter_mut().enumerate() {
            let n = add(grid.node(slot), low);
            if *number == 0 && exists(n) {
                *number = nodes.len() as u32;
                nodes.push(n);
            } else {
                *number = ABSENT;
            }
        }
        Self {
            low,
            grid,
            number,
            nodes,
        }
    }

    fn number(&self, n: NodeIndex) -> Option<u32> {
        let slot = self.grid.slot(add(n, self.low.map(|i| -i)))?;
        let number = self.number[slot];
        (number != ABSENT).then_some(number)
    }
}

/// The eight nodes around a point and their trilinear weights.
fn trilinear(p: [f64; 3]) -> [(NodeIndex, f64); 8] {
    let base = p.map(|x| x.floor());
    std::array::from_fn(|a| {
        let o = [(a >> 2) & 1, (a >> 1) & 1, a & 1];
        let n = std::array::from_fn(|d| base[d] as i32 + o[d] as i32);
        let w = (0..3)
            .map(|d| {
                let t = p[d] - base[d];
                if o[d] == 1 { t } else { 1.0 - t }
            })
            .product();
        (n, w)
    })
}

/// The interpolation matrix from lattice nodes to points; nodes that no point uses or for which `exists` is false are left out.
fn interpolation(
    points: &[Option<[f64; 3]>],
    exists: impl Fn(NodeIndex) -> bool,
    cancel: &Cancel,
) -> (Csr, CoarseNodes) {
    let lattice = CoarseNodes::new(points, exists, cancel);
    let matrix = Csr::from_rows(points.len(), lattice.nodes.len(), |i, sink| {
        if let Some(p) = points[i].filter(|_| !cancel.is_cancelled()) {
            for (n, w) in trilinear(p) {
                if let (true, Some(c)) = (w > LEAST, lattice.number(n)) {
                    sink.add(c, w);
                }
            }
        }
    });
    (matrix, lattice)
}

/// For each row, the vector from its node to the closest point on the zero set of `phi`, by central differences. `phi` must be a
/// distance at all nodes around the band. Zero for rows that are not unknowns.
///
/// One-sided differences at the ends of the band would not do: their normals jump from node to node, so functions that are
/// constant along them are rough, and the coarse levels would take smooth displacements for stiff ones.
pub fn feet(band: &Band, grid: &SparseGrid, phi: &[f64]) -> Vec<[f32; 3]> {
    let foot = |&i: &u32| {
        if !band.unknown[i as usize] || grid.is_cancelled() {
            return [0.0; 3];
        }
        let slot = band.slots[i as usize] as usize;
        let around = grid.around(slot);
        let own = phi[slot];
        let value = |k: usize| phi.get(around[k] as usize).map_or(own, |&v| v);
        let g: [f64; 3] = std::array::from_fn(|d| {
            let step = [9, 3, 1][d];
            0.5 * (value(13 + step) - value(13 - step))
        });
        // In a distance |∇φ| is 1; at least ¼ for its square keeps the step short where the gradient is poor.
        let gg = (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]).max(0.25);
        g.map(|g| (-own / gg * g) as f32)
    };
    band.layout.rows.par_iter().map(foot).collect_indexed()
}

/// The closest points of the unknowns in coordinates of a lattice of twice the voxel size, by layout position; `None` for other
/// positions.
fn halved(band: &Band, grid: &SparseGrid, feet: &[[f32; 3]]) -> Vec<Option<[f64; 3]>> {
    let layout = &band.layout;
    let mut points = vec![None; layout.len];
    for ((r, &i), foot) in layout.rows.iter().enumerate().zip(feet) {
        if band.unknown[i as usize] {
            let x = grid.node(band.slots[i as usize] as usize);
            let y = std::array::from_fn(|d| 0.5 * (f64::from(x[d]) + f64::from(foot[d])));
            points[layout.position_of(r)] = Some(y);
        }
    }
    points
}

/// The multigrid hierarchy for a system, with the closest points from [`feet`]. `None` if it cannot be built or if the grid's
/// token is set; the caller then preconditions with the diagonal.
pub fn hierarchy(
    grid: &SparseGrid,
    mask: &[bool],
    band: &Band,
    feet: &[[f32; 3]],
    system: &System,
) -> Option<Multigrid> {
    let free = |n: NodeIndex| grid.slot(n).is_none_or(|s| mask[s]);
    let cancel = grid.cancel();
    // The first coarse level, on twice the voxel size.
    let exists = |n: NodeIndex| free(n.map(|i| 2 * i));
    let (first, mut lattice) = interpolation(&halved(band, grid, feet), exists, cancel);
    if lattice.nodes.is_empty() {
        return None;
    }
    let matrix = system.galerkin(&first);
    if cancel.is_cancelled() {
        return None;
    }
    // Coarser levels, each on twice the voxel size of the level before.
    let mut coarser = Vec::new();
    // Node n of a coarse lattice is at fine-grid node scale · n + first_node.
    let (mut scale, mut first_node) = (2, 0);
    while lattice.nodes.len() > FEW_UNKNOWNS.get() && coarser.len() < 12 {
        first_node += scale / 2;
        scale *= 2;
        let points: Vec<Option<[f64; 3]>> = lattice
            .nodes
            .iter()
            .map(|n| Some(n.map(|i| 0.5 * f64::from(i) - 0.25)))
            .collect();
        let at = |n: NodeIndex| free(n.map(|i| scale * i + first_node));
        let (p, next) = interpolation(&points, at, cancel);
        if next.nodes.is_empty() || next.nodes.len() >= lattice.nodes.len() {
            break;
        }
        coarser.push(p);
        lattice = next;
    }
    Multigrid::new(system, first, matrix, coarser)
}
