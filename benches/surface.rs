//! Benchmarks of marching cubes on a dense volume, and of stitching a patch.
//!
//! Medians on two cores of a shared machine (November 2026), in seconds: the gyroid (2.52 million triangles) 0.120, the ball
//! (0.39 million) 0.038, where VTK 9.7's FlyingEdges3D with two threads took 0.106 and 0.037 in the same minute; patches of
//! 800 faces 0.020, of 7062 faces 0.172.

mod common;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use isomend::Volume;
use isomend::glam::DVec3;
use isomend::level_surface;
use isomend::{Inspection, Mesh};
use isomend_core::sdf::Surface;
use isomend_core::sdf::{RimSet, Sampler};
use isomend_core::stitch::{StitchInput, StitchParams, stitch};

/// The values of a function on `nodes`³ nodes of the cube from −`half` to `half`.
fn volume(nodes: usize, half: f64, value: impl Fn(DVec3) -> f64) -> Volume {
    let mut out = Volume {
        dims: [nodes; 3],
        origin: DVec3::splat(-half),
        spacing: DVec3::splat(2.0 * half / (nodes - 1) as f64),
        values: Vec::with_capacity(nodes.pow(3)),
    };
    for node in 0..nodes.pow(3) {
        let [i, j, k] = [node % nodes, node / nodes % nodes, node / nodes.pow(2)];
        let p = out.position(DVec3::new(i as f64, j as f64, k as f64));
        out.values.push(value(p));
    }
    out
}

/// A gyroid of four periods and a ball, in 256³ nodes.
fn extraction(criterion: &mut Criterion) {
    let gyroid = |p: DVec3| p.x.sin() * p.y.cos() + p.y.sin() * p.z.cos() + p.z.sin() * p.x.cos();
    let periods = 4.0 * std::f64::consts::PI;
    let mut group = common::group(criterion, "marching cubes");
    for (name, field) in [
        ("gyroid", volume(256, periods, gyroid)),
        ("ball", volume(256, 1.25, |p| p.length() - 1.0)),
    ] {
        let surface = || level_surface(&field, 0.0, false).expect("a surface");
        group.throughput(Throughput::Elements(surface().faces.len() as u64));
        group.bench_function(name, |b| b.iter(surface));
    }
}

/// The unit sphere as the exact surface to which a patch is stitched.
struct Ball<'a> {
    sampler: &'a Sampler<'a>,
    rims: &'a RimSet,
}

impl Surface for Ball<'_> {
    fn project(&self, p: DVec3) -> Option<(DVec3, DVec3)> {
        p.try_normalize().map(|n| (n, n))
    }

    fn depth(&self, p: DVec3) -> f64 {
        match self.sampler.closest_of_all(self.rims, p) {
            Some((closest, true)) => closest.distance,
            Some((closest, false)) => -closest.distance,
            None => f64::INFINITY,
        }
    }
}

/// Stitches a patch for the ball's missing cap; an icosahedron's edges are divided into `n`.
fn stitching(criterion: &mut Criterion) {
    let mut group = common::group(criterion, "stitching");
    for (n, nodes) in [(20, 48), (60, 144)] {
        let found = Inspection::new(common::open_ball(n)).expect("a sound mesh");
        let sampler = Sampler::new(&found.mesh, &found.topology);
        let rims = RimSet::new(found.holes.iter());
        let field = volume(nodes, 1.25, |p| p.length() - 1.0);
        let extracted: Mesh = level_surface(&field, 0.0, false).expect("a surface");
        let input = StitchInput {
            mesh: &found.mesh,
            loops: &[found.holes[0].rim.clone()],
            surface: &Ball {
                sampler: &sampler,
                rims: &rims,
            },
            extracted: &extracted,
            voxel: field.spacing.x,
            params: StitchParams::default(),
        };
        let patch = || stitch(&input).expect("a patch");
        let faces = patch().faces.len() as u64;
        group.throughput(Throughput::Elements(faces));
        group.bench_function(format!("cap of {faces} faces"), |b| b.iter(patch));
    }
}

criterion_group!(benches, extraction, stitching);
criterion_main!(benches);
