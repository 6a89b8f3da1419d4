//! Dense symmetric matrices: Cholesky factorisation, reflections, largest eigenvalue.

use super::rows::{axpy, dot};

/// A dense symmetric matrix; the lower triangle is stored row by row.
#[derive(Clone)]
pub struct Symmetric {
    n: usize,
    entries: Vec<f64>,
}

/// Steps of the power method: enough for the first digit.
const POWERS: usize = 8;

/// Start of row `i` in the stored lower triangle.
fn start(i: usize) -> usize {
    i * (i + 1) / 2
}

impl Symmetric {
    /// A matrix from a function of row and column, which is called only for rows ≥ columns.
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

    /// A lower bound of the largest eigenvalue, by a few steps of the power method from the vector of ones.
    pub fn largest_eigenvalue(&self) -> f64 {
        let (mut x, mut largest) = (vec![1.0; self.n], 0.0);
        for _ in 0..POWERS {
            let norm = dot(&x, &x).sqrt();
            x.iter_mut().for_each(|x| *x /= norm);
            let mut y = vec![0.0; self.n];
            for i in 0..self.n {
                let row = self.row(i);
                axpy(x[i], &row[..i], &mut y[..i]);
                y[i] += dot(row, &x[..=i]);
            }
            largest = dot(&y, &y).sqrt();
            if largest == 0.0 || !largest.is_finite() {
                break;
            }
            x = y;
        }
        largest
    }

    /// A row up to its diagonal.
    pub(super) fn row(&self, i: usize) -> &[f64] {
        &self.entries[start(i)..=start(i) + i]
    }

    /// The stored rows before row `k`, and row `k` without its diagonal.
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

/// The Cholesky factor: the lower triangle `L` of `L Lᵀ`.
pub struct Triangle(Symmetric);

impl Symmetric {
    /// The Cholesky factor of the matrix with `shift` added to the diagonal; `None` if that is not positive definite.
    pub fn cholesky(mut self, shift: f64) -> Option<Triangle> {
        for i in 0..self.n {
            let (above, row) = self.entries.split_at_mut(start(i));
            let row = &mut row[..=i];
            for j in 0..i {
                let other = &above[start(j)..=start(j) + j];
                row[j] = (row[j] - dot(&row[..j], &other[..j])) / other[j];
            }
            let pivot = row[i] + shift - dot(&row[..i], &row[..i]);
            if pivot <= 0.0 || !pivot.is_finite() {
                return None;
            }
            row[i] = pivot.sqrt();
        }
        Some(Triangle(self))
    }
}

impl Triangle {
    /// Solves `L y = x` in place.
    pub fn forward(&self, x: &mut [f64]) {
        for i in 0..x.len() {
            let row = self.0.row(i);
            x[i] = (x[i] - dot(&row[..i], &x[..i])) / row[i];
        }
    }

    /// Solves `Lᵀ y = x` in place.
    pub fn backward(&self, x: &mut [f64]) {
        for i in (0..x.len()).rev() {
            let row = self.0.row(i);
            x[i] /= row[i];
            let value = x[i];
            axpy(-value, &row[..i], &mut x[..i]);
        }
    }
}

/// Applies a reflection to the leading rows and columns of a lower triangle, `v.len()` of them; `p` is scratch space.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cholesky_factor_solves_and_refuses_what_is_not_positive() {
        let matrix = Symmetric::new(40, |i, j| (-0.05 * (i as f64 - j as f64).powi(2)).exp());
        let wanted: Vec<f64> = (0..40).map(|i| (f64::from(i) * 0.9).sin()).collect();
        let mut x: Vec<f64> = (0..40)
            .map(|i| (0..40).map(|j| matrix.get(i, j) * wanted[j]).sum::<f64>() + wanted[i])
            .collect();
        let factor = matrix.clone().cholesky(1.0).unwrap();
        factor.forward(&mut x);
        factor.backward(&mut x);
        for (x, w) in x.iter().zip(wanted) {
            assert!((x - w).abs() < 1e-13);
        }
        assert!(matrix.cholesky(-1.5).is_none());
    }
}
