//! Willmore flow of closed surfaces in time: spheres stay, tori of revolution evolve to the Clifford torus, and sphere-like surfaces
//! become round.

use std::time::Instant;

use super::closed::{Closed, Field, Form, SIDE};
use super::{line, variant_name};
use crate::observer::{Observer, StudyError};
use crate::report::{Chart, Panel, ResultTable, StatedBy, StudyReport, TableCell};
use isomend_core::flow::{Evolution, FlowSettings, Pause, Variant};

/// Settings of the experiment.
#[derive(Clone, Debug)]
pub struct SurfacesSettings {
    /// Number of voxels across about the width of the torus.
    pub voxels: usize,
    /// The surfaces and their final times, in length⁴.
    pub runs: Vec<(Closed, f64)>,
    /// The time at which the variants are compared on the uneven sphere, in length⁴; 0 for no comparison.
    pub compared: f64,
}

impl Default for SurfacesSettings {
    fn default() -> Self {
        Self {
            voxels: 64,
            runs: vec![
                (Closed::Sphere, 0.3),
                (Closed::Wave, 0.02),
                (Closed::Torus, 0.6),
                (Closed::Uneven, 0.3),
                (Closed::Cube, 0.3),
            ],
            compared: 0.02,
        }
    }
}

/// Factor between the times of successive table rows.
const ROW_FACTOR: f64 = 2.0;
/// Time of the first row after the start, as a fraction of the final time.
const FIRST_ROW: f64 = 1e-3;

/// Decay rate of a wave of degree 2 on the unit sphere: waves of degree l on a sphere of radius R decay as
/// exp(−(l − 1) l (l + 1) (l + 2) t / R⁴).
const DECAY: f64 = 24.0;

/// One run.
struct SurfaceRun {
    rows: Vec<Vec<TableCell>>,
    evolution: Evolution,
    first: Form,
    last: Form,
    energies: Vec<(f64, f64)>,
    steady: bool,
    seconds: f64,
}

impl SurfaceRun {
    fn rises(&self) -> usize {
        let rises = |s: &&isomend_core::flow::EvolutionStep| s.energy_after > s.energy_before;
        self.evolution.steps.iter().filter(rises).count()
    }
}

/// Runs the experiment.
pub fn surfaces(
    settings: &SurfacesSettings,
    observer: &dyn Observer,
) -> Result<StudyReport, StudyError> {
    let clock = Instant::now();
    let mut report = StudyReport::new(
        "surfaces",
        "Willmore flow of closed surfaces in time; energy 1/2 int h^2, h the sum of the principal curvatures",
    );
    let mut curves = Vec::new();
    let voxel = SIDE / settings.voxels as f64;
    for &(surface, time) in &settings.runs {
        let run = evolve(
            surface,
            Variant::GaussNewton,
            time,
            settings.voxels,
            observer,
        )?;
        let measure = if surface == Closed::Torus {
            "R / r"
        } else {
            "unevenness"
        };
        let mut table = ResultTable::new(
            &format!(
                "{}, {:.1} voxels per unit of length",
                surface.name(),
                1.0 / voxel
            ),
            &[
                "time",
                "steps",
                "1/2 int h^2",
                "relative to steady state",
                "radius",
                measure,
            ],
        );
        table.rows.clone_from(&run.rows);
        report.tables.push(table);
        claims(&mut report, surface, &run, voxel);
        curves.push(line(surface.name(), run.energies.clone()));
    }
    if settings.compared > 0.0 {
        compare(&mut report, settings, observer)?;
    }
    report.panels.push(Panel::Chart(Chart {
        title: "Energy relative to the steady state".to_owned(),
        axes: ["time", "1/2 int h^2, over 8 pi or 4 pi^2"],
        logarithmic: [true, false],
        order: None,
        curves,
    }));
    report.remarks.push(
        "with H = h/2 the energies are int H^2: 4 pi for a sphere, 2 pi^2 for the Clifford torus"
            .to_owned(),
    );
    report.seconds = clock.elapsed().as_secs_f64();
    Ok(report)
}

/// The same evolution by the three schemes.
fn compare(
    report: &mut StudyReport,
    settings: &SurfacesSettings,
    observer: &dyn Observer,
) -> Result<(), StudyError> {
    let mut table = ResultTable::new(
        &format!(
            "uneven sphere at time {}, by each scheme",
            settings.compared
        ),
        &[
            "variant",
            "steps",
            "refused",
            "iterations",
            "1/2 int h^2",
            "unevenness",
            "radius",
            "s",
        ],
    );
    let mut ends = Vec::new();
    for variant in [Variant::I, Variant::II, Variant::GaussNewton] {
        let run = evolve(
            Closed::Uneven,
            variant,
            settings.compared,
            settings.voxels,
            observer,
        )?;
        let steps = &run.evolution.steps;
        table.rows.push(vec![
            variant_name(variant).into(),
            steps.len().into(),
            steps.iter().map(|s| s.refused).sum::<usize>().into(),
            steps.iter().map(|s| s.iterations).sum::<usize>().into(),
            run.evolution.willmore().into(),
            run.last.shape.into(),
            run.last.radius.into(),
            run.seconds.into(),
        ]);
        let rises = run.rises();
        report.claim(
            StatedBy::Theory,
            &format!("energy, variant {}", variant_name(variant)),
            "falls in every step".to_owned(),
            format!("{rises} rises in {} steps", steps.len()),
            rises == 0 && run.evolution.time >= settings.compared * (1.0 - 1e-9) / voxel4(settings),
        );
        ends.push(run.evolution.willmore());
    }
    report.tables.push(table);
    let spread = (ends.iter().copied().fold(0.0, f64::max)
        - ends.iter().copied().fold(f64::INFINITY, f64::min))
        / ends[2];
    report.claim(
        StatedBy::Project,
        "the schemes agree",
        "energies within 0.5 % of each other".to_owned(),
        format!("{:.3} %", 100.0 * spread),
        spread < 5e-3,
    );
    Ok(())
}

fn voxel4(settings: &SurfacesSettings) -> f64 {
    (SIDE / settings.voxels as f64).powi(4)
}

fn claims(report: &mut StudyReport, surface: Closed, run: &SurfaceRun, voxel: f64) {
    let name = surface.name();
    let rises = run.rises();
    report.claim(
        StatedBy::Theory,
        &format!("{name}: energy"),
        "falls in every step".to_owned(),
        format!(
            "{rises} rises in {} steps{}",
            run.evolution.steps.len(),
            if run.steady {
                ""
            } else {
                ", not steady after them"
            }
        ),
        rises == 0 && run.steady,
    );
    claim_energy(report, surface, run);
    let (first, last) = (run.first, run.last);
    match surface {
        Closed::Sphere => report.claim(
            StatedBy::Theory,
            "sphere: stays",
            "its radius changes by less than 0.1 h".to_owned(),
            format!("{:.4} h", (last.radius - 1.0).abs() / voxel),
            (last.radius - 1.0).abs() < 0.1 * voxel,
        ),
        Closed::Wave => {
            let time = run.evolution.time * voxel.powi(4);
            let rate = (first.shape / last.shape).ln() / time;
            report.claim(
                StatedBy::Theory,
                "sphere with a wave: decays as linear theory says",
                format!("at the rate {DECAY:.0} within 10 %"),
                format!("{rate:.2}"),
                (rate / DECAY - 1.0).abs() < 0.1,
            );
        }
        Closed::Torus => report.claim(
            StatedBy::Theory,
            "torus: evolves to the Clifford torus",
            "R / r to 1.4142 within 2 %".to_owned(),
            format!("{:.4} -> {:.4}", first.shape, last.shape),
            (last.shape / 2f64.sqrt() - 1.0).abs() < 0.02,
        ),
        Closed::Uneven | Closed::Cube => report.claim(
            StatedBy::Theory,
            &format!("{name}: becomes round"),
            "unevenness below 0.1 h".to_owned(),
            format!(
                "{:.4} -> {:.4}, {:.4} h",
                first.shape,
                last.shape,
                last.shape * last.radius / voxel
            ),
            last.shape * last.radius < 0.1 * voxel,
        ),
    }
}

/// The energy at the end beside the energy of the surface that theory says it becomes.
fn claim_energy(report: &mut StudyReport, surface: Closed, run: &SurfaceRun) {
    let over = run.evolution.willmore() / surface.steady_energy() - 1.0;
    let most = 0.015;
    let what = if surface == Closed::Torus {
        "4 pi^2"
    } else {
        "8 pi"
    };
    report.claim(
        StatedBy::Theory,
        &format!("{}: energy at the end", surface.name()),
        format!("{what} within {:.1} %", 100.0 * most),
        format!("{:+.2} %", 100.0 * over),
        over.abs() < most,
    );
}

/// Evolves a surface to a time, and measures it at growing intervals.
fn evolve(
    surface: Closed,
    variant: Variant,
    time: f64,
    voxels: usize,
    observer: &dyn Observer,
) -> Result<SurfaceRun, StudyError> {
    let clock = Instant::now();
    let mut field = Field::new(surface, voxels);
    // All nodes are free but a margin at the boundary of the lattice.
    let mask: Vec<bool> = (0..field.grid.len())
        .map(|s| field.grid.is_interior(field.grid.node(s), 3))
        .collect();
    let voxel = field.lattice.voxel;
    let mut evolution = Evolution::new(
        FlowSettings {
            variant,
            ..FlowSettings::default()
        }
        .across(2.0 / voxel),
    );
    // The flow's time is in voxels⁴, the tables' in length⁴.
    let unit = voxel.powi(4);
    let first = field.form();
    let mut rows = Vec::new();
    let mut next = FIRST_ROW * time;
    loop {
        let pause = evolution.run(&field.grid, &mut field.phi, &mask, next / unit, &mut |_| {
            observer.keep_going()
        });
        if pause == Pause::Stopped {
            return Err(StudyError::Stopped);
        }
        if rows.is_empty() {
            rows.push(row(0.0, 0, evolution.willmore_before, surface, first));
        }
        let now = field.form();
        let (at, done) = (evolution.time * unit, evolution.steps.len());
        rows.push(row(at, done, evolution.willmore(), surface, now));
        field.report(&evolution, now, observer)?;
        // End at the final time, or if the flow could not go on.
        if pause != Pause::Done || next >= time {
            let energies = evolution
                .steps
                .iter()
                .map(|s| (s.time * unit, s.willmore / surface.steady_energy()));
            return Ok(SurfaceRun {
                rows,
                energies: energies.collect(),
                first,
                last: now,
                steady: pause == Pause::Done,
                evolution,
                seconds: clock.elapsed().as_secs_f64(),
            });
        }
        next = (ROW_FACTOR * next).min(time);
    }
}

fn row(time: f64, steps: usize, energy: f64, surface: Closed, form: Form) -> Vec<TableCell> {
    vec![
        time.into(),
        steps.into(),
        energy.into(),
        (energy / surface.steady_energy()).into(),
        form.radius.into(),
        form.shape.into(),
    ]
}
