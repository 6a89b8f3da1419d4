//! Accuracy of finished patches whose true surface is known.

use super::super::patch::Located;
use super::super::*;
use super::{
    clifford_torus, finished, noise, rms, square, surroundings, torus_distance, with_patch,
};
use crate::mesh::Mesh;
use crate::mesh::shapes::{grid, icosphere};

/// Finishes a patch with the Willmore energy only.
fn minimum(mesh: &Mesh, patch: &[u32]) -> Finished {
    let params = FinishParams {
        method: FinishMethod::Willmore,
        ..FinishParams::default()
    };
    finish(&surroundings(mesh, patch), patch, &params)
}

#[test]
fn spheres_are_mended_to_spheres() {
    let cap = |p: DVec3| p.z > 0.8;
    let (mesh, patch) = with_patch(icosphere(4), cap, |v, p| {
        p * (0.03 * noise(v) - 0.1 * (p.z - 0.8))
    });
    for (result, most) in [
        (minimum(&mesh, &patch), 1e-4),
        (finished(&mesh, &patch), 1e-5),
    ] {
        assert_ne!(result.found.result, FinishResult::Unchanged);
        let error = rms(&result, |p| p.length() - 1.0);
        assert!(error < most, "{error}");
        assert!(result.found.energy_after < result.found.energy_before);
        assert_eq!(result.found.folds_after, 0);
    }
}

#[test]
fn clifford_tori_are_mended_to_tori() {
    let outside = |p: DVec3| p.distance(DVec3::new(2f64.sqrt() + 1.0, 0.0, 0.0)) < 0.7;
    let (mesh, patch) = with_patch(clifford_torus(70), outside, |v, p| {
        DVec3::X * (0.02 * noise(v) - 0.05 * (p.x - 1.8))
    });
    let energy = minimum(&mesh, &patch);
    let error = rms(&energy, torus_distance);
    assert!(error < 5e-4, "{error}");
    let blend = finished(&mesh, &patch);
    assert_eq!(blend.found.result, FinishResult::Blend);
    let error = rms(&blend, torus_distance);
    assert!(error < 2e-4, "{error}");
}

#[test]
fn planes_are_mended_to_planes() {
    let (mesh, patch) = with_patch(
        square(24, |x, y| 0.5 * x - 0.2 * y),
        |p| p.truncate().length() < 0.35,
        |v, _| DVec3::Z * (0.1 + 0.02 * noise(v)),
    );
    let result = finished(&mesh, &patch);
    let error = rms(&result, |p| p.z - 0.5 * p.x + 0.2 * p.y);
    assert!(error < 1e-6, "{error}");
    let expected_error = result.expected_error.iter().copied().fold(0.0, f64::max);
    assert!(expected_error < 1e-4, "{expected_error}");
}

#[test]
fn cylinders_are_continued_better_than_by_the_energy() {
    let cylinder = grid(60, 40, [true, false], |s, t| {
        let angle = s * std::f64::consts::TAU;
        DVec3::new(angle.cos(), angle.sin(), 4.0 * t - 2.0)
    });
    let side = |p: DVec3| p.distance(DVec3::X) < 0.45;
    let (mesh, patch) = with_patch(cylinder, side, |v, _| DVec3::X * (0.02 * noise(v) - 0.03));
    let distance = |p: DVec3| p.truncate().length() - 1.0;
    let minimum = minimum(&mesh, &patch);
    let energy = rms(&minimum, distance);
    let blend = finished(&mesh, &patch);
    assert_eq!(blend.minimum, minimum.positions);
    assert!(minimum.minimum.is_empty());
    let error = rms(&blend, distance);
    assert!(error < 0.4 * energy, "{error} {energy}");
    let orders: Vec<u8> = blend.found.candidates.iter().map(|c| c.order).collect();
    assert!(orders.iter().any(|&o| o >= 4), "{orders:?}");
}

#[test]
fn noise_is_seen_and_not_continued() {
    // A single draw of noise varies too much: take the geometric mean of the errors over twelve.
    let (mut ratio, mut sizes, draws) = (1.0, 1.0, 12);
    for draw in 0..draws {
        let mut mesh = square(30, |_, _| 0.0);
        for (v, p) in mesh.positions.iter_mut().enumerate() {
            p.z += 0.01 * noise(v as u32 + 1000 * draw);
        }
        let (mesh, patch) = with_patch(mesh, |p| p.truncate().length() < 0.5, |_, _| DVec3::ZERO);
        let energy = rms(&minimum(&mesh, &patch), |p| p.z);
        let blend = finished(&mesh, &patch);
        let error = rms(&blend, |p| p.z);
        ratio *= error / energy;
        let kriged = blend.found.candidates.iter().filter(|c| c.order > 0);
        assert_eq!(kriged.clone().count(), 2);
        assert!(kriged.clone().all(|c| c.nugget > 0.0));
        let weights: f64 = blend.found.candidates.iter().map(|c| c.weight).sum();
        assert!((weights - 1.0).abs() < 1e-12);
        // The expected error is of the size of the true one.
        let squares: f64 = blend.expected_error.iter().map(|s| s * s).sum();
        let size = error * blend.found.diameter / (squares / patch.len() as f64).sqrt();
        assert!(size > 0.1 && size < 6.0, "{size}");
        sizes *= size;
    }
    let mean = |product: f64| product.powf(1.0 / f64::from(draws));
    assert!(mean(ratio) < 0.7, "{ratio}");
    assert!(mean(sizes) > 0.5 && mean(sizes) < 2.5, "{sizes}");
}

#[test]
fn the_expected_error_grows_from_the_rim_inwards() {
    let saddle = square(28, |x, y| 0.3 * x * x - 0.2 * x * y * y);
    let (mesh, patch) = with_patch(
        saddle,
        |p| p.truncate().length() < 0.45,
        |v, _| DVec3::Z * 0.01 * noise(v),
    );
    for result in [finished(&mesh, &patch), minimum(&mesh, &patch)] {
        let mut sums = [(0.0, 0.0); 3];
        for (p, s) in result.positions.iter().zip(&result.expected_error) {
            let third = ((0.45 - p.truncate().length()) / 0.15).clamp(0.0, 2.0) as usize;
            sums[third] = (sums[third].0 + s, sums[third].1 + 1.0);
        }
        let largest = result.expected_error.iter().copied().fold(0.0, f64::max);
        assert_eq!(result.found.largest_expected_error, Some(largest));
        assert!(result.found.mean_expected_error.unwrap() < largest);
        let [rim, middle, deep] = sums.map(|s| s.0 / s.1);
        assert!(
            0.0 < rim && 1.2 * rim < middle && 1.1 * middle < deep,
            "{rim} {middle} {deep}"
        );
    }
}

#[test]
fn large_patches_are_blended_with_one_continuation() {
    let cap = |p: DVec3| p.z > 0.4;
    let (mesh, patch) = with_patch(icosphere(5), cap, |_, p| p * -0.05 * (p.z - 0.4));
    assert!(patch.len() > 3000);
    let result = finished(&mesh, &patch);
    assert_eq!(result.found.result, FinishResult::Blend);
    assert_eq!(result.found.blend_refused, None);
    assert_eq!(result.found.candidates.len(), 2);
    let error = rms(&result, |p| p.length() - 1.0);
    assert!(error < 1e-3, "{error}");
    assert!(result.expected_error.iter().all(|s| *s > 0.0));
}

#[test]
fn a_large_patch_that_goes_round_an_axis_has_no_continuation() {
    // The neck of a catenoid, which a sphere in its middle fits so that no normal is steep over it.
    let catenoid = grid(160, 110, [true, false], |s, t| {
        let (angle, z) = (s * std::f64::consts::TAU, 2.0 * t - 1.0);
        DVec3::new(z.cosh() * angle.cos(), z.cosh() * angle.sin(), z)
    });
    let neck = |p: DVec3| p.z.abs() < 0.5;
    let (mesh, patch) = with_patch(catenoid, neck, |v, p| {
        p * (0.002 * noise(v) - 0.02 * (0.5 - p.z.abs()))
    });
    assert!(patch.len() > 3000);
    let result = finished(&mesh, &patch);
    assert_eq!(result.found.result, FinishResult::Willmore);
    assert_eq!(result.found.blend_refused, Some(Refusal::TooLarge));
    let error = rms(&result, |p| p.truncate().length() - p.z.cosh());
    assert!(error < 1e-3, "{error} {:?}", result.found.candidates);
}

#[test]
fn a_large_patch_whose_surroundings_bend_both_ways_has_no_continuation() {
    // Across the top of the torus the curvature changes its sign, which no sphere follows.
    let top = |p: DVec3| p.distance(DVec3::new(2f64.sqrt(), 0.0, 1.0)) < 1.0;
    let (mesh, patch) = with_patch(clifford_torus(300), top, |v, p| {
        DVec3::Z * (0.001 * noise(v) - 0.05 * (p.z - 0.7))
    });
    assert!(patch.len() > 3000);
    let result = finished(&mesh, &patch);
    assert_eq!(result.found.result, FinishResult::Willmore);
    assert_eq!(result.found.blend_refused, Some(Refusal::TooLarge));
    let error = rms(&result, torus_distance);
    assert!(error < 3e-4, "{error} {:?}", result.found.candidates);
}

#[test]
fn a_large_patch_that_is_crumpled_at_its_rim_converges() {
    let cap = |p: DVec3| p.z > 0.4;
    let (mesh, patch) = with_patch(icosphere(5), cap, |v, p| {
        let crumpled = if p.z < 0.5 { 0.02 } else { 0.0 };
        p * (crumpled * noise(v) - 0.05 * (p.z - 0.4))
    });
    let result = finished(&mesh, &patch);
    assert!(
        result.found.converged
            && result.found.second_initialisation == SecondInitialisation::Better
    );
    assert!(result.found.energy_before > 5.0 * result.found.energy_after);
    let error = rms(&result, |p| p.length() - 1.0);
    assert!(error < 1e-3, "{error}");
}

#[test]
fn a_large_patch_with_a_finely_meshed_rough_rim_converges() {
    let mut mesh = icosphere(5);
    for (v, p) in (0..).zip(&mut mesh.positions) {
        *p *= 1.0 + 3e-3 * noise(v);
    }
    let cap = |p: DVec3| p.z > 0.4;
    let (mesh, patch) = with_patch(mesh, cap, |_, p| p * -0.02 * (p.z - 0.4));
    let result = finished(&mesh, &patch);
    // 9 steps; 15 without the bound on the roughness in the system.
    let found = &result.found;
    assert!(found.converged && found.steps <= 12, "{found:?}");
    let error = rms(&result, |p| p.length() - 1.0);
    assert!(error < 2e-2, "{error}");
}

#[test]
fn faces_that_are_folded_over_are_unfolded_and_nothing_else_is_moved() {
    let cap = |p: DVec3| p.z > 0.6;
    let (mesh, patch) = with_patch(icosphere(4), cap, |_, _| DVec3::ZERO);
    let around = surroundings(&mesh, &patch);
    let located = Located::new(&around, &patch).unwrap();
    let start = located.patch.shape();
    let mut folded = start.clone();
    let middle = start.len() / 2;
    folded[middle] = folded[middle] + 2.5 * (folded[middle + 1] - folded[middle]);
    let folds = folds::folds(&located.patch, &folded);
    assert!(folds > 0);
    let unfolded = folds::unfolded(&located.patch, &folded, 0).unwrap();
    assert_eq!(folds::folds(&located.patch, &unfolded), 0);
    let moved = unfolded.iter().zip(&folded).filter(|(a, b)| a != b);
    assert!(moved.count() <= 3 * folds);
    let kept = folds::unfolded(&located.patch, &folded, folds).unwrap();
    assert_eq!(kept, folded);
}

#[test]
fn a_folded_start_is_given_up_for_the_biharmonic_one() {
    let cap = |p: DVec3| p.z > 0.8;
    let (mesh, patch) = with_patch(icosphere(4), cap, |v, _| {
        0.15 * DVec3::new(noise(v), noise(v + 1000), noise(v + 2000))
    });
    let around = surroundings(&mesh, &patch);
    assert!(folds(&around, &patch).unwrap() > 0);
    let result = finished(&mesh, &patch);
    assert_eq!(
        result.found.second_initialisation,
        SecondInitialisation::Better
    );
    assert_eq!(result.found.folds_after, 0);
    let error = rms(&result, |p| p.length() - 1.0);
    assert!(error < 1e-3, "{error}");
}
