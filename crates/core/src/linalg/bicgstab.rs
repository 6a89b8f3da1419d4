//! BiCGstab for nonsymmetric linear systems, with guards against breakdown.

use super::cg::{CgOutcome, LinearOperator, Preconditioner, dot};

/// A scalar product below this fraction of the product of the norms counts as zero.
const BREAKDOWN: f64 = 1e-14;

/// Solves `A x = b` from x = 0 until the residual is at most `tolerance` times the norm of `b` (van der Vorst 1992).
///
/// When a scalar product vanishes, the recurrence restarts from the true residual. After three passes, or when the iterations are
/// used up, the result is the best iterate so far with its residual.
pub fn bicgstab(
    operator: &impl LinearOperator,
    preconditioner: &dyn Preconditioner,
    b: &[f64],
    x: &mut [f64],
    tolerance: f64,
    max_iterations: usize,
) -> CgOutcome {
    let n = b.len();
    let reference = dot(b, b).sqrt();
    let goal = tolerance * reference;
    x.fill(0.0);
    let mut r = b.to_vec();
    let mut best = (reference, x.to_vec());
    let (mut iterations, mut restarts) = (0, 0);
    let (mut y, mut v, mut z, mut t) = (vec![0.0; n], vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    let goes_on = |iterations| iterations < max_iterations && !operator.is_cancelled();
    // Each pass starts from the best iterate. Its true residual is also the shadow residual.
    'restart: while best.0 > goal && goes_on(iterations) && restarts < 3 {
        restarts += 1;
        x.copy_from_slice(&best.1);
        operator.apply(x, &mut v);
        (0..n).for_each(|i| r[i] = b[i] - v[i]);
        let shadow = r.clone();
        let mut p = r.clone();
        let mut rho = dot(&shadow, &r);
        while goes_on(iterations) {
            iterations += 1;
            // Step α along the direction p, after which the residual is orthogonal to the shadow residual.
            preconditioner.apply(&p, &mut y);
            operator.apply(&y, &mut v);
            let slope = dot(&shadow, &v);
            if slope.abs() <= BREAKDOWN * (dot(&shadow, &shadow) * dot(&v, &v)).sqrt() {
                continue 'restart;
            }
            let alpha = rho / slope;
            (0..n).for_each(|i| r[i] -= alpha * v[i]);
            // Step ω along the preconditioned residual, which minimises the norm of the next residual.
            preconditioner.apply(&r, &mut z);
            operator.apply(&z, &mut t);
            let tt = dot(&t, &t);
            let omega = if tt > 0.0 { dot(&t, &r) / tt } else { 0.0 };
            for i in 0..n {
                x[i] += alpha * y[i] + omega * z[i];
                r[i] -= omega * t[i];
            }
            let norm = dot(&r, &r).sqrt();
            if !norm.is_finite() {
                continue 'restart;
            }
            // Residuals do not fall monotonically: the best iterate is the result.
            if norm < best.0 {
                best = (norm, x.to_vec());
            }
            let next = dot(&shadow, &r);
            if norm <= goal {
                break 'restart;
            }
            // With ω or ρ vanishing there is no next direction: restart.
            if omega == 0.0 || next.abs() <= BREAKDOWN * norm * dot(&shadow, &shadow).sqrt() {
                continue 'restart;
            }
            let beta = next / rho * alpha / omega;
            (0..n).for_each(|i| p[i] = r[i] + beta * (p[i] - omega * v[i]));
            rho = next;
        }
    }
    x.copy_from_slice(&best.1);
    CgOutcome {
        iterations,
        relative_residual: best.0 / reference.max(f64::MIN_POSITIVE),
    }
}

#[cfg(test)]
mod tests {
    use super::super::cg::Jacobi;
    use super::*;

    /// Convection and diffusion in one dimension.
    struct Line(Vec<f64>);

    impl LinearOperator for Line {
        fn apply(&self, x: &[f64], y: &mut [f64]) {
            let n = x.len();
            let at = |i: usize| if i < n { x[i] } else { 0.0 };
            for i in 0..n {
                let before = if i > 0 { x[i - 1] } else { 0.0 };
                y[i] = 2.5 * x[i] - 1.4 * before - 0.6 * at(i + 1);
            }
        }

        fn jacobi(&self) -> &[f64] {
            &self.0
        }
    }

    #[test]
    fn a_nonsymmetric_system_is_solved() {
        let n = 200;
        let line = Line(vec![0.4; n]);
        let wanted: Vec<f64> = (0..n).map(|i| (0.1 * i as f64).sin()).collect();
        let mut b = vec![0.0; n];
        line.apply(&wanted, &mut b);
        let mut x = vec![0.0; n];
        let end = bicgstab(&line, &Jacobi(line.jacobi()), &b, &mut x, 1e-10, 400);
        assert!(end.relative_residual <= 1e-10, "{end:?}");
        let error = x.iter().zip(&wanted).map(|(a, b)| (a - b).abs());
        assert!(error.fold(0.0, f64::max) < 1e-8);
    }

    #[test]
    fn a_zero_right_hand_side_gives_zero() {
        let line = Line(vec![0.4; 5]);
        let mut x = vec![1.0; 5];
        let end = bicgstab(&line, &Jacobi(line.jacobi()), &[0.0; 5], &mut x, 1e-6, 50);
        assert_eq!((end.iterations, x), (0, vec![0.0; 5]));
    }
}
