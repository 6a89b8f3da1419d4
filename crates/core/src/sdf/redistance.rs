//! Redistancing of a level set by closest points on a smooth interpolant.
//!
//! Nodes next to the zero set are projected on the zero set of the tricubic interpolant. Closest points then spread outward layer
//! by layer; each is projected again. This is Chopp's bicubic construction ("Some improvements of the fast marching method",
//! 2001) with closest points carried along.

use glam::DVec3;
use rayon::prelude::*;

use crate::grid::{
    ABSENT, BLOCK_NODES, NodeIndex, SparseGrid, Tricubic, add, as_point, value_and_gradient,
};
use crate::threads::CollectFiltered;

/// Maximum number of steps of a projection.
const ITERATIONS: usize = 16;
/// A projection has converged when it is this close to the zero set, in voxels (well below the interpolant's own error),
const CONVERGED: f64 = 1e-7;
/// and when the error of its foot along the zero set lengthens the distance by at most this, in voxels.
const LONGER: f64 = 2e-8;
/// Fraction of the tangential offset that a step corrects: minimum and maximum.
const SLIDE: [f64; 2] = [0.8, 1.25];

/// Maximum number of passes in which nodes may take a neighbour's closer foot.
const SWEEPS: usize = 3;

/// Flags of the nodes in and around a block.
const POSITIVE: u8 = 1;
const NEGATIVE: u8 = 2;
const FREE: u8 = 4;

/// The slots of the 26 neighbours.
fn neighbours(grid: &SparseGrid, slot: usize) -> impl Iterator<Item = usize> {
    let around = grid.around(slot);
    (0..27)
        .filter(|&i| i != 13)
        .map(move |i| around[i])
        .filter(|&s| s != ABSENT)
        .map(|s| s as usize)
}

/// The point closest to `x` on the zero set of the tricubic interpolant, starting from `p` (lattice coordinates), by damped steps
/// along the gradient and along the zero set. `None` if it does not converge, the gradient vanishes, nodes are not stored, or the
/// grid's token is set.
///
/// On a zero set of curvature κ, a step that corrects the fraction s of the tangential offset leaves `1 − s (1 + κd)` of it. The
/// fraction of the next step is derived from the offset that the last one left.
pub fn project_on_zero_set(
    grid: &SparseGrid,
    phi: &[f64],
    x: DVec3,
    mut p: DVec3,
) -> Option<DVec3> {
    if grid.is_cancelled() {
        return None;
    }
    let mut patch = Tricubic::default();
    let mut last: Option<(DVec3, f64)> = None;
    for _ in 0..ITERATIONS {
        if !patch.gather(grid, phi, p) {
            return None;
        }
        // φ in voxels and its gradient at p; a vanishing gradient gives no direction.
        let (f, g) = patch.evaluate(p);
        let gg = g.length_squared();
        if gg < 1e-3 {
            return None;
        }
        // The tangential offset: the vector to x along the zero set, zero at the closest point.
        let away = x - p;
        let tangential = away - g * (away.dot(g) / gg);
        let aside = tangential.length_squared();
        // The fraction of it that this step corrects, from the last step; long offsets are corrected by at most 0.4 voxel.
        let part = last.map_or(SLIDE[0], |(before, part)| {
            let left = tangential.dot(before) / before.length_squared();
            (part / (1.0 - left)).clamp(SLIDE[0], SLIDE[1])
        });
        let slide = if aside > 0.25 {
            part.min(0.4 / aside.sqrt())
        } else {
            part
        };
        // A Newton step to the zero set along the gradient, of at most 0.7 voxel.
        let reach = f.abs() / gg.sqrt();
        let damping = if reach > 0.7 { 0.7 / reach } else { 1.0 };
        p += g * (-f / gg * damping) + tangential * slide;
        if reach < CONVERGED && aside < 2.0 * LONGER * x.distance(p) {
            return Some(p);
        }
        last = (aside > 0.0).then_some((tangential, slide));
    }
    if !patch.gather(grid, phi, p) {
        return None;
    }
    // Out of iterations: a point within a thousandth of a voxel of the zero set is accepted.
    (patch.evaluate(p).0.abs() < 1e-3).then_some(p)
}

/// Whether a node has a closest point yet.
#[derive(Clone, Copy, PartialEq)]
enum State {
    Far,
    Done,
}

/// The state of a redistancing: new values and closest points (feet) of the nodes.
struct Front<'a> {
    grid: &'a SparseGrid,
    phi: &'a [f64],
    mask: &'a [bool],
    out: Vec<f64>,
    foot: Vec<DVec3>,
    state: Vec<State>,
}

/// Replaces `phi` at the masked nodes by the signed distance (in voxels) to its zero set, out to `reach` voxels; farther nodes
/// get ±(`reach` + 1). `phi` has one value for each slot of the grid. Nodes outside the mask keep their values and seed the front
/// next to the mask.
pub fn redistance(grid: &SparseGrid, phi: &[f64], mask: &[bool], reach: f64) -> Vec<f64> {
    let mut front = Front {
        grid,
        phi,
        mask,
        out: phi.to_vec(),
        foot: vec![DVec3::ZERO; grid.len()],
        state: vec![State::Far; grid.len()],
    };
    // The front: seeds, then layer by layer outward.
    let mut layer = front.seed(reach);
    for _ in 0..(reach as usize + 3) {
        if layer.is_empty() || grid.is_cancelled() {
            break;
        }
        layer = front.advance(&layer, reach);
    }
    // Nodes take closer feet from neighbours until none changes.
    let mut changed: Option<Vec<usize>> = None;
    for _ in 0..SWEEPS {
        if grid.is_cancelled() {
            break;
        }
        let found = front.sweep(changed.as_deref());
        if found.is_empty() {
            break;
        }
        changed = Some(found);
    }
    for slot in 0..grid.len() {
        if mask[slot] && front.state[slot] == State::Far {
            front.out[slot] = (reach + 1.0).copysign(phi[slot]);
        }
    }
    front.out
}

impl Front<'_> {
    /// Whether a node is masked (free) and in that state.
    fn is(&self, slot: usize, state: State) -> bool {
        self.mask[slot] && self.state[slot] == state
    }

    /// Finds the closest points of nodes next to the zero set and of fixed nodes next to the mask.
    fn seed(&mut self, reach: f64) -> Vec<usize> {
        let round = self.grid.or_with_neighbours(|s| {
            let sign = if self.phi[s] > 0.0 {
                POSITIVE
            } else {
                NEGATIVE
            };
            sign | if self.mask[s] { FREE } else { 0 }
        });
        let both = |flags: u8| flags & (POSITIVE | NEGATIVE) == POSITIVE | NEGATIVE;
        let found: Vec<(usize, DVec3)> = (0..self.grid.len())
            .into_par_iter()
            .filter_map(|slot| {
                let round = round[slot / BLOCK_NODES];
                let foot = if self.mask[slot] {
                    both(round).then(|| self.free_seed(slot))
                } else {
                    (round & FREE != 0).then(|| self.fixed_seed(slot, reach))
                };
                foot.flatten().map(|p| (slot, p))
            })
            .collect_filtered();
        for &(slot, p) in &found {
            self.foot[slot] = p;
            self.state[slot] = State::Done;
            if self.mask[slot] {
                let d = as_point(self.grid.node(slot)).distance(p);
                self.out[slot] = d.copysign(self.phi[slot]);
            }
        }
        found.into_iter().map(|s| s.0).collect()
    }

    /// The foot of a free node next to the zero set: the projection, or a step along the gradient if that fails.
    fn free_seed(&self, slot: usize) -> Option<DVec3> {
        if self.grid.is_cancelled() {
            return None;
        }
        let n = self.grid.node(slot);
        let positive = self.phi[slot] > 0.0;
        if !neighbours(self.grid, slot).any(|s| (self.phi[s] > 0.0) != positive) {
            return None;
        }
        let x = as_point(n);
        project_on_zero_set(self.grid, self.phi, x, x).or_else(|| {
            let g = self.central_gradient(n)?;
            let gg = g.length_squared() + 1e-12;
            let s = (self.phi[slot] / gg).clamp(-1.8 / gg.sqrt(), 1.8 / gg.sqrt());
            Some(x - g * s)
        })
    }

    /// The foot of a fixed node next to the mask. Its value is a distance; a foot is accepted only if it agrees with that
    /// distance.
    fn fixed_seed(&self, slot: usize, reach: f64) -> Option<DVec3> {
        let value = self.phi[slot];
        if value.abs() >= reach {
            return None;
        }
        let n = self.grid.node(slot);
        if !neighbours(self.grid, slot).any(|s| self.mask[s]) {
            return None;
        }
        let g = self.one_sided_gradient(n, value);
        let gg = g.length_squared();
        if gg < 1e-6 {
            return None;
        }
        let x = as_point(n);
        let start = x - g * (value / gg);
        let agrees = |p: DVec3| (x.distance(p) - value.abs()).abs() < 0.3;
        if let Some(p) = project_on_zero_set(self.grid, self.phi, x, start)
            && agrees(p)
        {
            return Some(p);
        }
        let (f, _) = value_and_gradient(self.grid, self.phi, start)?;
        (agrees(start) && f.abs() < 0.3).then_some(start)
    }

    fn central_gradient(&self, n: NodeIndex) -> Option<DVec3> {
        let mut g = DVec3::ZERO;
        for a in 0..3 {
            let mut o = [0; 3];
            o[a] = 1;
            let high = self.phi[self.grid.slot(add(n, o))?];
            o[a] = -1;
            g[a] = 0.5 * (high - self.phi[self.grid.slot(add(n, o))?]);
        }
        Some(g)
    }

    fn one_sided_gradient(&self, n: NodeIndex, value: f64) -> DVec3 {
        let fixed = |o: NodeIndex| {
            let slot = self.grid.slot(add(n, o))?;
            (!self.mask[slot]).then(|| self.phi[slot])
        };
        let mut g = DVec3::ZERO;
        for a in 0..3 {
            let mut o = [0; 3];
            o[a] = 1;
            let high = fixed(o);
            o[a] = -1;
            let low = fixed(o);
            g[a] = match (low, high) {
                (Some(l), Some(h)) => 0.5 * (h - l),
                (None, Some(h)) => h - value,
                (Some(l), None) => value - l,
                (None, None) => 0.0,
            };
        }
        g
    }

    /// The closest foot among the neighbours that have one, with its distance, and the value of that neighbour for the sign.
    fn best_neighbour(&self, slot: usize) -> Option<(f64, DVec3, f64)> {
        if self.grid.is_cancelled() {
            return None;
        }
        let x = as_point(self.grid.node(slot));
        let mut best: Option<(f64, DVec3, f64)> = None;
        for s in neighbours(self.grid, slot) {
            if self.state[s] == State::Done {
                let d = x.distance_squared(self.foot[s]);
                if best.is_none_or(|b| d < b.0) {
                    best = Some((d, self.foot[s], self.out[s]));
                }
            }
        }
        best.map(|(d, p, sign)| (d.sqrt(), p, sign))
    }

    /// Projects a neighbour's foot for this node; returns the foot and its distance.
    fn improved(&self, slot: usize, start: DVec3, distance: f64) -> (DVec3, f64) {
        let x = as_point(self.grid.node(slot));
        match project_on_zero_set(self.grid, self.phi, x, start) {
            Some(p) if x.distance(p) <= distance + 0.05 => (p, x.distance(p)),
            _ => (start, distance),
        }
    }

    /// Gives feet to the next layer of nodes; returns the ones that are within `reach`.
    fn advance(&mut self, layer: &[usize], reach: f64) -> Vec<usize> {
        let found: Vec<(usize, DVec3, f64)> = self
            .round(layer, State::Far)
            .into_par_iter()
            .filter_map(|slot| {
                let (d, start, sign) = self.best_neighbour(slot)?;
                let (p, d) = self.improved(slot, start, d);
                Some((slot, p, d.copysign(sign)))
            })
            .collect_filtered();
        for &(slot, p, d) in &found {
            self.foot[slot] = p;
            self.out[slot] = d;
            self.state[slot] = State::Done;
        }
        found
            .into_iter()
            .filter(|f| f.2.abs() < reach)
            .map(|f| f.0)
            .collect()
    }

    /// Lets nodes take a neighbour's closer foot; returns the nodes that did. Visits only neighbours of the nodes in `changed`,
    /// if given.
    fn sweep(&mut self, changed: Option<&[usize]>) -> Vec<usize> {
        let candidates = match changed {
            Some(changed) => self.round(changed, State::Done),
            None => {
                let all = 0..self.grid.len();
                all.filter(|&s| self.is(s, State::Done)).collect()
            }
        };
        let found: Vec<(usize, DVec3, f64)> = candidates
            .into_par_iter()
            .filter_map(|slot| {
                let (d, start, _) = self.best_neighbour(slot)?;
                if d >= self.out[slot].abs() - 0.02 {
                    return None;
                }
                let (p, d) = self.improved(slot, start, d);
                Some((slot, p, d.copysign(self.phi[slot])))
            })
            .collect_filtered();
        for &(slot, p, d) in &found {
            self.foot[slot] = p;
            self.out[slot] = d;
        }
        found.into_iter().map(|f| f.0).collect()
    }

    /// The masked nodes in a state next to some nodes, in rising order.
    fn round(&self, nodes: &[usize], state: State) -> Vec<usize> {
        let adjacent = nodes.iter().flat_map(|&s| neighbours(self.grid, s));
        let mut round: Vec<usize> = adjacent.filter(|&s| self.is(s, state)).collect();
        round.sort_unstable();
        round.dedup();
        round
    }
}
