//! The data at the nodes of a lattice, asked for only where they matter.
//!
//! A distance query costs far more than anything else that is done for a node. Where a lattice of twice the voxel shows that a
//! node lies well inside or well outside the free part, the node takes values interpolated from that lattice.

use glam::DVec3;
use rayon::prelude::*;

use super::distance::{DistanceData, NodeData, Wanted};
use crate::grid::{
    BLOCK_NODES, Lattice, NodeIndex, SparseGrid, as_point, dilate, linear, value_and_gradient,
};
use crate::tuning::tuning;

/// Nodes at the faces of the box that are never free.
const BORDER: i32 = 3;
/// No band reaches nodes farther than this from the known surface, in voxels: the distance to its triangles is good enough there.
pub const SMOOTH: f64 = FAR + 1.0;
/// The flow depends on the values of fixed nodes within so many steps of a free one.
const DEPENDS: usize = 3;
/// Nodes farther than this from the surface, in voxels, are outside the band: only the start of the flow uses their values.
const FAR: f64 = 8.0;
/// Free nodes nearer to the evolved surface than this, in voxels, lie beside it.
const BESIDE: f64 = 2.0;
/// How many coarser lattices, each of twice the voxel of the next, are sampled before the nodes of a box.
const LOOKS: usize = 2;

/// What is known of a node before the data are sampled there.
pub enum Known {
    /// φ in voxels, and whether the node is free unless it lies at the side of the box.
    Node(f64, bool),
    /// Nothing; `rough` allows the sign to be wrong if the node turns out to be free.
    Nothing {
        /// As in [`Wanted`].
        rough: bool,
        /// An upper bound of the distance to the known surface, in voxels, that may fail; infinite where there is none.
        within: f64,
    },
}

impl Known {
    /// Nothing at all.
    pub fn nothing(rough: bool) -> Self {
        Self::Nothing {
            rough,
            within: f64::INFINITY,
        }
    }
}

/// The values on a lattice of twice the voxel.
pub struct Coarser<'a> {
    grid: &'a SparseGrid,
    phi: &'a [f64],
    free: &'a [bool],
    /// Nodes all of whose neighbours are free.
    inner: Vec<bool>,
    /// Nodes within one step of a free one.
    beside: Vec<bool>,
    /// Nodes within two steps of a free one.
    near: Vec<bool>,
}

impl<'a> Coarser<'a> {
    /// From φ in its own voxels and the free nodes.
    pub fn new(grid: &'a SparseGrid, phi: &'a [f64], free: &'a [bool]) -> Self {
        let fixed: Vec<bool> = free.iter().map(|f| !f).collect();
        let inner = dilate(grid, &fixed).into_iter().map(|f| !f).collect();
        let beside = dilate(grid, free);
        Self {
            near: dilate(grid, &beside),
            beside,
            grid,
            phi,
            free,
            inner,
        }
    }

    /// Nodes within two steps of a free one.
    pub fn near_free(&self) -> &[bool] {
        &self.near
    }

    /// Nodes within two steps of a free one beside the evolved surface: in thin parts there may be fixed ones among them
    /// whose values know only of the opposite wall.
    fn close_to_evolved(&self) -> Vec<bool> {
        let free = self.phi.iter().zip(self.free);
        let beside: Vec<bool> = free.map(|(v, &f)| f && v.abs() < BESIDE).collect();
        dilate(self.grid, &dilate(self.grid, &beside))
    }

    /// The slot of the node beside one of the finer lattice.
    fn beside(&self, fine: NodeIndex) -> Option<usize> {
        self.grid.slot(fine.map(|i| (i + 1) / 2))
    }

    /// φ at a node of the finer lattice, in its voxels.
    fn prolonged(&self, fine: NodeIndex) -> Option<f64> {
        let p = 0.5 * as_point(fine);
        value_and_gradient(self.grid, self.phi, p)
            .map(|v| v.0)
            .or_else(|| linear(self.grid, self.phi, p))
            .map(|v| 2.0 * v)
    }

    /// Whether a node of the finer lattice is free unless it lies at the side of the box; none where that has to be asked.
    fn tells(&self, fine: NodeIndex) -> Option<bool> {
        let slot = self.beside(fine)?;
        if self.inner[slot] {
            return Some(true);
        }
        (!self.near[slot]).then_some(false)
    }

    /// The same where the values are those of the known surface alone, and nodes farther from it than `far` (in the coarser
    /// voxels) are free where one of the coarser nodes round them is; `close` marks the coarser nodes that are near a free one.
    fn tells_of_known(&self, fine: NodeIndex, far: f64, close: &[bool]) -> Option<bool> {
        let slot = self.beside(fine)?;
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

    /// φ at a node of the finer lattice and whether it is free unless it lies at the side of the box, where the values are
    /// those of an evolved surface and `close` marks what is close to it; none where that has to be asked.
    fn tells_of_evolved(&self, fine: NodeIndex, close: &[bool]) -> Option<(f64, bool)> {
        let (value, slot) = (self.prolonged(fine)?, self.beside(fine)?);
        let free = match self.tells(fine) {
            None if value.abs() > FAR && !close[slot] => self.free[slot],
            told => told?,
        };
        Some((value, free))
    }

    /// A bound of the distance from a node of the finer lattice to the known surface, in its voxels, if all is well.
    fn within(&self, fine: NodeIndex) -> f64 {
        let slot = self.beside(fine).filter(|&s| !self.free[s]);
        slot.map_or(f64::INFINITY, |s| {
            2.0 * self.phi[s].abs() + tuning().region.spacing
        })
    }
}

/// The sampling of the data at the nodes of a grid.
#[derive(Clone, Copy)]
pub struct Sampling<'a> {
    /// Where its nodes are.
    pub lattice: &'a Lattice,
    /// Its nodes.
    pub grid: &'a SparseGrid,
    /// What is asked.
    pub data: &'a dyn DistanceData,
    /// The voxel that distances are compared with.
    pub voxel: f64,
    /// Nodes farther than this from the known surface, in voxels, take the distance to its triangles instead of that to the smooth
    /// surface; usually [`SMOOTH`].
    pub reach: f64,
}

/// What was found at the nodes.
struct Asked {
    /// φ in voxels.
    phi: Vec<f64>,
    /// Whether a node is free unless it lies at the side of the box.
    free: Vec<bool>,
    /// Whether its values were asked for, not interpolated.
    exact: Vec<bool>,
}

impl Sampling<'_> {
    /// φ in voxels and the mask of all nodes but those that are known.
    pub fn except(&self, known: &(dyn Fn(NodeIndex) -> Known + Sync)) -> (Vec<f64>, Vec<bool>) {
        let Asked { phi, free, .. } = self.ask(known);
        let mask = self.inside(&free);
        (phi, mask)
    }

    /// φ and mask of a lattice that halves the voxel of another: φ is prolonged where it is free.
    pub fn refining(&self, coarser: &Coarser) -> (Vec<f64>, Vec<bool>) {
        let close = coarser.close_to_evolved();
        let known = |n: NodeIndex| match coarser.tells_of_evolved(n, &close) {
            Some((value, free)) => Known::Node(value, free),
            None => Known::Nothing {
                rough: self.grid.is_interior(n, BORDER),
                within: coarser.within(n),
            },
        };
        let (mut phi, mask) = self.except(&known);
        phi.par_iter_mut().enumerate().for_each(|(s, v)| {
            let n = self.grid.node(s);
            if mask[s]
                && !self.grid.is_cancelled()
                && coarser.tells(n).is_none()
                && let Some(prolonged) = coarser.prolonged(n)
            {
                *v = prolonged;
            }
        });
        (phi, mask)
    }

    /// φ and mask of a whole box, after a look at every other node. The values of free nodes mean little.
    pub fn of_box(&self) -> (Vec<f64>, Vec<bool>) {
        let Asked { phi, free, .. } = self.looked_at(LOOKS, self.grid.dims());
        let mask = self.inside(&free);
        (phi, mask)
    }

    /// φ in voxels of the nodes of a whole box, and whether they are free unless they lie at its side; `dims` are the box's
    /// nodes at the last look. What lies at the side is fixed there: its sign must be right, and that of the coarser nodes from
    /// which it may be interpolated.
    fn looked_at(&self, looks: usize, dims: NodeIndex) -> Asked {
        // Nodes of this look are `spacing` nodes of the last one apart. Those near the side of the box need the right sign.
        let last = looks == LOOKS;
        let spacing = 1 << (LOOKS - looks);
        let border = BORDER + if last { 0 } else { spacing };
        let inside =
            |n: NodeIndex| (0..3).all(|d| (border..dims[d] - border).contains(&(spacing * n[d])));
        if looks == 0 {
            return self.ask(&|n| Known::nothing(inside(n)));
        }
        // The look before: every other node of this one.
        let lattice = Lattice {
            origin: self.lattice.origin,
            voxel: 2.0 * self.lattice.voxel,
        };
        let grid = SparseGrid::new(self.grid.dims().map(|d| d / 2), |_| true)
            .stopped_by(self.grid.cancel());
        let Asked { phi, free, .. } = Sampling {
            lattice: &lattice,
            grid: &grid,
            // From coarser nodes only the mask is taken, and values that nothing depends on.
            reach: 0.0,
            ..*self
        }
        .looked_at(looks - 1, dims);
        // From these, nodes well inside or outside the free part take interpolated values.
        let coarser = Coarser::new(&grid, &phi, &free);
        // Half a coarse voxel more, for the distance of the coarser nodes from the finer ones.
        let far = FAR * self.voxel / lattice.voxel + if last { 0.0 } else { 0.5 };
        // The fixed nodes on which the flow depends are asked once the free ones are known.
        let margin = if last { &coarser.beside } else { &coarser.near };
        let asked = self.ask(&|n| {
            let rough = inside(n);
            // At the side of the box all nodes are fixed, and the outermost have no cell or stencil that uses their values.
            let matters = !rough && self.grid.is_interior(n, 1);
            let value = linear(&grid, &phi, 0.5 * as_point(n));
            let close = value.is_none_or(|v| v.abs() < far + 0.5);
            let told = coarser
                .tells_of_known(n, far, margin)
                .filter(|&free| !(free && matters && close));
            let node = || Some(Known::Node(2.0 * value?, told?));
            node().unwrap_or_else(|| Known::Nothing {
                rough,
                within: coarser.within(n),
            })
        });
        // The flow uses the values of fixed nodes near free ones: they are asked for.
        if last {
            self.with_neighbours(asked, &|n| coarser.within(n))
        } else {
            asked
        }
    }

    /// Asks for the fixed nodes in the reach of free ones, of which `before` has interpolated values.
    fn with_neighbours(&self, before: Asked, within: &(dyn Fn(NodeIndex) -> f64 + Sync)) -> Asked {
        let mut near = self.inside(&before.free);
        for _ in 0..DEPENDS {
            near = dilate(self.grid, &near);
        }
        self.ask(&|n| match self.grid.slot(n) {
            Some(s)
                if before.free[s] || !near[s] || before.exact[s] || before.phi[s].abs() > FAR =>
            {
                Known::Node(before.phi[s], before.free[s])
            }
            _ => Known::Nothing {
                rough: false,
                within: within(n),
            },
        })
    }

    /// The mask from the nodes that are free unless they lie at the side of the box.
    fn inside(&self, free: &[bool]) -> Vec<bool> {
        let inside = |s: usize| self.grid.is_interior(self.grid.node(s), BORDER);
        let mask = free.iter().enumerate();
        mask.map(|(s, &free)| free && inside(s)).collect()
    }

    /// φ in voxels, and whether a node is free unless it lies at the side of the box.
    fn ask(&self, known: &(dyn Fn(NodeIndex) -> Known + Sync)) -> Asked {
        let mut samples = vec![(0.0, false, false); self.grid.len()];
        let blocks = samples.par_chunks_mut(BLOCK_NODES).enumerate();
        blocks.for_each(|(b, samples)| {
            // Walks the block so that each node bounds the distance of the next.
            let mut last: Option<(DVec3, NodeData, Option<DVec3>)> = None;
            for (i, sample) in samples.iter_mut().enumerate() {
                if self.grid.is_cancelled() {
                    return;
                }
                let n = self.grid.node(b * BLOCK_NODES + i);
                let (rough, within) = match known(n) {
                    Known::Node(value, free) => {
                        *sample = (value, free, false);
                        continue;
                    }
                    Known::Nothing { rough, within } => (rough, within * self.lattice.voxel),
                };
                let x = self.lattice.to_world(as_point(n));
                let limit = last.map_or(within, |(y, s, closest)| {
                    let bound = closest.map_or(s.distance + x.distance(y), |p| p.distance(x));
                    bound * (1.0 + 1e-9) + 1e-9 * self.voxel
                });
                let wanted = Wanted {
                    rough,
                    reach: self.reach * self.voxel,
                    deep: tuning().region.deep * self.voxel,
                };
                let (s, closest) = self.data.sample_for(x, limit, &wanted);
                last = Some((x, s, closest));
                *sample = (s.signed / self.lattice.voxel, s.free, true);
            }
        });
        Asked {
            phi: samples.iter().map(|s| s.0).collect(),
            free: samples.iter().map(|s| s.1).collect(),
            exact: samples.iter().map(|s| s.2).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit sphere of which the upper part is missing; free points that may have a wrong sign have one.
    struct Bowl;

    impl DistanceData for Bowl {
        fn sample(&self, x: DVec3, limit: f64) -> NodeData {
            self.sample_for(x, limit, &Wanted::exact()).0
        }

        fn sample_for(&self, x: DVec3, _: f64, wanted: &Wanted) -> (NodeData, Option<DVec3>) {
            let signed = x.length() - 1.0;
            let free = x.z > 0.2 * x.length();
            let wrong = free && wanted.rough;
            let data = NodeData {
                signed: if wrong { -signed } else { signed },
                distance: signed.abs(),
                free,
            };
            (data, None)
        }
    }

    /// A lattice round the bowl, and its nodes.
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
            reach: SMOOTH,
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
                if grid.is_interior(n, BORDER) {
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
        for _ in 0..DEPENDS {
            near = dilate(grid, &near);
        }
        let mut exact = 0;
        for (slot, &value) in phi.iter().enumerate() {
            let n = grid.node(slot);
            let wanted = distance(&nodes, n);
            if near[slot] && !mask[slot] && wanted.abs() < FAR - 1.0 && grid.is_interior(n, BORDER)
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
    fn free_nodes_well_inside_are_not_asked_for() {
        let nodes = box_of([36, 40, 44], 0.07);
        let asked = sampling(&nodes).looked_at(LOOKS, nodes.1.dims());
        let mut edge: Vec<bool> = asked.free.iter().map(|f| !f).collect();
        for _ in 0..3 {
            edge = dilate(&nodes.1, &edge);
        }
        let mut well_inside = 0;
        for slot in (0..edge.len()).filter(|&s| !edge[s]) {
            let n = nodes.1.node(slot);
            if nodes.1.is_interior(n, BORDER + 1) {
                assert!(!asked.exact[slot], "{n:?}");
                well_inside += 1;
            }
        }
        assert!(well_inside > 1000, "{well_inside}");
    }
}
