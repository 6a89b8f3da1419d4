//! The flow loop: steps to the steady state, or a number of steps in time.

use super::band::Band;
use super::energy::BandEnergy;
use super::outcome::FlowOutcome;
use super::pull::Pull;
use super::settings::{FlowSettings, REACH};
use super::state::BandState;
use super::stopping::{Stop, StopRules};
use crate::grid::SparseGrid;
use crate::sdf::redistance;

/// Lets `phi` flow to the steady state of an energy; `make` builds the energy on a band with eikonal weight κ. See
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
        if run.starts_lost(&band) {
            run.outcome.update = f64::MAX;
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

/// A running flow, to the steady state or in time.
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
                update: 0.0,
                converged: false,
                energy_plateau: false,
                unknowns: 0,
                energy_before: 0.0,
                energy_after: 0.0,
                kappa: settings.kappa,
            },
            lowest: None,
        }
    }

    /// Redistances `phi` and makes a band around its zero set. `None` if redistancing changed the shape of the surface; `phi`
    /// then stays as it was.
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

    /// Whether the data are inconsistent, so that no step is taken, and the surface counts as diverged.
    fn starts_lost<E: BandEnergy>(&self, band: &BandState<E>) -> bool {
        let rules = StopRules::new(self.settings);
        let energy = band.at.as_ref().map_or(0.0, |at| at.energy);
        self.outcome.steps.is_empty() && rules.before(energy, self.outcome.unknowns)
    }

    /// Takes a step, writes its values to `phi` and keeps the state of lowest energy.
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
        self.outcome.update = record.update;
        if !self.settings.in_time() {
            match &mut self.lowest {
                Some(lowest) if !lowest.is_above(reached.0) => {
                    lowest.phi.get_or_insert_with(|| phi.to_vec());
                }
                _ => {
                    self.lowest = Some(Lowest {
                        energies: reached,
                        update: record.update,
                        phi: None,
                    });
                }
            }
        }
        band.energy.band().scatter(&band.values, phi);
    }

    /// Whether the last step ends the run; records the reason.
    fn is_over(&mut self) -> bool {
        let rules = StopRules::new(self.settings);
        let stop = rules.after(&self.outcome.steps, self.outcome.unknowns);
        self.outcome.converged = stop == Some(Stop::Converged);
        self.outcome.energy_plateau = stop == Some(Stop::Plateau);
        stop.is_some()
    }

    /// Doubles κ if the steps grow or none lowers the energy; returns whether it did.
    fn raises_kappa(&mut self) -> bool {
        let raises = StopRules::raises_kappa(&self.outcome.steps, self.outcome.kappa);
        if raises {
            self.outcome.kappa *= 2.0;
        }
        raises
    }

    /// The outcome. If the flow did not converge, `phi` becomes the state of lowest energy.
    fn finish(self, phi: &mut Vec<f64>) -> FlowOutcome {
        let mut outcome = self.outcome;
        if let (false, Some(lowest)) = (outcome.converged, self.lowest) {
            outcome.energy_after = lowest.energies.1;
            outcome.update = lowest.update;
            if let Some(values) = lowest.phi {
                *phi = values;
            }
        }
        outcome
    }
}

/// The state of lowest energy so far: the result if the flow does not converge.
struct Lowest {
    /// The total energy and the energy of the surface.
    energies: (f64, f64),
    /// Update of the step that led there.
    update: f64,
    /// The values of φ; `None` while they are the flow's current ones.
    phi: Option<Vec<f64>>,
}

impl Lowest {
    /// Whether another energy is lower; false for NaN.
    fn is_above(&self, energy: f64) -> bool {
        energy < self.energies.0
    }
}
