//! Benchmarks of a complete fill: against the hole's size in voxels, the mesh's size, and the number of holes.
//!
//! Medians on two cores of a shared machine under load (November 2026), in seconds: 16, 32, 64 and 128 voxels across 0.85,
//! 1.4, 3.5 and 7.9; five holes of equal size in 11 393 and 99 630 triangles 1.7 and 2.8.

mod common;

use criterion::{Criterion, criterion_group, criterion_main};
use isomend::{FillParams, Mesh, VoxelSize, fill};

fn run(mesh: &Mesh, params: &FillParams) {
    let filled = fill(mesh, params).expect("a sound mesh");
    assert!(!filled.report.incomplete());
}

/// A cap of a ball, 60 degrees across; its rim is a circle of radius one half.
fn voxels(criterion: &mut Criterion) {
    let mesh = common::open_ball(30);
    let mut group = common::group(criterion, "fill, voxels across");
    for across in [16, 32, 64, 128] {
        let mut params = FillParams::default();
        params.voxel = VoxelSize::Length(1.0 / f64::from(across));
        group.bench_function(across.to_string(), |b| b.iter(|| run(&mesh, &params)));
    }
}

/// Five holes of the same size, with the same voxel, in finer and finer meshes.
fn triangles(criterion: &mut Criterion) {
    let mut group = common::group(criterion, "fill, triangles");
    for n in [24, 71, 224] {
        let mesh = common::with_holes(n, 5, 0.995);
        let mut params = FillParams::default();
        params.voxel = VoxelSize::Length(0.2 / 32.0);
        group.bench_function(mesh.faces.len().to_string(), |b| {
            b.iter(|| run(&mesh, &params))
        });
    }
}

/// Holes of the same size spread over a ball.
fn holes(criterion: &mut Criterion) {
    let mut group = common::group(criterion, "fill, holes");
    for count in [1u32, 10, 100] {
        let mesh = common::with_holes(60, count, 0.997);
        let params = FillParams::default();
        group.bench_function(count.to_string(), |b| b.iter(|| run(&mesh, &params)));
    }
}

criterion_group!(benches, voxels, triangles, holes);
criterion_main!(benches);
