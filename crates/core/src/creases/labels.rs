//! Assignment of rim edges to smooth sides: a shortest cyclic path over costs (Viterbi 1967).

use super::collar::Collar;
use super::segment::Sides;
use crate::tuning::{Tunable, tunable};

/// Maximum cost of a corner that is off the sheet of its edge.
const MOST_OFF: Tunable<f64> = tunable("creases.labels.most_off", 9.0);
/// A rim edge is on a second sheet too if the cost of both corners is below this.
const ON: Tunable<f64> = tunable("creases.labels.on", 1.0);

/// Costs and limits for assigning rim edges to sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct LabelCosts {
    /// Distance of a corner from a sheet that costs 1, in edges.
    pub(super) tolerance: f64,
    /// Cost of assigning an edge to the side of its own face if the edge is on another sheet too: then the hole is beyond a
    /// crease.
    pub(super) beyond: f64,
    /// Cost of each change of side.
    pub(super) change: f64,
    /// Only sides with a face at most this many rings from the rim are candidates.
    pub(super) ring: u32,
}

/// The side of each rim edge; `None` if no side is near the rim.
pub(super) fn labels(collar: &Collar, sides: &Sides, costs: &LabelCosts) -> Option<Vec<usize>> {
    let comes_near = |s: &usize| {
        let mut rings = sides.list[*s].faces.iter().map(|&f| collar.ring[f]);
        rings.any(|r| r <= costs.ring)
    };
    let near: Vec<usize> = (0..sides.list.len()).filter(comes_near).collect();
    if near.is_empty() {
        return None;
    }
    let cost = edge_costs(collar, sides, &near, costs);
    let path = cheapest_cycle(&cost, costs.change);
    Some(path.into_iter().map(|j| near[j]).collect())
}

/// For each edge, the costs of the sides near the rim.
fn edge_costs(collar: &Collar, sides: &Sides, near: &[usize], costs: &LabelCosts) -> Vec<Vec<f64>> {
    let count = collar.rim.len();
    let corner = |i: usize, side: usize| {
        let off = sides.list[side].sheet.distance(collar.rim_point(i)).abs();
        (off / costs.tolerance / collar.edge)
            .powi(2)
            .min(MOST_OFF.get())
    };
    let corners: Vec<Vec<f64>> = (0..count)
        .map(|i| near.iter().map(|&s| corner(i, s)).collect())
        .collect();
    let of_edge = |i: usize| {
        let (a, b) = (&corners[i], &corners[(i + 1) % count]);
        let worse: Vec<f64> = a.iter().zip(b).map(|(a, b)| a.max(*b)).collect();
        let beyond = sides.of_face[collar.beyond[i] as usize];
        let is_on = |w: f64| w < ON.get();
        let on = worse.iter().filter(|w| is_on(**w)).count();
        let one = |(j, side): (usize, &usize)| {
            let is_on_other = on > usize::from(is_on(worse[j]));
            let extra = if *side == beyond && is_on_other {
                costs.beyond
            } else {
                0.0
            };
            0.5 * (a[j] + b[j]) + extra
        };
        near.iter().enumerate().map(one).collect()
    };
    (0..count).map(of_edge).collect()
}

/// The cyclic sequence of states with the lowest sum of costs; each change of state costs `change`.
fn cheapest_cycle(cost: &[Vec<f64>], change: f64) -> Vec<usize> {
    // Start states that cannot be better than the one of lowest own cost need no path: the rest of the cycle costs at least what it
    // does from any state.
    let free = sums_from(cost, vec![0.0; cost[0].len()], change, |_, _, _| {});
    let rest = free[lowest(&free)];
    let bound = cycle_from(cost, lowest(&cost[0]), change).0;
    let worthwhile = (0..cost[0].len()).filter(|s| (cost[0][*s] + rest) * (1.0 - 1e-9) <= bound);
    let all = worthwhile.map(|start| cycle_from(cost, start, change));
    let best = all.min_by(|a, b| a.0.total_cmp(&b.0));
    best.unwrap_or_default().1
}

/// The lowest sums of costs of paths that end in each state, with `sums` at the first edge. At each later edge `note` gets the sums
/// before it, the sum from which a change of state leads there, and the state that has it.
fn sums_from(
    cost: &[Vec<f64>],
    mut sums: Vec<f64>,
    change: f64,
    mut note: impl FnMut(&[f64], f64, usize),
) -> Vec<f64> {
    for own in &cost[1..] {
        let lowest = lowest(&sums);
        let leap = sums[lowest] + change;
        note(&sums, leap, lowest);
        sums = sums.iter().zip(own).map(|(s, c)| s.min(leap) + c).collect();
    }
    sums
}

/// The cheapest cycle that starts in a state, and its sum. A path that ends in another state pays for one more change.
fn cycle_from(cost: &[Vec<f64>], start: usize, change: f64) -> (f64, Vec<usize>) {
    let mut first = vec![f64::INFINITY; cost[0].len()];
    first[start] = cost[0][start];
    // The state before each state, edge by edge.
    let mut from = Vec::with_capacity(cost.len());
    let mut sums = sums_from(cost, first, change, |sums, leap, lowest| {
        let before = |(j, sum): (usize, &f64)| if *sum <= leap { j } else { lowest };
        from.push(sums.iter().enumerate().map(before).collect::<Vec<_>>());
    });
    for (j, sum) in sums.iter_mut().enumerate() {
        *sum += if j == start { 0.0 } else { change };
    }
    let mut at = lowest(&sums);
    let total = sums[at];
    let mut path = vec![at];
    for before in from.iter().rev() {
        at = before[at];
        path.push(at);
    }
    path.reverse();
    (total, path)
}

/// The index of the lowest value, the first one if several are equal.
fn lowest(values: &[f64]) -> usize {
    let all = values.iter().enumerate();
    all.min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(j, _)| j)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_outliers_do_not_change_the_side() {
        let mut cost = vec![vec![0.0, 4.0]; 6];
        cost.extend(vec![vec![4.0, 0.0]; 6]);
        cost[2] = vec![3.0, 0.0];
        let expected = [vec![0; 6], vec![1; 6]].concat();
        assert_eq!(cheapest_cycle(&cost, 2.0), expected);
        // If a change costs less than the outlier, the outlier gets its own stretch.
        assert_eq!(cheapest_cycle(&cost, 1.0)[2], 1);
    }

    /// Against all sequences of a short cycle.
    #[test]
    fn it_is_the_cheapest_of_all() {
        let cost: Vec<Vec<f64>> = (0..6)
            .map(|i: i32| {
                (0..3)
                    .map(|j| f64::from((i * 7 + j * j * 5) % 11))
                    .collect()
            })
            .collect();
        let total = |path: &[usize]| {
            let own: f64 = path.iter().zip(&cost).map(|(j, c)| c[*j]).sum();
            let changes = (0..6).filter(|&i| path[i] != path[(i + 1) % 6]).count();
            own + 3.0 * changes as f64
        };
        let all = (0..3usize.pow(6))
            .map(|code| (0..6).map(|i| code / 3usize.pow(i) % 3).collect::<Vec<_>>());
        let lowest = all.map(|path| total(&path)).fold(f64::INFINITY, f64::min);
        assert_eq!(total(&cheapest_cycle(&cost, 3.0)), lowest);
    }
}
