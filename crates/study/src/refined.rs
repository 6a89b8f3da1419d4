//! Solver of the nonsymmetric systems of variant I: BiCGstab in single precision with iterative refinement in double precision.
//!
//! A step needs its system solved to four to seven digits. A solve in single precision gives five, with half the memory and twice the
//! numbers per instruction. Further rounds solve for the remaining residual.

use super::grid::{SquareGrid, Stencils};
use super::system::StepSystem;
use isomend_core::linalg::{CgOutcome, LinearOperator};

/// Lower bound of a round's tolerance relative to its initial residual: single precision reaches no smaller one.
const LEAST: f64 = 1e-5;
/// A round's tolerance relative to the goal; below 1, since the round's own residual has rounding errors.
const MARGIN: f64 = 0.9;
/// Upper bound of the number of iterations of all rounds.
const MOST_ITERATIONS: usize = 4000;
/// Upper bound of the number of iterations of one round; then the residual is recomputed in double precision.
const MOST_IN_ROUND: usize = 500;

/// The system in single precision, with rows scaled by its diagonal D, and the work vectors of a solve.
pub struct Refined {
    /// `M⁻¹ L3`.
    inner: Stencils<f32>,
    /// `τ D⁻¹ L2`.
    outer: Stencils<f32>,
    /// `D⁻¹ (M + τ/2 L1)`.
    near: Stencils<f32>,
    vectors: [Vec<f32>; 7],
}

impl Refined {
    /// Allocates memory for systems on a grid.
    pub fn new(grid: &SquareGrid) -> Self {
        let matrix = || Stencils::zero(grid);
        Self {
            inner: matrix(),
            outer: matrix(),
            near: matrix(),
            vectors: std::array::from_fn(|_| vec![0.0; grid.field_len()]),
        }
    }

    /// Solves `A x = b` from the given `x` until the residual divided by the diagonal has a norm of at most `goal`.
    pub fn solve(&mut self, system: &StepSystem, b: &[f64], x: &mut [f64], goal: f64) -> CgOutcome {
        let scaling = system.jacobi();
        let whole = norm(b.iter().zip(scaling).map(|(b, s)| s * b));
        let mut rest = vec![0.0; b.len()];
        let (mut iterations, mut before) = (0, f64::INFINITY);
        let mut rounded = false;
        loop {
            system.apply(x, &mut rest);
            for ((r, b), s) in rest.iter_mut().zip(b).zip(scaling) {
                *r = s * (b - *r);
            }
            let left = norm(rest.iter().copied());
            // Stop after a round that did not halve the residual: further rounds would not either.
            let gained = left < 0.5 * before;
            if left <= goal || !gained || iterations >= MOST_ITERATIONS {
                return CgOutcome {
                    iterations,
                    relative_residual: left / whole.max(f64::MIN_POSITIVE),
                };
            }
            if !rounded {
                system.round(&mut self.inner, &mut self.outer, &mut self.near);
                rounded = true;
            }
            before = left;
            iterations += self.round(&rest, left, (MARGIN * goal / left).max(LEAST), x);
        }
    }

    /// `y = D⁻¹ A x`.
    fn apply(&self, x: &[f32], bent: &mut [f32], y: &mut [f32]) {
        self.inner.apply(x, bent);
        self.near.apply(x, y);
        self.outer.apply_add(bent, y);
    }

    /// BiCGstab (van der Vorst 1992), started at zero, for a right-hand side `b` of norm `size`; adds the solution to `x`. Stops at the
    /// relative tolerance, or when a scalar product vanishes or overflows. Returns the number of iterations.
    fn round(&mut self, b: &[f64], size: f64, tolerance: f64, x: &mut [f64]) -> usize {
        let mut vectors = std::mem::take(&mut self.vectors);
        let [r, shadow, p, v, t, d, bent] = &mut vectors;
        // Scale the right-hand side to norm 1.
        for (r, b) in r.iter_mut().zip(b) {
            *r = (b / size) as f32;
        }
        shadow.copy_from_slice(r);
        p.copy_from_slice(r);
        d.fill(0.0);
        let mut rho = dot(r, r);
        let goal = rho * tolerance * tolerance;
        let mut iterations = 0;
        while iterations < MOST_IN_ROUND {
            iterations += 1;
            // Step along the search direction p.
            self.apply(p, bent, v);
            let alpha = rho / dot(shadow, v);
            if !alpha.is_finite() {
                break;
            }
            add(r, -alpha, v);
            // Stabilising step along the residual r, which minimises the new residual.
            self.apply(r, bent, t);
            let square = dot(t, t);
            let omega = if square > 0.0 {
                dot(t, r) / square
            } else {
                0.0
            };
            add(d, alpha, p);
            add(d, omega, r);
            add(r, -omega, t);
            // Next search direction.
            let next = dot(shadow, r);
            let beta = next / rho * alpha / omega;
            if dot(r, r) <= goal || !beta.is_finite() {
                break;
            }
            let (keep, less) = (beta as f32, (beta * omega) as f32);
            for ((p, r), v) in p.iter_mut().zip(&*r).zip(&*v) {
                *p = r + keep * *p - less * v;
            }
            rho = next;
        }
        // Add the correction in double precision if it is finite.
        if d.iter().all(|d| d.is_finite()) {
            x.iter_mut()
                .zip(&*d)
                .for_each(|(x, d)| *x += size * f64::from(*d));
        }
        self.vectors = vectors;
        iterations
    }
}

/// `x += s y`.
fn add(x: &mut [f32], s: f64, y: &[f32]) {
    let s = s as f32;
    x.iter_mut().zip(y).for_each(|(x, y)| *x += s * y);
}

pub(super) fn norm(v: impl Iterator<Item = f64>) -> f64 {
    v.map(|x| x * x).sum::<f64>().sqrt()
}

/// `a · b`: sixteen partial sums in single precision over stretches of 256 numbers; the stretches are added in double precision.
fn dot(a: &[f32], b: &[f32]) -> f64 {
    const STRETCH: usize = 256;
    let stretch = |(a, b): (&[f32], &[f32])| {
        let ((x, last_x), (y, last_y)) = (a.as_chunks::<16>(), b.as_chunks::<16>());
        let mut sums = [0.0f32; 16];
        for (x, y) in x.iter().zip(y) {
            for k in 0..16 {
                sums[k] += x[k] * y[k];
            }
        }
        let rest: f32 = last_x.iter().zip(last_y).map(|(x, y)| x * y).sum();
        f64::from(sums.iter().sum::<f32>() + rest)
    };
    a.chunks(STRETCH).zip(b.chunks(STRETCH)).map(stretch).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::PlaneEnergy;
    use isomend_core::flow::Variant;
    use isomend_core::linalg::{Jacobi, bicgstab};

    #[test]
    fn a_system_is_solved_far_beyond_single_precision() {
        let grid = SquareGrid::centred(24);
        let h = grid.h();
        let phi = grid.field(|[x, y]| x.hypot(y) - 0.2 + 0.05 * (9.0 * x).sin());
        let energy = PlaneEnergy::natural(grid.clone(), h * h);
        let (at, tau) = (energy.linearise(&phi), 10.0 * h.powi(4));
        let system = StepSystem::new(&energy, &at, Variant::I, tau);
        let b: Vec<f64> = at.gradient.iter().map(|g| -tau * g).collect();
        let mut wanted = vec![0.0; b.len()];
        let jacobi = Jacobi(system.jacobi());
        let end = bicgstab(&system, &jacobi, &b, &mut wanted, 1e-13, 4000);
        assert!(end.relative_residual < 1e-12, "{end:?}");
        let size = norm(b.iter().zip(system.jacobi()).map(|(b, s)| s * b));
        let mut x = vec![0.0; b.len()];
        let found = Refined::new(&grid).solve(&system, &b, &mut x, 1e-10 * size);
        assert!(found.relative_residual <= 1e-10, "{found:?}");
        let most = wanted.iter().fold(0.0, |m: f64, w| m.max(w.abs()));
        for (x, w) in x.iter().zip(&wanted) {
            assert!((x - w).abs() < 1e-8 * most, "{x:e} {w:e}");
        }
    }

    #[test]
    fn an_unsolvable_system_ends() {
        let grid = SquareGrid::centred(8);
        let phi = grid.field(|[x, y]| x.hypot(y) - 0.2);
        let energy = PlaneEnergy::natural(grid.clone(), 0.01);
        let at = energy.linearise(&phi);
        let system = StepSystem::new(&energy, &at, Variant::I, 1e-4);
        let mut b = vec![1.0; phi.len()];
        b[grid.index(3, 3)] = f64::NAN;
        let mut x = vec![0.0; b.len()];
        let end = Refined::new(&grid).solve(&system, &b, &mut x, 1e-10);
        assert!(end.relative_residual.is_nan() && x.iter().all(|&x| x == 0.0));
        // An unreachable goal ends as well, near rounding.
        b[grid.index(3, 3)] = 1.0;
        let end = Refined::new(&grid).solve(&system, &b, &mut x, 0.0);
        assert!(end.relative_residual < 1e-12, "{end:?}");
    }
}
