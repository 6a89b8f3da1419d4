//! Invariance of a finish: motions, scale, mirroring, far parts of the mesh, threads.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::super::*;
use super::{faces_of, finished, noise, square, surroundings, with_patch};
use crate::mesh::Mesh;
use crate::mesh::shapes::{icosphere, punch};

/// A wavy square with noise and a badly filled hole: kriging, the ring test and Gauss-Newton are all exercised.
fn wavy() -> (Mesh, Vec<u32>) {
    let mut mesh = square(30, |x, y| 0.2 * x * x + 0.1 * (3.0 * y).sin());
    for (v, p) in mesh.positions.iter_mut().enumerate() {
        p.z += 0.002 * noise(v as u32);
    }
    with_patch(
        mesh,
        |p| p.truncate().length() < 0.33,
        |v, _| DVec3::Z * (0.03 + 0.01 * noise(v + 5)),
    )
}

/// Largest difference between the result on a mesh and the result on the mapped mesh, mapped back, in diameters of the hole.
/// `turn` reverses the faces.
fn difference(map: impl Fn(DVec3) -> DVec3, back: impl Fn(DVec3) -> DVec3, turn: bool) -> f64 {
    let (mut mesh, patch) = wavy();
    let first = finished(&mesh, &patch);
    assert_eq!(first.found.result, FinishResult::Blend);
    mesh.positions.iter_mut().for_each(|p| *p = map(*p));
    if turn {
        mesh.faces.iter_mut().for_each(|f| f.swap(1, 2));
    }
    let second = finished(&mesh, &patch);
    let ways = first.positions.iter().zip(&second.positions);
    let farthest = ways.map(|(a, b)| a.distance(back(*b))).fold(0.0, f64::max);
    farthest / first.found.diameter
}

#[test]
fn the_result_moves_turns_and_scales_with_the_mesh() {
    let turn = DMat3::from_euler(glam::EulerRot::ZYX, 0.3, 1.1, -0.7);
    let turned = difference(|p| turn * p, |p| turn.transpose() * p, false);
    assert!(turned < 1e-7, "{turned}");
    let shift = DVec3::new(1e4, -3e4, 2e4);
    let moved = difference(|p| p + shift, |p| p - shift, false);
    assert!(moved < 1e-7, "{moved}");
    for scale in [1e-70, 1e-3, 1e75] {
        let scaled = difference(|p| p * scale, |p| p / scale, false);
        assert!(scaled < 1e-7, "{scaled}");
    }
}

#[test]
fn mirrored_and_inside_out_it_is_the_same() {
    let flip = |p: DVec3| DVec3::new(-p.x, p.y, p.z);
    let mirrored = difference(flip, flip, true);
    assert!(mirrored < 1e-7, "{mirrored}");
    let inside_out = difference(|p| p, |p| p, true);
    assert!(inside_out < 1e-7, "{inside_out}");
}

#[test]
fn what_is_far_away_does_not_matter_to_the_bit() {
    let (mesh, patch) = with_patch(icosphere(4), |p| p.z > 0.93, |v, p| p * 0.02 * noise(v));
    let whole = finished(&mesh, &patch);
    assert_eq!(whole.found.result, FinishResult::Blend);
    let near = punch(&mesh, |p| p.z < -0.2);
    assert!(near.positions.len() < mesh.positions.len() / 3 * 2);
    // The vertices of the part in their order in the whole mesh.
    let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    order.retain(|&v| near.positions.contains(&mesh.positions[v as usize]));
    let positions: Vec<DVec3> = order.iter().map(|&v| mesh.positions[v as usize]).collect();
    let number = |v: u32| order.binary_search(&v).ok().map(|i| i as u32);
    let part: Vec<[u32; 3]> = mesh
        .faces
        .iter()
        .filter_map(|f| {
            let [a, b, c] = f.map(number);
            Some([a?, b?, c?])
        })
        .collect();
    let part = Mesh::new(positions, part);
    let patch: Vec<u32> = patch.iter().filter_map(|&v| number(v)).collect();
    let cut = finished(&part, &patch);
    assert_eq!(whole.positions, cut.positions);
    assert_eq!(whole.expected_error, cut.expected_error);
}

#[test]
fn the_bits_are_the_same_on_any_number_of_threads() {
    let mesh = icosphere(4);
    let tops = [
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        -DVec3::X,
        -DVec3::Y,
        -DVec3::Z,
    ];
    let inside = |p: DVec3| tops.iter().any(|t| t.dot(p) > 0.93);
    let (mesh, patch) = with_patch(mesh, inside, |v, p| p * 0.02 * noise(v));
    let around = surroundings(&mesh, &patch);
    let patches = around.patches(&faces_of(&mesh, &patch));
    assert_eq!(patches.len(), 6);
    let params = FinishParams::default();
    let run = |threads: usize| -> Vec<(Vec<DVec3>, Vec<f64>)> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let one = |own: &Vec<u32>| {
            let finished = finish(&around, own, &params);
            assert_eq!(finished.found.result, FinishResult::Blend);
            (finished.positions, finished.expected_error)
        };
        pool.build()
            .unwrap()
            .install(|| patches.par_iter().map(one).collect())
    };
    assert_eq!(run(1), run(4));
}
