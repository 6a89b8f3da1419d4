//! The nested solve: initialises the coarsest lattice, then runs the flow on each lattice, from coarse to fine.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::distance::DistanceData;
use super::level::Level;
use crate::flow::{
    BendingEnergy, Energy, Evolution, FlowOutcome, FlowSettings, Pace, Pause, Pull, UserEnergy,
    biharmonic_fill, relax,
};
use crate::grid::{Lattice, NodeIndex};
use crate::tuning::{Tunable, tunable};

/// Relative residual of the biharmonic fill that initialises the flow.
const START_TOLERANCE: Tunable<f64> = tunable("region.start_tolerance", 3e-3);

/// Steps on a coarser level, at most.
const COARSE_STEPS: Tunable<usize> = tunable("region.coarse_steps", 14);

/// Ratio of the tolerance on a coarser level to the tolerance on the finest.
const COARSE_TOLERANCE: Tunable<f64> = tunable("region.coarse_tolerance", 20.0);

/// Voxels. Upper bound of the tolerance on a coarser level, unless the tolerance on the finest is larger.
const MOST_COARSE_TOLERANCE: Tunable<f64> = tunable("region.most_coarse_tolerance", 0.4);

/// Voxels. A level whose last update was longer than this is far from converged.
const FAR_FROM_CONVERGED: Tunable<f64> = tunable("region.far_from_converged", 0.05);

/// Ratio of the energy at the start of a level to the energy at the end of the coarser one. Above this, if the latter was
/// above `ENERGY_BLOWUP_LEAST`, the data are inconsistent: the energy of a surface tends to a limit as voxels
/// shrink. Of 577 levels of 52 meshes all with such a start belonged to regions that ended without a surface.
const ENERGY_BLOWUP: Tunable<f64> = tunable("region.energy_blowup", 3.0);

/// Energy at the end of the coarser level. Lower bound for the test of `ENERGY_BLOWUP`.
const ENERGY_BLOWUP_LEAST: Tunable<f64> = tunable("region.energy_blowup_least", 300.0);

/// Settings of a nested solve.
#[derive(Clone, Copy)]
pub struct NestedSettings<'a> {
    /// The coarsest lattice.
    pub lattice: Lattice,
    /// Its box, in nodes.
    pub dims: NodeIndex,
    /// Number of refinements, each of which halves the voxel.
    pub refinements: usize,
    /// Whether to stop if the flow does not converge on a coarser level: its grid cannot resolve the region. A diverged level
    /// always stops the solve.
    pub stop_if_unconverged: bool,
    /// The initial surface on the coarsest lattice.
    pub start: Start,
    /// A solved level that replaces the initial surface.
    pub from: Option<&'a Level>,
    /// The flow's settings on the finest level.
    pub flow: FlowSettings,
    /// The caller's energy, if the flow minimises [`Energy::Own`].
    pub own: Option<&'a dyn BendingEnergy>,
    /// Time span in which the surface evolves, from the data's guess, on the finest lattice; none for the flow to the steady
    /// state.
    pub time: Option<TimeSpan>,
}

impl NestedSettings<'_> {
    /// The flow's settings on a level. The result of the level initialises the next.
    fn flow_on(&self, refinement: usize) -> FlowSettings {
        let (flow, last) = (&self.flow, refinement == self.refinements);
        let coarser = (self.refinements - refinement) as i32;
        FlowSettings {
            kappa: (flow.kappa * 0.5f64.powi(coarser)).max(flow.kappa.min(1.0)),
            tolerance: match last {
                true => flow.tolerance,
                false => (COARSE_TOLERANCE.get() * flow.tolerance)
                    .min(MOST_COARSE_TOLERANCE.get().max(flow.tolerance)),
            },
            max_steps: if last {
                flow.max_steps
            } else if flow.time_step.is_finite() {
                // A flow in time runs on the finest grid only.
                0
            } else {
                flow.max_steps.min(COARSE_STEPS.get())
            },
            ..*flow
        }
    }
}

/// Time span of a flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSpan {
    /// The time, in length⁴.
    pub time: f64,
    /// How closely the time steps follow the flow.
    pub pace: Pace,
}

/// The initial surface of the flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// The biharmonic fill of the free nodes.
    Biharmonic,
    /// The data's guess: the distance to a triangulation of the rims, or to the surface whose shape is kept.
    Triangulation,
    /// The sphere that continues the surroundings where there is one; otherwise as [`Start::Biharmonic`].
    Sphere,
}

/// Report of one level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LevelReport {
    /// Voxel size in world units.
    pub voxel: f64,
    /// Number of stored nodes.
    pub nodes: usize,
    /// The flow's steps and result.
    pub flow: FlowOutcome,
    /// Seconds for sampling the distances, and for initialisation and flow, in this order.
    pub seconds: [f64; 2],
}

/// The result of a nested solve.
pub struct Solved {
    /// The finest level after the flow; φ is in its voxels.
    pub level: Level,
    /// Reports of all levels, the coarsest first.
    pub reports: Vec<LevelReport>,
    /// The time that the flow has reached, in length⁴; 0 for a flow to the steady state.
    pub time: f64,
}

impl Solved {
    /// Whether the flow converged on the finest level.
    pub fn converged(&self) -> bool {
        self.reports.last().is_some_and(|r| r.flow.converged)
    }

    /// Whether the flow on the last level was far from converged when its steps ran out.
    pub fn is_far_from_converged(&self) -> bool {
        self.reports
            .last()
            .is_none_or(|r| is_far_from_converged(&r.flow))
    }

    /// See [`FlowOutcome::willmore`].
    pub fn willmore(&self) -> f64 {
        let last = self.reports.last();
        last.map_or(f64::INFINITY, |r| r.flow.willmore())
    }

    /// The last update of the surface, in voxels of the last level.
    pub fn last_update(&self) -> f64 {
        let last = self.reports.last();
        last.map_or(f64::INFINITY, |r| r.flow.update)
    }

    /// Whether the flow diverged on the last level: its zero set is meaningless, because the data are inconsistent.
    pub fn has_diverged(&self) -> bool {
        self.reports.last().is_none_or(|r| r.flow.has_diverged())
    }
}

fn is_far_from_converged(flow: &FlowOutcome) -> bool {
    !(flow.converged || flow.energy_plateau || flow.update <= FAR_FROM_CONVERGED.get())
}

/// Upper bound of the initial energy of the level after `coarser`.
fn highest_after(coarser: &LevelReport) -> f64 {
    let (times, least) = (ENERGY_BLOWUP.get(), ENERGY_BLOWUP_LEAST.get());
    let flow = &coarser.flow;
    match flow.steps.last() {
        Some(last) if flow.energy == Energy::Willmore && last.energy > least => times * last.energy,
        _ => f64::INFINITY,
    }
}

/// The energies whose flows run on a level, in order.
fn stages(energy: Energy, refinement: usize) -> Vec<Energy> {
    let start = energy.needs().start.iter().copied();
    let start = start.filter(|_| refinement == 0);
    start.chain([energy]).collect()
}

impl Level {
    /// Runs the flow to the steady state of the settings' energy; `own` is the caller's energy, if there is one.
    fn relax(
        &mut self,
        own: Option<&dyn BendingEnergy>,
        settings: &FlowSettings,
        pull: Option<&Pull>,
        keep_going: &dyn Fn() -> bool,
    ) -> FlowOutcome {
        let (lattice, grid, phi, mask) = (self.lattice, &self.grid, &mut self.phi, &self.mask);
        let own = own.map(|energy| UserEnergy { energy, lattice });
        relax(grid, phi, mask, settings, own, pull, keep_going)
    }
}

/// Solves on each level in turn. If `keep_going` ends it early, the result is the present state, not converged.
pub fn solve_nested(
    data: &dyn DistanceData,
    settings: &NestedSettings,
    keep_going: &dyn Fn() -> bool,
) -> Solved {
    match settings.time {
        Some(span) => evolve_nested(data, settings, span, keep_going),
        None => relax_nested(data, settings, keep_going),
    }
}

/// Refines to the finest lattice, initialises it with the data's guess, and lets the surface evolve there.
fn evolve_nested(
    data: &dyn DistanceData,
    settings: &NestedSettings,
    span: TimeSpan,
    keep_going: &dyn Fn() -> bool,
) -> Solved {
    let clock = Instant::now();
    // At free nodes a level's values are prolonged from the coarser lattice and not exact: the guess replaces them.
    let mut level = Level::coarsest(settings.lattice, settings.dims, data);
    level.initialise_from_guess(data);
    for _ in 0..settings.refinements {
        if !keep_going() {
            break;
        }
        level = level.refined(data);
        level.initialise_from_guess(data);
    }
    // The flow measures time in units of h⁴.
    let sampling = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let voxel = level.lattice.voxel;
    let until = span.time / voxel.powi(4);
    let mut evolution = Evolution::new(settings.flow);
    evolution.pace = span.pace;
    // Runs until the time is reached. Where the surface reaches the end of the stored nodes, blocks are added and the flow
    // continues.
    let pause = loop {
        if !keep_going() {
            break Pause::Stopped;
        }
        let pause = evolution.run(&level.grid, &mut level.phi, &level.mask, until, &mut |_| {
            keep_going()
        });
        if pause != Pause::OffGrid {
            break pause;
        }
        match level.regrown(data) {
            Some(wider) => level = wider,
            None => break pause,
        }
    };
    // For a flow in time, converged means that it reached its time.
    let mut flow = evolution.outcome();
    flow.converged = pause == Pause::Done;
    let report = LevelReport {
        voxel,
        nodes: level.grid.len(),
        flow,
        seconds: [sampling, clock.elapsed().as_secs_f64()],
    };
    Solved {
        level,
        reports: vec![report],
        time: evolution.time * voxel.powi(4),
    }
}

/// Initialises the coarsest level.
fn initialise(level: &mut Level, data: &dyn DistanceData, settings: &NestedSettings) {
    let is_ready = match (settings.from, settings.start) {
        (Some(surface), _) => {
            level.initialise_from(surface);
            true
        }
        (None, Start::Triangulation) => level.initialise_from_guess(data),
        (None, Start::Sphere) => level.initialise_from_sphere(data),
        (None, Start::Biharmonic) => false,
    };
    if !is_ready {
        biharmonic_fill(
            &level.grid,
            &mut level.phi,
            &level.mask,
            START_TOLERANCE.get(),
        );
    }
}

fn relax_nested(
    data: &dyn DistanceData,
    settings: &NestedSettings,
    keep_going: &dyn Fn() -> bool,
) -> Solved {
    // The coarsest lattice: distances of the data, and initial values at the free nodes.
    let mut clock = Instant::now();
    let mut level = Level::coarsest(settings.lattice, settings.dims, data);
    let mut sampling = clock.elapsed().as_secs_f64();
    let mut reports = Vec::new();
    clock = Instant::now();
    initialise(&mut level, data, settings);
    let rims = data.rims();
    for refinement in 0..=settings.refinements {
        if refinement > 0 {
            clock = Instant::now();
            level = level.refined(data);
            sampling = clock.elapsed().as_secs_f64();
            clock = Instant::now();
        }
        // Components of the zero set that touch no rim are held fixed: otherwise their energy would dominate.
        level.hold_detached(&rims);
        // The result of a coarser level initialises the next.
        let last = refinement == settings.refinements;
        let flow_settings = settings.flow_on(refinement);
        let pull = level.pull(data);
        // If a level starts with far more energy than the coarser level's final energy, and its first step is long, the data are
        // inconsistent: the flow ends.
        let highest = reports.last().map_or(f64::INFINITY, highest_after);
        // On the coarsest level the energies that initialise the requested one run first.
        for energy in stages(settings.flow.energy, refinement) {
            let flow_settings = FlowSettings {
                energy,
                highest,
                tolerance: flow_settings.tolerance * energy.needs().tolerance,
                ..flow_settings
            };
            let flow = level.relax(settings.own, &flow_settings, pull.as_ref(), keep_going);
            reports.push(LevelReport {
                voxel: level.lattice.voxel,
                nodes: level.grid.len(),
                flow,
                seconds: [sampling, clock.elapsed().as_secs_f64()],
            });
            sampling = 0.0;
            clock = Instant::now();
        }
        // A level that diverged, or with `stop_if_unconverged` is far from converged, cannot initialise the next.
        let flow = &reports[reports.len() - 1].flow;
        let lost = level.grid.is_cancelled()
            || !last
                && (flow.has_diverged()
                    || settings.stop_if_unconverged && is_far_from_converged(flow));
        if lost {
            break;
        }
    }
    Solved {
        level,
        reports,
        time: 0.0,
    }
}
