//! Runs of many flow steps in the plane, with their energies and solver iterations.

use super::observer::{Observer, StudyError};
use super::step::PlaneFlow;

/// The record of a run.
#[derive(Clone, Debug, Default)]
#[doc(hidden)]
pub struct PlaneRun {
    /// Energy before each step.
    pub energies: Vec<f64>,
    /// Total number of iterations of the linear solver.
    pub iterations: usize,
    /// Number of steps whose system was not solved to its tolerance.
    pub unsolved: usize,
}

impl PlaneRun {
    /// Takes `steps` steps from `phi`.
    pub fn advance(
        &mut self,
        flow: &mut PlaneFlow,
        phi: &mut [f64],
        steps: usize,
        observer: &dyn Observer,
    ) -> Result<(), StudyError> {
        for _ in 0..steps {
            if !observer.keep_going() {
                return Err(StudyError::Stopped);
            }
            let step = flow.step(phi);
            self.energies.push(step.energy);
            self.iterations += step.iterations;
            self.unsolved += usize::from(!step.solved);
            if !step.energy.is_finite() || !step.update.is_finite() {
                return Err(StudyError::BlewUp {
                    step: self.energies.len(),
                });
            }
        }
        Ok(())
    }

    /// Number of steps in which the energy rose by more than rounding.
    pub fn rises(&self) -> usize {
        self.energies
            .windows(2)
            .filter(|e| e[1] > e[0] * (1.0 + 1e-12))
            .count()
    }

    /// Mean number of iterations of the linear solver per step.
    pub fn iterations_per_step(&self) -> f64 {
        self.iterations as f64 / self.energies.len().max(1) as f64
    }

    /// (time, energy) before each step, thinned to at most 500 points.
    pub fn curve(&self, tau: f64) -> Vec<(f64, f64)> {
        let every = self.energies.len().div_ceil(500).max(1);
        let points = self.energies.iter().enumerate().step_by(every);
        points.map(|(k, &e)| (k as f64 * tau, e)).collect()
    }
}
