//! Redistancing by closest points on a smooth interpolant.
//!
//! Seeds beside the zero set are projected on the zero set of the tricubic interpolant; closest points then spread outward
//! layer by layer, each projected again. Chopp's bicubic construction ("Some improvements of the fast marching method",
//! 2001) with closest points carried along.

use glam::DVec3;
use rayon::prelude::*;

use crate::grid::{
    ABSENT, BLOCK_NODES, NodeIndex, SparseGrid, Tricubic, add, as_point, value_and_gradient,
};

const ITERATIONS: usize = 16;
/// A projection ends when it is this near to the zero set, in voxels: well below the interpolant's own error.
const SETTLED: f64 = 1e-7;
/// And when its foot, off the closest point along the zero set, makes the distance too long by no more than this.
const LONGER: f64 = 2e-8;
/// The part of the way along the zero set that a step goes: at least, and at most.
const SLIDE: [f64; 2] = [0.8, 1.25];

/// Times that nodes may take a neighbour's closer foot.
const SWEEPS: usize = 3;

/// What a block holds.
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

/// The point of the zero set of the tricubic interpolant closest to `x`, from the start `p` (lattice coordinates):
/// damped steps along the gradient and along the zero set. None where it does not converge, the gradient vanishes or nodes are not
/// stored, and once the grid's token is set.
///
/// A step of the part s leaves `1 − s (1 + κd)` of what is to go along a zero set with curvature κ: the next one's part is
/// taken from what the last has left.
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
        // φ in voxels and its gradient at p; where that is nearly zero there is no direction to go.
        let (f, g) = patch.evaluate(p);
        let gg = g.length_squared();
        if gg < 1e-3 {
            return None;
        }
        // The way to x along the zero set: none is left at the closest point.
        let away = x - p;
        let tangential = away - g * (away.dot(g) / gg);
        let aside = tangential.length_squared();
        // How much of it is gone at once, from what the last step left of it; of long ways at most 0.4 voxel.
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
        if reach < SETTLED && aside < 2.0 * LONGER * x.distance(p) {
            return Some(p);
        }
        last = (aside > 0.0).then_some((tangential, slide));
    }
    if !patch.gather(grid, phi, p) {
        return None;
    }
    // Out of iterations: a point within a thousandth of a voxel of the zero set is good enough.
    (patch.evaluate(p).0.abs() < 1e-3).then_some(p)
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    Far,
    Done,
}

struct Front<'a> {
    grid: &'a SparseGrid,
    phi: &'a [f64],
    mask: &'a [bool],
    out: Vec<f64>,
    foot: Vec<DVec3>,
    state: Vec<State>,
}

/// `phi`, one value for each slot of the grid, with the masked nodes replaced by the signed distance (in voxels) to its zero set, out to
/// `reach` voxels; farther nodes get
/// ±(`reach` + 1). Nodes outside the mask are kept, and seed the front where the mask begins.
pub fn redistance(grid: &SparseGrid, phi: &[f64], mask: &[bool], reach: f64) -> Vec<f64> {
    let mut front = Front {
        grid,
        phi,
        mask,
        out: phi.to_vec(),
        foot: vec![DVec3::ZERO; grid.len()],
        state: vec![State::Far; grid.len()],
    };
    let mut layer = front.seed(reach);
    for _ in 0..(reach as usize + 3) {
        if layer.is_empty() || grid.is_cancelled() {
            break;
        }
        layer = front.advance(&layer, reach);
    }
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
    /// Whether a node is free and of that state.
    fn is(&self, slot: usize, state: State) -> bool {
        self.mask[slot] && self.state[slot] == state
    }

    /// Closest points of the nodes beside the zero set, and of fixed nodes beside the mask.
    fn seed(&mut self, reach: f64) -> Vec<usize> {
        let round = self.grid.summed_round(|s| {
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
            .collect();
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

    /// A fixed node beside the mask knows its distance; its foot counts only where it agrees with that.
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

    /// The nearest foot among the neighbours that have one, and the sign there.
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

    /// The foot of a node from a neighbour's, projected, and its distance.
    fn improved(&self, slot: usize, start: DVec3, distance: f64) -> (DVec3, f64) {
        let x = as_point(self.grid.node(slot));
        match project_on_zero_set(self.grid, self.phi, x, start) {
            Some(p) if x.distance(p) <= distance + 0.05 => (p, x.distance(p)),
            _ => (start, distance),
        }
    }

    fn advance(&mut self, layer: &[usize], reach: f64) -> Vec<usize> {
        let found: Vec<(usize, DVec3, f64)> = self
            .round(layer, State::Far)
            .into_par_iter()
            .filter_map(|slot| {
                let (d, start, sign) = self.best_neighbour(slot)?;
                let (p, d) = self.improved(slot, start, d);
                Some((slot, p, d.copysign(sign)))
            })
            .collect();
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

    /// Lets nodes take a neighbour's closer foot, and tells which did; only beside those that have `changed`, if that is
    /// known.
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
            .collect();
        for &(slot, p, d) in &found {
            self.foot[slot] = p;
            self.out[slot] = d;
        }
        found.into_iter().map(|f| f.0).collect()
    }

    /// The free nodes of a state beside others, in order.
    fn round(&self, nodes: &[usize], state: State) -> Vec<usize> {
        let beside = nodes.iter().flat_map(|&s| neighbours(self.grid, s));
        let mut round: Vec<usize> = beside.filter(|&s| self.is(s, state)).collect();
        round.sort_unstable();
        round.dedup();
        round
    }
}
