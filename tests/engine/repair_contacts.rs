//! Bodies in contact up to rounding: vertices of one in a plane of another, and sides that two bodies share with different edges.

use std::f64::consts::TAU;

use crate::repair_union::{repaired, single, verdict};
use crate::repair_unions::placed;
use crate::shapes::{Noise, cube, joined, moved, volume};
use glam::DVec3;
use isomend::Mesh;
use isomend_core::mesh::welded;

/// The mesh at the precision of an STL file, with one vertex at each position.
fn stored(mesh: &Mesh) -> Mesh {
    welded(&single(mesh)).0
}

/// A torus of radii 3 and 1 with edges along its circles.
fn ring(around: u32, across: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let at = |i: u32, j: u32| i % around * across + j % across;
    for (i, j) in (0..around).flat_map(|i| (0..across).map(move |j| (i, j))) {
        let [u, w] = [(i, around), (j, across)].map(|(k, n)| TAU * f64::from(k) / f64::from(n));
        let r = 3.0 + w.cos();
        let p = DVec3::new(r * u.cos(), r * u.sin(), w.sin());
        mesh.positions.push(p);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        mesh.faces.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

#[track_caller]
fn assert_united(mesh: &Mesh, truth: f64, what: &str) {
    let done = repaired(mesh);
    let after = verdict(&done.mesh);
    assert!(after.is_sound(), "{what}: {}", after.line());
    assert_eq!(after.components.len(), 1, "{what}");
    let relative = volume(&done.mesh) / truth - 1.0;
    assert!(relative.abs() < 5e-5, "{what}: {relative}");
    let steps = &done.report.steps;
    assert!(steps.intersection_passes.is_empty(), "{what}: cut out");
    assert_eq!(steps.relaxed_vertices, 0, "{what}");
}

#[test]
fn a_ring_half_sunk_in_a_block_far_from_the_origin_is_united() {
    let block = moved(&cube(1), 20.0, DVec3::splat(-10.0));
    let ring = moved(&ring(64, 16), 2.0, DVec3::new(0.0, 0.0, 10.0));
    let truth = volume(&block) + 0.5 * volume(&ring);
    let both = joined(&block, &ring);
    let mut noise = Noise(5);
    for round in 0..6 {
        let by = 500.0 * noise.vector();
        let mesh = stored(&moved(&both, 1.0, by));
        assert_united(&mesh, truth, &format!("{round}, at {by}"));
    }
}

#[test]
fn finely_divided_blocks_that_share_a_side_are_united() {
    let block = |n: i32| moved(&cube(n), 20.0 / f64::from(n), DVec3::ZERO);
    let truth = 2.0 * 8000.0;
    let mut noise = Noise(9);
    for (n, m, beside) in [
        (2, 2, 0.0),
        (1, 2, 0.0),
        (2, 3, 0.0),
        (4, 4, 0.0),
        (4, 4, 5.0),
        (3, 3, 7.0),
    ] {
        let other = moved(&block(m), 1.0, DVec3::new(20.0, beside, 0.0));
        let both = joined(&block(n), &other);
        for round in 0..4 {
            let mesh = placed(&both, &mut noise);
            assert_united(
                &stored(&mesh),
                truth,
                &format!("{n}, {m}, {beside}, {round}"),
            );
        }
    }
}
