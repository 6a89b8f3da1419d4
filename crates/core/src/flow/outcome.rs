//! The outcome of a flow: its steps and how it ended.

use serde::{Deserialize, Serialize};

use super::band::WIDTH;
use super::settings::{Energy, FlowSettings};
use crate::tuning::{Tunable, tunable};

/// Steps. After this many, a flow also counts as converged by the root mean square update of its nodes: on noisy data a
/// few nodes never converge.
pub(super) const LONG: Tunable<usize> = tunable("flow.long", 8);

/// Voxels. A flow whose last update was larger than this has diverged.
pub(super) const DIVERGED: Tunable<f64> = tunable("flow.diverged", 2.0);

/// Fraction of a step that has to be taken for the flow to count as converged. Steps are halved, so any value between ½
/// and 1 asks for whole steps; with 1 and more no flow would converge.
const WHOLE_STEP: Tunable<f64> = tunable("flow.whole_step", 0.9);
const _: () = assert!(WHOLE_STEP.chosen() > 0.5 && WHOLE_STEP.chosen() < 1.0);

/// One step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StepRecord {
    /// The total energy before the step, with the eikonal term.
    pub energy: f64,
    /// Update: largest displacement of a node within one voxel of the surface, in voxels.
    #[serde(alias = "movement")]
    pub update: f64,
    /// Root mean square displacement of those nodes, in voxels.
    #[serde(alias = "mean_movement")]
    pub rms_update: f64,
    /// Fraction of the step taken: 1, ½, ¼ …; 0 if none lowered the energy.
    pub fraction: f64,
    /// Iterations of the linear solver.
    pub iterations: usize,
}

impl StepRecord {
    /// Whether no node moves by more than the tolerance; or, after `tuning::flow.long` steps, the root mean square displacement
    /// is within it and no node moves by more than [`FlowSettings::largest_update_factor`] tolerances.
    pub(super) fn has_converged(&self, settings: &FlowSettings, steps: usize) -> bool {
        let tolerance = settings.tolerance;
        let within = self.update < tolerance
            || (steps >= LONG.get()
                && self.update < settings.largest_update_factor * tolerance
                && self.rms_update < tolerance);
        within && self.fraction > WHOLE_STEP.get()
    }
}

/// How the flow ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FlowOutcome {
    /// The energy that was minimised.
    pub energy: Energy,
    /// The steps.
    pub steps: Vec<StepRecord>,
    /// Update: largest displacement of a node within one voxel of the surface in the step that led to the result, in voxels;
    /// [`f64::MAX`] if no step was taken since the data are inconsistent.
    #[serde(alias = "movement")]
    pub update: f64,
    /// Whether the stopping test was met.
    pub converged: bool,
    /// Whether it ended because the energy hardly changed any more although nodes still moved: the minimum is nearly flat in some
    /// direction.
    #[serde(alias = "flat")]
    pub energy_plateau: bool,
    /// Number of unknowns of the last band.
    pub unknowns: usize,
    /// The surface's part of the energy at the start; for the Willmore energy ½∫h² of the free part times 2.5, the half width of
    /// the band in voxels.
    pub energy_before: f64,
    /// The surface's part of the energy at the end.
    pub energy_after: f64,
    /// Final weight of the eikonal term.
    pub kappa: f64,
}

impl FlowOutcome {
    /// Whether the flow ended so far from convergence that its surface is meaningless.
    pub fn has_diverged(&self) -> bool {
        !(self.converged || self.update <= DIVERGED.get())
    }

    /// ½∫h² of the free part of the surface at the end: by the co-area formula the mean over the levels in the band. Valid only
    /// if the Willmore energy was minimised.
    pub fn willmore(&self) -> f64 {
        self.energy_after / WIDTH
    }
}
