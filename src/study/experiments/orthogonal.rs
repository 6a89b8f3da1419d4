//! Figure 7: level lines that meet a natural border at right angles.

use std::f64::consts::PI;
use std::time::Instant;

use crate::flow::Variant;
use crate::study::contour::level_line;
use crate::study::evolution::PlaneRun;
use crate::study::grid::SquareGrid;
use crate::study::observer::{Frame, Observer, StudyError};
use crate::study::plane::PlaneEnergy;
use crate::study::report::{Levels, Panel, StudyReport, Table};
use crate::study::spline::Spline;
use crate::study::step::{PlaneFlow, Tolerance};

use super::{chart, claim_fall, line};

/// Settings of the experiment.
#[derive(Clone, Debug)]
pub struct OrthogonalSettings {
    /// Cells a side of the unit square.
    pub cells: usize,
    /// Steps in all.
    pub steps: usize,
    /// Rows of the table, and pictures.
    pub looks: usize,
}

impl Default for OrthogonalSettings {
    fn default() -> Self {
        Self {
            cells: 64,
            steps: 1600,
            looks: 4,
        }
    }
}

const TIME_STEP: f64 = 10.0;
/// The level whose arc round the corner is measured.
const LEVEL: f64 = 0.15;

/// `0.3 cos πx cos π(3y² − 2y³)`: the printed formula cannot be read; this one behaves as the text says.
fn start([x, y]: [f64; 2]) -> f64 {
    0.3 * (PI * x).cos() * (PI * (3.0 * y * y - 2.0 * y * y * y)).cos()
}

/// What is seen at one time.
struct Look {
    /// Largest |∇φ| at the nodes.
    steepest: f64,
    /// Farthest over nearest point of the arc, seen from the corner.
    arc: f64,
    /// Largest angle between the arc's ends and the border's normal directions, in degrees.
    angle: f64,
}

fn look(grid: &SquareGrid, phi: &[f64]) -> Look {
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
    Look {
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
        "Figure 7: level lines that end on a natural border; variant II, epsilon = h, time step 10 h^4",
    );
    let grid = SquareGrid::new(settings.cells, [0.0; 2], 1.0);
    let h = grid.h();
    let tau = TIME_STEP * h.powi(4);
    let mut phi = grid.field(start);
    let energy = PlaneEnergy::natural(grid.clone(), h);
    let mut flow = PlaneFlow::new(energy, Variant::II, tau, Tolerance::OfState(1e-7));
    let mut evolution = PlaneRun::default();
    let mut table = Table::new(
        &format!(
            "h = 1/{}; the arc is the line {LEVEL} round the corner (0, 0)",
            settings.cells
        ),
        &[
            "step",
            "energy",
            "largest |grad|",
            "arc: farthest / nearest",
            "off the right angle, degrees",
        ],
    );
    let mut looks = Vec::new();
    for k in 0..=settings.looks {
        let done = settings.steps * k / settings.looks;
        let before = evolution.energies.len();
        evolution.advance(&mut flow, &mut phi, done - before, observer)?;
        let seen = look(&grid, &phi);
        table.rows.push(vec![
            done.into(),
            flow.energy.energy(&phi).into(),
            seen.steepest.into(),
            seen.arc.into(),
            seen.angle.into(),
        ]);
        looks.push(seen);
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
    claims(&mut report, &evolution, &looks);
    report.panels.push(chart(
        "Energy",
        ["time", "energy"],
        vec![line("energy", evolution.curve(tau))],
    ));
    report.seconds = clock.elapsed().as_secs_f64();
    Ok(report)
}

fn claims(report: &mut StudyReport, evolution: &PlaneRun, looks: &[Look]) {
    claim_fall(report, evolution);
    if let [first, .., last] = looks {
        report.claim(
            "arcs",
            "get rounder".to_owned(),
            format!("farthest over nearest {:.4} -> {:.4}", first.arc, last.arc),
            last.arc < first.arc,
        );
        report.claim(
            "gradient",
            "gets steeper".to_owned(),
            format!("largest {:.3} -> {:.3}", first.steepest, last.steepest),
            last.steepest > first.steepest,
        );
        report.claim(
            "angle at the border",
            "level lines stay at right angles, here to 1 degree".to_owned(),
            format!(
                "{:.3} degrees off at most",
                looks.iter().fold(0.0, |m, l| f64::max(m, l.angle))
            ),
            looks.iter().all(|l| l.angle < 1.0),
        );
    }
}
