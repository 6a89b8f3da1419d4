//! The faces that a ball reaches from outside: a flood of the lattice nodes where the ball does not meet the surface.

use glam::DVec3;
use rayon::prelude::*;

use crate::spatial::Bvh;
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Nodes of the lattice in a radius of this ball. With two, an opening must be wider by a thickness to let the ball in.
const RADIUS_NODES: Tunable<f64> = tunable("solid.radius_nodes", 3.0);

/// Nodes of the lattice, at most: 128 MB.
const NODES: Tunable<usize> = tunable("solid.nodes", 64_000_000);

/// Nodes of the lattice for each face, at most, beside the first million: it bounds the time, half a microsecond each.
/// Double skins as they come from marching cubes have 4.
const FACE_NODES: Tunable<usize> = tunable("solid.face_nodes", 100);

/// Nodes along each side of a block. Blocks far from the surface or close to it take one query.
const BLOCK: usize = 4;

/// A lattice of the positions of a ball's centre.
struct BallLattice {
    /// The position of the first node.
    origin: DVec3,
    /// The distance of neighbouring nodes, in mesh units.
    spacing: f64,
    /// The number of nodes along each axis, a multiple of [`BLOCK`].
    dims: [usize; 3],
}

impl BallLattice {
    /// A lattice round a box, with the outermost nodes farther than `radius` from it; none if it has more than `most` nodes.
    fn new([low, high]: [DVec3; 2], radius: f64, spacing: f64, most: usize) -> Option<Self> {
        let margin = radius + 2.0 * spacing;
        let size = (high - low + 2.0 * margin) / spacing;
        if size.element_product() > most as f64 {
            return None;
        }
        let count = |n: f64| (n.ceil() as usize + 1).next_multiple_of(BLOCK);
        Some(Self {
            origin: low - DVec3::splat(margin),
            spacing,
            dims: size.to_array().map(count),
        })
    }

    fn position(&self, [i, j, k]: [usize; 3]) -> DVec3 {
        self.origin + self.spacing * DVec3::new(i as f64, j as f64, k as f64)
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.dims[1] + j) * self.dims[0] + i
    }

    /// For each node whether the surface is farther than `radius`.
    fn free(&self, bvh: &Bvh, radius: f64) -> Vec<bool> {
        let [nx, ny, nz] = self.dims;
        let mut free = vec![true; nx * ny * nz];
        let slabs = free.par_chunks_mut(nx * ny * BLOCK).enumerate();
        slabs.for_each(|(slab, free)| {
            for block in 0..(nx / BLOCK) * (ny / BLOCK) {
                let first = [
                    block % (nx / BLOCK) * BLOCK,
                    block / (nx / BLOCK) * BLOCK,
                    slab * BLOCK,
                ];
                self.mark_block(bvh, radius, first, free);
            }
        });
        free
    }

    /// Marks the nodes of a block that are not free. `free` are the nodes of the block's layers.
    fn mark_block(&self, bvh: &Bvh, radius: f64, first: [usize; 3], free: &mut [bool]) {
        let half = 0.5 * (BLOCK - 1) as f64 * self.spacing;
        let reach = half * 3f64.sqrt();
        let middle = self.position(first) + DVec3::splat(half);
        let Some(nearest) = bvh.closest(middle, radius + reach) else {
            return;
        };
        let is_blocked = nearest.distance + reach <= radius;
        for node in 0..BLOCK.pow(3) {
            let offset = [node % BLOCK, node / BLOCK % BLOCK, node / BLOCK.pow(2)];
            let at = [0, 1, 2].map(|k| first[k] + offset[k]);
            if is_blocked || bvh.closest(self.position(at), radius).is_some() {
                let [nx, ny, _] = self.dims;
                free[(offset[2] * ny + at[1]) * nx + at[0]] = false;
            }
        }
    }

    /// The free nodes that are connected with the first node, which is outside.
    fn flood(&self, mut free: Vec<bool>) -> Vec<bool> {
        let mut reached = vec![false; free.len()];
        let mut stack = vec![0];
        (free[0], reached[0]) = (false, true);
        let [nx, ny, nz] = self.dims;
        while let Some(n) = stack.pop() {
            let (i, j, k) = (n % nx, n / nx % ny, n / (nx * ny));
            let steps = [
                (i > 0, n.wrapping_sub(1)),
                (i + 1 < nx, n + 1),
                (j > 0, n.wrapping_sub(nx)),
                (j + 1 < ny, n + nx),
                (k > 0, n.wrapping_sub(nx * ny)),
                (k + 1 < nz, n + nx * ny),
            ];
            for (_, m) in steps.into_iter().filter(|(inside, _)| *inside) {
                if free[m] {
                    (free[m], reached[m]) = (false, true);
                    stack.push(m);
                }
            }
        }
        reached
    }

    /// Whether a marked node is within a distance of a point.
    fn is_near(&self, marked: &[bool], p: DVec3, distance: f64) -> bool {
        let last = |k: usize| (self.dims[k] - 1) as f64;
        let q = (p - self.origin) / self.spacing;
        let reach = distance / self.spacing;
        let low = [0, 1, 2].map(|k| (q[k] - reach).ceil().clamp(0.0, last(k)) as usize);
        let high = [0, 1, 2].map(|k| (q[k] + reach).floor().clamp(0.0, last(k)) as usize);
        for k in low[2]..=high[2] {
            for j in low[1]..=high[1] {
                for i in low[0]..=high[0] {
                    let offset = DVec3::new(i as f64, j as f64, k as f64) - q;
                    if marked[self.index([i, j, k])] && offset.length_squared() <= reach * reach {
                        return true;
                    }
                }
            }
        }
        false
    }
}

/// For each of some points of a surface whether a ball with the given radius, in mesh units, that comes from outside and does not
/// meet the surface touches it there. `within` is the bounding box of the surface. None if the ball is so small that the lattice would have too many nodes.
pub(super) fn reached(
    bvh: &Bvh,
    within: [DVec3; 2],
    points: &[DVec3],
    radius: f64,
) -> Option<Vec<bool>> {
    let spacing = radius / RADIUS_NODES.get();
    let most = NODES.get().min(1_000_000 + FACE_NODES.get() * points.len());
    let lattice = BallLattice::new(within, radius, spacing, most)?;
    let outside = lattice.flood(lattice.free(bvh, radius));
    // The centre of a ball that touches may lie half a cell's diagonal from a node.
    let distance = radius + 0.5 * 3f64.sqrt() * spacing;
    let near = |p: &DVec3| lattice.is_near(&outside, *p, distance);
    Some(points.par_iter().map(near).collect_indexed())
}
