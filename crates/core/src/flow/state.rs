//! State of a flow on one band, between two redistancings, and its steps.

use super::band::{MARGIN, WIDTH};
use super::coarse::{feet, hierarchy};
use super::energy::{BandEnergy, Evaluation};
use super::outcome::StepRecord;
use super::pull::{BandPull, Pull};
use super::settings::FlowSettings;
use super::system::System;
use crate::elementary::log2;
use crate::grid::SparseGrid;
use crate::linalg::{
    CgOutcome, Jacobi, LinearOperator, Multigrid, MultigridCycle, bicgstab, conjugate_gradient,
    solve_spd,
};
use crate::tuning::{Tunable, tunable};

/// Ratio of the surface energy after redistancing to the surface energy before it. Above this the zero set has changed
/// its shape.
const SURFACE_JUMP: Tunable<f64> = tunable("flow.surface_jump", 4.0);

/// The same ratio for the whole energy, with the eikonal term.
const ENERGY_JUMP: Tunable<f64> = tunable("flow.energy_jump", 8.0);

/// Voxels. The matrix of a step is reused until nodes near the surface may have moved this far.
const DRIFT: Tunable<f64> = tunable("flow.drift", 0.1);

/// Steps. Upper bound of the earlier steps that a step is combined with.
const MEMORY: Tunable<usize> = tunable("flow.memory", 2);

/// Voxels. Steps are combined as long as they move no node near the surface farther than this: longer steps are far from
/// the linear regime.
const COMBINED_UPDATE: Tunable<f64> = tunable("flow.combined_update", 0.3);

/// Ratio of a step's update to the update before it. Steps are combined as long as the ratio is below this.
const SHRINKING: Tunable<f64> = tunable("flow.shrinking", 0.9);

/// Voxels⁴. Up to this time step conjugate gradients need no coarse levels: the mass term dominates the smooth modes.
const SHORT: Tunable<f64> = tunable("flow.short", 1.0);

/// Powers of two. The coarse levels are rebuilt when the time step has changed by more than this.
const TIME_STEP_CHANGE: Tunable<f64> = tunable("flow.time_step_change", 2.5);

/// The direction of a step.
pub(super) struct Direction {
    /// The change of φ at the band's nodes, in voxels.
    pub d: Vec<f64>,
    /// Derivative of the energy along `d`.
    slope: f64,
    /// Largest entry within one voxel of the surface, before clipping.
    pub update: f64,
    /// Root mean square of those entries.
    pub rms_update: f64,
    /// Iterations of the linear solver.
    pub iterations: usize,
}

impl Direction {
    /// Clips each entry to ±`most`.
    pub(super) fn clip(&mut self, most: f64) {
        self.d.iter_mut().for_each(|d| *d = d.clamp(-most, most));
    }
}

/// The state of a flow on one band, between two redistancings.
pub(super) struct BandState<E> {
    /// The energy on the band.
    pub energy: E,
    /// φ at the band's nodes.
    pub values: Vec<f64>,
    /// Displacement of each node since the band was made, in voxels.
    moved: Vec<f64>,
    /// For Anderson acceleration: the last values and the steps computed there, oldest first; and the largest displacement of the
    /// last step.
    history: Vec<(Vec<f64>, Vec<f64>)>,
    last_update: f64,
    /// The attraction to a given surface, if any.
    pull: Option<BandPull>,
    /// The evaluation at `values`, if it is known.
    pub at: Option<Evaluation>,
    /// The matrix of a step, and a bound on the displacement of nodes near the surface since it was assembled.
    system: Option<System>,
    drift: f64,
    /// Coarse levels, built at the first step on this band; `Some(None)` if they could not be built.
    coarse: Option<Option<Multigrid>>,
    /// The time step for which they were built.
    coarse_step: f64,
    /// For each row, the vector from its node to the closest point on the surface when the band was made.
    feet: Vec<[f32; 3]>,
}

impl<E: BandEnergy> BandState<E> {
    /// The state of an energy on a band of `phi`, which is a distance within [`REACH`](super::settings::REACH) of its zero set.
    pub(super) fn new(grid: &SparseGrid, energy: E, phi: &[f64], pull: Option<&Pull>) -> Self {
        let band = energy.band();
        let values = band.gather(phi);
        let pull = pull.map(|p| BandPull::new(p, band, &values));
        let moved = vec![0.0; values.len()];
        let feet = feet(band, grid, phi);
        let mut state = Self {
            energy,
            pull,
            values,
            moved,
            history: Vec::new(),
            last_update: f64::INFINITY,
            at: None,
            system: None,
            drift: 0.0,
            coarse: None,
            coarse_step: f64::INFINITY,
            feet,
        };
        state.at = Some(state.evaluate(&state.values));
        state
    }

    /// Evaluates the energy and adds the energy of the attraction.
    fn evaluate(&self, values: &[f64]) -> Evaluation {
        let mut at = self.energy.evaluate(values);
        at.energy += self.pull.as_ref().map_or(0.0, |p| p.energy(values));
        at
    }

    /// Whether redistancing changed the shape of the surface: its energy is many times `before`.
    pub(super) fn has_jumped(&self, before: f64) -> bool {
        let jumped = |at: &Evaluation| {
            at.surface.is_nan()
                || at.surface > SURFACE_JUMP.get() * before
                || at.energy > ENERGY_JUMP.get() * before
        };
        self.at.as_ref().is_some_and(jumped)
    }

    /// Solves the system of a step: the direction, clipped to a voxel at each node. Takes the evaluation at the current values
    /// out of the state; the caller puts it back.
    pub(super) fn direction(
        &mut self,
        grid: &SparseGrid,
        mask: &[bool],
        settings: &FlowSettings,
    ) -> (Direction, Evaluation) {
        let at = self
            .at
            .take()
            .unwrap_or_else(|| self.evaluate(&self.values));
        // The matrix of the last step is reused until the surface has drifted; a flow in time assembles a new one for each step.
        let in_time = settings.time_step.is_finite();
        let system = match self.system.take() {
            Some(system) if !in_time && self.drift < DRIFT.get() => system,
            _ => self.assembled(&at, settings),
        };
        // The right-hand side is minus the gradient of the energy and of the attraction.
        let mut gradient = self.energy.gradient(&self.values, &at);
        if let Some(pull) = &self.pull {
            for (i, g) in gradient.iter_mut().enumerate() {
                *g += pull.gradient(i, &self.values);
            }
        }
        let layout = system.layout();
        let mut rhs = layout.spread(&gradient);
        rhs.iter_mut().for_each(|g| *g = -*g);
        let mut d = vec![0.0; rhs.len()];
        // Coarse levels are kept for the band unless the time step changes much. For short time steps M/τ dominates, and the
        // diagonal is a good preconditioner.
        let band = self.energy.band();
        let short = settings.time_step <= SHORT.get();
        if log2(settings.time_step / self.coarse_step).abs() > TIME_STEP_CHANGE.get() {
            self.coarse = None;
        }
        if !short && self.coarse.is_none() {
            self.coarse_step = settings.time_step;
            self.coarse = Some(hierarchy(grid, mask, band, &self.feet, &system));
        }
        let coarse = self.coarse.as_ref().and_then(Option::as_ref);
        let coarse = coarse.filter(|_| !short);
        let solved = solve(&system, coarse, &rhs, &mut d, settings.solver_tolerance);
        let mut d = layout.gathered(&d);
        let (update, rms_update) = updates(&d, &self.values, &band.unknown);
        // No value may change by more than a voxel. Entries are clipped one by one, because scaling all of them by the worst
        // would stop the flow; if clipping turns the step into an ascent, all are scaled.
        let slope_of = |d: &[f64]| -> f64 { gradient.iter().zip(d).map(|(g, d)| g * d).sum() };
        let clipped: Vec<f64> = d.iter().map(|x| x.clamp(-1.0, 1.0)).collect();
        if slope_of(&clipped) < 0.0 {
            d = clipped;
        } else {
            let top = d.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
            d.iter_mut().for_each(|x| *x /= top);
        }
        let slope = slope_of(&d);
        self.drift += update;
        self.system = Some(system);
        let direction = Direction {
            d,
            slope,
            update,
            rms_update,
            iterations: solved.iterations,
        };
        (direction, at)
    }

    /// Assembles the matrix at the current values.
    fn assembled(&mut self, at: &Evaluation, settings: &FlowSettings) -> System {
        self.drift = 0.0;
        let (variant, time_step) = (settings.variant, settings.time_step);
        let mut system = self.energy.system(&self.values, at, variant, time_step);
        if let Some(pull) = &self.pull {
            system.add(pull);
        }
        system
    }

    /// Takes a step towards the steady state; returns its record and the energy of the surface before it.
    pub(super) fn step(
        &mut self,
        grid: &SparseGrid,
        mask: &[bool],
        settings: &FlowSettings,
    ) -> (StepRecord, f64) {
        let (direction, at) = self.direction(grid, mask, settings);
        let (energy, surface) = (at.energy, at.surface);
        let combined = self.combined(&direction);
        let attempt = match combined {
            Some(d) => self.try_whole(&d, at),
            None => Err(at),
        };
        let fraction = match attempt {
            Ok(()) => 1.0,
            Err(at) => self.search(&direction.d, at, direction.slope),
        };
        let record = StepRecord {
            energy,
            update: direction.update,
            rms_update: direction.rms_update,
            fraction,
            iterations: direction.iterations,
        };
        (record, surface)
    }

    /// Takes the whole step if it does not raise the energy; returns whether it did.
    pub(super) fn advance(&mut self, direction: &Direction, at: Evaluation) -> bool {
        let refused = self.try_whole(&direction.d, at).err();
        let taken = refused.is_none();
        if !taken {
            self.at = refused;
        }
        taken
    }

    /// Takes the largest of the step, its half, its quarter … that does not raise the energy; returns the fraction taken.
    pub(super) fn advance_part(&mut self, direction: &Direction, at: Evaluation) -> f64 {
        self.search(&direction.d, at, 0.0)
    }

    /// Anderson acceleration ("Iterative procedures for nonlinear integral equations", 1965): combines the step with earlier ones
    /// so that the remaining step would be smallest if the map from values to steps were linear. Gauss-Newton steps converge
    /// linearly (they shrink by a constant factor), which the combination accelerates.
    fn combined(&mut self, direction: &Direction) -> Option<Vec<f64>> {
        let d = &direction.d;
        // If steps are long or do not shrink, convergence is not linear and the history is useless.
        let shrinks = direction.update < SHRINKING.get() * self.last_update;
        self.last_update = direction.update;
        if direction.update > COMBINED_UPDATE.get() || !shrinks {
            self.history.clear();
        }
        // Scalar products are over the nodes where χ is positive.
        let product = |a: &[f64], b: &[f64]| -> f64 {
            let terms = a.iter().zip(b).zip(&self.values);
            let inside = terms.filter(|(_, v)| v.abs() < WIDTH);
            inside.map(|((a, b), _)| a * b).sum()
        };
        let change = |now: &[f64], then: &[f64]| -> Vec<f64> {
            now.iter().zip(then).map(|(a, b)| a - b).collect()
        };
        // Changes Δφ of the values and Δd of the steps since each state in the history.
        let changes: Vec<(Vec<f64>, Vec<f64>)> = self
            .history
            .iter()
            .map(|(values, steps)| (change(&self.values, values), change(d, steps)))
            .collect();
        // Normal equations for the weights w that minimise |d − Σ w Δd|.
        let count = changes.len();
        let mut matrix = vec![0.0; count * count];
        let mut weights = vec![0.0; count];
        for (i, (_, a)) in changes.iter().enumerate() {
            for (j, (_, b)) in changes.iter().enumerate() {
                matrix[i * count + j] = product(a, b);
            }
            weights[i] = product(a, d);
        }
        self.history.push((self.values.clone(), d.clone()));
        if self.history.len() > MEMORY.get() {
            self.history.remove(0);
        }
        if count == 0 || !solve_spd(&mut matrix, &mut weights) {
            return None;
        }
        // The combined step d − Σ w (Δφ + Δd), relative to the current φ.
        let mut combined = d.clone();
        for ((values, steps), w) in changes.iter().zip(&weights) {
            for ((c, v), s) in combined.iter_mut().zip(values).zip(steps) {
                *c -= w * (v + s);
            }
        }
        combined.iter_mut().for_each(|c| *c = c.clamp(-1.0, 1.0));
        Some(combined)
    }

    /// Takes the whole step if it does not raise the energy; otherwise returns the evaluation.
    fn try_whole(&mut self, d: &[f64], at: Evaluation) -> Result<(), Evaluation> {
        let moved = self.values.iter().zip(d).map(|(v, d)| v + d);
        let trial: Vec<f64> = moved.collect();
        let there = self.evaluate(&trial);
        // Also false for an energy that is NaN.
        let falls = there.energy <= at.energy;
        if !falls {
            return Err(at);
        }
        for (m, d) in self.moved.iter_mut().zip(d) {
            *m += d;
        }
        self.values = trial;
        self.at = Some(there);
        Ok(())
    }

    /// Whether the surface has moved by more than half of the band's half width, so that a new band is needed.
    pub(super) fn is_stale(&self) -> bool {
        let mut moved = self.moved.iter().zip(&self.values);
        moved.any(|(m, v)| v.abs() < 1.0 && m.abs() > 0.5 * (WIDTH + MARGIN))
    }

    /// Halves the step until the energy falls by at least 1e-4 of the decrease that its slope predicts (sufficient decrease: J.
    /// Nocedal, S. J. Wright, "Numerical Optimization", 2006, equation (3.4)), and takes it. Returns the fraction taken; zero if
    /// the energy does not fall.
    fn search(&mut self, d: &[f64], at: Evaluation, slope: f64) -> f64 {
        let mut fraction = 1.0;
        let mut trial = self.values.clone();
        let mut reached = None;
        for _ in 0..8 {
            if self.energy.band().cancel.is_cancelled() {
                break;
            }
            for (t, (v, d)) in trial.iter_mut().zip(self.values.iter().zip(d)) {
                *t = v + fraction * d;
            }
            let there = self.evaluate(&trial);
            if there.energy <= at.energy + 1e-4 * fraction * slope {
                reached = Some(there);
                break;
            }
            fraction *= 0.5;
        }
        if reached.is_none() {
            self.at = Some(at);
            return 0.0;
        }
        self.at = reached;
        for (m, d) in self.moved.iter_mut().zip(d) {
            *m += fraction * d;
        }
        self.values = trial;
        fraction
    }
}

/// Largest and root mean square entry of a step over the unknowns within one voxel of the surface.
fn updates(d: &[f64], values: &[f64], unknown: &[bool]) -> (f64, f64) {
    let (mut top, mut sum, mut count) = (0.0f64, 0.0, 0.0);
    for ((d, v), &u) in d.iter().zip(values).zip(unknown) {
        if u && v.abs() < 1.0 {
            top = top.max(d.abs());
            sum += d * d;
            count += 1.0;
        }
    }
    (top, (sum / f64::max(count, 1.0)).sqrt())
}

/// Solves the system of a step: by BiCGstab if it is not symmetric, otherwise by conjugate gradients, preconditioned with a
/// multigrid cycle if there are coarse levels.
fn solve(
    system: &System,
    coarse: Option<&Multigrid>,
    rhs: &[f64],
    d: &mut [f64],
    tolerance: f64,
) -> CgOutcome {
    let scaling = Jacobi(system.jacobi());
    if !system.is_symmetric() {
        return bicgstab(system, &scaling, rhs, d, tolerance, 1000);
    }
    if let Some(coarse) = coarse {
        let cycle = MultigridCycle::new(system, coarse);
        let solved = conjugate_gradient(system, &cycle, rhs, d, tolerance, 60);
        if solved.iterations > 0 {
            return solved;
        }
        // Rounding can make the cycle indefinite; conjugate gradients then stop before the first iteration, which does not mean
        // that the surface has converged. Use the diagonal instead.
    }
    conjugate_gradient(system, &scaling, rhs, d, tolerance, 500)
}
