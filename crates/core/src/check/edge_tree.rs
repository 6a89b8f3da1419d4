//! A k-d tree over edges as points in six dimensions, for finding edges with end points near the end points of a given edge.

use glam::DVec3;

/// Edges as six coordinates (start, end). The root of a subtree is the middle of its range in the list; edges with a smaller
/// coordinate along the root's axis come before it.
pub(super) struct EdgeTree {
    edges: Vec<([f64; 6], u32)>,
    axes: Vec<u8>,
}

impl EdgeTree {
    /// Builds the tree; edges are identified by their index.
    pub(super) fn new(edges: impl Iterator<Item = [DVec3; 2]>) -> Self {
        let mut edges: Vec<([f64; 6], u32)> = edges.map(coordinates).zip(0..).collect();
        let mut axes = vec![0; edges.len()];
        build(&mut edges, &mut axes);
        Self { edges, axes }
    }

    /// Calls `visit` with each edge whose start is within `reach` of the start of the given edge and whose end is within `reach`
    /// of its end, and with the larger of the two distances (mesh units). `visit` returns the search radius for the rest of the
    /// search.
    pub(super) fn near(
        &self,
        edge: [DVec3; 2],
        reach: f64,
        visit: &mut impl FnMut(u32, f64) -> f64,
    ) {
        let query = Query {
            edge,
            at: coordinates(edge),
        };
        self.search(0, self.edges.len(), &query, reach, visit);
    }

    fn search(
        &self,
        start: usize,
        end: usize,
        query: &Query,
        mut reach: f64,
        visit: &mut impl FnMut(u32, f64) -> f64,
    ) -> f64 {
        if start == end {
            return reach;
        }
        let middle = start + (end - start) / 2;
        let (own, index) = self.edges[middle];
        let axis = usize::from(self.axes[middle]);
        let beyond = query.at[axis] - own[axis];
        let halves = [(start, middle), (middle + 1, end)];
        let [near, far] = if beyond < 0.0 { [0, 1] } else { [1, 0] };
        reach = self.search(halves[near].0, halves[near].1, query, reach, visit);
        if beyond.abs() > reach {
            return reach;
        }
        let ends = [DVec3::from_slice(&own[..3]), DVec3::from_slice(&own[3..])];
        let [from, to] = [0, 1].map(|k: usize| query.edge[k].distance(ends[k]));
        if from.max(to) <= reach {
            reach = visit(index, from.max(to));
        }
        self.search(halves[far].0, halves[far].1, query, reach, visit)
    }
}

struct Query {
    edge: [DVec3; 2],
    at: [f64; 6],
}

fn coordinates([a, b]: [DVec3; 2]) -> [f64; 6] {
    [a.x, a.y, a.z, b.x, b.y, b.z]
}

fn build(edges: &mut [([f64; 6], u32)], axes: &mut [u8]) {
    if edges.len() < 2 {
        return;
    }
    let (mut low, mut high) = (edges[0].0, edges[0].0);
    for (own, _) in &*edges {
        for k in 0..6 {
            low[k] = low[k].min(own[k]);
            high[k] = high[k].max(own[k]);
        }
    }
    let size = |k: usize| high[k] - low[k];
    let axis = (1..6).fold(0, |best, k| if size(k) > size(best) { k } else { best });
    let middle = edges.len() / 2;
    edges.select_nth_unstable_by(middle, |a, b| {
        a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1))
    });
    axes[middle] = axis as u8;
    let (low, high) = edges.split_at_mut(middle);
    let (of_low, of_high) = axes.split_at_mut(middle);
    build(low, of_low);
    build(&mut high[1..], &mut of_high[1..]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::noise;

    #[test]
    fn the_nearest_edge_is_that_of_a_search_through_all() {
        let mut noise = noise(7);
        let mut point = || DVec3::new(noise(), noise(), noise());
        let edges: Vec<[DVec3; 2]> = (0..300).map(|_| [point(), point()]).collect();
        let tree = EdgeTree::new(edges.iter().copied());
        for i in 0..300 {
            let distance = |j: usize| {
                let [from, to] = [0, 1].map(|k| edges[i][k].distance(edges[j][k]));
                from.max(to)
            };
            let others = (0..300).filter(|j| *j != i).map(distance);
            let nearest = others.fold(f64::INFINITY, f64::min);
            let mut best = f64::INFINITY;
            tree.near(edges[i], f64::INFINITY, &mut |j, apart| {
                if j as usize != i {
                    best = best.min(apart);
                }
                best
            });
            assert_eq!(best, nearest);
        }
    }
}
