//! One semi-implicit step of Willmore flow on a square grid, with the solution of its linear system.

use super::multigrid::coarse_levels;
use super::plane::PlaneEnergy;
use super::refined::{Refined, norm};
use super::system::StepSystem;
use isomend_core::flow::Variant;
use isomend_core::linalg::{
    CgOutcome, Jacobi, LinearOperator, Multigrid, MultigridCycle, Preconditioner, bicgstab,
    conjugate_gradient,
};

/// Upper bound of the number of iterations of one solve.
const MOST_ITERATIONS: usize = 4000;

/// The stopping criterion of the linear solver.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(hidden)]
pub enum Tolerance {
    /// For flows in time: the norm of the residual relative to `‖M φ‖`, as for the paper's systems for φ itself. In variant I it is the
    /// norm of the residual divided by the system's diagonal, about the error of φ, relative to `‖φ‖`. Without this scaling, nodes
    /// where φ is flat would dominate: their mass is up to 1/ε times larger.
    OfState(f64),
    /// For steady states: the norm of the residual relative to the right-hand side.
    OfStep(f64),
}

impl Tolerance {
    /// The norm that the residual must reach, for a right-hand side of norm `size`.
    fn goal(self, size: f64, state: impl Iterator<Item = f64>) -> f64 {
        match self {
            Self::OfStep(t) => t * size,
            Self::OfState(t) => t * norm(state),
        }
    }
}

/// The record of one step.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct PlaneStep {
    /// Energy before the step.
    pub energy: f64,
    /// Largest change of φ at a node.
    pub update: f64,
    /// Number of iterations of the linear solver.
    pub iterations: usize,
    /// Whether the residual reached its tolerance.
    pub solved: bool,
}

/// The flow of a function on a square.
#[doc(hidden)]
pub struct PlaneFlow {
    /// The energy.
    pub energy: PlaneEnergy,
    /// The scheme.
    pub variant: Variant,
    /// Time step τ, in units of length⁴.
    pub tau: f64,
    /// Stopping criterion of the linear solver.
    pub tolerance: Tolerance,
    coarse: Option<Multigrid>,
    /// Solver of variant I without multigrid.
    refined: Option<Refined>,
    /// The last steps since the start or the last restart, at most two.
    last: Vec<Vec<f64>>,
}

impl PlaneFlow {
    /// A flow whose linear systems are preconditioned by their diagonal.
    pub fn new(energy: PlaneEnergy, variant: Variant, tau: f64, tolerance: Tolerance) -> Self {
        let refined = (variant == Variant::I).then(|| Refined::new(&energy.grid));
        Self {
            energy,
            variant,
            tau,
            tolerance,
            coarse: None,
            refined,
            last: Vec::new(),
        }
    }

    /// Preconditions by multigrid, with coarse levels computed once, at φ. For time steps far above h⁴.
    pub fn with_multigrid(mut self, phi: &[f64]) -> Self {
        let at = self.energy.linearise(phi);
        let system = StepSystem::new(&self.energy, &at, Variant::GaussNewton, self.tau);
        self.coarse = coarse_levels(&self.energy, &system);
        self
    }

    /// Discards the last steps, from which the next one is extrapolated. Call it after φ was changed by other means than [`Self::step`].
    pub fn restart(&mut self) {
        self.last.clear();
    }

    /// Takes one step: `A d = −τ g`, `φ += d`.
    pub fn step(&mut self, phi: &mut [f64]) -> PlaneStep {
        // Assemble the system A and the right-hand side −τ g at φ.
        let at = self.energy.linearise(phi);
        let system = StepSystem::new(&self.energy, &at, self.variant, self.tau);
        let b: Vec<f64> = at.gradient.iter().map(|g| -self.tau * g).collect();
        // Initial guess from the last steps; then solve by refinement, or by a preconditioned Krylov method.
        let mut d = self.guess();
        let (end, tolerance) = match (&self.coarse, &mut self.refined) {
            (None, Some(refined)) => {
                let scaling = system.jacobi();
                let size = norm(b.iter().zip(scaling).map(|(b, s)| s * b));
                let goal = self.tolerance.goal(size, phi.iter().copied());
                let end = refined.solve(&system, &b, &mut d, goal);
                (end, goal / size.max(f64::MIN_POSITIVE))
            }
            (coarse, _) => {
                let free = self.energy.free();
                let state = (0..b.len()).map(|i| f64::from(free[i]) * at.mass[i] * phi[i]);
                let size = norm(b.iter().copied());
                let tolerance = self.tolerance.goal(size, state) / size.max(f64::MIN_POSITIVE);
                let cycle = coarse.as_ref().map(|c| MultigridCycle::new(&system, c));
                let scaling = Jacobi(system.jacobi());
                let preconditioner: &dyn Preconditioner = match &cycle {
                    Some(cycle) => cycle,
                    None => &scaling,
                };
                let end = solve(&system, preconditioner, &b, &mut d, tolerance, self.variant);
                (end, tolerance)
            }
        };
        // Apply the step, and store it for the next initial guess.
        phi.iter_mut().zip(&d).for_each(|(p, d)| *p += d);
        let update = d.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        if self.last.len() == 2 {
            self.last.remove(0);
        }
        self.last.push(d);
        PlaneStep {
            energy: at.energy,
            update,
            iterations: end.iterations,
            solved: end.relative_residual <= tolerance * (1.0 + 1e-9),
        }
    }

    /// Initial guess of the next step. For flows in time it is the last step, and in variant I the linear extrapolation of the last two.
    fn guess(&self) -> Vec<f64> {
        let in_time = matches!(self.tolerance, Tolerance::OfState(_));
        match &self.last[..] {
            [before, last] if in_time && self.variant == Variant::I => {
                last.iter().zip(before).map(|(l, b)| 2.0 * l - b).collect()
            }
            [.., last] if in_time => last.clone(),
            _ => vec![0.0; self.energy.grid.field_len()],
        }
    }
}

/// Conjugate gradients from `x` for the symmetric variants; BiCGstab for the correction to `x` for variant I.
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
