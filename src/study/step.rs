//! One semi-implicit step of the flow on a square: and the solution of its linear system.

use super::multigrid::coarse_levels;
use super::plane::PlaneEnergy;
use super::refined::{Refined, norm};
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
    /// The residual falls to this part of `‖M φ‖`, as for the paper's systems for φ itself: for flows in time. In variant I the
    /// residual over the system's diagonal, which is about the error of φ, falls to this part of `‖φ‖`: else nodes where φ is
    /// flat, whose mass is up to 1/ε times that of others, outweigh these.
    OfState(f64),
    /// The residual falls to this part of the right-hand side: for steady states.
    OfStep(f64),
}

impl Tolerance {
    /// The norm that a residual is to fall to, for a right-hand side of a norm and a state.
    fn goal(self, size: f64, state: impl Iterator<Item = f64>) -> f64 {
        match self {
            Self::OfStep(t) => t * size,
            Self::OfState(t) => t * norm(state),
        }
    }
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
    /// For variant I without multigrid.
    refined: Option<Refined>,
    /// The steps since the start, at most the last two.
    last: Vec<Vec<f64>>,
}

impl PlaneFlow {
    /// A flow whose systems are scaled by their diagonal.
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

    /// Solves by multigrid from now on, its coarse levels taken at φ. For time steps far above h⁴.
    pub fn with_multigrid(mut self, phi: &[f64]) -> Self {
        let at = self.energy.linearise(phi);
        let system = StepSystem::new(&self.energy, &at, Variant::GaussNewton, self.tau);
        self.coarse = coarse_levels(&self.energy, &system);
        self
    }

    /// Forgets the last steps, from which the next is guessed; to be called when φ is changed from outside.
    pub fn restart(&mut self) {
        self.last.clear();
    }

    /// Takes one step: `A d = −τ g`, `φ += d`.
    pub fn step(&mut self, phi: &mut [f64]) -> PlaneStep {
        let at = self.energy.linearise(phi);
        let system = StepSystem::new(&self.energy, &at, self.variant, self.tau);
        let b: Vec<f64> = at.gradient.iter().map(|g| -self.tau * g).collect();
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
        phi.iter_mut().zip(&d).for_each(|(p, d)| *p += d);
        let movement = d.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        if self.last.len() == 2 {
            self.last.remove(0);
        }
        self.last.push(d);
        PlaneStep {
            energy: at.energy,
            movement,
            iterations: end.iterations,
            solved: end.relative_residual <= tolerance * (1.0 + 1e-9),
        }
    }

    /// What the next step may be: in flows in time the last one, in variant I on a line through the last two.
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
