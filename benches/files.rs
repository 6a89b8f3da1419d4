//! Benchmarks of reading and writing files of a million triangles, in memory.
//!
//! Medians on two cores of a shared machine (November 2026), in seconds, with five holes in the ball:
//!
//! | | PLY | STL | GLB | OBJ |
//! |---|---|---|---|---|
//! | write | 0.017 | 0.051 | 0.035 | 0.209 |
//! | read | 0.037 | 0.099 | 0.036 | 0.125 |

mod common;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use isomend::io::{Format, WriteOptions, no_side_files, read_bytes, to_bytes};

fn files(criterion: &mut Criterion) {
    let mesh = common::million();
    let options = WriteOptions::default();
    let mut group = common::group(criterion, "files");
    group.throughput(Throughput::Elements(mesh.faces.len() as u64));
    for format in [Format::Ply, Format::Stl, Format::Glb, Format::Obj] {
        let write = || to_bytes(&mesh, format, &options).expect("a sound mesh");
        let bytes = write().bytes;
        let read = || read_bytes(&bytes, format, &no_side_files).expect("what was written");
        assert_eq!(read().mesh.faces.len(), mesh.faces.len());
        group.bench_function(format!("write {format}"), |b| b.iter(write));
        group.bench_function(format!("read {format}"), |b| b.iter(read));
    }
}

criterion_group!(benches, files);
criterion_main!(benches);
