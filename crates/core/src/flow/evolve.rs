//! Willmore flow in time: linearly implicit steps whose length follows the speed of the surface.

use serde::Serialize;

use super::band::{Band, MARGIN, WIDTH};
use super::energy::BandEnergy;
use super::outcome::{FlowOutcome, StepRecord};
use super::settings::{FlowSettings, REACH};
use super::state::BandState;
use super::willmore::WillmoreBand;
use crate::grid::{SparseGrid, add, offset};
use crate::sdf::redistance;
use crate::tuning::{Tunable, tunable};

/// Voxels. Upper bound of the update of a node within a voxel of the surface in a time step.
const MOST_UPDATE: Tunable<f64> = tunable("flow.most_update", 0.25);

/// Upper bound of the ratio of a time step to the one before.
const STEP_GROWTH: Tunable<f64> = tunable("flow.step_growth", 2.0);

/// Ratio of a time step to the refused one before it.
const STEP_CUT: Tunable<f64> = tunable("flow.step_cut", 0.3);

/// Fraction of the time since the start. Upper bound of a time step: waves that decay faster have nearly vanished, so
/// their error does not matter.
const STEP_PART: Tunable<f64> = tunable("flow.step_part", 0.15);

/// Voxels⁴. The first time step: in it, waves of four voxels lose a tenth of their height.
const FIRST_STEP: Tunable<f64> = tunable("flow.first_step", 0.02);

/// Refused time steps in a row after which the flow in time ends.
const MOST_REFUSALS: Tunable<usize> = tunable("flow.most_refusals", 8);

/// Voxels. Upper bound of a node's update in a time step where only the size of removed features matters. At creases and
/// where sheets touch the speed is unbounded; accurate time steps would be as short as for updates of a fifth of a voxel.
const MOST_AT_ONCE: Tunable<f64> = tunable("flow.most_at_once", 0.5);

/// Fraction of the whole time that the first step takes in that mode.
const FIRST_PART: Tunable<f64> = tunable("flow.first_part", 0.05);

/// How closely the steps follow the flow in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Steps are at most 0.15 of the time since the start, and short enough that no node moves by more than a quarter of a voxel.
    /// Implicit steps lag behind by about half of that fraction: a wave that has lost two thirds of its height is a tenth higher
    /// than it should be.
    Exact,
    /// Steps grow with the time since the start, and nodes that would move too far are clipped. Narrow features vanish and wide
    /// ones stay; about eight steps on any data.
    Coarse,
}

/// One step of the flow in time.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EvolutionStep {
    /// Time at its end, in units of h⁴.
    pub time: f64,
    /// Its length.
    pub time_step: f64,
    /// The minimised energy (band and eikonal term) before the step.
    pub energy_before: f64,
    /// The minimised energy after the step.
    pub energy_after: f64,
    /// ½∫h² of the free part of the surface after the step: by the co-area formula the mean over the levels in the band.
    pub willmore: f64,
    /// Largest displacement of a node within one voxel of the surface, in voxels.
    pub update: f64,
    /// Root mean square displacement of those nodes, in voxels.
    pub rms_update: f64,
    /// Iterations of the linear solver.
    pub iterations: usize,
    /// Number of steps refused before this one because they moved too far or did not lower the energy; with [`Pace::Coarse`] 1 if
    /// the step was shortened.
    pub refused: usize,
}

/// Data of a step before its result is evaluated; see [`EvolutionStep`].
struct Taken {
    time_step: f64,
    energy_before: f64,
    update: f64,
    rms_update: f64,
    iterations: usize,
    refused: usize,
}

/// Why a run paused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pause {
    /// The requested time is reached.
    Done,
    /// The surface has reached the end of the stored nodes: the caller stores more nodes and continues.
    OffGrid,
    /// The callback asked to stop.
    Stopped,
    /// No step lowers the energy any more.
    Stuck,
    /// There is no free surface.
    Gone,
}

/// Willmore flow in time, `∂φ/∂t = −|∇φ| (Δ_M h + ½ h³ − 2 k h)` where h is the sum and k the product of the principal
/// curvatures, in the weak form of Droske and Rumpf (2004), equations (9) and (10), by linearly implicit steps
/// `(M/τ + A) d = −∇E`. The metric has the same weight χ as the energy, so every level in the band moves by its own flow; the
/// eikonal term and redistancing keep the levels apart.
#[derive(Clone, Debug)]
pub struct Evolution {
    /// Variant, solver tolerance and κ.
    pub settings: FlowSettings,
    /// How closely the steps follow the flow.
    pub pace: Pace,
    /// Time reached, in units of h⁴.
    pub time: f64,
    /// The steps so far.
    pub steps: Vec<EvolutionStep>,
    /// Number of unknowns of the last band.
    pub unknowns: usize,
    /// ½∫h² of the free part at the start.
    pub willmore_before: f64,
    /// Length to try for the next step, in h⁴.
    next: f64,
}

impl Evolution {
    /// Starts at time 0.
    pub fn new(settings: FlowSettings) -> Self {
        Self {
            settings,
            pace: Pace::Exact,
            time: 0.0,
            steps: Vec::new(),
            unknowns: 0,
            willmore_before: f64::NAN,
            next: FIRST_STEP.get(),
        }
    }

    /// ½∫h² of the free part of the surface at present.
    pub fn willmore(&self) -> f64 {
        self.steps
            .last()
            .map_or(self.willmore_before, |s| s.willmore)
    }

    /// The run so far in the form of a flow to the steady state.
    pub fn outcome(&self) -> FlowOutcome {
        let record = |s: &EvolutionStep| StepRecord {
            energy: s.energy_before,
            update: s.update,
            rms_update: s.rms_update,
            fraction: 1.0,
            iterations: s.iterations,
        };
        FlowOutcome {
            energy: self.settings.energy,
            steps: self.steps.iter().map(record).collect(),
            update: self.steps.last().map_or(0.0, |s| s.update),
            converged: false,
            energy_plateau: false,
            unknowns: self.unknowns,
            energy_before: WIDTH * self.willmore_before,
            energy_after: WIDTH * self.willmore(),
            kappa: self.settings.kappa,
        }
    }

    /// Lets `phi` (in voxels) flow on the masked nodes until the time `until` (in h⁴) or a pause. `phi` and `mask` have one entry
    /// for each slot of the grid. `watch` is called after each step; if it returns false the run ends.
    pub fn run(
        &mut self,
        grid: &SparseGrid,
        phi: &mut Vec<f64>,
        mask: &[bool],
        until: f64,
        watch: &mut dyn FnMut(&EvolutionStep) -> bool,
    ) -> Pause {
        while self.time < until {
            if grid.is_cancelled() {
                return Pause::Stopped;
            }
            // A new band around the zero set, with recomputed distances.
            let distances = redistance(grid, phi, mask, REACH);
            let band = Band::new(grid, &distances, mask, WillmoreBand::NEEDS.dilations);
            self.unknowns = band.unknowns;
            if band.unknowns == 0 {
                return Pause::Gone;
            }
            let off = leaves(grid, &band, &distances);
            *phi = distances;
            if off {
                return Pause::OffGrid;
            }
            // Steps on the band until it is stale.
            let energy = WillmoreBand::new(band, self.settings.kappa);
            let mut state = BandState::new(grid, energy, phi, None);
            if self.willmore_before.is_nan() {
                self.willmore_before = state.at.as_ref().map_or(f64::NAN, |at| at.surface) / WIDTH;
            }
            let pause = match self.pace {
                Pace::Exact => self.exact_steps(&mut state, grid, mask, until, watch),
                Pace::Coarse => self.coarse_steps(&mut state, grid, mask, until, watch),
            };
            state.energy.band().scatter(&state.values, phi);
            if let Some(pause) = pause {
                return pause;
            }
        }
        Pause::Done
    }

    /// Takes exact steps until the band is stale or the run is over.
    fn exact_steps(
        &mut self,
        state: &mut BandState<WillmoreBand>,
        grid: &SparseGrid,
        mask: &[bool],
        until: f64,
        watch: &mut dyn FnMut(&EvolutionStep) -> bool,
    ) -> Option<Pause> {
        let (mut refused, mut band_steps) = (0, 0);
        while self.time < until && !state.is_stale() {
            if grid.is_cancelled() {
                return Some(Pause::Stopped);
            }
            // The step length τ, in h⁴: at most a fraction of the elapsed time, or the first step's length if that is longer.
            let settings = self.next_step(
                self.next
                    .min((STEP_PART.get() * self.time).max(FIRST_STEP.get())),
                until,
            );
            let time_step = settings.time_step;
            // Solves (M/τ + A) d = −∇E. The step is taken whole or not at all: part of it would be the flow of another time.
            let (direction, at) = state.direction(grid, mask, &settings);
            let energy_before = at.energy;
            let far = direction.update.is_nan() || direction.update > MOST_UPDATE.get();
            let taken = if far {
                state.at = Some(at);
                false
            } else {
                state.advance(&direction, at)
            };
            if !taken {
                refused += 1;
                if refused > MOST_REFUSALS.get() {
                    // On a new band, with distances recomputed, a step may still lower the energy.
                    return (band_steps == 0).then_some(Pause::Stuck);
                }
                // A step that moved too far is shortened towards 0.7 of the allowed displacement; one that raised the energy, by
                // a constant factor.
                let wanted = 0.7 * MOST_UPDATE.get() / direction.update;
                let cut = if far && wanted > 0.1 {
                    wanted
                } else {
                    STEP_CUT.get()
                };
                self.next = cut.min(0.7) * time_step;
                continue;
            }
            let step = Taken {
                time_step,
                energy_before,
                update: direction.update,
                rms_update: direction.rms_update,
                iterations: direction.iterations,
                refused,
            };
            let step = self.record(state, step, until);
            (refused, band_steps) = (0, band_steps + 1);
            // The next step aims at 0.7 of the allowed displacement, within the bounds on its growth.
            let growth = 0.7 * MOST_UPDATE.get() / direction.update.max(1e-9);
            self.next = self.next.max(time_step) * growth.clamp(STEP_CUT.get(), STEP_GROWTH.get());
            if !watch(&step) {
                return Some(Pause::Stopped);
            }
        }
        None
    }

    /// Settings for a step of the wanted length, or of the remaining time if that is hardly longer.
    fn next_step(&self, wanted: f64, until: f64) -> FlowSettings {
        let left = until - self.time;
        FlowSettings {
            time_step: if wanted < 0.9 * left { wanted } else { left },
            ..self.settings
        }
    }

    /// Records a step; the state is at its end.
    fn record(
        &mut self,
        state: &BandState<WillmoreBand>,
        taken: Taken,
        until: f64,
    ) -> EvolutionStep {
        let time_step = taken.time_step;
        self.time = if time_step == until - self.time {
            until
        } else {
            self.time + time_step
        };
        let at = state.at.as_ref();
        let (energy_after, surface) = at.map_or((f64::NAN, f64::NAN), |a| (a.energy, a.surface));
        let step = EvolutionStep {
            time: self.time,
            time_step,
            energy_before: taken.energy_before,
            energy_after,
            willmore: surface / WIDTH,
            update: taken.update,
            rms_update: taken.rms_update,
            iterations: taken.iterations,
            refused: taken.refused,
        };
        self.steps.push(step);
        step
    }

    /// Takes coarse steps, each as long as the elapsed time, until the band is stale or the run is over. The time advances by the
    /// full step even if the surface moved only part of the way.
    fn coarse_steps(
        &mut self,
        state: &mut BandState<WillmoreBand>,
        grid: &SparseGrid,
        mask: &[bool],
        until: f64,
        watch: &mut dyn FnMut(&EvolutionStep) -> bool,
    ) -> Option<Pause> {
        while self.time < until && !state.is_stale() {
            let settings = self.next_step(self.time.max(FIRST_PART.get() * until), until);
            let (mut direction, at) = state.direction(grid, mask, &settings);
            direction.clip(MOST_AT_ONCE.get());
            let energy_before = at.energy;
            let fraction = state.advance_part(&direction, at);
            let step = Taken {
                time_step: settings.time_step,
                energy_before,
                update: fraction * direction.update.min(MOST_AT_ONCE.get()),
                rms_update: fraction * direction.rms_update,
                iterations: direction.iterations,
                refused: usize::from(fraction < 1.0),
            };
            let step = self.record(state, step, until);
            if !watch(&step) {
                return Some(Pause::Stopped);
            }
            if fraction < 1.0 {
                // The next step starts better from recomputed distances.
                break;
            }
        }
        None
    }
}

/// Whether an unknown node near the surface lacks stored neighbours inside the grid's box.
fn leaves(grid: &SparseGrid, band: &Band, phi: &[f64]) -> bool {
    let lacks = |i: usize| {
        let n = grid.node(band.slots[i] as usize);
        (0..27).any(|k| {
            let near = add(n, offset(k));
            grid.slot(near).is_none() && (0..3).all(|d| near[d] >= 0 && near[d] < grid.dims()[d])
        })
    };
    (0..band.slots.len())
        .any(|i| band.unknown[i] && phi[band.slots[i] as usize].abs() < WIDTH + MARGIN && lacks(i))
}
