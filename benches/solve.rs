//! Benchmark of the level-set solve of one hole (initialisation, nested grids, all steps) from exact distances, at several resolutions.
//!
//! `cargo bench --bench solve -- 32 64 128` prints seconds, unknowns, steps and iterations for the catenoid's neck and a
//! spherical cap of 60 degrees.
//!
//! On two cores (November 2026), in seconds: catenoid 0.12, 0.39, 1.5 and 6.5 at 32, 64, 128 and 256 voxels across, cap
//! 0.11, 0.39, 1.7 and 8.6; 1 to 4 iterations a step; 558 MB at 256, 0.97 kB an unknown.

use std::time::Instant;

use glam::DVec3;
use isomend_core::flow::FlowSettings;
use isomend_core::grid::Lattice;
use isomend_core::region::{DistanceData, NestedSettings, NodeData, Start, solve_nested};

struct Shape {
    distance: fn(DVec3) -> f64,
}

impl DistanceData for Shape {
    fn sample(&self, x: DVec3, _limit: f64) -> NodeData {
        let d = (self.distance)(x);
        NodeData {
            signed: d,
            distance: d.abs(),
            free: x.length() < 1.0,
        }
    }
}

fn sphere(x: DVec3) -> f64 {
    let r = 1.0;
    (x + DVec3::new(0.6, 0.0, 0.8) * r).length() - r
}

fn catenoid(x: DVec3) -> f64 {
    let (r, z) = ((x.z + 1.0).hypot(x.x), x.y);
    let mut t = z;
    for _ in 0..60 {
        let (c, s) = (t.cosh(), t.sinh());
        let f = (c - r) * s + (t - z);
        let df = s * s + 1.0 + (c - r) * c;
        let step = (f / df.max(0.1)).clamp(-0.2, 0.2);
        t -= step;
        if step.abs() < 1e-15 {
            break;
        }
    }
    let d = (r - t.cosh()).hypot(z - t);
    if r > z.cosh() { d } else { -d }
}

fn main() {
    let wanted: Vec<f64> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let sizes = if wanted.is_empty() {
        vec![16.0, 32.0, 64.0]
    } else {
        wanted
    };
    println!("shape     D/h  seconds (sampling + solving)  unknowns  steps  iterations");
    for (name, distance) in [
        ("catenoid", catenoid as fn(DVec3) -> f64),
        ("sphere60", sphere),
    ] {
        for &across in &sizes {
            run(name, &Shape { distance }, across);
        }
    }
}

fn run(name: &str, shape: &Shape, across: f64) {
    let refinements = (across / 16.0).log2().max(0.0) as usize;
    let voxel = 2.0 / 16.0;
    let nodes = 36;
    let settings = NestedSettings {
        own: None,
        lattice: Lattice {
            origin: -DVec3::splat(17.5 * voxel) - voxel * DVec3::new(0.137, -0.251, 0.319),
            voxel,
        },
        dims: [nodes; 3],
        refinements,
        stop_if_unconverged: false,
        from: None,
        start: Start::Biharmonic,
        flow: FlowSettings::default().across(across),
        time: None,
    };
    let clock = Instant::now();
    let solved = solve_nested(shape, &settings, &|| true);
    let total = clock.elapsed().as_secs_f64();
    let sampling: f64 = solved.reports.iter().map(|r| r.seconds[0]).sum();
    let steps: Vec<usize> = solved.reports.iter().map(|r| r.flow.steps.len()).collect();
    let iterations: Vec<usize> = solved
        .reports
        .iter()
        .map(|r| r.flow.steps.iter().map(|s| s.iterations).sum())
        .collect();
    println!(
        "{name:9} {across:4}  {total:7.3} ({sampling:.3} + {:.3})  {:8}  {steps:?}  {iterations:?}{}",
        total - sampling,
        solved.reports.last().map_or(0, |r| r.flow.unknowns),
        if solved.converged() {
            ""
        } else {
            "  not converged"
        }
    );
}
