//! A band between two redistancings, and one step on it.

use super::band::{Band, MARGIN, WIDTH};
use super::coarse::hierarchy;
use super::energy::{BandEnergy, Evaluation};
use super::pull::{BandPull, Pull};
use super::steady::{FlowSettings, StepRecord};
use crate::grid::SparseGrid;
use crate::linalg::{
    Jacobi, LinearOperator, Multigrid, MultigridCycle, bicgstab, conjugate_gradient,
};

/// Redistancing may multiply the energy by no more than this.
const LEAP: f64 = 4.0;

/// The coarse levels are made again when the time step has changed by more than this, in powers of two.
const STALE: f64 = 2.5;

/// The direction of a step.
pub(super) struct Direction {
    /// The change of the values.
    pub d: Vec<f64>,
    /// Derivative of the energy along it.
    slope: f64,
    /// Largest entry within one voxel of the surface, before it was clipped.
    pub movement: f64,
    /// Root mean square of those entries.
    pub mean_movement: f64,
    /// Iterations of the linear solver.
    pub iterations: usize,
}

/// A band between two redistancings.
pub(super) struct BandState<E> {
    /// The energy on the band.
    pub energy: E,
    /// φ at the band's nodes.
    pub values: Vec<f64>,
    /// How far each node has moved since the band was made.
    moved: Vec<f64>,
    /// The pull to a given surface, if any.
    pull: Option<BandPull>,
    /// The evaluation at `values`, where it is known.
    pub at: Option<Evaluation>,
    /// Coarse levels, made for the first step in this band; none where they could not be made.
    coarse: Option<Option<Multigrid>>,
    /// The time step for which they were made.
    coarse_step: f64,
}

impl<E: BandEnergy> BandState<E> {
    pub(super) fn new(band: Band, phi: &[f64], kappa: f64, pull: Option<&Pull>) -> Self {
        let values = band.gather(phi);
        let pull = pull.map(|p| BandPull::new(p, &band, &values));
        let moved = vec![0.0; values.len()];
        let energy = E::new(band, kappa);
        let mut state = Self {
            energy,
            pull,
            values,
            moved,
            at: None,
            coarse: None,
            coarse_step: f64::INFINITY,
        };
        state.at = Some(state.evaluate(&state.values));
        state
    }

    /// The energy with that of the pull.
    fn evaluate(&self, values: &[f64]) -> Evaluation {
        let mut at = self.energy.evaluate(values);
        at.energy += self.pull.as_ref().map_or(0.0, |p| p.energy(values));
        at
    }

    /// Whether redistancing has torn the surface: its energy is many times what it was.
    pub(super) fn leaps(&self, before: f64) -> bool {
        self.at
            .as_ref()
            .is_some_and(|at| at.surface.is_nan() || at.surface > LEAP * before)
    }

    /// Solves the system of a step: the direction, clipped to a voxel at each node, and how the solve went. Takes the
    /// evaluation at the values, which the caller hands back.
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
        let mut system =
            self.energy
                .system(&self.values, &at, settings.variant, settings.time_step);
        if let Some(pull) = &self.pull {
            system.add(pull, &self.values);
        }
        let layout = system.layout();
        let mut rhs = layout.spread(&system.gradient);
        rhs.iter_mut().for_each(|g| *g = -*g);
        let mut d = vec![0.0; rhs.len()];
        let band = self.energy.band();
        if (settings.time_step / self.coarse_step).log2().abs() > STALE {
            self.coarse = None;
        }
        let coarse = self.coarse.get_or_insert_with(|| {
            self.coarse_step = settings.time_step;
            hierarchy(grid, mask, band, &self.values, &system)
        });
        let tolerance = settings.solver_tolerance;
        let solved = match coarse {
            _ if !system.is_symmetric() => {
                let scaling = Jacobi(system.jacobi());
                bicgstab(&system, &scaling, &rhs, &mut d, tolerance, 1000)
            }
            Some(coarse) => {
                let cycle = MultigridCycle::new(&system, coarse);
                conjugate_gradient(&system, &cycle, &rhs, &mut d, tolerance, 60)
            }
            None => {
                let scaling = Jacobi(system.jacobi());
                conjugate_gradient(&system, &scaling, &rhs, &mut d, tolerance, 500)
            }
        };
        let mut d = layout.gathered(&d);
        let (movement, mean_movement) = movements(&d, &self.values, &band.unknown);
        let slope_of =
            |d: &[f64]| -> f64 { system.gradient.iter().zip(d).map(|(g, d)| g * d).sum() };
        let clipped: Vec<f64> = d.iter().map(|x| x.clamp(-1.0, 1.0)).collect();
        if slope_of(&clipped) < 0.0 {
            d = clipped;
        } else {
            let top = d.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
            d.iter_mut().for_each(|x| *x /= top);
        }
        let slope = slope_of(&d);
        let direction = Direction {
            d,
            slope,
            movement,
            mean_movement,
            iterations: solved.iterations,
        };
        (direction, at)
    }

    /// One step towards the steady state: what was done, and the surface's energy before it.
    pub(super) fn step(
        &mut self,
        grid: &SparseGrid,
        mask: &[bool],
        settings: &FlowSettings,
    ) -> (StepRecord, f64) {
        let (direction, at) = self.direction(grid, mask, settings);
        let (energy, surface) = (at.energy, at.surface);
        let fraction = self.search(&direction.d, at, direction.slope);
        let record = StepRecord {
            energy,
            movement: direction.movement,
            mean_movement: direction.mean_movement,
            fraction,
            iterations: direction.iterations,
        };
        (record, surface)
    }

    /// Takes a whole step if the energy falls by it; hands the evaluation back, and says whether it did.
    pub(super) fn advance(&mut self, direction: &Direction, at: Evaluation) -> bool {
        let moved = self.values.iter().zip(&direction.d).map(|(v, d)| v + d);
        let trial: Vec<f64> = moved.collect();
        let there = self.evaluate(&trial);
        // Not a number is no fall either.
        let falls = there.energy <= at.energy;
        if falls {
            for (m, d) in self.moved.iter_mut().zip(&direction.d) {
                *m += d;
            }
            self.values = trial;
        }
        self.at = Some(if falls { there } else { at });
        falls
    }

    /// Whether the surface has moved so far that the band no longer lies round it.
    pub(super) fn is_worn(&self) -> bool {
        let mut moved = self.moved.iter().zip(&self.values);
        moved.any(|(m, v)| v.abs() < 1.0 && m.abs() > 0.5 * (WIDTH + MARGIN))
    }

    /// Halves the step until the energy falls (Armijo), and takes it; zero where it does not.
    fn search(&mut self, d: &[f64], at: Evaluation, slope: f64) -> f64 {
        let mut fraction = 1.0;
        let mut trial = self.values.clone();
        let mut reached = None;
        for _ in 0..8 {
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
fn movements(d: &[f64], values: &[f64], unknown: &[bool]) -> (f64, f64) {
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
