//! Biharmonic and minimal-surface fills, energy, and groups of patch vertices.

use glam::DVec3;

use super::super::*;
use super::{faces_of, noise, square, surroundings, with_patch};
use crate::mesh::Mesh;
use crate::mesh::shapes::icosphere;

fn placed(mesh: &Mesh, positions: &[(u32, DVec3)]) -> Mesh {
    let mut mesh = mesh.clone();
    for &(v, p) in positions {
        mesh.positions[v as usize] = p;
    }
    mesh
}

#[test]
fn the_biharmonic_fill_unfolds_a_crumpled_patch_and_keeps_the_slope() {
    let (mesh, patch) = with_patch(
        square(20, |x, _| 0.3 * x),
        |p| p.truncate().length() < 0.4,
        |v, _| 0.2 * DVec3::new(noise(v), noise(v + 99), noise(v + 999)),
    );
    let around = surroundings(&mesh, &patch);
    assert!(folds(&around, &patch).unwrap() > 2);
    let before = willmore_energy(&around, &patch).unwrap();
    let filled = placed(&mesh, &biharmonic(&around, &patch).unwrap());
    let around = surroundings(&filled, &patch);
    assert_eq!(folds(&around, &patch), Ok(0));
    assert!(willmore_energy(&around, &patch).unwrap() < 1e-6 * before);
    for &v in &patch {
        let p = filled.positions[v as usize];
        assert!((p.z - 0.3 * p.x).abs() < 1e-9 && p.truncate().length() < 0.45);
    }
}

#[test]
fn the_energy_of_half_a_sphere_is_that_of_the_formula() {
    // h = 2, area 2 π (1 − cos): ½ h² times the area.
    let (mesh, patch) = with_patch(icosphere(5), |p| p.z > 0.5, |_, _| DVec3::ZERO);
    let energy = willmore_energy(&surroundings(&mesh, &patch), &patch).unwrap();
    let wanted = 2.0 * std::f64::consts::TAU * 0.5;
    // The rim's vertices, whose curvature also depends on the patch, add a strip one edge wide.
    assert!((energy / wanted - 1.0).abs() < 0.08, "{energy} {wanted}");
}

#[test]
fn the_minimal_surface_of_a_circle_is_its_disk() {
    let ring = crate::mesh::shapes::grid(48, 6, [true, false], |s, t| {
        let (y, x) = (s * std::f64::consts::TAU).sin_cos();
        DVec3::new(x, y, -t)
    });
    // A dome over the ring: rows of vertices towards a pole.
    let mut mesh = ring;
    let rows = 7;
    let top = |i: u32| (i % 48) * 7;
    let mut last: Vec<u32> = (0..48).map(top).collect();
    let first_new = mesh.positions.len() as u32;
    for row in 1..rows {
        let radius = 1.0 - f64::from(row) / f64::from(rows);
        let next: Vec<u32> = (0..48)
            .map(|i| {
                let (y, x) = (f64::from(i) / 48.0 * std::f64::consts::TAU).sin_cos();
                let height = 0.8 * (1.0 - radius * radius);
                mesh.positions
                    .push(DVec3::new(radius * x, radius * y, height));
                mesh.positions.len() as u32 - 1
            })
            .collect();
        for i in 0..48 {
            let j = (i + 1) % 48;
            mesh.faces.push([last[i], last[j], next[i]]);
            mesh.faces.push([last[j], next[j], next[i]]);
        }
        last = next;
    }
    mesh.positions.push(DVec3::new(0.0, 0.0, 0.8));
    let pole = mesh.positions.len() as u32 - 1;
    for i in 0..48 {
        mesh.faces.push([last[i], last[(i + 1) % 48], pole]);
    }
    let patch: Vec<u32> = (first_new..=pole).collect();
    let around = surroundings(&mesh, &patch);
    let flat = minimal_surface(&around, &patch).unwrap();
    assert_eq!(flat.len(), patch.len());
    for (_, p) in &flat {
        assert!(p.z.abs() < 1e-3 && p.truncate().length() < 1.0, "{p}");
    }
    let flat = placed(&mesh, &flat);
    assert_eq!(folds(&surroundings(&flat, &patch), &patch), Ok(0));
}

#[test]
fn groups_are_connected() {
    let mesh = icosphere(3);
    let inside = |p: DVec3| p.z.abs() > 0.9;
    let (mesh, patch) = with_patch(mesh, inside, |_, _| DVec3::ZERO);
    let around = surroundings(&mesh, &patch);
    let patches = around.patches(&faces_of(&mesh, &patch));
    assert_eq!(patches.len(), 2);
    let mut all = patches.concat();
    all.sort_unstable();
    assert_eq!(all, patch);
    for one in patches {
        let side = mesh.positions[one[0] as usize].z.signum();
        let same = |v: &u32| mesh.positions[*v as usize].z * side > 0.9;
        assert!(one.iter().all(same));
    }
}

#[test]
fn vertices_whose_neighbours_are_all_on_the_rim_belong_to_the_patch() {
    // Two patch vertices far from each other, joined by the faces in between if those belong to the patch.
    let mesh = square(6, |_, _| 0.0);
    let inside = |v: &u32| {
        let p = mesh.positions[*v as usize];
        p.x.abs() < 0.99 && p.y.abs() < 0.99
    };
    let all: Vec<u32> = (0..mesh.positions.len() as u32).filter(inside).collect();
    let two = [all[0], all[all.len() - 1]];
    let around = surroundings(&mesh, &two);
    assert_eq!(around.patches(&mesh.faces), [two.to_vec()]);
    assert_eq!(around.patches(&faces_of(&mesh, &two)).len(), 2);
}
