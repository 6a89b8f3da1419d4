//! The flow in time: linearly implicit steps whose length follows the surface's speed.

use serde::Serialize;

use super::band::{Band, MARGIN, WIDTH};
use super::energy::BandEnergy;
use super::outcome::{FlowOutcome, StepRecord};
use super::settings::{FlowSettings, REACH};
use super::state::BandState;
use super::willmore::WillmoreBand;
use crate::grid::{SparseGrid, add, offset};
use crate::sdf::redistance;
use crate::tuning::tuning;

/// How closely steps follow the flow in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Steps are at most 0.15 of the time since the start, and short enough that no node moves by more than a quarter of a voxel.
    /// Implicit steps lag behind by about half of that part: a wave that has lost two thirds of its height is a tenth higher
    /// than it should be.
    Exact,
    /// Steps grow with the time since the start, and a node that would move too far lags behind: what is narrow goes, what is wide
    /// stays, in about eight steps on any data.
    Coarse,
}

/// One step of the flow in time.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EvolutionStep {
    /// Time at its end, in units of h⁴.
    pub time: f64,
    /// Its length.
    pub time_step: f64,
    /// The energy that is minimised, that of the band and the eikonal term, before it.
    pub energy_before: f64,
    /// The same after it.
    pub energy_after: f64,
    /// ½∫h² of the free part of the surface after it, by the co-area formula the mean over the levels in the band.
    pub willmore: f64,
    /// Largest movement of a node within one voxel of the surface, in voxels.
    pub movement: f64,
    /// Root mean square movement of those nodes.
    pub mean_movement: f64,
    /// Iterations of the linear solver.
    pub iterations: usize,
    /// Steps that were tried before it, and refused because they moved too far or did not lower the energy.
    pub refused: usize,
}

/// What is known of a step before its end is looked at; see [`EvolutionStep`].
struct Taken {
    time_step: f64,
    energy_before: f64,
    movement: f64,
    mean_movement: f64,
    iterations: usize,
    refused: usize,
}

/// Why a run paused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pause {
    /// The time asked for is reached.
    Done,
    /// The surface has come to the end of the stored nodes: the caller stores others and goes on.
    OffGrid,
    /// The callback asked to stop.
    Stopped,
    /// No step lowers the energy any more.
    Stuck,
    /// There is no free surface.
    Gone,
}

/// A Willmore flow in time, `∂φ/∂t = −|∇φ| (Δ_M h + ½ h³ − 2 k h)` with h the sum and k the product of the principal curvatures, in the
/// weak form of Droske and Rumpf (2004), equations (9) and (10), by linearly implicit steps `(M/τ + A) d = −∇E`. The metric carries
/// the same weight χ as the energy, so that every level in the band moves by its own flow; the eikonal term and redistancing keep
/// them apart.
#[derive(Clone, Debug)]
pub struct Evolution {
    /// Variant, tolerance of the solves and κ.
    pub settings: FlowSettings,
    /// How closely steps follow the flow.
    pub pace: Pace,
    /// Time reached, in units of h⁴.
    pub time: f64,
    /// The steps.
    pub steps: Vec<EvolutionStep>,
    /// Number of unknowns of the last band.
    pub unknowns: usize,
    /// ½∫h² of the free part at the start.
    pub willmore_before: f64,
    next: f64,
}

impl Evolution {
    /// At time 0.
    pub fn new(settings: FlowSettings) -> Self {
        Self {
            settings,
            pace: Pace::Exact,
            time: 0.0,
            steps: Vec::new(),
            unknowns: 0,
            willmore_before: f64::NAN,
            next: tuning().flow.first_step,
        }
    }

    /// ½∫h² of the free part of the surface now.
    pub fn willmore(&self) -> f64 {
        self.steps
            .last()
            .map_or(self.willmore_before, |s| s.willmore)
    }

    /// The run so far, described as a flow to the steady state is.
    pub fn outcome(&self) -> FlowOutcome {
        let record = |s: &EvolutionStep| StepRecord {
            energy: s.energy_before,
            movement: s.movement,
            mean_movement: s.mean_movement,
            fraction: 1.0,
            iterations: s.iterations,
        };
        FlowOutcome {
            energy: self.settings.energy,
            steps: self.steps.iter().map(record).collect(),
            movement: self.steps.last().map_or(0.0, |s| s.movement),
            converged: false,
            flat: false,
            unknowns: self.unknowns,
            energy_before: WIDTH * self.willmore_before,
            energy_after: WIDTH * self.willmore(),
            kappa: self.settings.kappa,
        }
    }

    /// Lets `phi` (in voxels) flow on the masked nodes until the time `until` (in h⁴) or a pause; `phi` and `mask` have one entry for each
    /// slot of the grid. `watch` is called after each step; false from it ends the run.
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
            let energy = WillmoreBand::new(band, self.settings.kappa);
            let mut state = BandState::new(grid, energy, phi, None);
            if self.willmore_before.is_nan() {
                self.willmore_before = state.at.as_ref().map_or(f64::NAN, |at| at.surface) / WIDTH;
            }
            let pause = match self.pace {
                Pace::Exact => self.on_band(&mut state, grid, mask, until, watch),
                Pace::Coarse => self.coarsely(&mut state, grid, mask, until, watch),
            };
            state.energy.band().scatter(&state.values, phi);
            if let Some(pause) = pause {
                return pause;
            }
        }
        Pause::Done
    }

    /// Steps until the band is stale or the run is over.
    fn on_band(
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
            // The length τ of the step, in h⁴: at most a part of the time so far, or the first length where that is longer.
            let settings = self.next_step(
                self.next
                    .min((tuning().flow.step_part * self.time).max(tuning().flow.first_step)),
                until,
            );
            let time_step = settings.time_step;
            // Solves (M/τ + A) d = −∇E. The step is taken whole or not at all: a part of it would be of another time.
            let (direction, at) = state.direction(grid, mask, &settings);
            let energy_before = at.energy;
            let far =
                direction.movement.is_nan() || direction.movement > tuning().flow.most_movement;
            let taken = if far {
                state.at = Some(at);
                false
            } else {
                state.advance(&direction, at)
            };
            if !taken {
                refused += 1;
                if refused > tuning().flow.most_refusals {
                    // On a new band, with distances computed again, a step may still lower the energy.
                    return (band_steps == 0).then_some(Pause::Stuck);
                }
                // A step that moved too far is cut to 0.7 of the movement allowed, one that raised the energy by a
                // constant.
                let wanted = 0.7 * tuning().flow.most_movement / direction.movement;
                let cut = if far && wanted > 0.1 {
                    wanted
                } else {
                    tuning().flow.step_cut
                };
                self.next = cut.min(0.7) * time_step;
                continue;
            }
            let step = Taken {
                time_step,
                energy_before,
                movement: direction.movement,
                mean_movement: direction.mean_movement,
                iterations: direction.iterations,
                refused,
            };
            let step = self.record(state, step, until);
            (refused, band_steps) = (0, band_steps + 1);
            // The next step aims at 0.7 of the movement allowed, but grows no faster than by the bound.
            let growth = 0.7 * tuning().flow.most_movement / direction.movement.max(1e-9);
            self.next = self.next.max(time_step)
                * growth.clamp(tuning().flow.step_cut, tuning().flow.step_growth);
            if !watch(&step) {
                return Some(Pause::Stopped);
            }
        }
        None
    }

    /// The settings of a step of the wanted length, or of what is left where that is hardly more.
    fn next_step(&self, wanted: f64, until: f64) -> FlowSettings {
        let left = until - self.time;
        FlowSettings {
            time_step: if wanted < 0.9 * left { wanted } else { left },
            ..self.settings
        }
    }

    /// Notes a step whose end the state is at.
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
            movement: taken.movement,
            mean_movement: taken.mean_movement,
            iterations: taken.iterations,
            refused: taken.refused,
        };
        self.steps.push(step);
        step
    }

    /// Steps that double the time, until the band is stale or the run is over; each takes its time, however far it gets.
    fn coarsely(
        &mut self,
        state: &mut BandState<WillmoreBand>,
        grid: &SparseGrid,
        mask: &[bool],
        until: f64,
        watch: &mut dyn FnMut(&EvolutionStep) -> bool,
    ) -> Option<Pause> {
        while self.time < until && !state.is_stale() {
            let settings = self.next_step(self.time.max(tuning().flow.first_part * until), until);
            let (mut direction, at) = state.direction(grid, mask, &settings);
            direction.clip(tuning().flow.most_at_once);
            let energy_before = at.energy;
            let fraction = state.advance_part(&direction, at);
            let step = Taken {
                time_step: settings.time_step,
                energy_before,
                movement: fraction * direction.movement.min(tuning().flow.most_at_once),
                mean_movement: fraction * direction.mean_movement,
                iterations: direction.iterations,
                refused: usize::from(fraction < 1.0),
            };
            let step = self.record(state, step, until);
            if !watch(&step) {
                return Some(Pause::Stopped);
            }
            if fraction < 1.0 {
                // Distances computed again make a better start for the next.
                break;
            }
        }
        None
    }
}

/// Whether an unknown node beside the surface lacks stored neighbours, though it is not at the side of the box.
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
