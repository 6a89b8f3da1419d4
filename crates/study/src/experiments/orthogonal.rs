//! Figure 7 of the paper: under natural boundary conditions, level lines meet the boundary at right angles.

use std::f64::consts::PI;
use std::time::Instant;

use crate::contour::level_line;
use crate::evolution::PlaneRun;
use crate::grid::SquareGrid;
use crate::observer::{Frame, Observer, StudyError};
use crate::plane::PlaneEnergy;
use crate::report::{Levels, Panel, ResultTable, StatedBy, StudyReport};
use crate::spline::Spline;
use crate::step::{PlaneFlow, Tolerance};
use isomend_core::flow::Variant;

use super::{chart, claim_fall, line};

/// Settings of the experiment.
#[derive(Clone, Debug)]
pub struct OrthogonalSettings {
    /// Number of cells a side of the unit square.
    pub cells: usize,
    /// Total number of steps.
    pub steps: usize,
    /// Number of table rows and pictures after the initial ones.
    pub rows: usize,
}

impl Default for OrthogonalSettings {
    fn default() -> Self {
        Self {
            cells: 64,
            steps: 1600,
            rows: 4,
        }
    }
}

/// Time step in units of h⁴.
const TIME_STEP: f64 = 10.0;
/// The level whose arc round the corner (0, 0) is measured.
const LEVEL: f64 = 0.15;

/// The initial function `0.3 cos πx cos π(3y² − 2y³)`. The formula in the paper is illegible; this one behaves as the paper's text
/// says.
fn start([x, y]: [f64; 2]) -> f64 {
    0.3 * (PI * x).cos() * (PI * (3.0 * y * y - 2.0 * y * y * y)).cos()
}

/// Measurements at one time.
struct Measurement {
    /// Largest |∇φ| at the nodes.
    steepest: f64,
    /// Largest over smallest distance of the arc from the corner.
    arc: f64,
    /// Largest angle between the arc at its ends and the normal of the boundary, in degrees.
    angle: f64,
}

fn measure(grid: &SquareGrid, phi: &[f64]) -> Measurement {
    let spline = Spline::new(grid, phi);
    let steepest = grid
        .nodes()
        .map(|(i, j)| spline.jet(grid.position(i, j)).gradient)
        .fold(0.0, |m, g| f64::max(m, g[0].hypot(g[1])));
    let line: Vec<[f64; 2]> = level_line(grid, phi, LEVEL)
        .into_iter()
        .flatten()
        .filter(|p| p[0] < 0.6 && p[1] < 0.6)
        .collect();
    let (near, far) = line.iter().fold((f64::MAX, 0.0f64), |(n, f), p| {
        let r = p[0].hypot(p[1]);
        (n.min(r), f.max(r))
    });
    let off = line.iter().filter_map(|p| {
        let g = spline.jet(*p).gradient;
        let along = if p[0] < 1e-12 {
            g[0]
        } else if p[1] < 1e-12 {
            g[1]
        } else {
            return None;
        };
        Some((along.abs() / g[0].hypot(g[1])).asin().to_degrees())
    });
    Measurement {
        steepest,
        arc: far / near,
        angle: off.fold(0.0, f64::max),
    }
}

/// Runs the experiment.
pub fn orthogonal(
    settings: &OrthogonalSettings,
    observer: &dyn Observer,
) -> Result<StudyReport, StudyError> {
    let clock = Instant::now();
    let mut report = StudyReport::new(
        "orthogonal",
        "Figure 7: level lines that end on a natural boundary; variant II, epsilon = h, time step 10 h^4",
    );
    let grid = SquareGrid::new(settings.cells, [0.0; 2], 1.0);
    let h = grid.h();
    let tau = TIME_STEP * h.powi(4);
    let mut phi = grid.field(start);
    let energy = PlaneEnergy::natural(grid.clone(), h);
    let mut flow = PlaneFlow::new(energy, Variant::II, tau, Tolerance::OfState(1e-7));
    let mut evolution = PlaneRun::default();
    let mut table = ResultTable::new(
        &format!(
            "h = 1/{}; the arc is the level line {LEVEL} round the corner (0, 0)",
            settings.cells
        ),
        &[
            "step",
            "energy",
            "largest |grad|",
            "arc: farthest / nearest",
            "deviation from right angle, degrees",
        ],
    );
    let mut measured = Vec::new();
    for k in 0..=settings.rows {
        let done = settings.steps * k / settings.rows;
        let before = evolution.energies.len();
        evolution.advance(&mut flow, &mut phi, done - before, observer)?;
        let seen = measure(&grid, &phi);
        table.rows.push(vec![
            done.into(),
            flow.energy.energy(&phi).into(),
            seen.steepest.into(),
            seen.arc.into(),
            seen.angle.into(),
        ]);
        measured.push(seen);
        report.panels.push(Panel::Levels(Levels {
            bold: level_line(&grid, &phi, LEVEL),
            ..super::merge::drawn(&grid, &phi, done)
        }));
        observer.progress(&format!("orthogonal: step {done} of {}", settings.steps));
        observer.frame(&Frame {
            series: "orthogonal",
            step: done,
            time: done as f64 * tau,
            volume: &grid.volume(&phi),
        })?;
    }
    report.tables.push(table);
    claims(&mut report, &evolution, &measured);
    report.panels.push(chart(
        "Energy",
        ["time", "energy"],
        vec![line("energy", evolution.curve(tau))],
    ));
    report.seconds = clock.elapsed().as_secs_f64();
    Ok(report)
}

fn claims(report: &mut StudyReport, evolution: &PlaneRun, measured: &[Measurement]) {
    claim_fall(report, evolution);
    if let [first, .., last] = measured {
        report.claim(
            StatedBy::Paper,
            "arcs",
            "get rounder".to_owned(),
            format!("farthest over nearest {:.4} -> {:.4}", first.arc, last.arc),
            last.arc < first.arc,
        );
        report.claim(
            StatedBy::Paper,
            "gradient",
            "gets steeper".to_owned(),
            format!("largest {:.3} -> {:.3}", first.steepest, last.steepest),
            last.steepest > first.steepest,
        );
        report.claim(
            StatedBy::Paper,
            "angle at the boundary",
            "level lines stay at right angles, here to 1 degree".to_owned(),
            format!(
                "{:.3} degrees off at most",
                measured.iter().fold(0.0, |m, s| f64::max(m, s.angle))
            ),
            measured.iter().all(|s| s.angle < 1.0),
        );
    }
}
