//! Facet compensation: moves vertices off the surface so that faces are on it on average.

use rayon::prelude::*;

use super::{LEAST_COSINE, Remesher};
use crate::stitch::half_edge::NONE;
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Rings of free vertices over which the compensation for chords grows to its full size.
const COMPENSATION_FADE: Tunable<u32> = tunable("stitch.compensation_fade", 2);

/// Mean edge lengths at a vertex. Upper bound of its displacement by the compensation.
const MOST_COMPENSATION: Tunable<f64> = tunable("stitch.most_compensation", 0.1);

/// Mean over a triangle of a quadratic function that vanishes at the corners, relative to its value at the centroid.
const MEAN_OVER_CENTROID: f64 = 0.75;

impl Remesher<'_> {
    /// Moves each free vertex along its normal against the mean offset of its faces from the surface, by the fraction `part`.
    pub(super) fn compensate(&mut self, part: f64) {
        let this = &*self;
        let offset: Vec<f64> = this
            .mesh
            .faces
            .par_iter()
            .map(|&f| this.facet_offset(f))
            .collect_indexed();
        if self.is_cancelled() {
            return;
        }
        let ring = self.rings(COMPENSATION_FADE.get());
        let moves: Vec<(u32, f64, f64)> = self
            .free_vertices()
            .map(|v| {
                let by = self.displacement(v, &offset, ring[v as usize]);
                (
                    v,
                    part * by,
                    part * MOST_COMPENSATION.get() * self.mesh.mean_length(v),
                )
            })
            .collect();
        for (v, by, most) in moves {
            if self.is_cancelled() {
                return;
            }
            self.displace(v, by, most);
        }
    }

    /// Moves a vertex along its normal by at most `most`, unless a face around it would become tilted.
    pub(super) fn displace(&mut self, v: u32, by: f64, most: f64) {
        let p = self.mesh.position[v as usize];
        let moved = p + by.clamp(-most, most) * self.mesh.normal[v as usize];
        if self.around(v, moved).0 >= LEAST_COSINE.get().min(self.around(v, p).0) {
            self.mesh.position[v as usize] = moved;
        }
    }

    /// Signed mean distance of a face from the surface.
    fn facet_offset(&self, face: [u32; 3]) -> f64 {
        if face[0] == NONE {
            return 0.0;
        }
        let centroid = face
            .iter()
            .map(|&v| self.mesh.position[v as usize])
            .sum::<glam::DVec3>()
            / 3.0;
        let size = face
            .iter()
            .map(|&v| self.mesh.size[v as usize])
            .sum::<f64>()
            / 3.0;
        self.project(centroid, size)
            .map_or(0.0, |(q, n)| MEAN_OVER_CENTROID * (centroid - q).dot(n))
    }

    /// Minus the mean offset of the faces around a vertex, weighted by area; fades in from the rim.
    fn displacement(&self, v: u32, offset: &[f64], ring: u32) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for h in self.mesh.outgoing(v) {
            let area = self
                .mesh
                .area_vector(self.mesh.faces[h as usize / 3])
                .length();
            sum += area * offset[h as usize / 3];
            weight += area;
        }
        let fade = f64::from(ring.min(COMPENSATION_FADE.get() + 1))
            / f64::from(COMPENSATION_FADE.get() + 1);
        if weight > 0.0 {
            -fade * sum / weight
        } else {
            0.0
        }
    }

    /// Number of edges from the rim to each vertex, up to `most`; `most + 1` beyond.
    pub(super) fn rings(&self, most: u32) -> Vec<u32> {
        let mut ring = vec![most + 1; self.mesh.position.len()];
        ring[..self.mesh.rim_len()].fill(0);
        for step in 0..most {
            for v in 0..ring.len() as u32 {
                if ring[v as usize] > step && self.mesh.is_used(v) {
                    let near = self.mesh.neighbours(v).any(|w| ring[w as usize] == step);
                    if near {
                        ring[v as usize] = step + 1;
                    }
                }
            }
        }
        ring
    }
}
