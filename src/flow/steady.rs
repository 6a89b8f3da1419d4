//! Steps of the flow, to its steady state or for a number of steps.

use super::band::Band;
use super::energy::BandEnergy;
use super::outcome::{FlowOutcome, LONG, StepRecord};
use super::pull::Pull;
use super::settings::{FlowSettings, REACH};
use super::state::BandState;
use crate::grid::SparseGrid;
use crate::sdf::redistance;

/// Then a surface that moves by less than this on average (root mean square, in voxels) is steady once its energy falls by
/// no more than this part in three steps: what is left is the roughness of the data.
const ROUGH_MOVEMENT: f64 = 0.01;
const ROUGH_FALL: f64 = 5e-3;
/// Five steps of more than a voxel that leave more of the energy than this part are idle.
const IDLE: f64 = 0.95;
/// κ is raised by doubling, up to this.
const KAPPA_LIMIT: f64 = 16.0;

/// Lets `phi` flow to the steady state of an energy; see [`super::relax`].
pub(super) fn relax_with<E: BandEnergy>(
    grid: &SparseGrid,
    phi: &mut Vec<f64>,
    mask: &[bool],
    settings: &FlowSettings,
    pull: Option<&Pull>,
    keep_going: &dyn Fn() -> bool,
) -> FlowOutcome {
    let mut outcome = FlowOutcome {
        energy: settings.energy,
        steps: Vec::new(),
        movement: 0.0,
        converged: false,
        flat: false,
        unknowns: 0,
        energy_before: 0.0,
        energy_after: 0.0,
        kappa: settings.kappa,
    };
    let mut state: Option<BandState<E>> = None;
    let mut lowest: Option<Lowest> = None;
    // Small steps of a flow in time say nothing about rest.
    let in_time = settings.time_step.is_finite();
    for step in 0..settings.max_steps {
        if !keep_going() {
            break;
        }
        let mut now = match state.take() {
            Some(now) => now,
            None => {
                let distances = redistance(grid, phi, mask, REACH);
                let band = Band::new(grid, &distances, mask, E::NEEDS.dilations);
                let next = BandState::<E>::new(grid, band, &distances, outcome.kappa, pull);
                if outcome.steps.last().is_some_and(|s| next.leaps(s.energy)) {
                    break;
                }
                let before = std::mem::replace(phi, distances);
                if let Some(l) = &mut lowest {
                    l.phi.get_or_insert(before);
                }
                next
            }
        };
        outcome.unknowns = now.energy.band().unknowns;
        if outcome.unknowns == 0 {
            outcome.converged = true;
            break;
        }
        let (record, surface) = now.step(grid, mask, settings);
        if step == 0 {
            outcome.energy_before = surface;
        }
        outcome.steps.push(record);
        let reached = now
            .at
            .as_ref()
            .map_or((f64::INFINITY, surface), |at| (at.energy, at.surface));
        outcome.energy_after = reached.1;
        outcome.movement = record.movement;
        if !in_time {
            match &mut lowest {
                Some(l) if !l.is_above(reached.0) => {
                    l.phi.get_or_insert_with(|| phi.clone());
                }
                _ => {
                    lowest = Some(Lowest {
                        energies: reached,
                        movement: record.movement,
                        phi: None,
                    });
                }
            }
        }
        now.energy.band().scatter(&now.values, phi);
        if !record.energy.is_finite() || !record.movement.is_finite() {
            break;
        }
        if !in_time && (record.is_steady(settings.tolerance, step + 1) || settled(&outcome.steps)) {
            outcome.converged = true;
            break;
        }
        outcome.flat = !in_time && stagnant(&outcome.steps);
        if outcome.flat || stuck(&outcome.steps) {
            break;
        }
        let grows = grows(&outcome.steps) || record.fraction == 0.0;
        if grows && outcome.kappa < KAPPA_LIMIT {
            outcome.kappa *= 2.0;
        } else if !now.is_worn() {
            state = Some(now);
        }
    }
    if let (false, Some(lowest)) = (outcome.converged, lowest) {
        outcome.energy_after = lowest.energies.1;
        outcome.movement = lowest.movement;
        if let Some(values) = lowest.phi {
            *phi = values;
        }
    }
    outcome
}

/// The values of the lowest energy so far: the result where the flow finds no rest.
struct Lowest {
    /// All of the energy, and the surface's part.
    energies: (f64, f64),
    /// The movement of the step that led there.
    movement: f64,
    /// The values; none while they are the flow's own.
    phi: Option<Vec<f64>>,
}

impl Lowest {
    /// Whether another energy is lower; one that is not a number is not.
    fn is_above(&self, energy: f64) -> bool {
        energy < self.energies.0
    }
}

/// No step has made the energy fall for three bands in a row, or the surface has leapt by many voxels for three steps, or by
/// some for five and to no avail.
fn stuck(steps: &[StepRecord]) -> bool {
    let last = |n: usize| steps.len().checked_sub(n).map(|i| &steps[i..]);
    last(3).is_some_and(|l| l.iter().all(|s| s.fraction == 0.0))
        || last(3).is_some_and(|l| l.iter().all(|s| s.movement > 5.0))
        || last(5)
            .is_some_and(|l| l.iter().all(|s| s.movement > 1.0) && l[4].energy > IDLE * l[0].energy)
}

/// Late in the run the surface hardly moves and its energy has all but stopped falling.
fn settled(steps: &[StepRecord]) -> bool {
    let n = steps.len();
    if n < LONG || steps[n - 1].mean_movement > ROUGH_MOVEMENT {
        return false;
    }
    let (before, now) = (steps[n - 4].energy, steps[n - 1].energy);
    now <= before && before - now < ROUGH_FALL * before
}

/// The energy has not changed by a five-hundredth over five steps, late in the run.
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

/// Large steps that do not get smaller over four in a row.
fn grows(steps: &[StepRecord]) -> bool {
    let n = steps.len();
    n >= 5
        && n % 4 == 1
        && steps[n - 1].movement > 0.05
        && steps[n - 1].movement > 0.7 * steps[n - 5].movement
}
