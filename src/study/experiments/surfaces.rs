//! Closed surfaces that evolve in time: spheres stay, tori of revolution go to the Clifford torus, and what is of the kind
//! of a sphere becomes round.

use std::f64::consts::PI;
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use super::{line, variant_name};
use crate::flow::{Evolution, FlowSettings, Pause, Variant};
use crate::grid::{Lattice, SparseGrid, Volume, as_point};
use crate::mesh::bounds;
use crate::sdf::project_on_zero_set;
use crate::study::observer::{Frame, Observer, StudyError};
use crate::study::report::{Cell, Chart, Panel, StudyReport, Table};

/// Settings of the experiment.
#[derive(Clone, Debug)]
pub struct SurfacesSettings {
    /// Voxels to the length `SIDE`, about that of the torus.
    pub voxels: usize,
    /// The surfaces and how long they evolve, in length⁴.
    pub runs: Vec<(Closed, f64)>,
    /// The time after which the variants are compared on the uneven sphere.
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

/// About the width of the torus.
pub const SIDE: f64 = 3.4;
/// Voxels round the boxes, for the band and nodes that are held.
const MARGIN: f64 = 8.0;
/// The tables have a row whenever the time has grown by this factor.
const LOOK: f64 = 2.0;
/// The first row after the start, of the whole time.
const FIRST_LOOK: f64 = 1e-3;

/// A closed surface at time 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closed {
    /// The unit sphere.
    Sphere,
    /// The unit sphere with a wave of degree 2 of 2.5 % of its radius up and down.
    Wave,
    /// The torus of revolution of radii 1 and ½.
    Torus,
    /// The unit sphere with harmonics of degree 2 and 3 of 15 % of its radius.
    Uneven,
    /// The cube of side 1.7.
    Cube,
}

impl Closed {
    fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Wave => "sphere with a wave",
            Self::Torus => "torus",
            Self::Uneven => "uneven sphere",
            Self::Cube => "cube",
        }
    }

    /// A function that is negative inside, with slopes of about 1.
    fn level(self, p: DVec3) -> f64 {
        match self {
            Self::Sphere => p.length() - 1.0,
            Self::Wave => {
                let n = p.normalize_or(DVec3::X);
                p.length() - (1.0 + 0.05 * n.y * n.z)
            }
            Self::Torus => (p.x.hypot(p.y) - 1.0).hypot(p.z) - 0.5,
            Self::Uneven => {
                let n = p.normalize_or(DVec3::X);
                let waves = n.y * n.z + 0.4 * n.x * (n.x * n.x - 3.0 * n.y * n.y);
                p.length() - (1.0 + 0.15 * waves)
            }
            Self::Cube => {
                let out = p.abs() - DVec3::splat(0.85);
                out.max(DVec3::ZERO).length() + out.max_element().min(0.0)
            }
        }
    }

    /// Half the sides of a box that it never leaves.
    fn reach(self) -> DVec3 {
        match self {
            Self::Torus => DVec3::new(1.55, 1.55, 0.75),
            _ => DVec3::splat(1.22),
        }
    }

    /// ½∫h² of the steady state: 8π for a sphere, 4π² for the Clifford torus (with H = h/2 these are ∫H² = 4π and 2π²).
    fn steady_energy(self) -> f64 {
        match self {
            Self::Torus => 4.0 * PI * PI,
            _ => 8.0 * PI,
        }
    }
}

/// A wave of degree l on a sphere of radius R decays as exp(−(l − 1) l (l + 1) (l + 2) t / R⁴).
const DECAY: f64 = 24.0;

/// What the zero set looks like.
#[derive(Clone, Copy, Debug)]
struct Form {
    /// Mean radius; of a torus that of its middle circle.
    radius: f64,
    /// Half the difference of the largest and the smallest radius, over the mean; of a torus the ratio of its two radii.
    shape: f64,
}

/// One run.
struct Run {
    rows: Vec<Vec<Cell>>,
    evolution: Evolution,
    first: Form,
    last: Form,
    energies: Vec<(f64, f64)>,
    steady: bool,
    seconds: f64,
}

impl Run {
    fn rises(&self) -> usize {
        let rises = |s: &&crate::flow::EvolutionStep| s.energy_after > s.energy_before;
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
        "Closed surfaces in time: Willmore flow of 1/2 int h^2, h the sum of the principal curvatures",
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
        let mut table = Table::new(
            &format!(
                "{}, {:.1} voxels to the unit of length",
                surface.name(),
                1.0 / voxel
            ),
            &[
                "time",
                "steps",
                "1/2 int h^2",
                "over the steady",
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
        title: "Energy over that of the steady state".to_owned(),
        axes: ["time", "1/2 int h^2, over 8 pi or 4 pi^2"],
        logarithmic: [true, false],
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
    let mut table = Table::new(
        &format!(
            "uneven sphere at the time {}, by each scheme",
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

fn claims(report: &mut StudyReport, surface: Closed, run: &Run, voxel: f64) {
    let name = surface.name();
    let rises = run.rises();
    report.claim(
        &format!("{name}: energy"),
        "falls in every step".to_owned(),
        format!("{rises} rises in {} steps", run.evolution.steps.len()),
        rises == 0 && run.steady,
    );
    let over = run.evolution.willmore() / surface.steady_energy() - 1.0;
    let most = 0.015;
    let what = if surface == Closed::Torus {
        "4 pi^2"
    } else {
        "8 pi"
    };
    report.claim(
        &format!("{name}: energy at the end"),
        format!("{what} within {:.1} %", 100.0 * most),
        format!("{:+.2} %", 100.0 * over),
        over.abs() < most,
    );
    let (first, last) = (run.first, run.last);
    match surface {
        Closed::Sphere => report.claim(
            "sphere: stays",
            "its radius changes by less than 0.1 h".to_owned(),
            format!("{:.4} h", (last.radius - 1.0).abs() / voxel),
            (last.radius - 1.0).abs() < 0.1 * voxel,
        ),
        Closed::Wave => {
            let time = run.evolution.time * voxel.powi(4);
            let rate = (first.shape / last.shape).ln() / time;
            report.claim(
                "sphere with a wave: decays as linear theory says",
                format!("at the rate {DECAY:.0} within 10 %"),
                format!("{rate:.2}"),
                (rate / DECAY - 1.0).abs() < 0.1,
            );
        }
        Closed::Torus => report.claim(
            "torus: goes to the Clifford torus",
            "R / r to 1.4142 within 2 %".to_owned(),
            format!("{:.4} -> {:.4}", first.shape, last.shape),
            (last.shape / 2f64.sqrt() - 1.0).abs() < 0.02,
        ),
        Closed::Uneven | Closed::Cube => report.claim(
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

/// Lets a surface evolve.
fn evolve(
    surface: Closed,
    variant: Variant,
    time: f64,
    voxels: usize,
    observer: &dyn Observer,
) -> Result<Run, StudyError> {
    let clock = Instant::now();
    let voxel = SIDE / voxels as f64;
    let half = surface.reach() + MARGIN * voxel;
    let dims = (2.0 * half / voxel).to_array().map(|n| n.ceil() as i32 + 1);
    // The lattice has no plane in common with the surface's symmetries.
    let lattice = Lattice {
        origin: -half + voxel * DVec3::new(0.137, -0.251, 0.319),
        voxel,
    };
    let grid = SparseGrid::new(dims, |_| true);
    let mask: Vec<bool> = (0..grid.len())
        .map(|s| grid.is_interior(grid.node(s), 3))
        .collect();
    let position = |s: usize| lattice.to_world(as_point(grid.node(s)));
    let mut phi: Vec<f64> = (0..grid.len())
        .map(|s| surface.level(position(s)) / voxel)
        .collect();
    let mut evolution = Evolution::new(
        FlowSettings {
            variant,
            ..FlowSettings::default()
        }
        .across(2.0 / voxel),
    );
    let unit = voxel.powi(4);
    let first = form(surface, &grid, &phi, &lattice);
    let mut rows = Vec::new();
    let mut next = FIRST_LOOK * time;
    let mut steady = true;
    loop {
        let mut steps = 0;
        let pause = evolution.run(&grid, &mut phi, &mask, next / unit, &mut |_| {
            steps += 1;
            observer.keep_going()
        });
        if pause == Pause::Stopped {
            return Err(StudyError::Stopped);
        }
        if rows.is_empty() {
            rows.push(row(0.0, 0, evolution.willmore_before, surface, first));
        }
        let now = form(surface, &grid, &phi, &lattice);
        let done = evolution.steps.len();
        let at = evolution.time * unit;
        rows.push(row(at, done, evolution.willmore(), surface, now));
        observer.progress(&format!(
            "{}, {}: time {at:.2e}, step {done}, 1/2 int h^2 {:.4}, {:.5}",
            surface.name(),
            variant_name(variant),
            evolution.willmore(),
            now.shape
        ));
        let series = format!(
            "surfaces-{}-{}",
            surface.name().replace(' ', "-"),
            variant_name(variant)
        );
        observer.frame(&Frame {
            series: &series,
            step: done,
            time: at,
            volume: &volume(&grid, &phi, &lattice),
        })?;
        if pause != Pause::Done || next >= time {
            steady &= pause == Pause::Done;
            let energies = evolution
                .steps
                .iter()
                .map(|s| (s.time * unit, s.willmore / surface.steady_energy()));
            return Ok(Run {
                rows,
                energies: energies.collect(),
                first,
                last: now,
                steady,
                evolution,
                seconds: clock.elapsed().as_secs_f64(),
            });
        }
        next = (LOOK * next).min(time);
    }
}

fn row(time: f64, steps: usize, energy: f64, surface: Closed, form: Form) -> Vec<Cell> {
    vec![
        time.into(),
        steps.into(),
        energy.into(),
        (energy / surface.steady_energy()).into(),
        form.radius.into(),
        form.shape.into(),
    ]
}

/// The form of the zero set, from the feet of the nodes beside it.
fn form(surface: Closed, grid: &SparseGrid, phi: &[f64], lattice: &Lattice) -> Form {
    let feet: Vec<DVec3> = (0..grid.len())
        .into_par_iter()
        .filter(|&s| phi[s].abs() < 0.9)
        .filter_map(|s| {
            let x = as_point(grid.node(s));
            project_on_zero_set(grid, phi, x, x).map(|p| lattice.to_world(p))
        })
        .collect();
    let centre = feet.iter().sum::<DVec3>() / feet.len().max(1) as f64;
    let extremes = |values: &dyn Fn(&DVec3) -> f64| {
        feet.iter()
            .map(values)
            .fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), v| {
                (low.min(v), high.max(v))
            })
    };
    if surface == Closed::Torus {
        let (low, high) = extremes(&|p| (*p - centre).truncate().length());
        return Form {
            radius: 0.5 * (low + high),
            shape: (low + high) / (high - low),
        };
    }
    // The middle of the extremes, which does not depend on how the feet are spread.
    let (low, high) = bounds(feet.iter().copied());
    let middle = 0.5 * (low + high);
    let (low, high) = extremes(&|p| p.distance(middle));
    Form {
        radius: 0.5 * (low + high),
        shape: (high - low) / (high + low),
    }
}

/// φ in units of length, as a volume.
fn volume(grid: &SparseGrid, phi: &[f64], lattice: &Lattice) -> Volume {
    let dims = grid.dims().map(|n| n as usize);
    let mut values = vec![0.0; dims.iter().product()];
    for (s, v) in phi.iter().enumerate() {
        let [i, j, k] = grid.node(s).map(|n| n as usize);
        values[(k * dims[1] + j) * dims[0] + i] = v * lattice.voxel;
    }
    Volume {
        dims,
        origin: lattice.origin,
        spacing: DVec3::splat(lattice.voxel),
        values,
    }
}
