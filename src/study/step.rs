//! One semi-implicit step of the flow on a square: and the solution of its linear system.

use super::multigrid::coarse_levels;
use super::plane::PlaneEnergy;
use super::system::StepSystem;
use crate::flow::Variant;
use crate::linalg::{
    CgOutcome, Jacobi, LinearOperator, Multigrid, MultigridCycle, Preconditioner, bicgstab,
    conjugate_gradient,
};

/// Most iterations of one solve.
const MOST_ITERATIONS: usize = 4000;

/// How the linear systems are solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// The residual falls to this part of `‖M φ‖`, as for the paper's systems for φ itself: for flows in time.
    OfState(f64),
    /// The residual falls to this part of the right-hand side: for steady states.
    OfStep(f64),
}

/// One step.
#[derive(Clone, Copy, Debug)]
pub struct PlaneStep {
    /// Energy before it.
    pub energy: f64,
    /// Largest change of φ.
    pub movement: f64,
    /// Iterations of the linear solver.
    pub iterations: usize,
    /// Whether the residual reached its tolerance.
    pub solved: bool,
}

/// The flow of a function on a square.
pub struct PlaneFlow {
    /// The energy.
    pub energy: PlaneEnergy,
    /// The scheme.
    pub variant: Variant,
    /// Time step τ, in units of length⁴.
    pub tau: f64,
    /// When a linear system counts as solved.
    pub tolerance: Tolerance,
    coarse: Option<Multigrid>,
    last: Vec<f64>,
}

impl PlaneFlow {
    /// A flow whose systems are scaled by their diagonal.
    pub fn new(energy: PlaneEnergy, variant: Variant, tau: f64, tolerance: Tolerance) -> Self {
        let last = vec![0.0; energy.grid.field_len()];
        Self {
            energy,
            variant,
            tau,
            tolerance,
            coarse: None,
            last,
        }
    }

    /// Solves by multigrid from now on, its coarse levels taken at φ. For time steps far above h⁴.
    pub fn with_multigrid(mut self, phi: &[f64]) -> Self {
        let at = self.energy.linearise(phi);
        let system = StepSystem::new(&self.energy, &at, Variant::GaussNewton, self.tau);
        self.coarse = coarse_levels(&self.energy, &system);
        self
    }

    /// Forgets the last step, which is the first guess of the next; to be called when φ is changed from outside.
    pub fn restart(&mut self) {
        self.last.fill(0.0);
    }

    /// Takes one step: `A d = −τ g`, `φ += d`.
    pub fn step(&mut self, phi: &mut [f64]) -> PlaneStep {
        let at = self.energy.linearise(phi);
        let system = StepSystem::new(&self.energy, &at, self.variant, self.tau);
        let b: Vec<f64> = at.gradient.iter().map(|g| -self.tau * g).collect();
        let size = norm(b.iter().copied());
        let tolerance = match self.tolerance {
            Tolerance::OfStep(t) => t,
            Tolerance::OfState(t) => {
                let free = self.energy.free();
                let state = (0..phi.len()).map(|i| f64::from(free[i]) * at.mass[i] * phi[i]);
                t * norm(state) / size.max(f64::MIN_POSITIVE)
            }
        };
        let mut d = std::mem::take(&mut self.last);
        if matches!(self.tolerance, Tolerance::OfStep(_)) {
            d.fill(0.0);
        }
        let end = match &self.coarse {
            Some(coarse) => {
                let cycle = MultigridCycle::new(&system, coarse);
                solve(&system, &cycle, &b, &mut d, tolerance, self.variant)
            }
            None => {
                let scaling = Jacobi(system.jacobi());
                solve(&system, &scaling, &b, &mut d, tolerance, self.variant)
            }
        };
        phi.iter_mut().zip(&d).for_each(|(p, d)| *p += d);
        let movement = d.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        self.last = d;
        PlaneStep {
            energy: at.energy,
            movement,
            iterations: end.iterations,
            solved: end.relative_residual <= tolerance * (1.0 + 1e-9),
        }
    }
}

fn norm(v: impl Iterator<Item = f64>) -> f64 {
    v.map(|x| x * x).sum::<f64>().sqrt()
}

/// Conjugate gradients from `x` where the variant is symmetric, else BiCGstab for the correction to `x`.
fn solve(
    system: &StepSystem,
    preconditioner: &dyn Preconditioner,
    b: &[f64],
    x: &mut [f64],
    tolerance: f64,
    variant: Variant,
) -> CgOutcome {
    if variant != Variant::I {
        return conjugate_gradient(system, preconditioner, b, x, tolerance, MOST_ITERATIONS);
    }
    let mut rest = vec![0.0; b.len()];
    system.apply(x, &mut rest);
    rest.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
    let (whole, left) = (norm(b.iter().copied()), norm(rest.iter().copied()));
    if left <= tolerance * whole {
        return CgOutcome {
            iterations: 0,
            relative_residual: left / whole.max(f64::MIN_POSITIVE),
        };
    }
    let mut correction = vec![0.0; b.len()];
    let end = bicgstab(
        system,
        preconditioner,
        &rest,
        &mut correction,
        tolerance * whole / left,
        MOST_ITERATIONS,
    );
    x.iter_mut().zip(&correction).for_each(|(x, c)| *x += c);
    CgOutcome {
        iterations: end.iterations,
        relative_residual: end.relative_residual * left / whole.max(f64::MIN_POSITIVE),
    }
}
