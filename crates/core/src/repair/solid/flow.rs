//! A smallest cut: the maximum flow between two sets of nodes (E. A. Dinic, "Algorithm for solution of a problem of maximum flow
//! in networks with power estimation", 1970).

use std::collections::VecDeque;

/// A network of nodes with undirected edges. The first two nodes are the source and the sink.
pub(super) struct Network {
    /// The arcs of each node: `arcs[first[n]..first[n + 1]]`.
    first: Vec<usize>,
    arcs: Vec<Arc>,
}

struct Arc {
    to: u32,
    /// The arc in the other direction.
    reverse: u32,
    /// What more may flow along it.
    residual: u64,
}

/// The node that the flow comes from.
pub(super) const SOURCE: u32 = 0;
/// The node that it goes to.
pub(super) const SINK: u32 = 1;

impl Network {
    /// A network with `nodes` nodes and edges of the given capacities.
    pub(super) fn new(nodes: usize, edges: &[(u32, u32, u64)]) -> Self {
        let mut first = vec![0usize; nodes + 1];
        for (a, b, _) in edges {
            first[*a as usize + 1] += 1;
            first[*b as usize + 1] += 1;
        }
        for n in 0..nodes {
            first[n + 1] += first[n];
        }
        let mut next = first.clone();
        let mut place = |n: u32| {
            next[n as usize] += 1;
            next[n as usize] - 1
        };
        let none = || Arc {
            to: 0,
            reverse: 0,
            residual: 0,
        };
        let mut arcs: Vec<Arc> = (0..2 * edges.len()).map(|_| none()).collect();
        for &(a, b, capacity) in edges {
            let (i, j) = (place(a), place(b));
            for (from, to, reverse) in [(i, b, j), (j, a, i)] {
                arcs[from] = Arc {
                    to,
                    reverse: reverse as u32,
                    residual: capacity,
                };
            }
        }
        Self { first, arcs }
    }

    /// The nodes on the sink's side of the smallest cut that lies nearest to the sink's side of the network.
    pub(super) fn sink_side(mut self) -> Vec<bool> {
        while let Some(levels) = self.levels() {
            self.block(&levels);
        }
        let mut side = vec![false; self.first.len() - 1];
        side[SINK as usize] = true;
        let mut stack = vec![SINK];
        while let Some(n) = stack.pop() {
            for arc in &self.arcs[self.first[n as usize]..self.first[n as usize + 1]] {
                let flows = self.arcs[arc.reverse as usize].residual > 0;
                if flows && !side[arc.to as usize] {
                    side[arc.to as usize] = true;
                    stack.push(arc.to);
                }
            }
        }
        side
    }

    /// The number of arcs from the source to each node along which more may flow; none if the sink is not reached.
    fn levels(&self) -> Option<Vec<u32>> {
        let mut levels = vec![u32::MAX; self.first.len() - 1];
        levels[SOURCE as usize] = 0;
        let mut queue = VecDeque::from([SOURCE]);
        while let Some(n) = queue.pop_front() {
            for arc in &self.arcs[self.first[n as usize]..self.first[n as usize + 1]] {
                if arc.residual > 0 && levels[arc.to as usize] == u32::MAX {
                    levels[arc.to as usize] = levels[n as usize] + 1;
                    queue.push_back(arc.to);
                }
            }
        }
        (levels[SINK as usize] != u32::MAX).then_some(levels)
    }

    /// Adds a blocking flow along arcs that lead one level on.
    fn block(&mut self, levels: &[u32]) {
        let mut next = self.first.clone();
        let mut path: Vec<usize> = Vec::new();
        let mut at = SOURCE;
        loop {
            if at == SINK {
                let least = path.iter().map(|a| self.arcs[*a].residual).min();
                let least = least.unwrap_or(0);
                for &a in &path {
                    self.arcs[a].residual -= least;
                    let reverse = self.arcs[a].reverse as usize;
                    self.arcs[reverse].residual += least;
                }
                path.clear();
                at = SOURCE;
            }
            let n = at as usize;
            let leads_on = |a: &usize| {
                let arc = &self.arcs[*a];
                arc.residual > 0 && levels[arc.to as usize] == levels[n] + 1
            };
            if let Some(a) = (next[n]..self.first[n + 1]).find(leads_on) {
                next[n] = a;
                path.push(a);
                at = self.arcs[a].to;
                continue;
            }
            // No arc leads on from here: go back, and never return.
            next[n] = self.first[n + 1];
            match path.pop() {
                Some(a) => {
                    at = self.arcs[self.arcs[a].reverse as usize].to;
                    next[at as usize] += 1;
                }
                None => return,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_narrowest_edges_are_cut() {
        // Two triangles joined by edges of capacity 1 and 2, with the terminals at far corners.
        let edges = [
            (SOURCE, 2, 9),
            (2, 3, 5),
            (2, 4, 5),
            (3, 4, 5),
            (3, 5, 1),
            (4, 6, 2),
            (5, 6, 5),
            (5, 7, 5),
            (6, 7, 5),
            (7, SINK, 9),
        ];
        let side = Network::new(8, &edges).sink_side();
        assert_eq!(side, [false, true, false, false, false, true, true, true]);
    }

    #[test]
    fn without_a_way_nothing_but_the_sinks_own_part_is_on_its_side() {
        let side = Network::new(5, &[(SOURCE, 2, 3), (3, SINK, 3)]).sink_side();
        assert_eq!(side, [false, true, false, true, false]);
    }

    #[test]
    fn the_flow_equals_the_capacity_of_the_cut_on_a_lattice() {
        // A lattice of 12 x 12 nodes with pseudo-random capacities, against cuts by all columns.
        let mut state = 1u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) % 20 + 1
        };
        let node = |i: u32, j: u32| 2 + 12 * j + i;
        let mut edges = Vec::new();
        for j in 0..12 {
            edges.push((SOURCE, node(0, j), 1000));
            edges.push((node(11, j), SINK, 1000));
            for i in 0..12 {
                if i < 11 {
                    edges.push((node(i, j), node(i + 1, j), random()));
                }
                if j < 11 {
                    edges.push((node(i, j), node(i, j + 1), random()));
                }
            }
        }
        let side = Network::new(146, &edges).sink_side();
        let cut = |side: &dyn Fn(u32) -> bool| -> u64 {
            let across = edges.iter().filter(|(a, b, _)| side(*a) != side(*b));
            across.map(|(_, _, c)| c).sum()
        };
        let found = cut(&|n| side[n as usize]);
        for column in 1..12 {
            let by_column = |n: u32| n == SINK || n > 1 && (n - 2) % 12 >= column;
            assert!(found <= cut(&by_column));
        }
        assert!(!side[SOURCE as usize] && side[SINK as usize]);
    }
}
