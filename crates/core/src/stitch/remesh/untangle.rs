//! Untangling: turns tilted or folded faces back, by flips, vertex moves and collapses.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{LEAST_COSINE, Remesher};
use crate::elementary::{cos, sin};
use crate::stitch::half_edge::NONE;
use crate::tuning::{Tunable, tunable};

/// Rounds over all folded faces.
const UNTANGLE_ROUNDS: Tunable<usize> = tunable("stitch.untangle_rounds", 3);

/// Number of directions in which a new position for a vertex of a folded face is searched.
const DIRECTIONS: usize = 12;
/// Distances of that search, in target edge lengths.
const REACH: [f64; 5] = [0.8, 0.4, 0.2, 0.1, 0.05];

impl Remesher<'_> {
    /// Faces whose normals differ by more than 60 degrees from the surface's.
    pub(super) fn tilted(&self) -> Vec<u32> {
        let faces = &self.mesh.faces;
        (0..faces.len() as u32)
            .filter(|&f| {
                faces[f as usize][0] != NONE && self.cosine(faces[f as usize]) < LEAST_COSINE.get()
            })
            .collect()
    }

    /// Flips edges and moves vertices of tilted faces; from the second round on also collapses their edges.
    pub(super) fn untangle(&mut self) {
        for round in 0..UNTANGLE_ROUNDS.get() {
            let tilted = self.tilted();
            if tilted.is_empty() {
                return;
            }
            for f in tilted {
                if self.is_cancelled() {
                    return;
                }
                self.unfold(f, round > 0);
            }
        }
    }

    /// Attempts to turn back one face: by flips, then by moving its vertices, then by collapses if `collapse` is true.
    fn unfold(&mut self, f: u32, collapse: bool) {
        let is_tilted = |work: &Self| {
            let face = work.mesh.faces[f as usize];
            face[0] != NONE && work.cosine(face) < LEAST_COSINE.get()
        };
        for k in 0..3 {
            if is_tilted(self) {
                self.flip_to_unfold(3 * f + k);
            }
        }
        for k in 0..3 {
            let v = self.mesh.faces[f as usize][k];
            if is_tilted(self) && !self.mesh.is_rim(v) && !self.is_hub(v) {
                self.search(v);
            }
        }
        for k in 0..3 {
            if collapse && is_tilted(self) && self.mesh.twin(3 * f + k).is_some() {
                self.collapse(3 * f + k, f64::INFINITY);
            }
        }
    }

    /// Flips an edge if that increases the smallest signed area of its two faces or leaves neither tilted.
    fn flip_to_unfold(&mut self, h: u32) {
        let Some([a, b, c, d]) = self.diamond(h) else {
            return;
        };
        let now = self.signed_area([a, b, c]).min(self.signed_area([b, a, d]));
        let then = self.signed_area([a, d, c]).min(self.signed_area([d, b, c]));
        let least = self.cosine([a, d, c]).min(self.cosine([d, b, c]));
        if self.may_flip([a, b, c, d]) && (then > now || least >= LEAST_COSINE.get()) {
            self.mesh.flip(h);
        }
    }

    /// Moves `v` to the nearby position where the smallest signed area of its faces is largest.
    fn search(&mut self, v: u32) {
        let n = self.mesh.normal[v as usize];
        let x = n.any_orthonormal_vector();
        let y = n.cross(x);
        let size = self.mesh.size[v as usize];
        let mut best = (
            self.least_area(v, self.mesh.position[v as usize]),
            self.mesh.position[v as usize],
        );
        for reach in REACH {
            let from = best.1;
            for i in 0..DIRECTIONS {
                let angle = TAU * i as f64 / DIRECTIONS as f64;
                let p: DVec3 = from + reach * size * (cos(angle) * x + sin(angle) * y);
                let area = self.least_area(v, p);
                if area > best.0 {
                    best = (area, p);
                }
            }
        }
        let now = self.least_area(v, self.mesh.position[v as usize]);
        if let Some((p, n)) = self
            .project(best.1, size)
            .filter(|q| self.least_area(v, q.0) > now)
        {
            self.mesh.position[v as usize] = p;
            self.mesh.normal[v as usize] = n;
        }
    }

    /// The smallest signed area, along the surface normal, of the faces around `v` if it were at `p`.
    pub(super) fn least_area(&self, v: u32, p: DVec3) -> f64 {
        let n = self.mesh.normal[v as usize];
        let area = |h: u32| {
            let face = self.mesh.faces[h as usize / 3];
            let [a, b, c] = face.map(|w| {
                if w == v {
                    p
                } else {
                    self.mesh.position[w as usize]
                }
            });
            (b - a).cross(c - a).dot(n)
        };
        self.mesh
            .outgoing(v)
            .map(area)
            .fold(f64::INFINITY, f64::min)
    }

    fn signed_area(&self, face: [u32; 3]) -> f64 {
        let normal: DVec3 = face.iter().map(|&v| self.mesh.normal[v as usize]).sum();
        self.mesh.area_vector(face).dot(normal.normalize_or_zero())
    }
}
