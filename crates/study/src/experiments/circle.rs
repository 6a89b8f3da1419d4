//! Figures 2 and 3 of the paper: a circle grows under Willmore flow, `r(t) = (2t + r0⁴)^¼`.
//!
//! Circle, square and grid share two axes of symmetry, so only a quarter is computed.

use std::time::Instant;

use crate::contour::level_line;
use crate::evolution::PlaneRun;
use crate::grid::SquareGrid;
use crate::mirror::Mirrored;
use crate::observer::{Frame, Observer, StudyError};
use crate::plane::PlaneEnergy;
use crate::redistance::{keeps_rule, redistance_at, redistance_interval, zero_points};
use crate::report::{Curve, Levels, Panel, ResultTable, StatedBy, StudyReport};
use crate::spline::Spline;
use crate::step::{PlaneFlow, Tolerance};
use isomend_core::flow::Variant;

use super::{chart, line, variant_name};

/// Settings of the experiment.
#[derive(Clone, Debug)]
pub struct CircleSettings {
    /// Number of cells a side and scheme of each run.
    pub runs: Vec<(usize, Variant)>,
    /// Initial radius, and the exact radius at which the run ends.
    pub radii: [f64; 2],
    /// Number of steps between redistancings; none to derive it from the grid.
    pub interval: Option<usize>,
    /// Time step in units of h⁴.
    pub time_step: f64,
    /// Number of table rows per run, about.
    pub rows: usize,
}

impl Default for CircleSettings {
    fn default() -> Self {
        Self {
            runs: vec![(128, Variant::I), (64, Variant::I), (64, Variant::II)],
            radii: [0.13, 0.2],
            interval: None,
            time_step: 10.0,
            rows: 10,
        }
    }
}

/// Used fraction of the largest interval that the rule allows; at the rule's bound the error starts to show.
const MARGIN: f64 = 0.5;

/// One measurement of the zero line.
#[derive(Clone, Copy, Debug)]
struct Sample {
    step: usize,
    time: f64,
    exact: f64,
    mean: f64,
    /// Largest distance of a point from the exact circle.
    largest: f64,
}

struct CircleRun {
    cells: usize,
    variant: Variant,
    interval: usize,
    rule: bool,
    samples: Vec<Sample>,
    evolution: PlaneRun,
    start: Vec<[[f64; 2]; 2]>,
    end: Vec<[[f64; 2]; 2]>,
}

fn run_one(
    settings: &CircleSettings,
    cells: usize,
    variant: Variant,
    observer: &dyn Observer,
) -> Result<CircleRun, StudyError> {
    let square = Mirrored::new(cells);
    let grid = &square.whole;
    let h = grid.h();
    let tau = settings.time_step * h.powi(4);
    let [first, last] = settings.radii;
    // Interval of redistancing, and number of steps to the final radius.
    let allowed = redistance_interval(tau, first);
    let interval = settings
        .interval
        .unwrap_or_else(|| ((allowed as f64 * MARGIN) as usize).max(1));
    let steps = ((last.powi(4) - first.powi(4)) / (2.0 * tau)).ceil() as usize;
    let start = grid.field(|[x, y]| x.hypot(y) - first);
    let mut phi = square.fold(&start);
    let energy = PlaneEnergy::natural(square.part.clone(), h * h);
    let mut flow = PlaneFlow::new(energy, variant, tau, Tolerance::OfState(1e-9));
    let mut evolution = PlaneRun::default();
    let mut samples = Vec::new();
    let series = format!("circle-{cells}-{}", variant_name(variant));
    let mut done = 0;
    let mut kept = 0;
    // Evolve for one interval, measure the zero line, and redistance. About twenty fields are stored.
    while done < steps {
        let part = interval.min(steps - done);
        evolution.advance(&mut flow, &mut phi, part, observer)?;
        done += part;
        let time = done as f64 * tau;
        let exact = (2.0 * time + first.powi(4)).powf(0.25);
        let whole = square.unfold(&phi);
        samples.push(measure(grid, &whole, done, time, exact)?);
        if done * 20 / steps > kept {
            kept = done * 20 / steps;
            observer.frame(&Frame {
                series: &series,
                step: done,
                time,
                volume: &grid.volume(&whole),
            })?;
            observer.progress(&format!("{series}: step {done} of {steps}"));
        }
        let distances = redistance_at(grid, &whole, square.nodes());
        phi = square.fold(&distances.ok_or(StudyError::NoZeroLine { step: done })?);
        flow.restart();
    }
    Ok(CircleRun {
        cells,
        variant,
        interval,
        rule: keeps_rule(interval, tau, first),
        samples,
        evolution,
        start: level_line(grid, &start, 0.0),
        end: level_line(grid, &square.unfold(&phi), 0.0),
    })
}

fn measure(
    grid: &SquareGrid,
    phi: &[f64],
    step: usize,
    time: f64,
    exact: f64,
) -> Result<Sample, StudyError> {
    let points = zero_points(grid, phi, &Spline::new(grid, phi));
    if points.is_empty() {
        return Err(StudyError::NoZeroLine { step });
    }
    let radii = || points.iter().map(|[x, y]| x.hypot(*y));
    Ok(Sample {
        step,
        time,
        exact,
        mean: radii().sum::<f64>() / points.len() as f64,
        largest: radii().fold(0.0, |m, r| f64::max(m, (r - exact).abs())),
    })
}

/// Runs the experiment; the runs share the threads.
pub fn circle(
    settings: &CircleSettings,
    observer: &dyn Observer,
) -> Result<StudyReport, StudyError> {
    let clock = Instant::now();
    let mut report = StudyReport::new(
        "circle",
        &format!(
            "Figures 2 and 3: a circle under Willmore flow, r(t) = (2 t + r0^4)^(1/4); \
             epsilon = h^2, time step {} h^4, natural boundary; computed on a quarter and mirrored",
            settings.time_step
        ),
    );
    let runs = super::in_parallel(&settings.runs, |&(cells, variant)| {
        run_one(settings, cells, variant, observer)
    })?;
    for run in &runs {
        add_run(&mut report, settings, run);
    }
    panels(&mut report, &runs);
    report.seconds = clock.elapsed().as_secs_f64();
    Ok(report)
}

fn run_name(run: &CircleRun) -> String {
    format!("h = 1/{}, variant {}", run.cells, variant_name(run.variant))
}

fn panels(report: &mut StudyReport, runs: &[CircleRun]) {
    let Some(longest) = runs.iter().max_by_key(|r| r.samples.len()) else {
        return;
    };
    let exact = longest.samples.iter().map(|s| (s.time, s.exact)).collect();
    let mut curves = vec![line("exact", exact)];
    curves.extend(runs.iter().map(|run| Curve {
        name: run_name(run),
        points: thinned(&run.samples).map(|s| (s.time, s.mean)).collect(),
        dots: true,
    }));
    let errors = runs.iter().map(|run| {
        let scaled = |s: &Sample| (s.time, (s.mean - s.exact) * run.cells as f64);
        line(&run_name(run), run.samples.iter().map(scaled).collect())
    });
    let errors = errors.collect();
    report
        .panels
        .push(chart("Radius of the circle", ["time", "radius"], curves));
    report.panels.push(chart(
        "Error of the mean radius, in h",
        ["time", "error / h"],
        errors,
    ));
    report.panels.push(Panel::Levels(Levels {
        title: format!("First and last circle, h = 1/{}", longest.cells),
        square: ([-0.5; 2], 1.0),
        thin: longest.start.clone(),
        bold: longest.end.clone(),
    }));
}

/// At most forty samples of a run, at equal intervals.
fn thinned(samples: &[Sample]) -> impl Iterator<Item = &Sample> {
    let every = samples.len().div_ceil(40).max(1);
    samples.iter().step_by(every)
}

fn add_run(report: &mut StudyReport, settings: &CircleSettings, run: &CircleRun) {
    let name = format!("h = 1/{}, variant {}", run.cells, variant_name(run.variant));
    let mut table = ResultTable::new(
        &format!(
            "{name}: redistanced every {} steps; {} steps, {:.1} iterations per step",
            run.interval,
            run.evolution.energies.len(),
            run.evolution.iterations_per_step(),
        ),
        &[
            "step",
            "time",
            "exact radius",
            "mean radius",
            "error / h",
            "largest deviation / h",
        ],
    );
    let h = 1.0 / run.cells as f64;
    let every = run.samples.len().div_ceil(settings.rows).max(1);
    for (k, s) in run.samples.iter().enumerate() {
        if (k + 1) % every == 0 || k + 1 == run.samples.len() {
            table.rows.push(vec![
                s.step.into(),
                s.time.into(),
                s.exact.into(),
                s.mean.into(),
                ((s.mean - s.exact) / h).into(),
                (s.largest / h).into(),
            ]);
        }
    }
    report.tables.push(table);
    let worst = run.samples.iter().fold(0.0, |m, s| f64::max(m, s.largest)) / h;
    let got = format!("{worst:.3} h");
    if run.variant == Variant::I {
        report.claim(
            StatedBy::Theory,
            &format!("{name}: deviation from the exact circle over the whole run"),
            "at most 0.1 h".to_owned(),
            got,
            worst <= 0.1,
        );
    } else {
        report.remarks.push(format!(
            "{name}: deviation from the exact circle at most {got} over the whole run"
        ));
    }
    if !run.rule {
        report.remarks.push(format!(
            "{name}: redistancing every {} steps violates the rule (2 K tau)^(1/4) < 0.45 r0",
            run.interval
        ));
    }
    if run.evolution.unsolved > 0 {
        report.remarks.push(format!(
            "{name}: in {} steps the linear system was not solved to its tolerance",
            run.evolution.unsolved
        ));
    }
}
