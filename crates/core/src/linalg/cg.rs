//! Preconditioned conjugate gradients; results do not depend on the number of threads.

use rayon::prelude::*;

use crate::threads::CollectIndexed;

/// Entries per partial sum of a scalar product, so that rounding is the same for every number of threads.
const CHUNK: usize = 2048;

/// A square linear operator. Conjugate gradients need it symmetric and positive (semi)definite; BiCGstab does not.
pub trait LinearOperator: Sync {
    /// `y = A x`.
    fn apply(&self, x: &[f64], y: &mut [f64]);
    /// `y = A x` in single precision, for preconditioners.
    fn apply_single(&self, x: &[f32], y: &mut [f32]) {
        let x: Vec<f64> = x.iter().map(|&v| v.into()).collect();
        let mut wide = vec![0.0; y.len()];
        self.apply(&x, &mut wide);
        y.iter_mut().zip(wide).for_each(|(y, v)| *y = v as f32);
    }
    /// The Jacobi preconditioner: the inverse of the diagonal, one positive factor for each unknown.
    fn jacobi(&self) -> &[f64];
    /// Whether solvers should stop early; their result will not be used.
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// An approximate inverse, symmetric and positive definite.
pub trait Preconditioner: Sync {
    /// `z ≈ A⁻¹ r`.
    fn apply(&self, r: &[f64], z: &mut [f64]);
    /// Whether `z` approximates the error of a solution well enough, given its residual. Solvers then stop by the size of `z`: if
    /// eigenvalues spread over many orders of magnitude, a small residual may hide a large smooth error.
    fn estimates_error(&self) -> bool {
        false
    }
}

/// Jacobi preconditioner: scaling by the inverse diagonal.
pub struct Jacobi<'a>(pub &'a [f64]);

impl Preconditioner for Jacobi<'_> {
    fn apply(&self, r: &[f64], z: &mut [f64]) {
        for ((z, r), s) in z.iter_mut().zip(r).zip(self.0) {
            *z = s * r;
        }
    }
}

/// Outcome of an iterative solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CgOutcome {
    /// Iterations done.
    pub iterations: usize,
    /// Norm of the residual over the norm of the right-hand side.
    pub relative_residual: f64,
}

/// Scalar product, summed in chunks.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    if a.len() <= CHUNK {
        return a.iter().zip(b).map(|(x, y)| x * y).sum();
    }
    let partial: Vec<f64> = a
        .par_chunks(CHUNK)
        .zip(b.par_chunks(CHUNK))
        .map(|(a, b)| a.iter().zip(b).map(|(x, y)| x * y).sum())
        .collect_indexed();
    partial.iter().sum()
}

/// Solves `A x = b` from the given `x` until the residual is at most `tolerance` times `b` or, if the preconditioner estimates
/// the error, the error is at most `tolerance` times `x`; in at most `max_iterations` (Hestenes and Stiefel 1952; preconditioned:
/// J. Nocedal, S. J. Wright, "Numerical Optimization", 2006, algorithm 5.3). Stops early at a direction without positive
/// curvature.
pub fn conjugate_gradient(
    operator: &impl LinearOperator,
    preconditioner: &dyn Preconditioner,
    b: &[f64],
    x: &mut [f64],
    tolerance: f64,
    max_iterations: usize,
) -> CgOutcome {
    let n = b.len();
    // `z` holds the preconditioned residual and A p in turn; they are never needed at the same time.
    let (mut r, mut z, mut p) = (b.to_vec(), vec![0.0; n], vec![0.0; n]);
    let reference = dot(b, b);
    // The residual of the given x.
    if x.iter().any(|&v| v != 0.0) {
        operator.apply(x, &mut z);
        for i in 0..n {
            r[i] -= z[i];
        }
    }
    preconditioner.apply(&r, &mut z);
    p.copy_from_slice(&z);
    let mut rz = dot(&r, &z);
    let mut rr = dot(&r, &r);
    let goal = tolerance * tolerance * reference;
    let mut iterations = 0;
    // Stops at |z| ≤ tolerance |x| if z ≈ A⁻¹ r estimates the error, otherwise at |r| ≤ tolerance |b|.
    let by_error = preconditioner.estimates_error();
    let reached = |rr: f64, z: &[f64], x: &[f64]| {
        if by_error {
            dot(z, z) <= tolerance * tolerance * dot(x, x)
        } else {
            rr <= goal
        }
    };
    while iterations < max_iterations && rz > 0.0 && !reached(rr, &z, x) {
        if operator.is_cancelled() {
            break;
        }
        operator.apply(&p, &mut z);
        let curvature = dot(&p, &z);
        if curvature <= 0.0 || !curvature.is_finite() {
            break;
        }
        // The minimiser of ½ xᵀ A x − bᵀ x along p.
        let alpha = rz / curvature;
        for i in 0..n {
            x[i] += alpha * p[i];
            r[i] -= alpha * z[i];
        }
        preconditioner.apply(&r, &mut z);
        // The next direction: the preconditioned residual made conjugate to all directions before.
        let next = dot(&r, &z);
        let beta = next / rz;
        for i in 0..n {
            p[i] = z[i] + beta * p[i];
        }
        rz = next;
        rr = dot(&r, &r);
        iterations += 1;
    }
    CgOutcome {
        iterations,
        relative_residual: (rr / reference.max(f64::MIN_POSITIVE)).sqrt(),
    }
}
