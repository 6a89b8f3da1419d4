//! Small dense systems.

/// Solves a symmetric positive definite system in place by Cholesky factorisation; `matrix` is row-major `n × n`, of which
/// the lower triangle is read and overwritten. False where it is not positive definite.
pub fn solve_spd(matrix: &mut [f64], rhs: &mut [f64]) -> bool {
    let n = rhs.len();
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
    true
}
