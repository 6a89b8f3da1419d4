//! Memory layout of vectors over the band's nodes, for the system of a step.

use crate::grid::NodeIndex;

/// Empty positions at either end of a run of nodes.
const PAD: u32 = 2;
/// Positions per unit of work of a thread.
pub const CHUNK: usize = 4096;

/// The band's nodes by columns along the last axis, with empty positions at the ends of each run. In each of the nine columns
/// around an active node its three neighbours are adjacent, so a row of 27 entries is nine short ones.
///
/// Positions without a node hold zero in every vector.
pub struct Layout {
    /// Number of positions.
    pub len: usize,
    /// Position of each node of the band, in rising order.
    pub position: Vec<u32>,
    /// The active nodes, which are the ones that have a row, in rising order.
    pub rows: Vec<u32>,
    /// For each row, the position of the first of the three neighbours in each column.
    pub starts: Vec<[u32; 9]>,
    /// First row of each chunk of [`CHUNK`] positions; the last entry is the number of rows.
    chunks: Vec<usize>,
}

impl Layout {
    /// Lays out nodes given in lexicographic order. `neighbours` returns the node numbers at the 27 offsets of a node; a number
    /// of at least `nodes.len()` means that there is no node.
    pub fn new(
        nodes: &[NodeIndex],
        active: impl Fn(usize) -> bool,
        neighbours: impl Fn(usize) -> [u32; 27],
    ) -> Self {
        // Along a column, nodes keep their distance over gaps of up to 2 PAD nodes. Wider gaps and new columns leave 2 PAD
        // positions empty.
        let mut position = Vec::with_capacity(nodes.len());
        let mut at = PAD + 1;
        for (i, n) in nodes.iter().enumerate() {
            if let Some(before) = i.checked_sub(1).map(|b| nodes[b]) {
                let gap = (n[2] - before[2]) as u32;
                let same_run = before[..2] == n[..2] && gap <= 2 * PAD + 1;
                at += if same_run { gap } else { 2 * PAD + 1 };
            }
            position.push(at);
        }
        // The active nodes' rows, and where the three neighbours begin in each of their nine columns. A column without neighbours
        // reads the empty positions at the start.
        let rows: Vec<u32> = (0..nodes.len() as u32)
            .filter(|&i| active(i as usize))
            .collect();
        let first = |near: &[u32]| {
            (0..3)
                .find_map(|k| position.get(near[k] as usize).map(|p| p - k as u32))
                .unwrap_or(0)
        };
        let starts = rows
            .iter()
            .map(|&i| {
                let near = neighbours(i as usize);
                std::array::from_fn(|c| first(&near[3 * c..3 * c + 3]))
            })
            .collect();
        let len = (at + PAD + 2) as usize;
        // The rows of each chunk of positions, so that threads write to disjoint parts of a vector.
        let chunks = (0..=len.div_ceil(CHUNK))
            .map(|c| rows.partition_point(|&i| (position[i as usize] as usize) < c * CHUNK))
            .collect();
        Self {
            len,
            position,
            rows,
            starts,
            chunks,
        }
    }

    /// The rows whose positions are in a chunk, each with its index within the chunk.
    pub fn rows_of(&self, chunk: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        (self.chunks[chunk]..self.chunks[chunk + 1])
            .map(move |r| (r, self.position_of(r) - chunk * CHUNK))
    }

    /// The position of a row's own node.
    pub fn position_of(&self, row: usize) -> usize {
        self.position[self.rows[row] as usize] as usize
    }

    /// Spreads values at the band's nodes to a vector over the positions.
    pub fn spread(&self, values: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.len];
        for (&p, &v) in self.position.iter().zip(values) {
            out[p as usize] = v;
        }
        out
    }

    /// Gathers the values at the band's nodes from a vector over the positions.
    pub fn gathered(&self, vector: &[f64]) -> Vec<f64> {
        self.position.iter().map(|&p| vector[p as usize]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_lie_side_by_side_and_missing_ones_on_empty_places() {
        let mut nodes: Vec<NodeIndex> = Vec::new();
        for i in 0..7 {
            for j in 0..7 {
                for k in 0..30 {
                    if (3 * i + 5 * j + k * k) % 7 < 4 {
                        nodes.push([i, j, k]);
                    }
                }
            }
        }
        let find = |n: NodeIndex| nodes.binary_search(&n).map_or(u32::MAX, |i| i as u32);
        let around = |i: usize| -> [u32; 27] {
            let n = nodes[i];
            std::array::from_fn(|k| {
                let o = [k as i32 / 9 - 1, k as i32 / 3 % 3 - 1, k as i32 % 3 - 1];
                find([n[0] + o[0], n[1] + o[1], n[2] + o[2]])
            })
        };
        let layout = Layout::new(&nodes, |i| i % 3 != 0, around);
        let numbers: Vec<f64> = (1..=nodes.len()).map(|i| i as f64).collect();
        let vector = layout.spread(&numbers);
        assert_eq!(layout.gathered(&vector), numbers);
        for (r, starts) in layout.starts.iter().enumerate() {
            let near = around(layout.rows[r] as usize);
            for k in 0..27 {
                let wanted = numbers.get(near[k] as usize).copied().unwrap_or(0.0);
                assert_eq!(vector[starts[k / 3] as usize + k % 3], wanted);
            }
        }
        let listed: usize = (0..layout.len.div_ceil(CHUNK))
            .map(|c| layout.rows_of(c).count())
            .sum();
        assert_eq!(listed, layout.rows.len());
    }
}
