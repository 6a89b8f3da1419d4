//! Small dense systems.

/// A Cholesky factorisation.
pub struct Cholesky {
    factor: Vec<f64>,
    n: usize,
}

impl Cholesky {
    /// Factorises a row-major `n × n` matrix; none where it is not positive definite.
    pub fn new(matrix: &[f64], n: usize) -> Option<Self> {
        let mut factor = matrix.to_vec();
        factorise(&mut factor, n).then_some(Self { factor, n })
    }

    /// Solves in place.
    pub fn solve(&self, x: &mut [f64]) {
        substitute(&self.factor, x, self.n);
    }
}

/// Solves a symmetric positive definite system in place by Cholesky factorisation; `matrix` is row-major `n × n`, of which
/// the lower triangle is read and overwritten. False where it is not positive definite.
pub fn solve_spd(matrix: &mut [f64], rhs: &mut [f64]) -> bool {
    let n = rhs.len();
    if !factorise(matrix, n) {
        return false;
    }
    substitute(matrix, rhs, n);
    true
}

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
