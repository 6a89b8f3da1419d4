//! Stopping rules of a level set flow: converged, on a plateau of its energy, or lost.

use super::outcome::StepRecord;
use super::outcome::{DIVERGED, LONG};
use super::settings::FlowSettings;
use crate::tuning::{Tunable, tunable};

/// Voxels, root mean square. After `LONG` steps a surface with a smaller update has converged if its energy
/// hardly falls.
const ROUGH_UPDATE: Tunable<f64> = tunable("flow.rough_update", 0.01);

/// Relative fall of the energy over three steps. Below this the energy hardly falls.
const ROUGH_FALL: Tunable<f64> = tunable("flow.rough_fall", 5e-3);

/// Fraction of the energy. The flow ends if more than this remains after five steps of more than a voxel each.
const IDLE: Tunable<f64> = tunable("flow.idle", 0.95);

/// Voxels. If the first step of a flow in time is longer than this, from an energy above `DIVERGING_ENERGY` and
/// `DIVERGING_DENSITY`, the data are inconsistent and the flow ends.
const DIVERGING_STEP: Tunable<f64> = tunable("flow.diverging_step", 4.0);

/// Energy. Lower bound of the initial energy of inconsistent data, from which no flow to the steady state is begun: of 372 patches of
/// scans, man-made shapes and small meshes with several faults none started above 5,600, while rims that run through each other
/// start at up to two millions, and a step of their 100,000 unknowns takes a second.
const DIVERGING_ENERGY: Tunable<f64> = tunable("flow.diverging_energy", 2e4);

/// Energy per unknown. Lower bound of the initial energy of inconsistent data.
const DIVERGING_DENSITY: Tunable<f64> = tunable("flow.diverging_density", 4.0);

/// κ is doubled when steps grow, until it is at least this.
const KAPPA_LIMIT: Tunable<f64> = tunable("flow.kappa_limit", 16.0);

/// Voxels. The flow ends after three successive steps longer than this.
const RUNNING_STEP: Tunable<f64> = tunable("flow.running_step", 5.0);

/// Voxels. The flow ends after five successive steps longer than this if more than `IDLE` of the energy remains.
const IDLE_STEP: Tunable<f64> = tunable("flow.idle_step", 1.0);

/// Steps. After this many, the flow may end on a plateau of the energy.
const PLATEAU_STEPS: Tunable<usize> = tunable("flow.plateau_steps", 12);

/// Voxels. A surface with a smaller update is left to converge and does not end on a plateau.
const PLATEAU_UPDATE: Tunable<f64> = tunable("flow.plateau_update", 0.02);

/// Relative change of the energy over five steps. Below this the energy is on a plateau.
const PLATEAU_CHANGE: Tunable<f64> = tunable("flow.plateau_change", 2e-3);

/// Voxels. κ is raised where steps are longer than this and do not shrink.
const KAPPA_UPDATE: Tunable<f64> = tunable("flow.kappa_update", 0.05);

/// Ratio of a step to the step four before it. Below this the steps shrink.
const KAPPA_SHRINKING: Tunable<f64> = tunable("flow.kappa_shrinking", 0.7);

/// Why a flow ends after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stop {
    /// The stopping test is met.
    Converged,
    /// The energy hardly changes any more although nodes still move: the minimum is nearly flat in some direction.
    Plateau,
    /// Values are not finite, the data are inconsistent, or no step makes progress.
    Lost,
}

/// The rules that end a flow.
pub(super) struct StopRules<'a> {
    settings: &'a FlowSettings,
}

impl<'a> StopRules<'a> {
    pub(super) fn new(settings: &'a FlowSettings) -> Self {
        Self { settings }
    }

    /// Whether and why the flow ends after the given steps on a band with `unknowns` unknowns. In a flow in time, small steps do
    /// not mean that the surface has converged.
    pub(super) fn after(&self, steps: &[StepRecord], unknowns: usize) -> Option<Stop> {
        let last = steps.last()?;
        if !last.energy.is_finite() || !last.update.is_finite() {
            return Some(Stop::Lost);
        }
        let in_time = self.settings.in_time();
        let converged = last.has_converged(self.settings, steps.len()) || energy_has_settled(steps);
        if converged && !in_time {
            return Some(Stop::Converged);
        }
        if !in_time && stagnant(steps) {
            return Some(Stop::Plateau);
        }
        let lost = stuck(steps)
            || starts_diverging(steps, unknowns)
            || is_too_high(steps, self.settings.highest);
        lost.then_some(Stop::Lost)
    }

    /// Whether a flow to the steady state is not begun on a band with `unknowns` unknowns, by the energy of its start.
    pub(super) fn before(&self, energy: f64, unknowns: usize) -> bool {
        !self.settings.in_time() && is_inconsistent(energy, unknowns)
    }

    /// Whether a larger weight κ of the eikonal term is needed: the steps grow, or none lowers the energy.
    pub(super) fn raises_kappa(steps: &[StepRecord], kappa: f64) -> bool {
        let grow = grows(steps) || steps.last().is_some_and(|s| s.fraction == 0.0);
        grow && kappa < KAPPA_LIMIT.get()
    }
}

/// Whether the data are inconsistent: the energy at the start is too high, also for each unknown.
fn is_inconsistent(energy: f64, unknowns: usize) -> bool {
    energy > DIVERGING_ENERGY.get() && energy > DIVERGING_DENSITY.get() * unknowns as f64
}

/// Whether the first step was too long and started from too high an energy.
fn starts_diverging(steps: &[StepRecord], unknowns: usize) -> bool {
    let is_one =
        |s: &StepRecord| s.update > DIVERGING_STEP.get() && is_inconsistent(s.energy, unknowns);
    steps.first().is_some_and(is_one)
}

/// Whether the first step was as long as in a diverged flow and started from more energy than a surface may have.
fn is_too_high(steps: &[StepRecord], highest: f64) -> bool {
    let is_one = |s: &StepRecord| s.energy > highest && s.update > DIVERGED.get();
    steps.first().is_some_and(is_one)
}

/// Whether the last three steps did not lower the energy, or the last three were very long, or the last five were long and hardly
/// lowered the energy.
fn stuck(steps: &[StepRecord]) -> bool {
    let last = |n: usize| steps.len().checked_sub(n).map(|i| &steps[i..]);
    let are_longer = |l: &[StepRecord], than: f64| l.iter().all(|s| s.update > than);
    last(3).is_some_and(|l| l.iter().all(|s| s.fraction == 0.0))
        || last(3).is_some_and(|l| are_longer(l, RUNNING_STEP.get()))
        || last(5).is_some_and(|l| {
            are_longer(l, IDLE_STEP.get()) && l[4].energy > IDLE.get() * l[0].energy
        })
}

/// Whether, after some steps, the surface hardly moves and its energy hardly falls.
fn energy_has_settled(steps: &[StepRecord]) -> bool {
    let n = steps.len();
    if n < LONG.get().max(4) || steps[n - 1].rms_update > ROUGH_UPDATE.get() {
        return false;
    }
    let (before, now) = (steps[n - 4].energy, steps[n - 1].energy);
    now <= before && before - now < ROUGH_FALL.get() * before
}

/// Whether, after some steps, the energy hardly changed over the last five although nodes still move.
fn stagnant(steps: &[StepRecord]) -> bool {
    let n = steps.len();
    if n < PLATEAU_STEPS.get().max(5) || steps[n - 1].update < PLATEAU_UPDATE.get() {
        return false;
    }
    let last = &steps[n - 5..];
    let (low, high) = last.iter().fold((f64::INFINITY, 0.0f64), |(l, h), s| {
        (l.min(s.energy), h.max(s.energy))
    });
    high - low < PLATEAU_CHANGE.get() * high
}

/// Every fourth step: whether steps are long and not shorter than four steps before.
fn grows(steps: &[StepRecord]) -> bool {
    let n = steps.len();
    n >= 5
        && n % 4 == 1
        && steps[n - 1].update > KAPPA_UPDATE.get()
        && steps[n - 1].update > KAPPA_SHRINKING.get() * steps[n - 5].update
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(energy: f64, update: f64) -> StepRecord {
        StepRecord {
            energy,
            update,
            rms_update: 0.2 * update,
            fraction: 1.0,
            iterations: 3,
        }
    }

    #[test]
    fn only_a_diverging_surface_is_given_up_after_one_step() {
        // Measured on walls without thickness: a step of 12 voxels, 20 units of energy for each of 2300 unknowns.
        assert!(starts_diverging(&[step(46_000.0, 12.0)], 2300));
        // A large region that converged, and a small rough one.
        assert!(!starts_diverging(&[step(15_086.0, 13.7)], 4600));
        assert!(!starts_diverging(&[step(1_528.0, 9.7)], 200));
        // A high energy spread over many unknowns, and a short step.
        assert!(!starts_diverging(&[step(36_150.0, 5.0)], 11_330));
        assert!(!starts_diverging(&[step(46_000.0, 1.0)], 2300));
        // Divergence after the first step is left to the other rules.
        assert!(!starts_diverging(
            &[step(100.0, 1.0), step(46_000.0, 12.0)],
            2300
        ));
    }

    #[test]
    fn a_start_with_too_high_an_energy_is_given_up_if_its_first_step_is_long() {
        assert!(is_too_high(&[step(3651.0, 2.6)], 2400.0));
        assert!(!is_too_high(&[step(3651.0, 0.9)], 2400.0));
        assert!(!is_too_high(&[step(2300.0, 2.6)], 2400.0));
        assert!(!is_too_high(&[step(3651.0, 2.6)], f64::INFINITY));
    }
}
