//! Benchmarks of the topology of a million triangles: welding, edges and boundary loops, and the whole inspection.
//!
//! Medians on two cores of a shared machine (November 2026), in seconds: weld 0.026, edges and loops 0.225, inspect
//! (which is both) 0.280.

mod common;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use isomend::inspect;
use isomend_core::mesh::{Topology, find_holes, welded};

fn topology(criterion: &mut Criterion) {
    let mesh = common::million();
    let mut group = common::group(criterion, "topology");
    group.throughput(Throughput::Elements(mesh.faces.len() as u64));
    group.bench_function("weld", |b| b.iter(|| welded(&mesh)));
    group.bench_function("edges and loops", |b| {
        let loops = |mut mesh| {
            let mut topology = Topology::new(&mut mesh);
            let (holes, _) = find_holes(&mesh, &mut topology);
            assert_eq!(holes.len(), 5);
        };
        b.iter_batched(|| mesh.clone(), loops, BatchSize::LargeInput);
    });
    group.bench_function("inspect", |b| b.iter(|| inspect(&mesh)));
}

criterion_group!(benches, topology);
criterion_main!(benches);
