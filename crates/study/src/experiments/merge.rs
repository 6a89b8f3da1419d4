//! Figure 6 of the paper: two squares become round and merge into one oval.

use std::time::Instant;

use crate::contour::{components_inside, level_line};
use crate::evolution::PlaneRun;
use crate::grid::SquareGrid;
use crate::observer::{Frame, Observer, StudyError};
use crate::plane::PlaneEnergy;
use crate::report::{Chart, Levels, Panel, ResultTable, StatedBy, StudyReport};
use crate::step::{PlaneFlow, Tolerance};
use isomend_core::flow::Variant;

use super::{claim_fall, line};

/// Settings of the experiment.
#[derive(Clone, Debug)]
pub struct MergeSettings {
    /// Number of cells a side of the unit square.
    pub cells: usize,
    /// Total number of steps.
    pub steps: usize,
    /// Steps after which the level lines are drawn.
    pub drawn: Vec<usize>,
    /// The step by which the squares must have merged.
    pub merged_by: usize,
}

impl Default for MergeSettings {
    fn default() -> Self {
        Self {
            cells: 128,
            steps: 6000,
            drawn: vec![0, 100, 1000, 2000, 3000, 6000],
            merged_by: 3000,
        }
    }
}

/// Half the side of a square.
const HALF: f64 = 0.1;
/// Centres of the two squares.
const CENTRES: [[f64; 2]; 2] = [[0.365, 0.5], [0.635, 0.5]];
/// Time step in units of h⁴.
const TIME_STEP: f64 = 10.0;
/// ε in units of h.
const EPSILON: f64 = 5.0;
/// Largest number of steps between two measurements of the level lines.
const MEASURE_INTERVAL: usize = 50;

/// Signed distance to a square of half side [`HALF`] round `centre`.
fn square([x, y]: [f64; 2], centre: [f64; 2]) -> f64 {
    let (dx, dy) = ((x - centre[0]).abs() - HALF, (y - centre[1]).abs() - HALF);
    dx.max(0.0).hypot(dy.max(0.0)) + dx.max(dy).min(0.0)
}

/// Measurements of the inside of the zero line.
struct Measurement {
    components: usize,
    area: f64,
    /// Largest over smallest distance from the centre of a component to its boundary; the largest ratio of all components.
    roundness: f64,
    /// Area relative to the convex hull.
    convexity: f64,
}

/// The measurements of a run so far.
struct Record<'a> {
    settings: &'a MergeSettings,
    observer: &'a dyn Observer,
    grid: SquareGrid,
    tau: f64,
    table: ResultTable,
    panels: Vec<Panel>,
    /// The step since which there is one component.
    merged: Option<usize>,
    /// Roundness at step 100.
    round: Option<f64>,
}

impl Record<'_> {
    fn add(
        &mut self,
        done: usize,
        phi: &[f64],
        energy: &PlaneEnergy,
    ) -> Result<Measurement, StudyError> {
        let seen = measure(&self.grid, phi);
        self.merged = (seen.components == 1).then(|| self.merged.unwrap_or(done));
        if done == 100 {
            self.round = Some(seen.roundness);
        }
        let last = self.settings.steps;
        if self.settings.drawn.contains(&done) || done == last {
            self.observer.progress(&format!(
                "merge: step {done} of {last}, {} components",
                seen.components
            ));
            self.table.rows.push(vec![
                done.into(),
                energy.energy(phi).into(),
                seen.components.into(),
                seen.area.into(),
                seen.roundness.into(),
                seen.convexity.into(),
            ]);
            self.panels
                .push(Panel::Levels(drawn(&self.grid, phi, done)));
            self.observer.frame(&Frame {
                series: "merge",
                step: done,
                time: done as f64 * self.tau,
                volume: &self.grid.volume(phi),
            })?;
        }
        Ok(seen)
    }

    /// Number of steps until the next measurement.
    fn interval(&self, done: usize) -> usize {
        let drawn = self.settings.drawn.iter().filter(|&&d| d > done).min();
        let next = drawn.map_or(self.settings.steps, |&d| d.min(self.settings.steps));
        MEASURE_INTERVAL.min(next - done)
    }
}

/// Runs the experiment.
pub fn merge(settings: &MergeSettings, observer: &dyn Observer) -> Result<StudyReport, StudyError> {
    let clock = Instant::now();
    let mut report = StudyReport::new(
        "merge",
        "Figure 6: two squares under Willmore flow; variant II, epsilon = 5 h, time step 10 h^4, natural boundary, no redistancing",
    );
    let grid = SquareGrid::new(settings.cells, [0.0; 2], 1.0);
    let h = grid.h();
    let tau = TIME_STEP * h.powi(4);
    let mut phi = grid.field(|x| square(x, CENTRES[0]).min(square(x, CENTRES[1])));
    let energy = PlaneEnergy::natural(grid.clone(), EPSILON * h);
    let mut flow = PlaneFlow::new(energy, Variant::II, tau, Tolerance::OfState(1e-7));
    let mut evolution = PlaneRun::default();
    let columns = [
        "step",
        "energy",
        "components",
        "area",
        "farthest / nearest",
        "area / hull",
    ];
    let mut record = Record {
        settings,
        observer,
        grid,
        tau,
        table: ResultTable::new(&format!("h = 1/{}", settings.cells), &columns),
        panels: Vec::new(),
        merged: None,
        round: None,
    };
    let mut last = record.add(0, &phi, &flow.energy)?;
    while evolution.energies.len() < settings.steps {
        let steps = record.interval(evolution.energies.len());
        evolution.advance(&mut flow, &mut phi, steps, observer)?;
        last = record.add(evolution.energies.len(), &phi, &flow.energy)?;
    }
    claims(&mut report, &record, &evolution, &last);
    report.tables.push(record.table);
    report.panels = record.panels;
    report.panels.push(Panel::Chart(Chart {
        title: "Energy".to_owned(),
        axes: ["step", "energy"],
        logarithmic: [false, true],
        order: None,
        curves: vec![line("energy", evolution.curve(1.0))],
    }));
    report.remarks.push(format!(
        "{:.1} iterations per step",
        evolution.iterations_per_step()
    ));
    report.seconds = clock.elapsed().as_secs_f64();
    Ok(report)
}

fn claims(report: &mut StudyReport, record: &Record, evolution: &PlaneRun, last: &Measurement) {
    let (settings, merged) = (record.settings, record.merged);
    claim_fall(report, evolution);
    if let Some(r) = record.round {
        report.claim(
            StatedBy::Paper,
            "round by step 100",
            "largest over smallest distance of the boundary from the centre below 1.1 (a square: 1.414)".to_owned(),
            format!("{r:.3}"),
            r < 1.1,
        );
    }
    if settings.steps >= settings.merged_by {
        report.claim(
            StatedBy::Paper,
            "one component",
            format!("by step {}", settings.merged_by),
            merged.map_or("never".to_owned(), |s| format!("by step {s}")),
            merged.is_some_and(|s| s <= settings.merged_by),
        );
    }
    if settings.steps >= 2 * settings.merged_by {
        report.claim(
            StatedBy::Paper,
            &format!("a convex oval at step {}", settings.steps),
            "one component that fills its convex hull to 1 %".to_owned(),
            format!(
                "components: {}, {:.2} % of the hull",
                last.components,
                100.0 * last.convexity
            ),
            last.components == 1 && last.convexity > 0.99,
        );
    }
}

/// The zero line and twenty other level lines.
pub(super) fn drawn(grid: &SquareGrid, phi: &[f64], step: usize) -> Levels {
    let values = grid.strip(phi);
    let (low, high) = values
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    let thin = (1..=20)
        .flat_map(|k| level_line(grid, phi, low + (high - low) * f64::from(k) / 21.0))
        .collect();
    Levels {
        title: format!("step {step}"),
        square: (grid.origin(), grid.h() * grid.cells() as f64),
        thin,
        bold: level_line(grid, phi, 0.0),
    }
}

fn measure(grid: &SquareGrid, phi: &[f64]) -> Measurement {
    let components = components_inside(grid, phi);
    let line = level_line(grid, phi, 0.0);
    // While there are two components, x = ½ separates them.
    let sides: Vec<Vec<[f64; 2]>> = if components == 2 {
        [true, false]
            .map(|left| {
                line.iter()
                    .flatten()
                    .copied()
                    .filter(|p| (p[0] < 0.5) == left)
                    .collect()
            })
            .to_vec()
    } else {
        vec![line.iter().flatten().copied().collect()]
    };
    // Area by triangles from the centre to each segment. The segments have no common direction, so the triangles' absolute areas are
    // added; this needs components that are star-shaped about their centre.
    let area = line
        .iter()
        .map(|[p, q]| {
            let centre = if components == 2 {
                CENTRES[usize::from(p[0] > 0.5)]
            } else {
                [0.5, 0.5]
            };
            let cross =
                (p[0] - centre[0]) * (q[1] - centre[1]) - (p[1] - centre[1]) * (q[0] - centre[0]);
            0.5 * cross.abs()
        })
        .sum();
    let hull: f64 = sides.iter().map(|s| hull_area(s)).sum();
    Measurement {
        components,
        area,
        roundness: sides.iter().map(|s| spread(s)).fold(0.0, f64::max),
        convexity: if hull > 0.0 { area / hull } else { 0.0 },
    }
}

/// Largest over smallest distance of points from their mean.
fn spread(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let mean = points
        .iter()
        .fold([0.0; 2], |m, p| [m[0] + p[0] / n, m[1] + p[1] / n]);
    let (low, high) = points.iter().fold((f64::MAX, 0.0f64), |(l, h), p| {
        let r = (p[0] - mean[0]).hypot(p[1] - mean[1]);
        (l.min(r), h.max(r))
    });
    high / low
}

/// Area of the convex hull (Andrew's monotone chain).
fn hull_area(points: &[[f64; 2]]) -> f64 {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut out: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while out.len() > 1 && turn(out[out.len() - 2], out[out.len() - 1], p) <= 0.0 {
                out.pop();
            }
            out.push(p);
        }
        out
    };
    let mut hull = chain(&mut sorted.iter().copied());
    let upper = chain(&mut sorted.iter().rev().copied());
    hull.extend(upper);
    let n = hull.len();
    (0..n)
        .map(|k| {
            let (p, q) = (hull[k], hull[(k + 1) % n]);
            0.5 * (p[0] * q[1] - p[1] * q[0])
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_squares_are_measured() {
        let grid = SquareGrid::new(100, [0.0; 2], 1.0);
        let phi = grid.field(|x| square(x, CENTRES[0]).min(square(x, CENTRES[1])));
        let seen = measure(&grid, &phi);
        assert_eq!(seen.components, 2);
        assert!((seen.area - 0.08).abs() < 1e-3, "{}", seen.area);
        assert!(
            (seen.roundness - 2f64.sqrt()).abs() < 0.05,
            "{}",
            seen.roundness
        );
        assert!((seen.convexity - 1.0).abs() < 0.01, "{}", seen.convexity);
    }
}
