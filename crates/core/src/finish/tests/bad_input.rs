//! Finishes of degenerate and invalid input, and cancellation.

use glam::DVec3;

use super::super::*;
use super::{finished, noise, square, surroundings, with_patch};
use crate::cancel::Cancel;
use crate::mesh::Mesh;
use crate::mesh::shapes::icosphere;

fn cap() -> (Mesh, Vec<u32>) {
    with_patch(icosphere(3), |p| p.z > 0.8, |v, p| p * 0.03 * noise(v))
}

/// Whether positions are equal to the mesh's, bit for bit.
fn unchanged(mesh: &Mesh, finished: &Finished) -> bool {
    let bits = |p: DVec3| p.to_array().map(f64::to_bits);
    let pairs = finished.vertices.iter().zip(&finished.positions);
    let same = pairs
        .clone()
        .all(|(&v, p)| bits(mesh.positions[v as usize]) == bits(*p));
    same && finished.found.result == FinishResult::Unchanged
}

#[test]
fn a_whole_mesh_has_nothing_known_round_it() {
    let mesh = icosphere(2);
    let all: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let result = finished(&mesh, &all);
    assert!(unchanged(&mesh, &result));
    assert_eq!(result.found.willmore_refused, Some(Refusal::NothingKnown));
    let around = surroundings(&mesh, &all);
    assert_eq!(biharmonic(&around, &all), Err(Refusal::NothingKnown));
    assert_eq!(willmore_energy(&around, &all), Err(Refusal::NothingKnown));
}

#[test]
fn vertices_that_are_not_there_or_not_used_are_left_out() {
    let (mut mesh, patch) = cap();
    let loose = mesh.positions.len() as u32;
    mesh.positions.push(DVec3::splat(7.0));
    let result = finished(&mesh, &[loose, loose + 9, u32::MAX]);
    assert!(result.vertices.is_empty() && result.positions.is_empty());
    assert_eq!(result.found.willmore_refused, Some(Refusal::NoVertices));
    let mut mixed = patch.clone();
    mixed.extend([loose, patch[0], u32::MAX]);
    let mixed = finish(
        &surroundings(&mesh, &patch),
        &mixed,
        &FinishParams::default(),
    );
    assert_eq!(mixed.positions, finished(&mesh, &patch).positions);
}

#[test]
fn what_is_not_a_number_is_refused() {
    for bad in [f64::NAN, f64::INFINITY] {
        for place in 0..3 {
            let (mut mesh, patch) = cap();
            let rim = (0..mesh.positions.len())
                .find(|&v| mesh.positions[v].z > 0.7)
                .unwrap();
            let v = [patch[3] as usize, rim, 0][place];
            mesh.positions[v].y = bad;
            let result = finished(&mesh, &patch);
            let finite = result.positions.iter().all(|p| p.is_finite());
            assert!(unchanged(&mesh, &result) || finite);
        }
    }
}

#[test]
fn coincident_vertices_and_zero_areas_do_no_harm() {
    let (mut mesh, patch) = cap();
    let place = mesh.positions[patch[0] as usize];
    for &v in &patch {
        mesh.positions[v as usize] = place;
    }
    let result = finished(&mesh, &patch);
    assert!(result.positions.iter().all(|p| p.is_finite()));
    // All vertices of the mesh in one place.
    mesh.positions.fill(place);
    let result = finished(&mesh, &patch);
    assert!(unchanged(&mesh, &result));
    // All on a line.
    for (i, p) in mesh.positions.iter_mut().enumerate() {
        *p = DVec3::X * i as f64;
    }
    let result = finished(&mesh, &patch);
    assert!(unchanged(&mesh, &result) || result.positions.iter().all(|p| p.is_finite()));
}

#[test]
fn faces_that_repeat_a_vertex_and_edges_of_three_faces_do_no_harm() {
    let (mut mesh, patch) = cap();
    let face = *mesh.faces.iter().find(|f| f.contains(&patch[0])).unwrap();
    mesh.faces.push([face[0], face[0], face[1]]);
    mesh.faces.push([face[1], face[1], face[1]]);
    let with_repeats = finished(&mesh, &patch);
    mesh.faces.truncate(mesh.faces.len() - 2);
    assert_eq!(with_repeats.positions, finished(&mesh, &patch).positions);
    mesh.positions.push(DVec3::new(0.1, 0.2, 1.4));
    let extra = mesh.positions.len() as u32 - 1;
    mesh.faces.push([face[0], face[1], extra]);
    let result = finished(&mesh, &patch);
    assert!(result.positions.iter().all(|p| p.is_finite()));
    assert!(result.found.folds_after <= result.found.folds_before);
}

#[test]
fn heaps_of_triangles_end_in_numbers() {
    for seed in 0..150u32 {
        let random = |i: u32| 0.5 + 0.5 * noise(7919 * seed + i);
        let count = 12 + seed % 30;
        // Coarse coordinates, so that many points coincide or are collinear or coplanar.
        let grain = f64::from(1 + seed % 4);
        let point = |v: u32| {
            let at = |k: u32| (random(3 * v + k) * grain * 3.0).floor() / grain;
            DVec3::new(at(0), at(1), if seed % 3 == 0 { 0.0 } else { at(2) })
        };
        let vertex = |i: u32| ((random(1000 + i) * f64::from(count)) as u32).min(count - 1);
        let faces = (0..4 * count).map(|f| [0, 1, 2].map(|k| vertex(3 * f + k)));
        let mesh = Mesh::new((0..count).map(point).collect(), faces.collect());
        let patch: Vec<u32> = (0..1 + seed % 8).collect();
        let result = finished(&mesh, &patch);
        assert!(result.positions.iter().all(|p| p.is_finite()), "{seed}");
        assert!(
            result.found.folds_after <= result.found.folds_before,
            "{seed}"
        );
        let around = surroundings(&mesh, &patch);
        for fill in [
            biharmonic(&around, &patch),
            minimal_surface(&around, &patch),
        ] {
            let finite = |p: &(u32, DVec3)| p.1.is_finite();
            assert!(fill.map_or(true, |fill| fill.iter().all(finite)), "{seed}");
        }
    }
}

#[test]
fn a_patch_at_the_border_of_the_mesh_is_finite_and_stays_near() {
    let (mesh, patch) = with_patch(
        square(16, |x, _| 0.1 * x * x),
        |p| p.distance(DVec3::X) < 0.5,
        |v, _| DVec3::Z * 0.02 * noise(v),
    );
    let result = finished(&mesh, &patch);
    assert!(result.positions.iter().all(|p| p.is_finite()));
    assert!(result.found.largest_move <= 0.3 * result.found.diameter);
}

#[test]
fn one_vertex_is_finished_too() {
    let mut mesh = icosphere(3);
    mesh.positions[0] *= 1.02;
    let result = finished(&mesh, &[0]);
    let error = (result.positions[0].length() - 1.0).abs();
    assert!(error < 2e-3, "{error}");
    assert!(result.expected_error[0] > 0.0);
}

#[test]
fn moves_beyond_the_limit_are_refused() {
    let (mesh, patch) = with_patch(icosphere(3), |p| p.z > 0.8, |_, p| p * 0.3 * (p.z - 0.7));
    let params = FinishParams {
        farthest: 1e-3,
        ..FinishParams::default()
    };
    let result = finish(&surroundings(&mesh, &patch), &patch, &params);
    assert!(unchanged(&mesh, &result));
    assert_eq!(result.found.willmore_refused, Some(Refusal::MovedTooFar));
    let few = FinishParams {
        most_vertices: 5,
        ..FinishParams::default()
    };
    let result = finish(&surroundings(&mesh, &patch), &patch, &few);
    assert!(unchanged(&mesh, &result));
    assert_eq!(result.found.willmore_refused, Some(Refusal::TooLarge));
}

#[test]
fn it_stops_when_cancelled_and_leaves_the_patch_unchanged() {
    let (mesh, patch) = cap();
    let params = FinishParams::default();
    let stopped_after = |reads: usize| {
        let cancel = Cancel::after(reads);
        let around = surroundings(&mesh, &patch).stopped_by(&cancel);
        (
            finish(&around, &patch, &params),
            reads - cancel.reads_left(),
        )
    };
    let (_, all) = stopped_after(usize::MAX);
    assert!(all > 100, "{all}");
    for reads in (0..all).step_by(7) {
        let (result, _) = stopped_after(reads);
        assert!(unchanged(&mesh, &result), "{reads} of {all}");
        assert_eq!(result.found.willmore_refused, Some(Refusal::Stopped));
    }
}
