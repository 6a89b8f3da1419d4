//! Preconditioned conjugate gradients whose result does not depend on the number of threads.

use rayon::prelude::*;

/// Vectors are summed in chunks of this many entries, so that rounding is the same for every number of threads.
const CHUNK: usize = 2048;

/// A symmetric positive (semi)definite operator.
pub trait LinearOperator: Sync {
    /// `y = A x`.
    fn apply(&self, x: &[f64], y: &mut [f64]);
    /// The inverse of the preconditioner, one positive factor for each unknown.
    fn jacobi(&self) -> &[f64];
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CgOutcome {
    /// Iterations done.
    pub iterations: usize,
    /// Norm of the preconditioned residual over that of the right-hand side.
    pub relative_residual: f64,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    if a.len() <= CHUNK {
        return a.iter().zip(b).map(|(x, y)| x * y).sum();
    }
    let partial: Vec<f64> = a
        .par_chunks(CHUNK)
        .zip(b.par_chunks(CHUNK))
        .map(|(a, b)| a.iter().zip(b).map(|(x, y)| x * y).sum())
        .collect();
    partial.iter().sum()
}

/// Solves `A x = b` from the given `x` until the preconditioned residual has fallen by `tolerance`, in at most
/// `max_iterations` (Hestenes and Stiefel 1952). Stops early where the operator shows no positive curvature.
pub fn conjugate_gradient(
    operator: &impl LinearOperator,
    b: &[f64],
    x: &mut [f64],
    tolerance: f64,
    max_iterations: usize,
) -> CgOutcome {
    let n = b.len();
    let scale = operator.jacobi();
    let (mut r, mut z, mut p, mut q) = (vec![0.0; n], vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    operator.apply(x, &mut q);
    for i in 0..n {
        r[i] = b[i] - q[i];
        z[i] = scale[i] * b[i];
    }
    let reference = dot(&z, b);
    for i in 0..n {
        z[i] = scale[i] * r[i];
    }
    p.copy_from_slice(&z);
    let mut rz = dot(&r, &z);
    let goal = tolerance * tolerance * reference.max(f64::MIN_POSITIVE);
    let mut iterations = 0;
    while iterations < max_iterations && rz > goal {
        operator.apply(&p, &mut q);
        let curvature = dot(&p, &q);
        if curvature <= 0.0 || !curvature.is_finite() {
            break;
        }
        let alpha = rz / curvature;
        for i in 0..n {
            x[i] += alpha * p[i];
            r[i] -= alpha * q[i];
            z[i] = scale[i] * r[i];
        }
        let next = dot(&r, &z);
        let beta = next / rz;
        for i in 0..n {
            p[i] = z[i] + beta * p[i];
        }
        rz = next;
        iterations += 1;
    }
    CgOutcome {
        iterations,
        relative_residual: (rz / reference.max(f64::MIN_POSITIVE)).sqrt(),
    }
}
