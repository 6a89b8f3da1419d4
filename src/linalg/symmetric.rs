//! Dense symmetric matrices.

use super::rows::{axpy, dot};

/// A dense symmetric matrix, of which the lower triangle is stored, row after row.
#[derive(Clone)]
pub struct Symmetric {
    n: usize,
    entries: Vec<f64>,
}

/// Start of a row of the lower triangle.
fn start(i: usize) -> usize {
    i * (i + 1) / 2
}

impl Symmetric {
    /// The matrix with the entries that a function gives for rows not above the columns.
    pub fn new(n: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let mut entries = Vec::with_capacity(start(n));
        for i in 0..n {
            entries.extend((0..=i).map(|j| entry(i, j)));
        }
        Self { n, entries }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.n
    }

    /// An entry.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.entries[start(i.max(j)) + i.min(j)]
    }

    /// A row up to its diagonal.
    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.entries[start(i)..=start(i) + i]
    }

    /// The rows before one, and that one without its diagonal.
    pub(super) fn split(&mut self, k: usize) -> (&mut [f64], &mut [f64]) {
        let (above, row) = self.entries.split_at_mut(start(k));
        (above, &mut row[..k])
    }

    /// The matrix without its first rows and columns.
    pub fn without_first(&self, count: usize) -> Self {
        Self::new(self.n.saturating_sub(count), |i, j| {
            self.get(i + count, j + count)
        })
    }

    /// `A ← H A H` with the reflection `H = 1 − factor v vᵀ`.
    pub fn reflect(&mut self, v: &[f64], factor: f64) {
        reflect(&mut self.entries, v, factor, &mut vec![0.0; v.len()]);
    }
}

/// Reflects the first rows of a lower triangle, as many as `v` is long.
pub(super) fn reflect(entries: &mut [f64], v: &[f64], factor: f64, p: &mut [f64]) {
    p.fill(0.0);
    for i in 0..v.len() {
        let row = &entries[start(i)..=start(i) + i];
        axpy(v[i], &row[..i], &mut p[..i]);
        p[i] += dot(row, &v[..=i]);
    }
    p.iter_mut().for_each(|x| *x *= factor);
    let half = 0.5 * factor * dot(v, p);
    axpy(-half, v, p);
    for i in 0..v.len() {
        let row = &mut entries[start(i)..=start(i) + i];
        let (vi, pi) = (v[i], p[i]);
        for ((t, p), v) in row.iter_mut().zip(p.iter()).zip(v) {
            *t -= vi * p + pi * v;
        }
    }
}
