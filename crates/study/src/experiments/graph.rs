//! Figures 4 and 5 of the paper: Willmore flow of a graph, compared with the parametric flow of the same surface.

use std::f64::consts::PI;
use std::time::Instant;

use glam::DVec3;

use crate::evolution::PlaneRun;
use crate::grid::SquareGrid;
use crate::observer::{Frame, Observer, StudyError};
use crate::parametric::ParametricFlow;
use crate::plane::PlaneEnergy;
use crate::report::{Chart, Curve, Panel, ResultTable, StatedBy, StudyReport, TableCell};
use crate::spline::Spline;
use crate::step::{PlaneFlow, Tolerance};
use isomend_core::flow::Variant;
use isomend_core::mesh::Mesh;

use super::{chart, claim_fall, line};

/// Settings of the experiment.
#[derive(Clone, Debug)]
pub struct GraphSettings {
    /// Number of cells a side of the unit square, for both flows.
    pub cells: usize,
    /// Time step of both flows.
    pub tau: f64,
    /// Total number of steps.
    pub steps: usize,
    /// Number of table rows after the initial one.
    pub rows: usize,
}

impl Default for GraphSettings {
    fn default() -> Self {
        Self {
            cells: 32,
            tau: 1e-8,
            steps: 2500,
            rows: 10,
        }
    }
}

/// Energies at the start and after 2500 steps with h = 1/32, computed by the prototype.
const REFERENCE: [f64; 2] = [136.7, 43.3];

/// The initial graph `¼ sin πy (¼ sin πx + sin 3πx)`.
fn start([x, y]: [f64; 2]) -> f64 {
    0.25 * (PI * y).sin() * (0.25 * (PI * x).sin() + (3.0 * PI * x).sin())
}

/// The graph as a triangle mesh; its squares are cut along alternating diagonals.
fn triangulated(grid: &SquareGrid, phi: &[f64]) -> Mesh {
    let side = grid.cells() as u32 + 1;
    let mut mesh = Mesh::default();
    for (i, j) in grid.nodes() {
        let [x, y] = grid.position(i, j);
        mesh.positions.push(DVec3::new(x, y, phi[grid.index(i, j)]));
    }
    for j in 0..side - 1 {
        for i in 0..side - 1 {
            let a = j * side + i;
            let (b, c, d) = (a + 1, a + side, a + side + 1);
            if (i + j) % 2 == 0 {
                mesh.faces.extend([[a, b, d], [a, d, c]]);
            } else {
                mesh.faces.extend([[a, b, c], [b, d, c]]);
            }
        }
    }
    mesh
}

/// Slope up to which heights are compared. On steeper walls, heights differ even if the surfaces do not.
const GENTLE: f64 = 2.0;

/// The difference between the parametric surface and the graph, at the surface's vertices.
#[derive(Clone, Copy, Debug)]
struct Difference {
    time: f64,
    /// L2 norm over the square of the difference of heights.
    l2: f64,
    /// Largest difference of heights.
    largest: f64,
    /// Largest difference of heights where the slope is below [`GENTLE`].
    gentle: f64,
    /// Largest distance between the surfaces, to first order: difference of heights over √(1 + |∇φ|²).
    distance: f64,
    /// Largest height of the graph.
    height: f64,
}

fn difference(grid: &SquareGrid, phi: &[f64], mesh: &Mesh, time: f64) -> Difference {
    let spline = Spline::new(grid, phi);
    let mut field = vec![0.0; phi.len()];
    let mut out = Difference {
        time,
        l2: 0.0,
        largest: 0.0,
        gentle: 0.0,
        distance: 0.0,
        height: phi.iter().fold(0.0, |m, p| m.max(p.abs())),
    };
    for ((i, j), p) in grid.nodes().zip(&mesh.positions) {
        let jet = spline.jet([p.x, p.y]);
        let d = p.z - jet.value;
        let slope = jet.gradient[0].hypot(jet.gradient[1]);
        field[grid.index(i, j)] = d;
        out.largest = out.largest.max(d.abs());
        out.distance = out.distance.max(d.abs() / 1f64.hypot(slope));
        if slope < GENTLE {
            out.gentle = out.gentle.max(d.abs());
        }
    }
    out.l2 = grid.l2_norm(&field);
    out
}

/// Both flows of the same surface.
struct Pair {
    phi: Vec<f64>,
    flow: PlaneFlow,
    evolution: PlaneRun,
    surface: ParametricFlow,
    /// (time, energy) of the parametric flow before each step.
    energies: Vec<(f64, f64)>,
}

impl Pair {
    fn new(settings: &GraphSettings) -> Self {
        let grid = SquareGrid::new(settings.cells, [0.0; 2], 1.0);
        let energy = PlaneEnergy::clamped(grid.clone(), 1.0, |_, _| 0.0);
        let mut phi = grid.field(start);
        for (p, free) in phi.iter_mut().zip(energy.free()) {
            *p *= f64::from(*free);
        }
        // At the boundary the surface is flat and horizontal, so the conormal is the square's outer normal.
        let outward = |p: DVec3, q: DVec3| {
            let edge = q - p;
            DVec3::new(edge.y, -edge.x, 0.0).normalize_or_zero()
        };
        Self {
            surface: ParametricFlow::new(triangulated(&grid, &phi), settings.tau, outward),
            flow: PlaneFlow::new(energy, Variant::II, settings.tau, Tolerance::OfState(1e-8)),
            evolution: PlaneRun::default(),
            energies: Vec::new(),
            phi,
        }
    }

    fn advance(&mut self, until: usize, observer: &dyn Observer) -> Result<(), StudyError> {
        for step in self.evolution.energies.len()..until {
            self.evolution
                .advance(&mut self.flow, &mut self.phi, 1, observer)?;
            let taken = self.surface.step();
            self.energies
                .push((step as f64 * self.surface.tau, taken.energy));
            if !taken.update.is_finite() {
                return Err(StudyError::BlewUp { step });
            }
        }
        Ok(())
    }

    fn row(&self, done: usize, now: &Difference) -> Vec<TableCell> {
        vec![
            done.into(),
            now.time.into(),
            self.flow.energy.energy(&self.phi).into(),
            self.surface.energy().into(),
            now.l2.into(),
            now.largest.into(),
            now.gentle.into(),
            (now.distance / self.flow.energy.grid.h()).into(),
            now.height.into(),
        ]
    }
}

const COLUMNS: [&str; 9] = [
    "step",
    "time",
    "energy of the graph",
    "energy, parametric",
    "L2 difference",
    "largest difference",
    "where slope < 2",
    "distance / h",
    "largest height",
];

/// Runs the experiment.
pub fn graph(settings: &GraphSettings, observer: &dyn Observer) -> Result<StudyReport, StudyError> {
    let clock = Instant::now();
    let mut report = StudyReport::new(
        "graph",
        "Figures 4 and 5: the graph of 1/4 sin(pi y) (1/4 sin(pi x) + sin(3 pi x)), clamped flat, and the \
         parametric flow of the same surface; epsilon = 1, variant II",
    );
    let mut pair = Pair::new(settings);
    let grid = pair.flow.energy.grid.clone();
    let title = format!("h = 1/{}, time step {:e}", settings.cells, settings.tau);
    let mut table = ResultTable::new(&title, &COLUMNS);
    let (mut apart, mut sections) = (Vec::new(), Vec::new());
    for k in 0..=settings.rows {
        let done = settings.steps * k / settings.rows;
        pair.advance(done, observer)?;
        let time = done as f64 * settings.tau;
        let now = difference(&grid, &pair.phi, &pair.surface.mesh, time);
        table.rows.push(pair.row(done, &now));
        apart.push(now);
        if k == 0 || 2 * k == settings.rows || k == settings.rows {
            sections.push(section(&grid, &pair.phi, done));
        }
        observer.progress(&format!("graph: step {done} of {}", settings.steps));
        observer.frame(&Frame {
            series: "graph",
            step: done,
            time,
            volume: &grid.volume(&pair.phi),
        })?;
    }
    report.tables.push(table);
    let end = pair.flow.energy.energy(&pair.phi);
    claims(&mut report, settings, &pair.evolution, end, &apart);
    panels(&mut report, pair, &apart, sections);
    report.seconds = clock.elapsed().as_secs_f64();
    Ok(report)
}

/// Heights along y = ½.
fn section(grid: &SquareGrid, phi: &[f64], step: usize) -> Curve {
    let j = grid.cells() / 2;
    Curve {
        name: format!("step {step}"),
        points: (0..=grid.cells())
            .map(|i| (grid.position(i, j)[0], phi[grid.index(i, j)]))
            .collect(),
        dots: false,
    }
}

fn claims(
    report: &mut StudyReport,
    settings: &GraphSettings,
    evolution: &PlaneRun,
    end: f64,
    apart: &[Difference],
) {
    claim_fall(report, evolution);
    let paper = GraphSettings::default();
    if (settings.cells, settings.steps) == (paper.cells, paper.steps) {
        let got = [evolution.energies[0], end];
        report.claim(
            StatedBy::Reference,
            "energy at the start and the end",
            format!("{} -> {}, to 0.5 %", REFERENCE[0], REFERENCE[1]),
            format!("{:.2} -> {:.2}", got[0], got[1]),
            got.iter()
                .zip(REFERENCE)
                .all(|(g, r)| (g / r - 1.0).abs() < 5e-3),
        );
    }
    let worst = |f: &dyn Fn(&Difference) -> f64| apart.iter().map(f).fold(0.0, f64::max);
    let gentle = worst(&|d| d.gentle / d.height);
    report.claim(
        StatedBy::Paper,
        "difference from the parametric flow where the slope is below 2",
        "stays small: at most 5 % of the largest height".to_owned(),
        format!("{:.2} % at most", 100.0 * gentle),
        gentle < 0.05,
    );
    let cells = settings.cells as f64;
    let distance = worst(&|d| d.distance * cells);
    report.claim(
        StatedBy::Paper,
        "distance between the two surfaces",
        "stays small: at most h".to_owned(),
        format!("{distance:.2} h at most"),
        distance < 1.0,
    );
    report.remarks.push(
        "within about two cells of the clamped boundary the surface steepens to walls, where heights differ although the \
         surfaces do not; on these walls the two energies also depend on the grid"
            .to_owned(),
    );
}

fn panels(report: &mut StudyReport, pair: Pair, apart: &[Difference], sections: Vec<Curve>) {
    report
        .panels
        .push(chart("Section y = 1/2", ["x", "height"], sections));
    let every = pair.energies.len().div_ceil(500).max(1);
    report.panels.push(Panel::Chart(Chart {
        title: "Energy".to_owned(),
        axes: ["time", "energy"],
        logarithmic: [false, true],
        order: None,
        curves: vec![
            line("graph", pair.evolution.curve(pair.flow.tau)),
            line(
                "parametric",
                pair.energies.into_iter().step_by(every).collect(),
            ),
        ],
    }));
    let over_time = |name: &str, f: &dyn Fn(&Difference) -> f64| {
        line(name, apart.iter().map(|d| (d.time, f(d))).collect())
    };
    report.panels.push(chart(
        "Parametric surface against graph",
        ["time", "difference"],
        vec![
            over_time("L2 norm", &|d| d.l2),
            over_time("largest where slope < 2", &|d| d.gentle),
            over_time("largest distance", &|d| d.distance),
        ],
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_surface_has_no_difference() {
        let grid = SquareGrid::new(16, [0.0; 2], 1.0);
        let phi = grid.field(start);
        let d = difference(&grid, &phi, &triangulated(&grid, &phi), 0.0);
        assert!(d.l2 < 1e-12 && d.largest < 1e-12);
    }
}
