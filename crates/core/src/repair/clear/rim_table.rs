//! The least triangulation of a ring, as a table over its diagonals, from which triangles are ruled out one by one.

use std::collections::HashSet;

use glam::DVec3;

use super::Ground;
use crate::mesh::area_vector;
use crate::spatial::intersecting;
use crate::tuning::{Tunable, tunable};

/// Weight of a diagonal's squared length relative to area: among triangulations of equal area the one with short
/// diagonals is taken.
const DIAGONAL: Tunable<f64> = tunable("repair.diagonal", 0.1);

/// Dynamic-programming table over the triangles between the corners of a ring.
pub(super) struct RimTable<'a> {
    ring: &'a [u32],
    at: Vec<DVec3>,
    /// Whether a diagonal is excluded, by `i * n + k`.
    blocked: Vec<bool>,
    /// One bit per triangle, by `(i * n + m) * n + k`: whether it is known to intersect something.
    crosses: Vec<u64>,
    /// Triangles that were tested.
    known: HashSet<[usize; 3]>,
    /// The least cost of a triangulation of the corners from `i` to `k`, by `i * n + k`, and the third corner of its triangle at
    /// this diagonal, from the last solution.
    cost: Vec<f64>,
    /// The same by `k * n + i`, so that what `best` adds lies side by side.
    cost_to: Vec<f64>,
    apex: Vec<usize>,
    /// Entries to recompute, because their triangle or diagonal was ruled out.
    stale: Vec<bool>,
}

impl<'a> RimTable<'a> {
    pub(super) fn new(ground: &Ground, ring: &'a [u32]) -> Self {
        let n = ring.len();
        let mut blocked = vec![false; n * n];
        for i in 0..n {
            for k in (i + 2..n).filter(|k| k - i < n - 1) {
                let (v, w) = (ring[i], ring[k]);
                blocked[i * n + k] = v == w || ground.edges.contains_key(&(v.min(w), v.max(w)));
            }
        }
        Self {
            ring,
            at: (ring.iter())
                .map(|v| ground.mesh.positions[*v as usize])
                .collect(),
            blocked,
            crosses: vec![0; (n * n * n).div_ceil(64)],
            known: HashSet::new(),
            cost: vec![0.0; n * n],
            cost_to: vec![0.0; n * n],
            apex: vec![0; n * n],
            stale: vec![true; n * n],
        }
    }

    fn crosses(&self, [i, m, k]: [usize; 3]) -> bool {
        let bit = (i * self.ring.len() + m) * self.ring.len() + k;
        self.crosses[bit / 64] >> (bit % 64) & 1 == 1
    }

    pub(super) fn set_crossing(&mut self, [i, m, k]: [usize; 3]) {
        let n = self.ring.len();
        let bit = (i * n + m) * n + k;
        self.crosses[bit / 64] |= 1 << (bit % 64);
        self.stale[i * n + k] |= self.apex[i * n + k] == m;
    }

    /// The best triangulation without triangles that are known to intersect something (Barequet and Sharir 1995).
    ///
    /// Costs only rise from one solution to the next. An entry therefore keeps its triangle unless the triangle was ruled out or
    /// the cost of one of its two sub-polygons rose.
    pub(super) fn solve(&mut self) -> Option<Vec<[usize; 3]>> {
        let n = self.ring.len();
        let mut rose = vec![false; n * n];
        for span in 2..n {
            for i in 0..n - span {
                let k = i + span;
                let (cell, m) = (i * n + k, self.apex[i * n + k]);
                let is_finite = self.cost[cell].is_finite();
                let is_stale =
                    self.stale[cell] || is_finite && (rose[i * n + m] || rose[m * n + k]);
                if is_stale {
                    let (cost, apex) = self.best(i, k);
                    rose[cell] = cost > self.cost[cell];
                    (self.cost[cell], self.apex[cell]) = (cost, apex);
                    self.cost_to[k * n + i] = cost;
                    self.stale[cell] = false;
                }
            }
        }
        if n < 3 || !self.cost[n - 1].is_finite() {
            return None;
        }
        let (mut faces, mut stack) = (Vec::with_capacity(n), vec![(0, n - 1)]);
        while let Some((i, k)) = stack.pop() {
            if k - i > 1 {
                let m = self.apex[i * n + k];
                faces.push([i, m, k]);
                stack.extend([(i, m), (m, k)]);
            }
        }
        Some(faces)
    }

    /// The least cost of a triangulation of the corners from `i` to `k`, and the third corner of its triangle at this diagonal.
    fn best(&self, i: usize, k: usize) -> (f64, usize) {
        let n = self.ring.len();
        let mut best = (f64::INFINITY, i + 1);
        if self.blocked[i * n + k] {
            return best;
        }
        let diagonal = DIAGONAL.get() * self.at[i].distance_squared(self.at[k]);
        let from = &self.cost[i * n + i + 1..i * n + k];
        let to = &self.cost_to[k * n + i + 1..k * n + k];
        for (m, (from, to)) in (i + 1..k).zip(from.iter().zip(to)) {
            let parts = from + to + diagonal;
            if parts >= best.0 || self.crosses([i, m, k]) {
                continue;
            }
            let all = parts + self.area([i, m, k]);
            if all < best.0 {
                best = (all, m);
            }
        }
        best
    }

    fn area(&self, triangle: [usize; 3]) -> f64 {
        let [i, m, k] = triangle;
        0.5 * area_vector([self.at[i], self.at[m], self.at[k]]).length()
    }

    /// Whether some triangle that intersects nothing stands on each side of the ring; without one there is no triangulation. Most
    /// searches that fail do so here, which takes one test for each corner instead of some for each round.
    pub(super) fn has_triangle_at_each_side(&mut self, ground: &Ground) -> bool {
        let n = self.ring.len();
        (0..n).all(|side| {
            // Corners next to the side first.
            let others = (1..n - 1).map(|j| match j % 2 {
                1 => (side + 1 + j.div_ceil(2)) % n,
                _ => (side + n - j / 2) % n,
            });
            let mut triangles = others.map(|m| {
                let mut t = [side, (side + 1) % n, m];
                t.sort_unstable();
                t
            });
            triangles.any(|t| self.has_free_sides(t) && self.is_clear(ground, t))
        })
    }

    /// Whether none of a triangle's sides is an excluded diagonal.
    fn has_free_sides(&self, [i, m, k]: [usize; 3]) -> bool {
        let n = self.ring.len();
        [(i, m), (m, k), (i, k)]
            .iter()
            .all(|(i, k)| !self.blocked[i * n + k])
    }

    /// Whether a triangle intersects nothing; what was tested is kept.
    fn is_clear(&mut self, ground: &Ground, t: [usize; 3]) -> bool {
        if !self.known.insert(t) {
            return !self.crosses(t);
        }
        let is_clear = ground.is_clear(t.map(|i| self.ring[i]));
        if !is_clear {
            self.set_crossing(t);
        }
        is_clear
    }

    /// Rules out the triangles that intersect something or one another; returns whether there were any.
    pub(super) fn rule_out(&mut self, ground: &Ground, triangles: &[[usize; 3]]) -> bool {
        let n = self.ring.len();
        let mut wrong = false;
        for &t in triangles {
            if self.known.contains(&t) || self.is_clear(ground, t) {
                continue;
            }
            wrong = true;
            let [i, m, k] = t;
            for (i, k) in [(i, m), (m, k), (i, k)] {
                let is_diagonal = k - i > 1 && k - i < n - 1;
                if is_diagonal && ground.is_pierced(self.ring[i], self.ring[k]) {
                    self.blocked[i * n + k] = true;
                    self.stale[i * n + k] = true;
                }
            }
        }
        if wrong {
            return true;
        }
        let faces: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|i| self.ring[i])).collect();
        let pairs = intersecting(&ground.mesh.positions, &faces, faces.len());
        for (f, g) in &pairs {
            let [t, u] = [*f, *g].map(|f| triangles[f as usize]);
            let larger = if self.area(t) < self.area(u) { u } else { t };
            self.set_crossing(larger);
        }
        !pairs.is_empty()
    }
}
