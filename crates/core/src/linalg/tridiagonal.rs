//! Symmetric matrices as `Q T Qᵀ` with tridiagonal `T`, for systems with many diagonal shifts of one matrix.
//!
//! Householder's reduction (G. H. Golub, C. F. Van Loan, "Matrix Computations", 8.3.1); after it, `T + s 1` is factorised for
//! each shift `s` in linear time.

use super::rows::{axpy, dot};
use super::symmetric::{Symmetric, reflect};
use crate::elementary::ln;

/// A dense symmetric matrix reduced to tridiagonal form.
pub struct Tridiagonal {
    n: usize,
    /// The diagonal of `T`.
    pub diagonal: Vec<f64>,
    /// The off-diagonal entries of `T`.
    pub off_diagonal: Vec<f64>,
    /// The Householder vectors: the vector of step `k` is the first `k` entries of row `k`.
    reflectors: Symmetric,
    /// The factor of each reflector; 0 where there is none.
    factors: Vec<f64>,
}

/// The factorisation `T + s 1 = L D Lᵀ` for one shift.
pub struct Shifted {
    /// The pivots `D`.
    pub pivots: Vec<f64>,
    multipliers: Vec<f64>,
}

impl Tridiagonal {
    /// Reduces a matrix to tridiagonal form.
    pub fn new(mut matrix: Symmetric) -> Self {
        let n = matrix.rows();
        let (mut off_diagonal, mut factors) = (vec![0.0; n.saturating_sub(1)], vec![0.0; n]);
        let mut p = vec![0.0; n];
        // From the last row up: reflects row k so that its only entry left of the diagonal is at k - 1.
        for k in (1..n).rev() {
            let (above, v) = matrix.split(k);
            let scale = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let tail = v[..k - 1].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            if tail == 0.0 || !scale.is_finite() {
                off_diagonal[k - 1] = v[k - 1];
                continue;
            }
            v.iter_mut().for_each(|x| *x /= scale);
            let norm = dot(v, v).sqrt();
            let first = -norm.copysign(v[k - 1]);
            off_diagonal[k - 1] = first * scale;
            factors[k] = 1.0 / (norm * (norm + v[k - 1].abs()));
            v[k - 1] -= first;
            reflect(above, v, factors[k], &mut p[..k]);
        }
        Self {
            n,
            diagonal: (0..n).map(|i| matrix.get(i, i)).collect(),
            off_diagonal,
            reflectors: matrix,
            factors,
        }
    }

    /// `x ← Qᵀ x`.
    pub fn to_reduced(&self, x: &mut [f64]) {
        (1..self.n).rev().for_each(|k| self.reflect(k, x));
    }

    /// `x ← Q x`.
    pub fn to_original(&self, x: &mut [f64]) {
        (1..self.n).for_each(|k| self.reflect(k, x));
    }

    fn reflect(&self, k: usize, x: &mut [f64]) {
        if self.factors[k] != 0.0 {
            let v = &self.reflectors.row(k)[..k];
            let s = self.factors[k] * dot(v, &x[..k]);
            axpy(-s, v, &mut x[..k]);
        }
    }

    /// The factorisation of `T + shift`; `None` if a pivot is not positive.
    pub fn shifted(&self, shift: f64) -> Option<Shifted> {
        let (mut pivots, mut multipliers) = (Vec::with_capacity(self.n), Vec::new());
        for i in 0..self.n {
            let mut pivot = self.diagonal[i] + shift;
            if i > 0 {
                let multiplier = self.off_diagonal[i - 1] / pivots[i - 1];
                pivot -= multiplier * self.off_diagonal[i - 1];
                multipliers.push(multiplier);
            }
            if pivot <= 0.0 || !pivot.is_finite() {
                return None;
            }
            pivots.push(pivot);
        }
        Some(Shifted {
            pivots,
            multipliers,
        })
    }
}

impl Shifted {
    /// The logarithm of the determinant.
    pub fn log_determinant(&self) -> f64 {
        self.pivots.iter().map(|p| ln(*p)).sum()
    }

    /// `yᵀ (T + s)⁻¹ y`.
    pub fn quadratic(&self, y: &[f64]) -> f64 {
        let (mut sum, mut last) = (0.0, 0.0);
        for (i, y) in y.iter().enumerate() {
            last = if i > 0 {
                y - self.multipliers[i - 1] * last
            } else {
                *y
            };
            sum += last * last / self.pivots[i];
        }
        sum
    }

    /// `y ← (T + s)⁻¹ y`.
    pub fn solve(&self, y: &mut [f64]) {
        for i in 1..y.len() {
            y[i] -= self.multipliers[i - 1] * y[i - 1];
        }
        for i in (0..y.len()).rev() {
            y[i] /= self.pivots[i];
            if i + 1 < y.len() {
                y[i] -= self.multipliers[i] * y[i + 1];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(n: usize) -> Vec<f64> {
        let entry = |i: usize, j: usize| {
            let d = i.abs_diff(j) as f64;
            (-0.1 * d * d).exp() + 0.1 * ((i * j) as f64).sin()
        };
        (0..n * n).map(|e| entry(e / n, e % n)).collect()
    }

    #[test]
    fn shifted_systems_and_determinants_are_those_of_the_matrix() {
        for n in [1, 2, 3, 30] {
            let a = matrix(n);
            let reduced = Tridiagonal::new(Symmetric::new(n, |i, j| a[i * n + j]));
            let shift = 1.5 * a.iter().map(|a| a.abs()).sum::<f64>();
            let shifted = reduced.shifted(shift).unwrap();
            let wanted: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            let mut b: Vec<f64> = (0..n)
                .map(|i| dot(&a[i * n..i * n + n], &wanted) + shift * wanted[i])
                .collect();
            let product = dot(&b, &wanted);
            reduced.to_reduced(&mut b);
            assert!((shifted.quadratic(&b) - product).abs() < 1e-10 * product.abs());
            shifted.solve(&mut b);
            reduced.to_original(&mut b);
            for (x, w) in b.iter().zip(&wanted) {
                assert!((x - w).abs() < 1e-12, "{n}");
            }
            let mut dense = a;
            (0..n).for_each(|i| dense[i * n + i] += shift);
            let mut log = 0.0;
            for k in 0..n {
                log += dense[k * n + k].ln();
                for i in k + 1..n {
                    let m = dense[i * n + k] / dense[k * n + k];
                    (k..n).for_each(|j| dense[i * n + j] -= m * dense[k * n + j]);
                }
            }
            assert!((shifted.log_determinant() - log).abs() < 1e-10 * (1.0 + log.abs()));
        }
    }

    #[test]
    fn matrices_that_are_not_positive_are_refused() {
        let reduced = Tridiagonal::new(Symmetric::new(2, |i, j| if i == j { 1.0 } else { 2.0 }));
        assert!(reduced.shifted(0.5).is_none());
        assert!(reduced.shifted(1.1).is_some());
        let broken = Tridiagonal::new(Symmetric::new(3, |_, _| f64::NAN));
        assert!(broken.shifted(1.0).is_none());
    }
}
