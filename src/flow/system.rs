//! The linear system of one step, matrix-free: two or three 27-point stencils a node.

use rayon::prelude::*;

use super::band::Band;
use crate::linalg::{Csr, LinearOperator};

const CHUNK: usize = 1024;

/// The linear system of one step.
pub struct System<'a> {
    band: &'a Band,
    /// Stencil rows of L[P/|∇φ|] (or L[1/|∇φ|] for variant II).
    curvature: Vec<[f64; 27]>,
    /// Stencil rows of the right factor where it is another than the left: L[1/|∇φ|] for variant I.
    inner: Option<Vec<[f64; 27]>>,
    /// Stencil rows of ½ L1 + κ L[n⊗n].
    second: Vec<[f64; 27]>,
    /// χ/M on R, else 0.
    weight: Vec<f64>,
    /// M/τ, or 0.
    diagonal: Vec<f64>,
    jacobi: Vec<f64>,
    /// The gradient of the energy on U, 0 elsewhere.
    pub gradient: Vec<f64>,
}

impl<'a> System<'a> {
    pub(super) fn new(
        band: &'a Band,
        curvature: Vec<[f64; 27]>,
        second: Vec<[f64; 27]>,
        weight: Vec<f64>,
        diagonal: Vec<f64>,
        gradient: Vec<f64>,
    ) -> Self {
        let jacobi = (0..weight.len())
            .into_par_iter()
            .map(|j| {
                if !band.unknown[j] {
                    return 0.0;
                }
                let mut d = second[j][13] + diagonal[j];
                for (k, &i) in band.neighbours[j].iter().enumerate() {
                    if let Some(w) = weight.get(i as usize) {
                        d += w * curvature[j][k] * curvature[j][k];
                    }
                }
                if d > 1e-12 { 1.0 / d } else { 1.0 }
            })
            .collect();
        Self {
            band,
            curvature,
            inner: None,
            second,
            weight,
            diagonal,
            jacobi,
            gradient,
        }
    }
}

impl System<'_> {
    pub(super) fn with_inner(mut self, inner: Option<Vec<[f64; 27]>>) -> Self {
        self.inner = inner;
        self
    }

    /// Whether the system is symmetric: all but variant I are.
    pub fn is_symmetric(&self) -> bool {
        self.inner.is_none()
    }

    /// `Pᵀ A P` for a prolongation `P` whose rows run over the band's nodes.
    pub fn galerkin(&self, p: &Csr) -> Csr {
        let n = self.weight.len();
        let spread = |rows: &[[f64; 27]], wanted: &(dyn Fn(usize) -> bool + Sync)| {
            Csr::from_rows(n, p.columns, |i, sink| {
                if wanted(i) {
                    for (k, &j) in self.band.neighbours[i].iter().enumerate() {
                        if (j as usize) < n && rows[i][k] != 0.0 {
                            for (c, v) in p.row(j as usize) {
                                sink(c, rows[i][k] * v);
                            }
                        }
                    }
                }
            })
        };
        let q = spread(&self.curvature, &|i| self.weight[i] != 0.0);
        let s = spread(&self.second, &|i| self.band.unknown[i]);
        let (qt, pt) = (q.transposed(), p.transposed());
        Csr::from_rows(p.columns, p.columns, |c, sink| {
            for (i, v) in qt.row(c) {
                let w = v * self.weight[i as usize];
                q.row(i as usize).for_each(|(j, x)| sink(j, w * x));
            }
            for (i, v) in pt.row(c) {
                s.row(i as usize).for_each(|(j, x)| sink(j, v * x));
                let d = v * self.diagonal[i as usize];
                if d != 0.0 {
                    p.row(i as usize).for_each(|(j, x)| sink(j, d * x));
                }
            }
        })
    }
}

impl LinearOperator for System<'_> {
    /// `y = (BPᵀ diag(χ/M) BP + S + M/τ) x` on the unknowns; `x` and `y` run over all nodes and are zero off the unknowns.
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let n = x.len();
        let mut padded = Vec::with_capacity(n + 1);
        padded.extend_from_slice(x);
        padded.push(0.0);
        let mut t = vec![0.0; n + 1];
        let inner = self.inner.as_ref().unwrap_or(&self.curvature);
        t[..n]
            .par_chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(c, out)| {
                for (i, o) in (c * CHUNK..).zip(out.iter_mut()) {
                    if self.weight[i] != 0.0 {
                        *o = self.weight[i] * stencil(&inner[i], &self.band.neighbours[i], &padded);
                    }
                }
            });
        y.par_chunks_mut(CHUNK).enumerate().for_each(|(c, out)| {
            for (j, o) in (c * CHUNK..).zip(out.iter_mut()) {
                *o = if self.band.unknown[j] {
                    let near = &self.band.neighbours[j];
                    stencil(&self.curvature[j], near, &t)
                        + stencil(&self.second[j], near, &padded)
                        + self.diagonal[j] * x[j]
                } else {
                    0.0
                };
            }
        });
    }

    fn jacobi(&self) -> &[f64] {
        &self.jacobi
    }
}

#[inline]
fn stencil(row: &[f64; 27], near: &[u32; 27], x: &[f64]) -> f64 {
    let mut s = [0.0; 3];
    for k in 0..9 {
        for d in 0..3 {
            s[d] += row[3 * k + d] * x[near[3 * k + d] as usize];
        }
    }
    s[0] + s[1] + s[2]
}
