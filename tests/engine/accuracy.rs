//! Patches are near the exact surface in thin walls and on noisy meshes too.

use crate::shapes::{cut, sphere};
use glam::DVec3;
use isomend::{FillParams, Mesh, fill};

/// A pseudo-random number from the standard normal distribution.
fn normal(i: usize) -> f64 {
    let uniform = |salt: f64| {
        let x = (i as f64 * 12.9898 + salt).sin() * 43_758.545_3;
        x - x.floor()
    };
    let (u, v) = (uniform(0.37).max(1e-12), uniform(4.11));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Root mean square of a distance over the vertices that a fill of all holes adds.
fn rms_of_patch(mesh: &Mesh, distance: impl Fn(DVec3) -> f64) -> f64 {
    let filled = fill(mesh, &FillParams::default()).unwrap();
    let new = &filled.mesh.positions[mesh.positions.len()..];
    assert!(!new.is_empty());
    let squares: f64 = new.iter().map(|p| distance(*p).powi(2)).sum();
    (squares / new.len() as f64).sqrt()
}

/// If the wall is thin relative to the hole's diameter, the level set bulges. Its patch has a far higher energy than the surface that
/// continues the wall; the finish must reach this surface.
#[test]
fn holes_in_thin_walls_are_filled_to_the_wall() {
    for (radius, part) in [
        (0.3, 0.2),
        (0.3, 0.3),
        (0.45, 0.2),
        (0.45, 0.3),
        (0.45, 0.5),
    ] {
        let diameter = 2.0 * radius;
        let half = 0.5 * part * diameter;
        let mut lens = sphere(32);
        lens.positions.iter_mut().for_each(|p| p.z *= half);
        let mesh = cut(&lens, |p| p.z > 0.0 && p.truncate().length() < radius);
        let distance =
            |p: DVec3| p.z - half * (1.0 - p.truncate().length_squared()).max(0.0).sqrt();
        let error = rms_of_patch(&mesh, distance) / diameter;
        assert!(
            error < 1e-3,
            "a wall of {part} diameters: {error} of the diameter"
        );
    }
}

/// The known vertices are noisy; a patch that follows their noise is farther from the sphere than a patch that does not.
#[test]
fn patches_of_noisy_spheres_do_not_follow_the_noise() {
    let edge = 1.05 / 16.0;
    for (noise, most) in [(0.03, 0.45e-3), (0.1, 1.2e-3)] {
        let mut product = 1.0;
        let seeds = 4;
        for seed in 0..seeds {
            let mut ball = sphere(16);
            for (i, p) in ball.positions.iter_mut().enumerate() {
                *p *= 1.0 + noise * edge * normal(i + 100_000 * seed);
            }
            let mesh = cut(&ball, |p| p.normalize().z > 0.5);
            let diameter = 2.0 * 0.75f64.sqrt();
            product *= rms_of_patch(&mesh, |p| p.length() - 1.0) / diameter;
        }
        let error = f64::powf(product, 1.0 / seeds as f64);
        assert!(
            error < most,
            "noise of {noise} edges: {error} of the diameter"
        );
    }
}
