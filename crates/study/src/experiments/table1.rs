//! Table 1 of the paper: the error of the spherical cap, computed as a graph, against h.

use std::time::Instant;

use crate::grid::SquareGrid;
use crate::observer::{Frame, Observer, StudyError};
use crate::plane::PlaneEnergy;
use crate::report::{Chart, Curve, Panel, ResultTable, StatedBy, StudyReport, short_number};
use crate::start::harmonic_fill;
use crate::step::{PlaneFlow, Tolerance};
use isomend_core::flow::Variant;

use super::variant_name;

/// Settings of the experiment.
#[derive(Clone, Debug)]
pub struct Table1Settings {
    /// Numbers of cells a side, ascending by factors of two.
    pub cells: Vec<usize>,
    /// The schemes.
    pub variants: Vec<Variant>,
    /// Time step; so large that each step aims at the steady state.
    pub tau: f64,
}

impl Default for Table1Settings {
    fn default() -> Self {
        Self {
            cells: vec![4, 8, 16, 32, 64, 128, 256],
            variants: vec![Variant::I, Variant::II, Variant::GaussNewton],
            tau: 1e6,
        }
    }
}

/// L2 errors at 8, 16, … 256 cells a side, computed by the prototype; the first is also in the paper.
const REFERENCE: [(usize, f64); 6] = [
    (8, 1.043e-3),
    (16, 2.519e-4),
    (32, 6.243e-5),
    (64, 1.560e-5),
    (128, 3.899e-6),
    (256, 9.75e-7),
];
/// A run has converged when no node moves by this or more in a step.
const CONVERGED: f64 = 1e-10;
/// Upper bound of the number of steps of a run.
const MOST_STEPS: usize = 60;

/// The height of the unit sphere.
pub(super) fn cap_height([x, y]: [f64; 2]) -> f64 {
    (1.0 - x * x - y * y).sqrt()
}

/// The energy of graphs over the centred unit square that are tangent to the unit sphere along the boundary: γ = −(x, y)·ν.
pub(super) fn cap_energy(cells: usize) -> PlaneEnergy {
    PlaneEnergy::clamped(SquareGrid::centred(cells), 1.0, |[x, y], n| {
        -(x * n[0] + y * n[1])
    })
}

/// The harmonic graph with the heights of the sphere on the boundary.
pub(super) fn cap_start(energy: &PlaneEnergy) -> Vec<f64> {
    let mut phi = energy.grid.field(cap_height);
    harmonic_fill(energy, &mut phi);
    phi
}

/// L2 error, and largest error at the nodes.
pub(super) fn cap_error(grid: &SquareGrid, phi: &[f64]) -> (f64, f64) {
    let exact = grid.field(cap_height);
    let error: Vec<f64> = phi.iter().zip(&exact).map(|(p, e)| p - e).collect();
    let largest = error.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
    (grid.l2_norm(&error), largest)
}

struct TableRun {
    error: f64,
    largest: f64,
    steps: usize,
    iterations: usize,
    seconds: f64,
    converged: bool,
}

fn run_one(
    cells: usize,
    variant: Variant,
    tau: f64,
    observer: &dyn Observer,
) -> Result<TableRun, StudyError> {
    let clock = Instant::now();
    let energy = cap_energy(cells);
    let mut phi = cap_start(&energy);
    let mut flow =
        PlaneFlow::new(energy, variant, tau, Tolerance::OfStep(1e-5)).with_multigrid(&phi);
    // Step until no node moves any more.
    let (mut steps, mut iterations, mut converged) = (0, 0, false);
    while steps < MOST_STEPS && !converged {
        if !observer.keep_going() {
            return Err(StudyError::Stopped);
        }
        let step = flow.step(&mut phi);
        steps += 1;
        iterations += step.iterations;
        converged = step.update < CONVERGED;
        if !step.update.is_finite() {
            return Err(StudyError::BlewUp { step: steps });
        }
    }
    let grid = &flow.energy.grid;
    observer.frame(&Frame {
        series: &format!("table1-{cells}-{}", variant_name(variant)),
        step: steps,
        time: steps as f64 * tau,
        volume: &grid.volume(&phi),
    })?;
    let (error, largest) = cap_error(grid, &phi);
    Ok(TableRun {
        error,
        largest,
        steps,
        iterations,
        seconds: clock.elapsed().as_secs_f64(),
        converged,
    })
}

/// The results of one scheme.
#[derive(Default)]
struct Column {
    /// (h, L2 error).
    points: Vec<(f64, f64)>,
    orders: Vec<f64>,
    /// Number of grids that the reference has.
    compared: usize,
    /// Largest relative difference from it.
    off: f64,
    unconverged: usize,
}

fn run_variant(
    settings: &Table1Settings,
    variant: Variant,
    observer: &dyn Observer,
) -> Result<(ResultTable, Column), StudyError> {
    let name = variant_name(variant);
    let mut table = ResultTable::new(
        &format!(
            "variant {name}, from the harmonic graph, time step {:e}",
            settings.tau
        ),
        &[
            "h",
            "L2 error",
            "order",
            "reference",
            "largest error",
            "steps",
            "iterations",
            "s",
        ],
    );
    let mut column = Column::default();
    for &cells in &settings.cells {
        let run = run_one(cells, variant, settings.tau, observer)?;
        observer.progress(&format!(
            "variant {name}, h = 1/{cells}: error {:.3e}",
            run.error
        ));
        // Order of convergence from the previous grid to this one.
        let order = column
            .points
            .last()
            .map(|&(h, e)| (e / run.error).ln() / (h * cells as f64).ln());
        let reference = REFERENCE.iter().find(|r| r.0 == cells).map(|r| r.1);
        if let Some(r) = reference {
            column.compared += 1;
            column.off = column.off.max((run.error / r - 1.0).abs());
        }
        column.orders.extend(order);
        column.points.push((1.0 / cells as f64, run.error));
        column.unconverged += usize::from(!run.converged);
        table.rows.push(vec![
            format!("1/{cells}").as_str().into(),
            run.error.into(),
            order.into(),
            reference.into(),
            run.largest.into(),
            run.steps.into(),
            run.iterations.into(),
            run.seconds.into(),
        ]);
    }
    Ok((table, column))
}

/// What the grids that were computed can test.
fn claims(report: &mut StudyReport, name: &str, column: &Column) {
    if column.compared > 0 {
        report.claim(
            StatedBy::Reference,
            &format!("variant {name}: errors"),
            "the same to 1 %, all runs converged".to_owned(),
            format!(
                "{:.2} % off at most, {} runs not converged",
                100.0 * column.off,
                column.unconverged
            ),
            column.off < 0.01 && column.unconverged == 0,
        );
    }
    let Some(start) = column.orders.len().checked_sub(3) else {
        return;
    };
    let finest = &column.orders[start..];
    let list: Vec<String> = finest.iter().map(|o| format!("{o:.3}")).collect();
    report.claim(
        StatedBy::Theory,
        &format!(
            "variant {name}: order of convergence from each of the finest four grids to the next"
        ),
        "2.0, to 0.06".to_owned(),
        list.join(", "),
        finest.iter().all(|o| (o - 2.0).abs() < 0.06),
    );
}

/// Runs the experiment.
pub fn table1(
    settings: &Table1Settings,
    observer: &dyn Observer,
) -> Result<StudyReport, StudyError> {
    let clock = Instant::now();
    let mut report = StudyReport::new(
        "table1",
        "Table 1: graph over (-1/2, 1/2)^2 with position and normal of the unit sphere on the boundary; steady state, epsilon = 1",
    );
    let mut curves = Vec::new();
    for &variant in &settings.variants {
        let name = variant_name(variant);
        let (table, column) = run_variant(settings, variant, observer)?;
        report.tables.push(table);
        claims(&mut report, name, &column);
        curves.push(Curve {
            name: format!("variant {name}"),
            points: column.points,
            dots: false,
        });
    }
    report.seconds = clock.elapsed().as_secs_f64();
    report.claim(
        StatedBy::Project,
        "time",
        "at most 60 s".to_owned(),
        format!("{} s", short_number(report.seconds)),
        report.seconds <= 60.0,
    );
    curves.push(Curve {
        name: "prototype".to_owned(),
        points: REFERENCE
            .iter()
            .map(|&(n, e)| (1.0 / n as f64, e))
            .collect(),
        dots: true,
    });
    report.panels.push(Panel::Chart(Chart {
        title: "Spherical cap: L2 error".to_owned(),
        axes: ["h", "L2 error"],
        logarithmic: [true, true],
        order: Some(2.0),
        curves,
    }));
    Ok(report)
}
