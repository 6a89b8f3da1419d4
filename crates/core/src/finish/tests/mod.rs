//! Tests of the finish of a patch, and their shared shapes.

mod accuracy;
mod bad_input;
mod invariance;
mod linear;

use glam::DVec3;

use super::{FinishParams, Finished, Surroundings, finish};
use crate::mesh::Mesh;

/// A pseudo-random number between -1 and 1.
fn noise(i: u32) -> f64 {
    let x = f64::from(i) * 12.9898;
    2.0 * (x.sin() * 43758.5453).rem_euclid(1.0) - 1.0
}

/// A mesh with a patch: the vertices for which `inside` is true, displaced by `disturb`.
pub(super) fn with_patch(
    mut mesh: Mesh,
    inside: impl Fn(DVec3) -> bool,
    disturb: impl Fn(u32, DVec3) -> DVec3,
) -> (Mesh, Vec<u32>) {
    let all = 0..mesh.positions.len() as u32;
    let patch: Vec<u32> = all
        .filter(|&v| inside(mesh.positions[v as usize]))
        .collect();
    assert!(patch.len() > 10, "{}", patch.len());
    for &v in &patch {
        let p = &mut mesh.positions[v as usize];
        *p += disturb(v, *p);
    }
    (mesh, patch)
}

/// The faces of a patch.
fn faces_of(mesh: &Mesh, patch: &[u32]) -> Vec<[u32; 3]> {
    let is_own = |f: &&[u32; 3]| f.iter().any(|v| patch.binary_search(v).is_ok());
    mesh.faces.iter().filter(is_own).copied().collect()
}

pub(super) fn surroundings<'a>(mesh: &'a Mesh, patch: &[u32]) -> Surroundings<'a> {
    let patch = patch.to_vec();
    Surroundings::new(mesh, move |v| patch.binary_search(&v).is_err())
}

fn finished(mesh: &Mesh, patch: &[u32]) -> Finished {
    let params = FinishParams::default();
    finish(&surroundings(mesh, patch), patch, &params)
}

/// Root mean square of a distance over the patch, in diameters of the hole.
fn rms(finished: &Finished, distance: impl Fn(DVec3) -> f64) -> f64 {
    let squares = finished.positions.iter().map(|&p| distance(p).powi(2));
    let mean = squares.sum::<f64>() / finished.positions.len() as f64;
    mean.sqrt() / finished.found.diameter
}

/// A round torus with a tube of radius 1 around a circle of radius √2, a critical surface of the energy.
fn clifford_torus(n: usize) -> Mesh {
    crate::mesh::shapes::grid(n, 5 * n / 7, [true, true], |s, t| {
        let (u, v) = (s * std::f64::consts::TAU, t * std::f64::consts::TAU);
        let across = 2f64.sqrt() + v.cos();
        DVec3::new(across * u.cos(), across * u.sin(), v.sin())
    })
}

fn torus_distance(p: DVec3) -> f64 {
    (p.truncate().length() - 2f64.sqrt()).hypot(p.z) - 1.0
}

/// A graph over a square 2 wide.
fn square(n: usize, height: impl Fn(f64, f64) -> f64) -> Mesh {
    crate::mesh::shapes::grid(n, n, [false, false], |s, t| {
        let (x, y) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        DVec3::new(x, y, height(x, y))
    })
}
