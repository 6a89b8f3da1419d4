//! Samples the signed distance at the nodes of a lattice, only where its values matter.
//!
//! A distance query costs far more than all other work at a node. Where a lattice of twice the voxel shows that a node is well
//! inside or well outside the free part, the node takes values interpolated from that lattice.

use glam::DVec3;
use rayon::prelude::*;

use super::distance::{DistanceData, NodeData, Wanted};
use crate::grid::{
    BLOCK_NODES, Lattice, NodeIndex, SparseGrid, as_point, dilate, linear, value_and_gradient,
};
use crate::tuning::{Tunable, tunable};

/// Voxels. A node near a hole that is farther than this from the known surface is a deep node: it may be free although a
/// rim is not the nearest part of the surface.
const DEEP: Tunable<f64> = tunable("region.deep", 5.5);

/// Voxels. Upper bound of the distance between a node and the nearest coarser node, with a margin for the difference
/// between the triangles and the smooth surface.
const SPACING: Tunable<f64> = tunable("region.spacing", 2.0);

/// Nodes. Width of the fixed margin at the sides of the box.
const FIXED_MARGIN_NODES: i32 = 3;
/// Voxels. No band reaches nodes farther than this from the known surface: there the distance to its triangles is accurate
/// enough.
pub fn smooth_band() -> f64 {
    FLOW_BAND.get() + 1.0
}
/// Nodes. The flow depends on fixed nodes within this distance of a free one.
const STENCIL_NODES: usize = 3;
/// Voxels. Nodes farther than this from the surface are outside the band, which has the corners of the cells that touch nodes within 3.5
/// voxels: only the initialisation of the flow uses their values. With 8 voxels fills of 143 holes of scans take 1.04 times as
/// long (median of three runs), with an error of 9.84 thousandths of the diameter instead of 9.80.
const FLOW_BAND: Tunable<f64> = tunable("region.flow_band", 5.25);
/// Voxels. Half-width of the band around the evolved surface whose surroundings are sampled anew on the next finer lattice.
const RESAMPLED_BAND_VOXELS: f64 = 2.0;
/// Number of coarser lattices, each of twice the voxel of the next, that are sampled before the nodes of a box.
const COARSER_LATTICES: usize = 2;

/// What is known about a node before its distance is sampled.
pub enum Known {
    /// φ in voxels, and whether the node is free unless it is at the side of the box.
    Node(f64, bool),
    /// Nothing: the distance has to be sampled.
    Nothing {
        /// As in [`Wanted`].
        any_sign: bool,
        /// Estimated upper bound, not guaranteed, of the distance to the known surface in voxels; infinite where there is none.
        within: f64,
    },
}

impl Known {
    /// Nothing is known, not even a bound.
    pub fn nothing(any_sign: bool) -> Self {
        Self::Nothing {
            any_sign,
            within: f64::INFINITY,
        }
    }
}

/// The values on a lattice of twice the voxel.
pub struct Coarser<'a> {
    grid: &'a SparseGrid,
    phi: &'a [f64],
    free: &'a [bool],
    /// Whether all neighbours of a node are free.
    inner: Vec<bool>,
    /// Whether a node is within one step of a free one.
    within_one: Vec<bool>,
    /// Whether a node is within two steps of a free one.
    within_two: Vec<bool>,
}

impl<'a> Coarser<'a> {
    /// From φ in the lattice's own voxels and the free nodes.
    pub fn new(grid: &'a SparseGrid, phi: &'a [f64], free: &'a [bool]) -> Self {
        let fixed: Vec<bool> = free.iter().map(|f| !f).collect();
        let inner = dilate(grid, &fixed).into_iter().map(|f| !f).collect();
        let within_one = dilate(grid, free);
        Self {
            within_two: dilate(grid, &within_one),
            within_one,
            grid,
            phi,
            free,
            inner,
        }
    }

    /// Marks the nodes within two steps of a free one.
    pub fn near_free(&self) -> &[bool] {
        &self.within_two
    }

    /// Marks the nodes within two steps of a free one near the evolved surface. In thin parts there may be fixed nodes among them
    /// whose distances refer to the opposite wall.
    fn close_to_evolved(&self) -> Vec<bool> {
        let free = self.phi.iter().zip(self.free);
        let near: Vec<bool> = free
            .map(|(v, &f)| f && v.abs() < RESAMPLED_BAND_VOXELS)
            .collect();
        dilate(self.grid, &dilate(self.grid, &near))
    }

    /// The slot of the coarser node nearest to a node of the finer lattice.
    fn nearest_slot(&self, fine: NodeIndex) -> Option<usize> {
        self.grid.slot(fine.map(|i| (i + 1) / 2))
    }

    /// φ prolonged to a node of the finer lattice, in its voxels.
    fn prolonged(&self, fine: NodeIndex) -> Option<f64> {
        let p = 0.5 * as_point(fine);
        value_and_gradient(self.grid, self.phi, p)
            .map(|v| v.0)
            .or_else(|| linear(self.grid, self.phi, p))
            .map(|v| 2.0 * v)
    }

    /// Whether a node of the finer lattice is free, unless it is at the side of the box; none where the data have to be sampled.
    fn is_free(&self, fine: NodeIndex) -> Option<bool> {
        let slot = self.nearest_slot(fine)?;
        if self.inner[slot] {
            return Some(true);
        }
        (!self.within_two[slot]).then_some(false)
    }

    /// The same where φ belongs to the known surface alone. Nodes farther from it than `far` (in coarser voxels) are free if one
    /// of the coarser nodes around them is. `close` marks the coarser nodes near a free one.
    fn is_free_by_known(&self, fine: NodeIndex, far: f64, close: &[bool]) -> Option<bool> {
        let slot = self.nearest_slot(fine)?;
        if self.phi[slot].abs() < far {
            return match self.inner[slot] {
                true => Some(true),
                false => (!close[slot]).then_some(false),
            };
        }
        Some((0..8).any(|a: i32| {
            let corner = [a >> 2, a >> 1, a].map(|bit| bit & 1);
            let corner = std::array::from_fn(|d| (fine[d] + corner[d]) / 2);
            self.grid.slot(corner).is_some_and(|s| self.free[s])
        }))
    }

    /// φ at a node of the finer lattice, and whether the node is free unless it is at the side of the box, where φ belongs to an
    /// evolved surface; `close` marks the nodes near that surface. None where the data have to be sampled.
    fn value_by_evolved(&self, fine: NodeIndex, close: &[bool]) -> Option<(f64, bool)> {
        let (value, slot) = (self.prolonged(fine)?, self.nearest_slot(fine)?);
        let free = match self.is_free(fine) {
            None if value.abs() > FLOW_BAND.get() && !close[slot] => self.free[slot],
            known_free => known_free?,
        };
        Some((value, free))
    }

    /// Estimated upper bound, not guaranteed, of the distance from a node of the finer lattice to the known surface, in its
    /// voxels.
    fn within(&self, fine: NodeIndex) -> f64 {
        let slot = self.nearest_slot(fine).filter(|&s| !self.free[s]);
        slot.map_or(f64::INFINITY, |s| 2.0 * self.phi[s].abs() + SPACING.get())
    }
}

/// Sampling of a region's data at the nodes of a grid.
#[derive(Clone, Copy)]
pub struct Sampling<'a> {
    /// The positions of the nodes.
    pub lattice: &'a Lattice,
    /// The nodes.
    pub grid: &'a SparseGrid,
    /// The data to sample.
    pub data: &'a dyn DistanceData,
    /// The voxel in which `reach` and the depth of deep nodes are measured.
    pub voxel: f64,
    /// Voxels. Nodes farther than this from the known surface take the distance to its triangles instead of the smooth surface;
    /// usually [`smooth_band`].
    pub reach: f64,
}

/// Values at the nodes after sampling.
struct Sampled {
    /// φ in voxels.
    phi: Vec<f64>,
    /// Whether a node is free unless it is at the side of the box.
    free: Vec<bool>,
    /// Whether the values of a node were sampled, not interpolated.
    exact: Vec<bool>,
}

impl Sampling<'_> {
    /// φ in voxels and the mask of free nodes; only unknown nodes are sampled.
    pub fn except(&self, known: &(dyn Fn(NodeIndex) -> Known + Sync)) -> (Vec<f64>, Vec<bool>) {
        let Sampled { phi, free, .. } = self.sample(known);
        let mask = self.inside(&free);
        (phi, mask)
    }

    /// φ and mask on a lattice of half the voxel: φ is prolonged where it is free.
    pub fn refining(&self, coarser: &Coarser) -> (Vec<f64>, Vec<bool>) {
        let close = coarser.close_to_evolved();
        let known = |n: NodeIndex| match coarser.value_by_evolved(n, &close) {
            Some((value, free)) => Known::Node(value, free),
            None => Known::Nothing {
                any_sign: self.grid.is_interior(n, FIXED_MARGIN_NODES),
                within: coarser.within(n),
            },
        };
        let (mut phi, mask) = self.except(&known);
        phi.par_iter_mut().enumerate().for_each(|(s, v)| {
            let n = self.grid.node(s);
            if mask[s]
                && !self.grid.is_cancelled()
                && coarser.is_free(n).is_none()
                && let Some(prolonged) = coarser.prolonged(n)
            {
                *v = prolonged;
            }
        });
        (phi, mask)
    }

    /// φ and mask of a whole box, sampled from coarse to fine. The values of free nodes are only a rough initialisation.
    pub fn of_box(&self) -> (Vec<f64>, Vec<bool>) {
        let Sampled { phi, free, .. } = self.sample_from_coarse(COARSER_LATTICES, self.grid.dims());
        let mask = self.inside(&free);
        (phi, mask)
    }

    /// φ in voxels of the nodes of a whole box, and whether they are free unless they are at its side. `dims` are the box's nodes
    /// on the last lattice. Nodes at the side are fixed: their signs must be right, and so must the signs of the coarser nodes
    /// from which they may be interpolated.
    fn sample_from_coarse(&self, depth: usize, dims: NodeIndex) -> Sampled {
        // On this lattice nodes are `spacing` nodes of the last lattice apart. Those near the side of the box need the right
        // sign.
        let last = depth == COARSER_LATTICES;
        let spacing = 1 << (COARSER_LATTICES - depth);
        let border = FIXED_MARGIN_NODES + if last { 0 } else { spacing };
        let inside =
            |n: NodeIndex| (0..3).all(|d| (border..dims[d] - border).contains(&(spacing * n[d])));
        if depth == 0 {
            return self.sample(&|n| Known::nothing(inside(n)));
        }
        // The coarser lattice: every other node of this one.
        let lattice = Lattice {
            origin: self.lattice.origin,
            voxel: 2.0 * self.lattice.voxel,
        };
        let grid = SparseGrid::new(self.grid.dims().map(|d| d / 2), |_| true)
            .stopped_by(self.grid.cancel());
        let Sampled { phi, free, .. } = Sampling {
            lattice: &lattice,
            grid: &grid,
            // Only the mask of coarser nodes is used, and values that nothing depends on.
            reach: 0.0,
            ..*self
        }
        .sample_from_coarse(depth - 1, dims);
        // Nodes well inside or outside the free part take values interpolated from the coarser lattice.
        let coarser = Coarser::new(&grid, &phi, &free);
        // Half a coarse voxel more, for the distance between coarser and finer nodes.
        let far = FLOW_BAND.get() * self.voxel / lattice.voxel + if last { 0.0 } else { 0.5 };
        // The fixed nodes on which the flow depends are sampled once the free ones are known.
        let margin = if last {
            &coarser.within_one
        } else {
            &coarser.within_two
        };
        let sampled = self.sample(&|n| {
            let any_sign = inside(n);
            // At the side of the box all nodes are fixed; the outermost have no cell or stencil that uses their values.
            let matters = !any_sign && self.grid.is_interior(n, 1);
            let value = linear(&grid, &phi, 0.5 * as_point(n));
            let close = value.is_none_or(|v| v.abs() < far + 0.5);
            let known_free = coarser
                .is_free_by_known(n, far, margin)
                .filter(|&free| !(free && matters && close));
            let node = || Some(Known::Node(2.0 * value?, known_free?));
            node().unwrap_or_else(|| Known::Nothing {
                any_sign,
                within: coarser.within(n),
            })
        });
        // The flow uses the values of fixed nodes near free ones: these are sampled.
        if last {
            self.with_stencils(sampled, &|n| coarser.within(n))
        } else {
            sampled
        }
    }

    /// Samples the fixed nodes on which free ones depend and whose values in `before` are interpolated.
    fn with_stencils(
        &self,
        before: Sampled,
        within: &(dyn Fn(NodeIndex) -> f64 + Sync),
    ) -> Sampled {
        let mut near = self.inside(&before.free);
        for _ in 0..STENCIL_NODES {
            near = dilate(self.grid, &near);
        }
        self.sample(&|n| match self.grid.slot(n) {
            Some(s)
                if before.free[s]
                    || !near[s]
                    || before.exact[s]
                    || before.phi[s].abs() > FLOW_BAND.get() =>
            {
                Known::Node(before.phi[s], before.free[s])
            }
            _ => Known::Nothing {
                any_sign: false,
                within: within(n),
            },
        })
    }

    /// The mask, from the nodes that are free unless they are at the side of the box.
    fn inside(&self, free: &[bool]) -> Vec<bool> {
        let inside = |s: usize| self.grid.is_interior(self.grid.node(s), FIXED_MARGIN_NODES);
        let mask = free.iter().enumerate();
        mask.map(|(s, &free)| free && inside(s)).collect()
    }

    /// Samples all nodes about which nothing is known.
    fn sample(&self, known: &(dyn Fn(NodeIndex) -> Known + Sync)) -> Sampled {
        let mut samples = vec![(0.0, false, false); self.grid.len()];
        let blocks = samples.par_chunks_mut(BLOCK_NODES).enumerate();
        blocks.for_each(|(b, samples)| {
            // Walks through the block in order, so that the distance at each node bounds the distance at the next.
            let mut last: Option<(DVec3, NodeData, Option<DVec3>)> = None;
            for (i, sample) in samples.iter_mut().enumerate() {
                if self.grid.is_cancelled() {
                    return;
                }
                let n = self.grid.node(b * BLOCK_NODES + i);
                let (any_sign, within) = match known(n) {
                    Known::Node(value, free) => {
                        *sample = (value, free, false);
                        continue;
                    }
                    Known::Nothing { any_sign, within } => (any_sign, within * self.lattice.voxel),
                };
                let x = self.lattice.to_world(as_point(n));
                let limit = last.map_or(within, |(y, s, closest)| {
                    let bound = closest.map_or(s.distance + x.distance(y), |p| p.distance(x));
                    bound * (1.0 + 1e-9) + 1e-9 * self.voxel
                });
                let wanted = Wanted {
                    any_sign,
                    reach: self.reach * self.voxel,
                    deep: DEEP.get() * self.voxel,
                };
                let (s, closest) = self.data.sample_for(x, limit, &wanted);
                last = Some((x, s, closest));
                *sample = (s.signed / self.lattice.voxel, s.free, true);
            }
        });
        Sampled {
            phi: samples.iter().map(|s| s.0).collect(),
            free: samples.iter().map(|s| s.1).collect(),
            exact: samples.iter().map(|s| s.2).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit sphere whose upper part is missing. Free points that may have a wrong sign get one.
    struct Bowl;

    impl DistanceData for Bowl {
        fn sample(&self, x: DVec3, limit: f64) -> NodeData {
            self.sample_for(x, limit, &Wanted::exact()).0
        }

        fn sample_for(&self, x: DVec3, _: f64, wanted: &Wanted) -> (NodeData, Option<DVec3>) {
            let signed = x.length() - 1.0;
            let free = x.z > 0.2 * x.length();
            let wrong = free && wanted.any_sign;
            let data = NodeData {
                signed: if wrong { -signed } else { signed },
                distance: signed.abs(),
                free,
            };
            (data, None)
        }
    }

    /// A lattice around the bowl, and its nodes.
    fn box_of(dims: NodeIndex, voxel: f64) -> (Lattice, SparseGrid) {
        let lattice = Lattice {
            origin: -0.5 * voxel * as_point(dims) + DVec3::splat(0.3 * voxel),
            voxel,
        };
        (lattice, SparseGrid::new(dims, |_| true))
    }

    fn sampling<'a>((lattice, grid): &'a (Lattice, SparseGrid)) -> Sampling<'a> {
        Sampling {
            lattice,
            grid,
            data: &Bowl,
            voxel: lattice.voxel,
            reach: smooth_band(),
        }
    }

    /// The signed distance of a node from the sphere, in voxels.
    fn distance((lattice, _): &(Lattice, SparseGrid), n: NodeIndex) -> f64 {
        (lattice.to_world(as_point(n)).length() - 1.0) / lattice.voxel
    }

    #[test]
    fn signs_are_right_at_the_sides_of_boxes_of_any_size() {
        for dims in [[32, 32, 32], [36, 40, 44], [44, 36, 40], [40, 44, 36]] {
            let nodes = box_of(dims, 0.07);
            let (phi, mask) = sampling(&nodes).of_box();
            let grid = &nodes.1;
            for (slot, value) in phi.into_iter().enumerate() {
                let n = grid.node(slot);
                if grid.is_interior(n, FIXED_MARGIN_NODES) {
                    continue;
                }
                assert!(!mask[slot]);
                let wanted = distance(&nodes, n);
                if grid.is_interior(n, 1) {
                    assert!(
                        (value - wanted).abs() < 0.3,
                        "{dims:?} {n:?}: {value} {wanted}"
                    );
                }
            }
        }
    }

    #[test]
    fn fixed_nodes_that_the_flow_depends_on_are_not_interpolated() {
        let nodes = box_of([36, 40, 44], 0.07);
        let (phi, mask) = sampling(&nodes).of_box();
        let grid = &nodes.1;
        let mut near = mask.clone();
        for _ in 0..STENCIL_NODES {
            near = dilate(grid, &near);
        }
        let mut exact = 0;
        for (slot, &value) in phi.iter().enumerate() {
            let n = grid.node(slot);
            let wanted = distance(&nodes, n);
            if near[slot]
                && !mask[slot]
                && wanted.abs() < FLOW_BAND.get() - 1.0
                && grid.is_interior(n, FIXED_MARGIN_NODES)
            {
                assert!((value - wanted).abs() < 1e-9, "{n:?}: {value} {wanted}");
                exact += 1;
            }
        }
        let free = mask.iter().filter(|&&m| m).count();
        assert!(
            exact > 1000 && exact < phi.len() / 4 && free > 1000,
            "{exact} {free}"
        );
    }

    #[test]
    fn free_nodes_well_inside_are_not_sampled() {
        let nodes = box_of([36, 40, 44], 0.07);
        let sampled = sampling(&nodes).sample_from_coarse(COARSER_LATTICES, nodes.1.dims());
        let mut edge: Vec<bool> = sampled.free.iter().map(|f| !f).collect();
        for _ in 0..3 {
            edge = dilate(&nodes.1, &edge);
        }
        let mut well_inside = 0;
        for slot in (0..edge.len()).filter(|&s| !edge[s]) {
            let n = nodes.1.node(slot);
            if nodes.1.is_interior(n, FIXED_MARGIN_NODES + 1) {
                assert!(!sampled.exact[slot], "{n:?}");
                well_inside += 1;
            }
        }
        assert!(well_inside > 1000, "{well_inside}");
    }
}
