//! Tangential smoothing of patch vertices, with projection on the surface.

use glam::DVec3;
use rayon::prelude::*;

use super::{LEAST_COSINE, Remesher};
use crate::stitch::half_edge::prev;
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Fraction of the way to its goal that a vertex moves in smoothing.
const SMOOTH_STEP: Tunable<f64> = tunable("stitch.smooth_step", 0.7);

impl Remesher<'_> {
    /// Moves free vertices towards the centroid of the faces around them, weighted so that edges approach their target lengths.
    /// Returns the root mean square displacement relative to the targets.
    pub(super) fn smooth_by_area(&mut self) -> f64 {
        let free: Vec<u32> = self.free_vertices().collect();
        self.smooth_at(&free, Self::area_goal, 0.3)
    }

    /// Moves free vertices towards the mean of the apexes that would make the faces around them equilateral. Returns the same as
    /// [`Self::smooth_by_area`].
    pub(super) fn smooth_by_shape(&mut self) -> f64 {
        let free: Vec<u32> = self.free_vertices().collect();
        self.smooth_at(&free, Self::shape_goal, 1.0)
    }

    /// Mean of the centroids of the faces around a vertex, weighted by area over the fourth power of the target size.
    fn area_goal(&self, v: u32) -> DVec3 {
        let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
        for h in self.mesh.outgoing(v) {
            let face = self.mesh.faces[h as usize / 3];
            let centroid = face
                .iter()
                .map(|&w| self.mesh.position[w as usize])
                .sum::<DVec3>()
                / 3.0;
            let size = face
                .iter()
                .map(|&w| self.mesh.size[w as usize])
                .sum::<f64>()
                / 3.0;
            let w = self.mesh.area_vector(face).length() / size.powi(4);
            sum += w * centroid;
            weight += w;
        }
        sum / weight
    }

    /// Mean of the apexes that would make the faces around a vertex equilateral.
    pub(super) fn shape_goal(&self, v: u32) -> DVec3 {
        let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
        let n = self.mesh.normal[v as usize];
        for h in self.mesh.outgoing(v) {
            let [a, b] =
                [self.mesh.to(h), self.mesh.from(prev(h))].map(|w| self.mesh.position[w as usize]);
            sum += (a + b) / 2.0 + 0.75f64.sqrt() * n.cross(b - a);
            weight += 1.0;
        }
        sum / weight
    }

    /// Moves vertices towards their goals along the surface. A move is rejected if it would tilt a face or reduce the worst
    /// quality around the vertex below `keep` times its old value; then the vertex is only projected on the surface.
    pub(super) fn smooth_at(
        &mut self,
        free: &[u32],
        goal: impl Fn(&Self, u32) -> DVec3 + Sync,
        keep: f64,
    ) -> f64 {
        let this = &*self;
        let moved: Vec<Option<(DVec3, DVec3)>> = free
            .par_iter()
            .map(|&v| {
                if this.is_cancelled() {
                    return None;
                }
                let (p, n) = (this.mesh.position[v as usize], this.mesh.normal[v as usize]);
                let step = goal(this, v) - p;
                let step = SMOOTH_STEP.get() * (step - step.dot(n) * n);
                if !step.is_finite() {
                    return None;
                }
                this.project(p + step, this.mesh.size[v as usize])
            })
            .collect_indexed();
        let mut squares = 0.0;
        for (&v, moved) in free.iter().zip(moved) {
            if self.is_cancelled() {
                break;
            }
            let before = self.mesh.position[v as usize];
            if !moved.is_some_and(|(p, n)| self.try_move(v, p, n, keep)) {
                self.reproject(v, keep);
            }
            let way = before.distance(self.mesh.position[v as usize]);
            squares += (way / self.mesh.size[v as usize]).powi(2);
        }
        (squares / free.len().max(1) as f64).sqrt()
    }

    /// Projects a vertex on the surface without a tangential move.
    fn reproject(&mut self, v: u32, keep: f64) {
        let p = self.mesh.position[v as usize];
        if let Some((q, n)) = self.project(p, self.mesh.size[v as usize]) {
            self.try_move(v, q, n, keep);
        }
    }

    /// Moves a vertex if the faces around it stay good; returns whether it did.
    fn try_move(&mut self, v: u32, p: DVec3, n: DVec3, keep: f64) -> bool {
        let (old, old_normal) = (self.mesh.position[v as usize], self.mesh.normal[v as usize]);
        let before = self.around(v, old);
        self.mesh.normal[v as usize] = n;
        let after = self.around(v, p);
        let good = (after.0 >= LEAST_COSINE.get() && after.1 >= keep * before.1)
            || (before.0 < LEAST_COSINE.get() && self.least_area(v, p) > self.least_area(v, old));
        if good {
            self.mesh.position[v as usize] = p;
        } else {
            self.mesh.normal[v as usize] = old_normal;
        }
        good
    }
}
