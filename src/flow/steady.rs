//! Steps of the flow, to its steady state or for a number of steps.

use serde::Serialize;

use super::band::{Band, MARGIN, WIDTH};
use super::energy::{BandEnergy, Energy};
use super::pull::Pull;
use super::state::BandState;
use super::variation::VariationBand;
use super::willmore::WillmoreBand;
use crate::grid::SparseGrid;
use crate::sdf::redistance;

/// How far out redistancing goes, in voxels: one layer more, so that the band's outermost nodes have their distance.
pub(super) const REACH: f64 = WIDTH + MARGIN + 1.0;
/// After so many steps single nodes that do not come to rest are let be.
const LONG: usize = 8;
/// Then a surface that moves by less than this on average (root mean square, in voxels) is steady once its energy falls by
/// no more than this part in three steps: what is left is the roughness of the data.
const ROUGH_MOVEMENT: f64 = 0.01;
const ROUGH_FALL: f64 = 5e-3;
/// Five steps of more than a voxel that leave more of the energy than this part are idle.
const IDLE: f64 = 0.95;
/// Up to so many voxels across a hole κ is as set.
const KAPPA_ACROSS: f64 = 20.0;
/// κ is raised by doubling, up to this.
const KAPPA_LIMIT: f64 = 16.0;

/// Which approximation of the Hessian a step uses. All share their steady states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Variant {
    /// `L2 M⁻¹ L3`, nonsymmetric: the paper's first scheme.
    I,
    /// `L3 M⁻¹ L3`: the paper's second scheme.
    II,
    /// `L2 M⁻¹ L2`.
    GaussNewton,
}

/// How the flow is run.
#[derive(Clone, Copy, Debug)]
pub struct FlowSettings {
    /// What the flow makes small.
    pub energy: Energy,
    /// The metric of a step of the Willmore flow; the variation of curvature knows Gauss-Newton alone.
    pub variant: Variant,
    /// Time step in units of h⁴ (h⁶ with the variation of curvature); infinite for the steady state at once.
    pub time_step: f64,
    /// Most steps to take.
    pub max_steps: usize,
    /// Converged when no node within one voxel of the surface moves by more than this, in voxels; or, on rough data, once
    /// the surface hardly moves and its energy has settled.
    pub tolerance: f64,
    /// Relative error of the linear solves (relative residual, for the variants that are not preconditioned by multigrid).
    pub solver_tolerance: f64,
    /// Weight κ of the eikonal term to begin with; on nested grids that of the finest, half of it on the next, but at
    /// least 1. It should grow with the number of voxels across: with 1 the surface drifts on fine grids.
    pub kappa: f64,
}

impl Default for FlowSettings {
    fn default() -> Self {
        Self {
            energy: Energy::Willmore,
            variant: Variant::GaussNewton,
            time_step: f64::INFINITY,
            max_steps: 20,
            tolerance: 2e-4,
            solver_tolerance: 2e-2,
            kappa: 1.0,
        }
    }
}

impl FlowSettings {
    /// The same for a hole of so many voxels across: the eikonal weight κ grows with their number beyond 20. At a fixed
    /// weight the surface drifts on fine grids, by a distance of the order of a voxel over κ.
    #[must_use]
    pub fn across(self, voxels: f64) -> Self {
        Self {
            kappa: self.kappa * (voxels / KAPPA_ACROSS).max(1.0),
            ..self
        }
    }
}

/// One step.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct StepRecord {
    /// Energy before it.
    pub energy: f64,
    /// Largest movement of a node within one voxel of the surface, in voxels.
    pub movement: f64,
    /// Root mean square movement of those nodes.
    pub mean_movement: f64,
    /// Fraction of the step taken.
    pub fraction: f64,
    /// Iterations of the linear solver.
    pub iterations: usize,
}

impl StepRecord {
    /// No node moves by more than the tolerance; or, after many steps, where the data are rough and single nodes do not come
    /// to rest, none by many times as much and the surface as a whole by less than it.
    fn is_steady(&self, tolerance: f64, steps: usize) -> bool {
        let calm = self.movement < tolerance
            || (steps >= LONG
                && self.movement < 30.0 * tolerance
                && self.mean_movement < tolerance);
        calm && self.fraction > 0.9
    }
}

/// How the flow ended.
#[derive(Clone, Debug, Serialize)]
pub struct FlowOutcome {
    /// What was made small.
    pub energy: Energy,
    /// The steps.
    pub steps: Vec<StepRecord>,
    /// Largest movement of a node within one voxel of the surface in the step that led to the result, in voxels.
    pub movement: f64,
    /// Whether the stopping test was met.
    pub converged: bool,
    /// Whether it ended because the energy hardly changed any more, though nodes still moved: along some way the energy is flat.
    pub flat: bool,
    /// Number of unknowns of the last band.
    pub unknowns: usize,
    /// The surface's part of the energy at the start.
    pub energy_before: f64,
    /// The surface's part of the energy at the end.
    pub energy_after: f64,
    /// Weight of the eikonal term at the end.
    pub kappa: f64,
}

/// Lets `phi` flow on the masked nodes until it is steady, or for `max_steps`; `pull` holds it to a given surface.
/// `keep_going` may end it early.
///
/// A step solves `A d = −∇E`, clips `d` to one voxel at each node and is halved until the energy falls; κ is raised when
/// steps grow. So it always ends.
pub fn relax(
    grid: &SparseGrid,
    phi: &mut Vec<f64>,
    mask: &[bool],
    settings: &FlowSettings,
    pull: Option<&Pull>,
    keep_going: &dyn Fn() -> bool,
) -> FlowOutcome {
    let run = match settings.energy {
        Energy::Willmore => relax_with::<WillmoreBand>,
        Energy::CurvatureVariation => relax_with::<VariationBand>,
    };
    run(grid, phi, mask, settings, pull, keep_going)
}

fn relax_with<E: BandEnergy>(
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
                let band = Band::new(grid, &distances, mask, E::DILATIONS);
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
