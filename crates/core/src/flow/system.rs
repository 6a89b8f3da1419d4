//! The linear system of one step, matrix-free: a few 27-point stencils for each node.
//!
//! Stencils are stored in single precision. The rounding error in the sum of a row is subtracted at its centre, in the precision
//! of the vectors, so that constants are annihilated: smooth functions on a hole of diameter D have eigenvalues of the order
//! (h/D)⁴, which that error would hide.

use std::ops::Range;
use std::sync::{Arc, LazyLock, Mutex};

use super::band::{Band, NONE};
use super::layout::{CHUNK, Layout};
use super::pull::BandPull;
use super::stencil::Stencil;
use crate::cancel::Cancel;
use crate::linalg::{Accumulator, Csr, LinearOperator, Real};
use crate::threads::for_each_chunk;

/// Rows multiplied with a prolongation at a time.
const SLAB: usize = 16_384;

/// The weights of one row, besides its stencils.
#[derive(Clone, Copy, Default)]
pub struct RowWeights {
    /// χ/M on R, else 0.
    pub residual: f32,
    /// M/τ, from the left-hand side of equation (9) of Droske and Rumpf (2004), or 0.
    pub inertia: f32,
    /// Whether the node is an unknown.
    pub unknown: bool,
}

/// The stencils of a system; each list has one for each row of the band's layout.
pub struct Factors {
    /// L[P/|∇φ|] (or L[1/|∇φ|] for variant II).
    pub curvature: Vec<Stencil>,
    /// The right factor if it differs from the left: L[1/|∇φ|] for variant I.
    pub inner: Option<Vec<Stencil>>,
    /// The matrix between the two factors that replaces their weights: K of the curvature variation.
    pub middle: Option<Vec<Stencil>>,
    /// ½ L1 + κ L[n⊗n].
    pub second: Vec<Stencil>,
}

/// Scratch vectors of both precisions, reused from one product to the next.
#[derive(Default)]
struct Scratch {
    double: [Vec<f64>; 2],
    single: [Vec<f32>; 2],
}

/// The linear system of one step. Its vectors run over the positions of the band's layout.
pub struct System {
    layout: Arc<Layout>,
    factors: Factors,
    weights: Vec<RowWeights>,
    jacobi: Vec<f64>,
    scratch: Mutex<Scratch>,
    cancel: Cancel,
}

impl System {
    /// A system from its stencils and one weight for each row of the band's layout.
    pub(super) fn new(band: &Band, factors: Factors, weights: Vec<RowWeights>) -> Self {
        let mut system = Self {
            layout: band.layout.clone(),
            factors,
            weights,
            jacobi: Vec::new(),
            scratch: Mutex::default(),
            cancel: band.cancel.clone(),
        };
        system.jacobi = system.inverse_diagonal();
        system
    }

    /// Adds an attraction to the matrix.
    pub(super) fn add(&mut self, pull: &BandPull) {
        for (weights, &i) in self.weights.iter_mut().zip(&self.layout.rows) {
            weights.inertia += pull.diagonal(i as usize) as f32;
        }
        self.jacobi = self.inverse_diagonal();
    }

    /// The Jacobi preconditioner: the inverse of the diagonal, at each position.
    fn inverse_diagonal(&self) -> Vec<f64> {
        let layout = &*self.layout;
        // χ/M at each position, zero outside R.
        let mut weight = vec![0.0; layout.len];
        for (r, w) in self.weights.iter().enumerate() {
            weight[layout.position_of(r)] = f64::from(w.residual);
        }
        // With a middle factor: the row at each position on R.
        let mut row_at = Vec::new();
        if self.factors.middle.is_some() {
            row_at.resize(layout.len, NONE);
            for (r, w) in self.weights.iter().enumerate() {
                if w.residual != 0.0 {
                    row_at[layout.position_of(r)] = r as u32;
                }
            }
        }
        let mut out = vec![0.0; layout.len];
        for_each_chunk(&mut out, CHUNK, &|c, out| {
            for (r, place) in layout.rows_of(c) {
                if self.cancel.is_cancelled() {
                    return;
                }
                if !self.weights[r].unknown {
                    continue;
                }
                // The diagonal of ½ L1 + κ L[n⊗n] + M/τ.
                let mut d = self.factors.second[r].entry(13) + f64::from(self.weights[r].inertia);
                // The diagonal of BPᵀ diag(χ/M) BP, from the squares of BP's column. BP is symmetric, so its row is used. For
                // variant I, with its different right factor, this is an approximation.
                let curvature = &self.factors.curvature[r];
                if let Some(middle) = &self.factors.middle {
                    d += enclosed_diagonal(middle, curvature, |k| {
                        row_at[layout.starts[r][k / 3] as usize + k % 3]
                    });
                } else {
                    for k in 0..27 {
                        let entry = curvature.entry(k);
                        let at = layout.starts[r][k / 3] as usize + k % 3;
                        d += weight[at] * entry * entry;
                    }
                }
                // Rows with hardly any energy are not scaled.
                out[place] = if d > 1e-12 { 1.0 / d } else { 1.0 };
            }
        });
        out
    }

    /// Whether the system is symmetric: all but variant I are.
    pub fn is_symmetric(&self) -> bool {
        self.factors.inner.is_none()
    }

    /// The positions of the system's vectors.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// `Pᵀ A P` for a prolongation `P` whose rows are the layout's positions, summed over slabs of rows; empty once the token is
    /// set.
    pub fn galerkin(&self, p: &Csr) -> Csr {
        let rows = self.layout.rows.len();
        // Partial sums of 1, 2, 4 … slabs, so that each entry takes part in few additions.
        let mut sums: Vec<(u32, Csr)> = Vec::new();
        for first in (0..rows).step_by(SLAB) {
            if self.cancel.is_cancelled() {
                return Csr::default();
            }
            let (mut order, mut sum) = (0, self.galerkin_of(p, first..rows.min(first + SLAB)));
            while let Some((_, before)) = sums.pop_if(|s| s.0 == order) {
                sum = before.plus(&sum);
                order += 1;
            }
            sums.push((order, sum));
        }
        let all = sums.into_iter().rev().map(|s| s.1);
        all.reduce(|sum, before| before.plus(&sum))
            .unwrap_or_default()
            .mirrored()
    }

    /// The contribution of some rows to the upper triangle of `Pᵀ A P`: with Q = BP·P, `Qᵀ diag(χ/M) Q + Pᵀ S P + Pᵀ M/τ P`.
    fn galerkin_of(&self, p: &Csr, range: Range<usize>) -> Csr {
        let layout = &*self.layout;
        let (first, count) = (range.start, range.len());
        // A row of a stencil times P.
        let times = |stencil: &Stencil, r: usize, sink: &mut Accumulator| {
            if self.cancel.is_cancelled() {
                return;
            }
            for k in 0..27 {
                let entry = stencil.entry(k);
                if entry != 0.0 {
                    let at = layout.starts[r][k / 3] as usize + k % 3;
                    p.row(at).for_each(|(c, v)| sink.add(c, entry * v));
                }
            }
        };
        // Q = BP·P on R, S·P on the unknowns with S = ½ L1 + κ L[n⊗n], and the rows of P itself.
        let q = Csr::from_rows(count, p.columns, |i, sink| {
            let r = first + i;
            if self.weights[r].residual != 0.0 {
                times(&self.factors.curvature[r], r, sink);
            }
        });
        let s = Csr::from_rows(count, p.columns, |i, sink| {
            let r = first + i;
            if self.weights[r].unknown {
                times(&self.factors.second[r], r, sink);
            }
        });
        let own = Csr::from_rows(count, p.columns, |i, sink| {
            let row = p.row(layout.position_of(first + i));
            row.for_each(|(c, v)| sink.add(c, v));
        });
        // With a middle factor the product is Qᵀ K Q, so K Q replaces Q on the right.
        let enclosed = self
            .factors
            .middle
            .as_ref()
            .map(|middle| self.enclosed(p, middle, range));
        let right = enclosed.as_ref().unwrap_or(&q);
        // Rows of the upper triangle: entries from the diagonal on.
        let (qt, pt) = (q.transposed(), own.transposed());
        Csr::from_rows(p.columns, p.columns, |c, sink| {
            for (i, v) in qt.row(c) {
                let w = v * f64::from(self.weights[first + i as usize].residual);
                right
                    .row_from(i as usize, c as u32)
                    .for_each(|(j, x)| sink.add(j, w * x));
            }
            for (i, v) in pt.row(c) {
                s.row_from(i as usize, c as u32)
                    .for_each(|(j, x)| sink.add(j, v * x));
                let d = v * f64::from(self.weights[first + i as usize].inertia);
                if d != 0.0 {
                    own.row_from(i as usize, c as u32)
                        .for_each(|(j, x)| sink.add(j, d * x));
                }
            }
        })
    }

    /// Rows of K Q.
    fn enclosed(&self, p: &Csr, middle: &[Stencil], range: Range<usize>) -> Csr {
        let layout = &*self.layout;
        let mut row_at = vec![NONE; layout.len];
        for (r, w) in self.weights.iter().enumerate() {
            if w.residual != 0.0 {
                row_at[layout.position_of(r)] = r as u32;
            }
        }
        let places = |r: usize| (0..27).map(move |k| (k, layout.starts[r][k / 3] as usize + k % 3));
        Csr::from_rows(range.len(), p.columns, |i, sink| {
            let r = range.start + i;
            if self.weights[r].residual == 0.0 {
                return;
            }
            for (k, at) in places(r) {
                let (entry, near) = (middle[r].entry(k), row_at[at]);
                if entry == 0.0 || near == NONE {
                    continue;
                }
                let curvature = &self.factors.curvature[near as usize];
                for (k, at) in places(near as usize) {
                    let both = entry * curvature.entry(k);
                    p.row(at).for_each(|(c, v)| sink.add(c, both * v));
                }
            }
        })
    }

    /// `y = (BPᵀ diag(χ/M) BP + S + M/τ) x`; with a middle factor K replaces diag(χ/M).
    fn product<T: Real>(&self, x: &[T], y: &mut [T], [t, between]: &mut [Vec<T>; 2]) {
        let layout = &*self.layout;
        t.resize(layout.len, T::ZERO);
        let inner = self
            .factors
            .inner
            .as_ref()
            .unwrap_or(&self.factors.curvature);
        // t = χ/M B x on R, with B = L[P/|∇φ|], or L[1/|∇φ|] as the right factor of variants I and II.
        let first = |(c, out): (usize, &mut [T])| {
            if self.cancel.is_cancelled() {
                return;
            }
            for (r, place) in layout.rows_of(c) {
                let weight = self.weights[r].residual;
                if weight != 0.0 {
                    let own = c * CHUNK + place;
                    out[place] = T::of(weight) * inner[r].apply(&layout.starts[r], own, x);
                }
            }
        };
        each_chunk(t, first);
        // With a middle factor t becomes K t.
        if let Some(middle) = &self.factors.middle {
            between.resize(layout.len, T::ZERO);
            let t = &t[..];
            each_chunk(between, |(c, out)| {
                if self.cancel.is_cancelled() {
                    return;
                }
                for (r, place) in layout.rows_of(c) {
                    if self.weights[r].residual != 0.0 {
                        out[place] = middle[r].apply(&layout.starts[r], c * CHUNK + place, t);
                    }
                }
            });
        }
        let t = if self.factors.middle.is_some() {
            &between[..]
        } else {
            &t[..]
        };
        // y = Bᵀ t + S x + M/τ x on the unknowns, zero elsewhere. B is symmetric, so its own stencils apply Bᵀ.
        let second = |(c, out): (usize, &mut [T])| {
            out.fill(T::ZERO);
            if self.cancel.is_cancelled() {
                return;
            }
            for (r, place) in layout.rows_of(c) {
                let weights = &self.weights[r];
                if weights.unknown {
                    let (starts, own) = (&layout.starts[r], c * CHUNK + place);
                    out[place] = self.factors.curvature[r].apply(starts, own, t)
                        + self.factors.second[r].apply(starts, own, x)
                        + T::of(weights.inertia) * x[own];
                }
            }
        };
        each_chunk(y, second);
    }
}

/// All (i, k, e) such that the stencil offset from neighbour `i` to neighbour `k` of a node is neighbour offset `e`.
static CHAINS: LazyLock<Vec<(usize, usize, usize)>> = LazyLock::new(|| {
    let axes = |i: usize| [i / 9, i / 3 % 3, i % 3];
    let pairs = (0..27 * 27).map(|n| (n / 27, n % 27));
    pairs
        .filter_map(|(i, k)| {
            let (a, b) = (axes(i), axes(k));
            let near = (0..3).all(|d| a[d].abs_diff(b[d]) <= 1);
            near.then(|| (i, k, (0..3).fold(0, |e, d| 3 * e + b[d] + 1 - a[d])))
        })
        .collect()
});

/// One diagonal entry of `BPᵀ K BP`. BP is symmetric, so `column` is also its row; `row` returns the row of K at each neighbour.
fn enclosed_diagonal(middle: &[Stencil], column: &Stencil, row: impl Fn(usize) -> u32) -> f64 {
    let rows: [u32; 27] = std::array::from_fn(row);
    let column: [f64; 27] = std::array::from_fn(|k| {
        if rows[k] == NONE {
            0.0
        } else {
            column.entry(k)
        }
    });
    CHAINS
        .iter()
        .filter(|&&(i, ..)| column[i] != 0.0)
        .map(|&(i, k, e)| column[i] * middle[rows[i] as usize].entry(e) * column[k])
        .sum()
}

/// Runs over the chunks of a vector, in parallel if there are more than two.
fn each_chunk<T: Real>(vector: &mut [T], run: impl Fn((usize, &mut [T])) + Sync + Send) {
    if vector.len() <= 2 * CHUNK {
        vector.chunks_mut(CHUNK).enumerate().for_each(run);
    } else {
        for_each_chunk(vector, CHUNK, &|c, out| run((c, out)));
    }
}

impl LinearOperator for System {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let mut t = self.take(|s| &mut s.double);
        self.product(x, y, &mut t);
        self.give(|s| &mut s.double, t);
    }

    fn apply_single(&self, x: &[f32], y: &mut [f32]) {
        let mut t = self.take(|s| &mut s.single);
        self.product(x, y, &mut t);
        self.give(|s| &mut s.single, t);
    }

    fn jacobi(&self) -> &[f64] {
        &self.jacobi
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }
}

impl System {
    /// Takes the scratch vectors out, so that no lock is held during a product.
    fn take<T>(&self, which: impl Fn(&mut Scratch) -> &mut [Vec<T>; 2]) -> [Vec<T>; 2] {
        let scratch = self.scratch.lock();
        scratch.map_or_else(
            |_| Default::default(),
            |mut s| std::mem::take(which(&mut s)),
        )
    }

    fn give<T>(&self, which: impl Fn(&mut Scratch) -> &mut [Vec<T>; 2], vectors: [Vec<T>; 2]) {
        if let Ok(mut s) = self.scratch.lock() {
            *which(&mut s) = vectors;
        }
    }
}
