//! Dilation of sets of lattice nodes, with one 64-bit word per block.

use rayon::prelude::*;

use super::sparse::{BLOCK_NODES, SparseGrid, offset};

/// For each axis: the bit distance of neighbours in a word, and the masks of the nodes at the low and the high end of a
/// block.
const AXES: [(u32, u64, u64); 3] = [
    (16, 0xffff, 0xffff << 48),
    (4, 0x000f_000f_000f_000f, 0xf000_f000_f000_f000),
    (1, 0x1111_1111_1111_1111, 0x8888_8888_8888_8888),
];

/// Marks the nodes within one step (26 neighbours) of a marked node.
pub fn dilate(grid: &SparseGrid, marked: &[bool]) -> Vec<bool> {
    if grid.is_cancelled() {
        return marked.to_vec();
    }
    let word = |nodes: &[bool]| {
        let bits = nodes.iter().enumerate();
        bits.fold(0, |word, (i, &m)| word | u64::from(m) << i)
    };
    let words: Vec<u64> = marked.chunks_exact(BLOCK_NODES).map(word).collect();
    let mut out = vec![false; marked.len()];
    let blocks = out.par_chunks_exact_mut(BLOCK_NODES).enumerate();
    blocks.with_min_len(64).for_each(|(b, out)| {
        let reached = (0..27).map(offset).fold(0, |reached, o| {
            let neighbour = grid.neighbour_block(b, o);
            reached | neighbour.map_or(0, |b| reach(words[b], o))
        });
        for (i, o) in out.iter_mut().enumerate() {
            *o = (reached >> i) & 1 == 1;
        }
    });
    out
}

/// The nodes of a block within one step of marked nodes in the block at `offset`.
fn reach(marked: u64, offset: [i32; 3]) -> u64 {
    let along = |word: u64, (&o, (step, low, high)): (&i32, (u32, u64, u64))| match o {
        -1 => (word & high) >> (3 * step),
        1 => (word & low) << (3 * step),
        _ => word | (word & !high) << step | (word & !low) >> step,
    };
    if marked == 0 {
        return 0;
    }
    offset.iter().zip(AXES).fold(marked, along)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::add;

    #[test]
    fn the_26_neighbours_are_reached_across_blocks_that_are_not_stored() {
        let grid = SparseGrid::new([16, 12, 20], |c| (c[0] + 3 * c[1] + c[2]) % 16 != 4);
        let marked: Vec<bool> = (0..grid.len()).map(|s| s * 7919 % 37 == 0).collect();
        let reached = dilate(&grid, &marked);
        for (slot, &reached) in reached.iter().enumerate() {
            let near = (0..27).any(|i| {
                let offset = [i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1];
                let slot = grid.slot(add(grid.node(slot), offset));
                slot.is_some_and(|s| marked[s])
            });
            assert_eq!(reached, near);
        }
    }
}
