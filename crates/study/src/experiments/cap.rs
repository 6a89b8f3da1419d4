//! Figure 1 of the paper: a graph evolves to the spherical cap that its boundary conditions prescribe.

use std::time::Instant;

use crate::evolution::PlaneRun;
use crate::grid::SquareGrid;
use crate::observer::{Frame, Observer, StudyError};
use crate::report::{Curve, ResultTable, StatedBy, StudyReport};
use crate::step::{PlaneFlow, Tolerance};
use isomend_core::flow::Variant;

use super::table1::{cap_energy, cap_error, cap_height, cap_start};
use super::{chart, claim_fall, line};

/// Settings of the experiment.
#[derive(Clone, Debug)]
pub struct CapSettings {
    /// Number of cells a side; even.
    pub cells: usize,
    /// Time step.
    pub tau: f64,
    /// Steps after which the graph is measured and drawn, ascending.
    pub reported_steps: Vec<usize>,
}

impl Default for CapSettings {
    fn default() -> Self {
        Self {
            cells: 64,
            tau: 2e-5,
            reported_steps: vec![0, 1, 3, 10, 30, 100, 300, 700],
        }
    }
}

/// Runs the experiment.
pub fn cap(settings: &CapSettings, observer: &dyn Observer) -> Result<StudyReport, StudyError> {
    let clock = Instant::now();
    let mut report = StudyReport::new(
        "cap",
        "Figure 1: a harmonic graph evolves to the unit sphere, whose position and normal are held on the boundary; \
         epsilon = 1, variant II",
    );
    let energy = cap_energy(settings.cells);
    let mut phi = cap_start(&energy);
    let grid = energy.grid.clone();
    let mut flow = PlaneFlow::new(energy, Variant::II, settings.tau, Tolerance::OfState(1e-10))
        .with_multigrid(&phi);
    let mut evolution = PlaneRun::default();
    let mut table = ResultTable::new(
        &format!("h = 1/{}, time step {:e}", settings.cells, settings.tau),
        &["step", "time", "energy", "L2 error", "largest error"],
    );
    let (mut curves, mut errors) = (Vec::new(), Vec::new());
    for &step in &settings.reported_steps {
        let done = evolution.energies.len();
        evolution.advance(&mut flow, &mut phi, step.saturating_sub(done), observer)?;
        let (error, largest) = cap_error(&grid, &phi);
        let time = step as f64 * settings.tau;
        table.rows.push(vec![
            step.into(),
            time.into(),
            flow.energy.energy(&phi).into(),
            error.into(),
            largest.into(),
        ]);
        errors.push((error, largest));
        curves.push(line(&format!("step {step}"), section(&grid, &phi)));
        observer.progress(&format!("cap: step {step}, error {largest:.2e}"));
        observer.frame(&Frame {
            series: "cap",
            step,
            time,
            volume: &grid.volume(&phi),
        })?;
    }
    report.tables.push(table);
    curves.push(Curve {
        name: "sphere".to_owned(),
        points: section(&grid, &grid.field(cap_height))
            .into_iter()
            .step_by(4)
            .collect(),
        dots: true,
    });
    claims(&mut report, &evolution, &errors, grid.h());
    report
        .panels
        .push(chart("Section y = 0", ["x", "height"], curves));
    report.seconds = clock.elapsed().as_secs_f64();
    Ok(report)
}

fn claims(report: &mut StudyReport, evolution: &PlaneRun, errors: &[(f64, f64)], h: f64) {
    claim_fall(report, evolution);
    if let (Some(first), Some(last)) = (errors.first(), errors.last()) {
        // The error of the steady state is 6.4e-2 h² (Table 1).
        let bound = 0.07 * h * h;
        report.claim(
            StatedBy::Reference,
            "final surface is the sphere",
            format!("L2 error below 0.07 h^2 = {bound:.2e}"),
            format!("{:.3e} -> {:.3e}", first.0, last.0),
            last.0 < bound,
        );
    }
}

/// Heights along y = 0.
fn section(grid: &SquareGrid, phi: &[f64]) -> Vec<(f64, f64)> {
    let j = grid.cells() / 2;
    (0..=grid.cells())
        .map(|i| (grid.position(i, j)[0], phi[grid.index(i, j)]))
        .collect()
}
