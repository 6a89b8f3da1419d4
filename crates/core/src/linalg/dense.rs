//! Small dense systems (Cholesky) and eigenvalues of symmetric 3 × 3 matrices.

use crate::elementary::{hypot, ln};
use glam::DVec3;

/// A Cholesky factorisation of a dense matrix.
pub struct Cholesky {
    factor: Vec<f64>,
    n: usize,
}

impl Cholesky {
    /// Factorises a row-major `n × n` matrix; `None` if it is not positive definite.
    pub fn new(matrix: &[f64], n: usize) -> Option<Self> {
        let mut factor = matrix.to_vec();
        factorise(&mut factor, n).then_some(Self { factor, n })
    }

    /// Solves in place.
    pub fn solve(&self, x: &mut [f64]) {
        substitute(&self.factor, x, self.n);
    }

    /// Natural logarithm of the matrix's determinant.
    pub fn log_determinant(&self) -> f64 {
        let diagonal = self.factor.iter().step_by(self.n + 1);
        2.0 * diagonal.map(|d| ln(*d)).sum::<f64>()
    }
}

/// Solves a symmetric positive definite system in place by Cholesky factorisation. `matrix` is row-major `n × n`; its lower
/// triangle is read and overwritten. Returns false if it is not positive definite.
pub fn solve_spd(matrix: &mut [f64], rhs: &mut [f64]) -> bool {
    let n = rhs.len();
    if !factorise(matrix, n) {
        return false;
    }
    substitute(matrix, rhs, n);
    true
}

/// Cholesky factorisation of the lower triangle in place; false if the matrix is not positive definite.
fn factorise(matrix: &mut [f64], n: usize) -> bool {
    for j in 0..n {
        let mut d = matrix[j * n + j];
        for k in 0..j {
            d -= matrix[j * n + k] * matrix[j * n + k];
        }
        if d <= 0.0 || !d.is_finite() {
            return false;
        }
        let d = d.sqrt();
        matrix[j * n + j] = d;
        for i in j + 1..n {
            let mut s = matrix[i * n + j];
            for k in 0..j {
                s -= matrix[i * n + k] * matrix[j * n + k];
            }
            matrix[i * n + j] = s / d;
        }
    }
    true
}

/// Forward and back substitution with a Cholesky factor.
fn substitute(matrix: &[f64], rhs: &mut [f64], n: usize) {
    for i in 0..n {
        for k in 0..i {
            rhs[i] -= matrix[i * n + k] * rhs[k];
        }
        rhs[i] /= matrix[i * n + i];
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            rhs[i] -= matrix[k * n + i] * rhs[k];
        }
        rhs[i] /= matrix[i * n + i];
    }
}

/// The second moment matrix Σ x xᵀ of some vectors.
pub fn second_moments(vectors: impl Iterator<Item = DVec3>) -> [[f64; 3]; 3] {
    let mut moments = [[0.0; 3]; 3];
    for x in vectors.map(|v| v.to_array()) {
        (0..9).for_each(|k| moments[k / 3][k % 3] += x[k / 3] * x[k % 3]);
    }
    moments
}

/// Maximum number of sweeps of Jacobi's method. It converges quadratically, within six.
const SWEEPS: usize = 30;

/// The eigenvalues of a symmetric 3 × 3 matrix in rising order, and unit eigenvectors, by Jacobi's cyclic method (Golub and Van
/// Loan, Matrix Computations, section 8.5).
pub fn symmetric_eigen(matrix: &[[f64; 3]; 3]) -> ([f64; 3], [DVec3; 3]) {
    let mut a = *matrix;
    let mut axes = [DVec3::X, DVec3::Y, DVec3::Z];
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            // The rotation in the plane of axes p and q that makes entry (p, q) zero.
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + hypot(theta, 1.0));
            let c = 1.0 / hypot(t, 1.0);
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            let (of_p, of_q) = (a[p], a[q]);
            a[p] = [0, 1, 2].map(|k| c * of_p[k] - s * of_q[k]);
            a[q] = [0, 1, 2].map(|k| s * of_p[k] + c * of_q[k]);
            (axes[p], axes[q]) = (c * axes[p] - s * axes[q], s * axes[p] + c * axes[q]);
            (a[p][q], a[q][p]) = (0.0, 0.0);
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| a[*i][*i].total_cmp(&a[*j][*j]));
    (order.map(|i| a[i][i]), order.map(|i| axes[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_are_scaled_by_their_eigenvalues() {
        let matrices = [
            [[2.0, -1.0, 0.5], [-1.0, 3.0, 0.25], [0.5, 0.25, -1.0]],
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [[1e-9, 1e-5, 0.0], [1e-5, 1.0, 0.0], [0.0, 0.0, 0.0]],
        ];
        for m in matrices {
            let (values, axes) = symmetric_eigen(&m);
            assert!(values.is_sorted());
            for (value, axis) in values.iter().zip(axes) {
                let image = DVec3::from(m.map(|row| DVec3::from(row).dot(axis)));
                assert!(image.distance(axis * *value) < 1e-14, "{m:?}");
                assert!((axis.length() - 1.0).abs() < 1e-14);
            }
        }
    }
}
