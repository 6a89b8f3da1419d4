//! Shared code of the benchmarks: meshes, and groups that take seconds instead of minutes.
#![allow(dead_code)] // Each bench uses some of it.

use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, SamplingMode};
use isomend::Mesh;
use isomend::glam::DVec3;

#[path = "../../tests/common/shapes.rs"]
pub mod shapes;

/// Ten samples of one or a few runs each.
pub fn group<'c>(criterion: &'c mut Criterion, name: &str) -> BenchmarkGroup<'c, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group
        .sample_size(10)
        .sampling_mode(SamplingMode::Flat)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    group
}

/// A ball of about a million triangles (1 003 520 before the cut) with five round holes; its coordinates are exact in 32-bit floats.
pub fn million() -> Mesh {
    let mut mesh = with_holes(224, 5, 0.995);
    for p in &mut mesh.positions {
        *p = p.as_vec3().as_dvec3();
    }
    mesh
}

/// A ball with `count` holes spread over it, an icosahedron with its edges divided into `n`. `cosine` is the cosine of a hole's angular
/// radius.
pub fn with_holes(n: u32, count: u32, cosine: f64) -> Mesh {
    // Centres on a Fibonacci spiral.
    let turn = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let centre = |i: u32| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let (y, x) = (turn * f64::from(i)).sin_cos();
        (DVec3::new(x, y, 0.0) * (1.0 - z * z).sqrt()) + z * DVec3::Z
    };
    let centres: Vec<DVec3> = (0..count).map(centre).collect();
    shapes::cut(&shapes::sphere(n), |p| {
        centres.iter().any(|c| p.normalize().dot(*c) > cosine)
    })
}

/// A ball without a cap 60 degrees across, an icosahedron with its edges divided into `n`.
pub fn open_ball(n: u32) -> Mesh {
    let rim = 30f64.to_radians().cos();
    shapes::turned(shapes::cut(&shapes::sphere(n), |p| p.z > rim))
}
