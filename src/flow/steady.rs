//! Steps of the flow, to its steady state or for a number of steps.

use super::band::Band;
use super::energy::BandEnergy;
use super::outcome::{DIVERGED, FlowOutcome, LONG, StepRecord};
use super::pull::Pull;
use super::settings::{FlowSettings, REACH};
use super::state::BandState;
use crate::grid::SparseGrid;
use crate::sdf::redistance;

/// On rough data a few nodes never become steady. After [`LONG`] steps a surface counts as steady when its root mean square
/// movement is below this, in voxels, and its energy falls by less than [`ROUGH_FALL`].
const ROUGH_MOVEMENT: f64 = 0.01;
/// Relative fall of the energy over three steps.
const ROUGH_FALL: f64 = 5e-3;
/// Five steps of more than a voxel each are useless when they leave more than this part of the energy.
const IDLE: f64 = 0.95;
/// Data that contradict each other leave a surface in shreds: after a first step of more than this, in voxels, from an energy of
/// more than so many units, and so many for each unknown, the flow is over. Of 295 levels of eleven real meshes none of these
/// became steady.
const SHREDS: (f64, f64, f64) = (4.0, 2e4, 4.0);
/// κ is doubled when steps grow, until it is at least this.
const KAPPA_LIMIT: f64 = 16.0;

/// Lets `phi` flow to the steady state of an energy, which `make` puts on a band with the weight κ of the eikonal term; see
/// [`super::relax`].
pub(super) fn relax_with<E: BandEnergy>(
    make: impl Fn(Band, f64) -> E,
    grid: &SparseGrid,
    phi: &mut Vec<f64>,
    mask: &[bool],
    settings: &FlowSettings,
    pull: Option<&Pull>,
    keep_going: &dyn Fn() -> bool,
) -> FlowOutcome {
    let mut run = Relaxation::new(settings);
    let mut state: Option<BandState<E>> = None;
    for _ in 0..settings.max_steps {
        if !keep_going() {
            break;
        }
        let band = match state.take() {
            Some(band) => Some(band),
            None => run.new_band(&make, grid, phi, mask, pull),
        };
        let Some(mut band) = band else { break };
        if grid.is_cancelled() {
            break;
        }
        run.outcome.unknowns = band.energy.band().unknowns;
        if run.outcome.unknowns == 0 {
            run.outcome.converged = true;
            break;
        }
        run.step(&mut band, grid, phi, mask);
        if run.is_over() {
            break;
        }
        if !run.raises_kappa() && !band.is_stale() {
            state = Some(band);
        }
    }
    run.finish(phi)
}

/// A flow to the steady state, or in time, as it goes on.
struct Relaxation<'a> {
    settings: &'a FlowSettings,
    outcome: FlowOutcome,
    lowest: Option<Lowest>,
}

impl<'a> Relaxation<'a> {
    fn new(settings: &'a FlowSettings) -> Self {
        Self {
            settings,
            outcome: FlowOutcome {
                energy: settings.energy,
                steps: Vec::new(),
                movement: 0.0,
                converged: false,
                flat: false,
                unknowns: 0,
                energy_before: 0.0,
                energy_after: 0.0,
                kappa: settings.kappa,
            },
            lowest: None,
        }
    }

    /// In a flow in time small steps do not mean that the surface is steady.
    fn in_time(&self) -> bool {
        self.settings.time_step.is_finite()
    }

    /// Redistances `phi` and makes a band round its zero set; none where redistancing has changed the shape of the surface, and
    /// `phi` then stays as it was.
    fn new_band<E: BandEnergy>(
        &mut self,
        make: impl Fn(Band, f64) -> E,
        grid: &SparseGrid,
        phi: &mut Vec<f64>,
        mask: &[bool],
        pull: Option<&Pull>,
    ) -> Option<BandState<E>> {
        let distances = redistance(grid, phi, mask, REACH);
        let band = Band::new(grid, &distances, mask, E::NEEDS.dilations);
        let energy = make(band, self.outcome.kappa);
        let next = BandState::new(grid, energy, &distances, pull);
        let last = self.outcome.steps.last();
        if last.is_some_and(|s| next.has_jumped(s.energy)) {
            return None;
        }
        let before = std::mem::replace(phi, distances);
        if let Some(lowest) = &mut self.lowest {
            lowest.phi.get_or_insert(before);
        }
        Some(next)
    }

    /// Takes a step, writes its values to `phi` and keeps the lowest energy.
    fn step<E: BandEnergy>(
        &mut self,
        band: &mut BandState<E>,
        grid: &SparseGrid,
        phi: &mut [f64],
        mask: &[bool],
    ) {
        let (record, surface) = band.step(grid, mask, self.settings);
        if self.outcome.steps.is_empty() {
            self.outcome.energy_before = surface;
        }
        self.outcome.steps.push(record);
        let reached = band
            .at
            .as_ref()
            .map_or((f64::INFINITY, surface), |at| (at.energy, at.surface));
        self.outcome.energy_after = reached.1;
        self.outcome.movement = record.movement;
        if !self.in_time() {
            match &mut self.lowest {
                Some(lowest) if !lowest.is_above(reached.0) => {
                    lowest.phi.get_or_insert_with(|| phi.to_vec());
                }
                _ => {
                    self.lowest = Some(Lowest {
                        energies: reached,
                        movement: record.movement,
                        phi: None,
                    });
                }
            }
        }
        band.energy.band().scatter(&band.values, phi);
    }

    /// Whether the last step ends the run; notes why.
    fn is_over(&mut self) -> bool {
        let steps = &self.outcome.steps;
        let Some(last) = steps.last() else {
            return false;
        };
        if !last.energy.is_finite() || !last.movement.is_finite() {
            return true;
        }
        let steady = last.is_steady(self.settings, steps.len()) || settled(steps);
        self.outcome.converged = !self.in_time() && steady;
        if self.outcome.converged {
            return true;
        }
        self.outcome.flat = !self.in_time() && stagnant(steps);
        self.outcome.flat
            || stuck(steps)
            || in_shreds(steps, self.outcome.unknowns)
            || is_too_high(steps, self.settings.highest)
    }

    /// Doubles κ when the steps grow or none lowers the energy, and says whether it did.
    fn raises_kappa(&mut self) -> bool {
        let steps = &self.outcome.steps;
        let grow = grows(steps) || steps.last().is_some_and(|s| s.fraction == 0.0);
        let raises = grow && self.outcome.kappa < KAPPA_LIMIT;
        if raises {
            self.outcome.kappa *= 2.0;
        }
        raises
    }

    /// The outcome, with `phi` of the lowest energy where the flow did not become steady.
    fn finish(self, phi: &mut Vec<f64>) -> FlowOutcome {
        let mut outcome = self.outcome;
        if let (false, Some(lowest)) = (outcome.converged, self.lowest) {
            outcome.energy_after = lowest.energies.1;
            outcome.movement = lowest.movement;
            if let Some(values) = lowest.phi {
                *phi = values;
            }
        }
        outcome
    }
}

/// The state of the lowest energy so far: the result where the flow does not become steady.
struct Lowest {
    /// All of the energy, and the surface's part.
    energies: (f64, f64),
    /// The movement of the step that led there.
    movement: f64,
    /// The values; none while they are the flow's own.
    phi: Option<Vec<f64>>,
}

impl Lowest {
    /// Whether another energy is lower; false for one that is not a number.
    fn is_above(&self, energy: f64) -> bool {
        energy < self.energies.0
    }
}

/// The first step was too long from too high an energy.
fn in_shreds(steps: &[StepRecord], unknowns: usize) -> bool {
    let (movement, energy, density) = SHREDS;
    let is_one =
        |s: &StepRecord| s.movement > movement && s.energy > energy.max(density * unknowns as f64);
    steps.first().is_some_and(is_one)
}

/// The first step was as long as one of a flow that has diverged, from a higher energy than a surface may have.
fn is_too_high(steps: &[StepRecord], highest: f64) -> bool {
    let is_one = |s: &StepRecord| s.energy > highest && s.movement > DIVERGED;
    steps.first().is_some_and(is_one)
}

/// The last three steps found no lower energy, or three steps in a row moved the surface by more than five voxels,
/// or five moved it by more than one and hardly lowered the energy.
fn stuck(steps: &[StepRecord]) -> bool {
    let last = |n: usize| steps.len().checked_sub(n).map(|i| &steps[i..]);
    last(3).is_some_and(|l| l.iter().all(|s| s.fraction == 0.0))
        || last(3).is_some_and(|l| l.iter().all(|s| s.movement > 5.0))
        || last(5)
            .is_some_and(|l| l.iter().all(|s| s.movement > 1.0) && l[4].energy > IDLE * l[0].energy)
}

/// After [`LONG`] steps the surface hardly moves and its energy hardly falls.
fn settled(steps: &[StepRecord]) -> bool {
    let n = steps.len();
    if n < LONG || steps[n - 1].mean_movement > ROUGH_MOVEMENT {
        return false;
    }
    let (before, now) = (steps[n - 4].energy, steps[n - 1].energy);
    now <= before && before - now < ROUGH_FALL * before
}

/// After twelve steps: the energy has changed by less than a five-hundredth over the last five, though nodes still move.
fn stagnant(steps: &[StepRecord]) -> bool {
    let n = steps.len();
    if n < 12 || steps[n - 1].movement < 0.02 {
        return false;
    }
    let last = &steps[n - 5..];
    let (low, high) = last.iter().fold((f64::INFINITY, 0.0f64), |(l, h), s| {
        (l.min(s.energy), h.max(s.energy))
    });
    high - low < 2e-3 * high
}

/// Every fourth step: whether steps are large and have not become smaller than 0.7 of the one four before.
fn grows(steps: &[StepRecord]) -> bool {
    let n = steps.len();
    n >= 5
        && n % 4 == 1
        && steps[n - 1].movement > 0.05
        && steps[n - 1].movement > 0.7 * steps[n - 5].movement
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(energy: f64, movement: f64) -> StepRecord {
        StepRecord {
            energy,
            movement,
            mean_movement: 0.2 * movement,
            fraction: 1.0,
            iterations: 3,
        }
    }

    #[test]
    fn only_a_surface_in_shreds_is_given_up_after_one_step() {
        // As measured on walls without thickness: 12 voxels from 20 units for each of 2300 unknowns.
        assert!(in_shreds(&[step(46_000.0, 12.0)], 2300));
        // A large region that became steady, and a small rough one.
        assert!(!in_shreds(&[step(15_086.0, 13.7)], 4600));
        assert!(!in_shreds(&[step(1_528.0, 9.7)], 200));
        // A high energy spread over many unknowns, and a short step.
        assert!(!in_shreds(&[step(36_150.0, 5.0)], 11_330));
        assert!(!in_shreds(&[step(46_000.0, 1.0)], 2300));
        // What was not so at first is left to the other rules.
        assert!(!in_shreds(&[step(100.0, 1.0), step(46_000.0, 12.0)], 2300));
    }

    #[test]
    fn a_start_with_too_high_an_energy_is_given_up_if_it_is_far_from_rest() {
        assert!(is_too_high(&[step(3651.0, 2.6)], 2400.0));
        assert!(!is_too_high(&[step(3651.0, 0.9)], 2400.0));
        assert!(!is_too_high(&[step(2300.0, 2.6)], 2400.0));
        assert!(!is_too_high(&[step(3651.0, 2.6)], f64::INFINITY));
    }
}
