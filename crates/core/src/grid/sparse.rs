//! A sparse regular lattice that stores only some blocks of nodes.

use glam::DVec3;

use crate::cancel::Cancel;

/// Nodes along the edge of a block.
pub const BLOCK: i32 = 4;
/// Nodes of a block.
pub const BLOCK_NODES: usize = (BLOCK * BLOCK * BLOCK) as usize;
/// Marks a node or block that is not stored.
pub const ABSENT: u32 = u32::MAX;

/// Integer coordinates of a node.
pub type NodeIndex = [i32; 3];

/// The node at an offset from another node.
#[inline]
pub fn add(n: NodeIndex, o: NodeIndex) -> NodeIndex {
    [n[0] + o[0], n[1] + o[1], n[2] + o[2]]
}

/// The offset of the i-th node of a 3 × 3 × 3 neighbourhood, in lexicographic order.
#[inline]
pub fn offset(i: i32) -> NodeIndex {
    [i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1]
}

/// The position of a node in lattice coordinates.
#[inline]
pub fn as_point(n: NodeIndex) -> DVec3 {
    DVec3::new(n[0].into(), n[1].into(), n[2].into())
}

/// The position and spacing of a lattice in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// World position of node (0, 0, 0).
    pub origin: DVec3,
    /// Distance of neighbouring nodes in world units.
    pub voxel: f64,
}

impl Lattice {
    /// World position of a point in lattice coordinates.
    pub fn to_world(self, x: DVec3) -> DVec3 {
        self.origin + x * self.voxel
    }

    /// Lattice coordinates of a world position.
    pub fn to_lattice(self, p: DVec3) -> DVec3 {
        (p - self.origin) / self.voxel
    }

    /// Estimated number of blocks of the lattice around a box with `margin` on all sides.
    pub fn blocks(low: DVec3, high: DVec3, margin: DVec3, voxel: f64) -> f64 {
        let nodes = ((high - low + 2.0 * margin) / voxel).ceil() + 1.0;
        (nodes / f64::from(BLOCK)).ceil().element_product()
    }

    /// The lattice around a box with `margin` on all sides, and its size in nodes, rounded up to whole blocks.
    pub fn around(low: DVec3, high: DVec3, margin: DVec3, voxel: f64) -> (Self, NodeIndex) {
        let nodes = ((high - low + 2.0 * margin) / voxel).ceil() + 1.0;
        let blocks = (nodes / f64::from(BLOCK)).ceil().as_ivec3();
        let dims = (BLOCK * blocks).to_array();
        let size = DVec3::from_array(dims.map(|d| f64::from(d - 1))) * voxel;
        // An irregular offset keeps nodes off the symmetry planes and vertices of regular meshes.
        let offset = voxel * DVec3::new(0.0137, -0.0251, 0.0319);
        let origin = 0.5 * (low + high) - 0.5 * size + offset;
        (Self { origin, voxel }, dims)
    }
}

/// The stored nodes of a box of `dims` nodes, in blocks of 4 × 4 × 4. Blocks are in lexicographic order.
#[derive(Clone, Debug)]
pub struct SparseGrid {
    dims: NodeIndex,
    block_dims: NodeIndex,
    map: Vec<u32>,
    blocks: Vec<NodeIndex>,
    cancel: Cancel,
}

impl SparseGrid {
    /// A box that stores the blocks for which `wanted(corner node of the block)` is true. `dims` are rounded up to
    /// whole blocks.
    pub fn new(dims: NodeIndex, mut wanted: impl FnMut(NodeIndex) -> bool) -> Self {
        let block_dims = dims.map(|d| (d + BLOCK - 1) / BLOCK);
        let count = block_dims.iter().map(|&d| d as usize).product();
        let (mut map, mut blocks) = (vec![ABSENT; count], Vec::new());
        let mut at = 0;
        for i in 0..block_dims[0] {
            for j in 0..block_dims[1] {
                for k in 0..block_dims[2] {
                    let corner = [i * BLOCK, j * BLOCK, k * BLOCK];
                    if wanted(corner) {
                        map[at] = blocks.len() as u32;
                        blocks.push(corner);
                    }
                    at += 1;
                }
            }
        }
        Self {
            dims: block_dims.map(|d| d * BLOCK),
            block_dims,
            map,
            blocks,
            cancel: Cancel::new(),
        }
    }

    /// Sets the token that cancels computations on this grid.
    #[must_use]
    pub fn stopped_by(mut self, cancel: &Cancel) -> Self {
        self.cancel = cancel.clone();
        self
    }

    /// The token that cancels computations on this grid.
    pub fn cancel(&self) -> &Cancel {
        &self.cancel
    }

    /// Whether computations on this grid should stop.
    #[inline]
    pub fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }

    /// Nodes of the whole box along each axis.
    pub fn dims(&self) -> NodeIndex {
        self.dims
    }

    /// Number of stored nodes.
    pub fn len(&self) -> usize {
        self.blocks.len() * BLOCK_NODES
    }

    /// Whether no node is stored.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Corner nodes of the stored blocks.
    pub fn blocks(&self) -> &[NodeIndex] {
        &self.blocks
    }

    /// The slot (index in a field) of a node; `None` if it is not stored.
    #[inline]
    pub fn slot(&self, n: NodeIndex) -> Option<usize> {
        let inside = (0..3).all(|a| n[a] >= 0 && n[a] < self.dims[a]);
        if !inside {
            return None;
        }
        let b = [n[0] >> 2, n[1] >> 2, n[2] >> 2];
        let at = (b[0] * self.block_dims[1] + b[1]) * self.block_dims[2] + b[2];
        let block = self.map[at as usize];
        if block == ABSENT {
            return None;
        }
        let local = ((n[0] & 3) << 4) | ((n[1] & 3) << 2) | (n[2] & 3);
        Some(block as usize * BLOCK_NODES + local as usize)
    }

    /// Copies the field values at the 4 × 4 × 4 nodes from `corner` on, in lexicographic order. False if a node is not
    /// stored. The nodes must be within the box.
    #[inline]
    pub(crate) fn gather_cube(
        &self,
        corner: NodeIndex,
        field: &[f64],
        values: &mut [f64; 64],
    ) -> bool {
        // The cube overlaps at most two blocks along each axis.
        let first = corner.map(|c| c >> 2);
        let mut blocks = [0; 8];
        for (i, block) in blocks.iter_mut().enumerate() {
            let b: NodeIndex = std::array::from_fn(|d| {
                let second = (i >> (2 - d)) & 1 == 1 && corner[d] & 3 != 0;
                first[d] + i32::from(second)
            });
            let at = (b[0] * self.block_dims[1] + b[1]) * self.block_dims[2] + b[2];
            *block = self.map[at as usize];
            if *block == ABSENT {
                return false;
            }
        }
        let along = |d: usize, shift: u32| -> [(usize, usize); 4] {
            std::array::from_fn(|i| {
                let local = (corner[d] & 3) as usize + i;
                (local >> 2, (local & 3) << shift)
            })
        };
        let (x, y, z) = (along(0, 4), along(1, 2), along(2, 0));
        for (row, values) in values.chunks_exact_mut(4).enumerate() {
            let (x, y) = (x[row >> 2], y[row & 3]);
            for (value, z) in values.iter_mut().zip(z) {
                let block = blocks[4 * x.0 + 2 * y.0 + z.0] as usize;
                *value = field[block * BLOCK_NODES + x.1 + y.1 + z.1];
            }
        }
        true
    }

    /// The slots of the 3 × 3 × 3 nodes around the node at `slot`, in lexicographic order; `ABSENT` for nodes that are
    /// not stored.
    #[inline]
    pub(crate) fn around(&self, slot: usize) -> [u32; 27] {
        let local = slot % BLOCK_NODES;
        let local = [local >> 4, (local >> 2) & 3, local & 3];
        let own = self.blocks[slot / BLOCK_NODES].map(|c| c >> 2);
        // The neighbourhood overlaps at most one other block along each axis.
        let side = local.map(|l| i32::from(l == 3) - i32::from(l == 0));
        let blocks: [u32; 8] = std::array::from_fn(|i| {
            let b: NodeIndex = std::array::from_fn(|d| {
                let other = (i >> (2 - d)) & 1 == 1;
                own[d] + if other { side[d] } else { 0 }
            });
            let inside = (0..3).all(|d| b[d] >= 0 && b[d] < self.block_dims[d]);
            let at = (b[0] * self.block_dims[1] + b[1]) * self.block_dims[2] + b[2];
            if inside {
                self.map[at as usize]
            } else {
                ABSENT
            }
        });
        let along: [[(usize, u32); 3]; 3] = std::array::from_fn(|d| {
            std::array::from_fn(|i| {
                // Shifted by one block, so that the number is not negative.
                let next = local[d] + i + 3;
                (usize::from(!(4..8).contains(&next)), (next & 3) as u32)
            })
        });
        std::array::from_fn(|i| {
            let (x, y, z) = (along[0][i / 9], along[1][i / 3 % 3], along[2][i % 3]);
            let block = blocks[4 * x.0 + 2 * y.0 + z.0];
            if block == ABSENT {
                ABSENT
            } else {
                block * BLOCK_NODES as u32 + 16 * x.1 + 4 * y.1 + z.1
            }
        })
    }

    /// For each stored block, the bitwise OR of `of` over all slots of the block and of its 26 neighbours.
    pub(crate) fn or_with_neighbours(&self, of: impl Fn(usize) -> u8) -> Vec<u8> {
        let range = |b: usize| b * BLOCK_NODES..(b + 1) * BLOCK_NODES;
        let own: Vec<u8> = (0..self.blocks.len())
            .map(|b| range(b).fold(0, |sum, s| sum | of(s)))
            .collect();
        (0..self.blocks.len())
            .map(|b| {
                let round = (0..27).filter_map(|i| self.neighbour_block(b, offset(i)));
                round.fold(0, |sum, b| sum | own[b])
            })
            .collect()
    }

    /// The stored block at an offset (in blocks) from another block.
    pub(crate) fn neighbour_block(&self, block: usize, offset: NodeIndex) -> Option<usize> {
        let slot = self.slot(add(self.blocks[block], offset.map(|o| o * BLOCK)))?;
        Some(slot / BLOCK_NODES)
    }

    /// The node at a slot.
    #[inline]
    pub fn node(&self, slot: usize) -> NodeIndex {
        let corner = self.blocks[slot / BLOCK_NODES];
        let local = (slot % BLOCK_NODES) as i32;
        [
            corner[0] + (local >> 4),
            corner[1] + ((local >> 2) & 3),
            corner[2] + (local & 3),
        ]
    }

    /// Whether a node is at least `margin` nodes away from the faces of the box.
    pub fn is_interior(&self, n: NodeIndex, margin: i32) -> bool {
        (0..3).all(|a| n[a] >= margin && n[a] < self.dims[a] - margin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_and_nodes_are_inverse_of_each_other() {
        let grid = SparseGrid::new([9, 8, 13], |c| (c[0] + c[1] + c[2]) % 8 == 0);
        assert_eq!(grid.dims(), [12, 8, 16]);
        for slot in 0..grid.len() {
            assert_eq!(grid.slot(grid.node(slot)), Some(slot));
        }
        for slot in 0..grid.len() {
            let around = std::array::from_fn(|i| {
                let i = i as i32;
                let near = add(grid.node(slot), [i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1]);
                grid.slot(near).map_or(ABSENT, |s| s as u32)
            });
            assert_eq!(grid.around(slot), around);
        }
        assert_eq!(grid.slot([4, 0, 0]), None);
        assert_eq!(grid.slot([-1, 0, 0]), None);
        assert_eq!(grid.slot([12, 0, 0]), None);
    }
}
