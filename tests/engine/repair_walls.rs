//! Open sheets in a repair: bowls and vases get planar caps, terrains get walls, and walls that are too thin are reported.

use std::collections::HashSet;

use crate::shapes::{joined, volume};
use glam::DVec3;
use isomend::check::{CheckParams, DefectKind, Verdict};
use isomend::{
    Carried, Closure, Control, HoleOutcome, Mesh, RepairParams, Repaired, inspect, repair,
};

fn closed(mesh: &Mesh, params: RepairParams) -> Repaired {
    let params = params.with_borders(true);
    repair(mesh, &params, &Carried::default(), &Control::new()).unwrap()
}

fn verdict(mesh: &Mesh, min_wall: Option<f64>) -> Verdict {
    let mut params = CheckParams::default();
    params.min_wall = min_wall;
    inspect(mesh).unwrap().check(&params)
}

/// The result is sound, and the faces of the input are there bit for bit and in order.
#[track_caller]
fn assert_whole(bad: &Mesh, done: &Repaired) {
    let after = verdict(&done.mesh, None);
    assert!(after.is_sound(), "{}", after.line());
    assert_eq!(done.report.lost_faces, 0);
    let corners = |mesh: &Mesh, f: usize| mesh.faces[f].map(|v| mesh.positions[v as usize]);
    for f in 0..bad.faces.len() {
        assert_eq!(corners(bad, f), corners(&done.mesh, f));
    }
}

/// A grid of `n` by `m` squares over the unit square, each divided into two triangles.
fn grid(n: usize, m: usize, at: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=n {
        for j in 0..=m {
            let (u, v) = (i as f64 / n as f64, j as f64 / m as f64);
            mesh.positions.push(at(u, v));
        }
    }
    let index = |i: usize, j: usize| (i * (m + 1) + j) as u32;
    for i in 0..n {
        for j in 0..m {
            let [a, b] = [index(i, j), index(i + 1, j)];
            mesh.faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    mesh
}

/// A vessel: a surface of revolution with a closed bottom; `profile` lists radius and height from the bottom up.
fn vessel(profile: &[(f64, f64)], around: u32) -> Mesh {
    let mut mesh = Mesh::new(vec![DVec3::new(0.0, 0.0, profile[0].1)], Vec::new());
    for &(r, z) in profile {
        mesh.positions.extend((0..around).map(|i| {
            let a = std::f64::consts::TAU * f64::from(i) / f64::from(around);
            DVec3::new(r * a.cos(), r * a.sin(), z)
        }));
    }
    for i in 0..around {
        let next = (i + 1) % around;
        mesh.faces.push([0, 1 + next, 1 + i]);
        for ring in 0..profile.len() as u32 - 1 {
            let [a, b] = [i, next].map(|i| 1 + ring * around + i);
            mesh.faces
                .extend([[a, b, b + around], [a, b + around, a + around]]);
        }
    }
    mesh
}

/// The bottom of the unit sphere up to an angle from the south pole, open at the top.
fn bowl(degrees: f64) -> Mesh {
    let at = |i: u32| degrees.to_radians() * f64::from(i) / 16.0;
    let profile: Vec<(f64, f64)> = (1..=16).map(|i| (at(i).sin(), -at(i).cos())).collect();
    vessel(&profile, 48)
}

fn vase() -> Mesh {
    let mut profile: Vec<(f64, f64)> = (1..8).map(|i| (0.1 * f64::from(i), 0.0)).collect();
    profile.extend((0..=30).map(|i| {
        let z = 0.1 * f64::from(i);
        (0.8 + 0.35 * (1.6 * z).sin(), z)
    }));
    vessel(&profile, 48)
}

fn height(x: f64, y: f64) -> f64 {
    0.08 * (7.0 * x).sin() * (5.0 * y).cos() + 0.05 * (13.0 * x + 1.0).sin() * (11.0 * y).sin()
}

fn terrain() -> Mesh {
    grid(40, 30, |u, v| {
        DVec3::new(4.0 * u, 3.0 * v, 2.0 * height(u, v))
    })
}

fn mean_edge(mesh: &Mesh) -> f64 {
    let around = mesh.faces.iter().map(|f| {
        let [a, b, c] = f.map(|v| mesh.positions[v as usize]);
        a.distance(b) + b.distance(c) + c.distance(a)
    });
    around.sum::<f64>() / (3 * mesh.faces.len()) as f64
}

#[test]
fn bowls_and_vases_get_flat_caps() {
    for (mesh, top) in [(bowl(90.0), 0.0), (bowl(60.0), -0.5), (vase(), 3.0)] {
        let done = closed(&mesh, RepairParams::new());
        assert_whole(&mesh, &done);
        assert_eq!(done.fill.tally().flat, 1);
        assert!(done.report.offset_shells.is_empty());
        let new = &done.mesh.positions[mesh.positions.len()..];
        assert!(!new.is_empty());
        for p in new {
            assert!((p.z - top).abs() < 1e-3, "{p} of a cap at {top}");
        }
    }
}

#[test]
fn a_terrain_gets_walls_of_the_given_thickness() {
    let mesh = terrain();
    for wall in [None, Some(0.05), Some(0.2)] {
        let mut params = RepairParams::new();
        params.wall = wall;
        let done = closed(&mesh, params);
        assert_whole(&mesh, &done);
        let regions = done.fill.regions.iter();
        assert!(
            regions
                .filter_map(|r| r.closure.as_ref())
                .any(|how| *how == Closure::Walls)
        );
        let outcomes = done.fill.holes.iter().map(|h| &h.outcome);
        assert_eq!(
            outcomes.collect::<Vec<_>>(),
            [&HoleOutcome::Closed(Closure::Walls)]
        );
        let [(1, shell)] = done.report.offset_shells[..] else {
            panic!("{:?}", done.report.offset_shells);
        };
        let wanted = wall.unwrap_or(mean_edge(&mesh));
        let [least, mean] = [shell.least_wall, shell.mean_wall].map(Option::unwrap);
        assert!((mean - wanted).abs() < 0.1 * wanted, "{mean} for {wanted}");
        assert!(least > 0.5 * wanted, "{least} for {wanted}");
        assert!(done.report.thin_offset_shells.is_empty());
        // A check measures the thickness that the repair reported.
        let found = verdict(&done.mesh, Some(0.45 * wanted));
        assert!(found.is_sound(), "{}", found.line());
        let found = verdict(&done.mesh, Some(1.2 * wanted));
        assert!(found.count(DefectKind::ThinWall) > mesh.faces.len());
    }
}

#[test]
fn parallel_sheets_get_walls_that_fit_between_them() {
    let sheet = |z: f64| {
        grid(20, 20, |u, v| {
            DVec3::new(u, v, z + 0.02 * (6.0 * u).sin() * (5.0 * v).sin())
        })
    };
    let apart = 0.04;
    let mesh = joined(&sheet(0.0), &sheet(apart));
    let done = closed(&mesh, RepairParams::new());
    assert_whole(&mesh, &done);
    assert_eq!(verdict(&done.mesh, None).components.len(), 2);
    let shells = &done.report.offset_shells;
    assert_eq!(
        shells.iter().map(|l| l.0).collect::<HashSet<_>>(),
        [1, 2].into()
    );
    for (_, shell) in shells {
        assert!(shell.mean_wall.unwrap() > 0.4 * apart, "{shells:?}");
    }
}

#[test]
fn sheets_with_borders_near_each_other_get_separate_walls() {
    let sheet = |x: f64| {
        grid(6, 6, |u, v| {
            DVec3::new(x + u, v, 0.1 * (u - 0.5).powi(2) + 0.02 * (7.0 * v).sin())
        })
    };
    let mesh = joined(&sheet(0.0), &sheet(1.7));
    let done = closed(&mesh, RepairParams::new());
    assert_whole(&mesh, &done);
    assert_eq!(verdict(&done.mesh, None).components.len(), 2);
    let holes = &done.fill.holes;
    assert!(
        holes
            .iter()
            .all(|h| h.outcome == HoleOutcome::Closed(Closure::Walls)),
        "{holes:?}"
    );
}

#[test]
fn walls_that_are_too_thin_are_reported_with_their_component() {
    // Sheets 0.001 apart: the wall of the upper one has too little room.
    let sheet = |z: f64| grid(12, 12, |u, v| DVec3::new(u, v, z + 0.1 * (3.0 * u).sin()));
    let mesh = joined(&sheet(0.0), &sheet(0.001));
    let done = closed(&mesh, RepairParams::new());
    assert_whole(&mesh, &done);
    let thin = &done.report.thin_offset_shells;
    assert_eq!(
        thin.iter().map(|t| t.0).collect::<Vec<_>>(),
        [2],
        "{:?}",
        done.report.offset_shells
    );
    let limit = 0.5 * mean_edge(&mesh);
    assert!((thin[0].1 - limit).abs() < 0.1 * limit);
    let params = RepairParams::new().with_min_wall(limit);
    let strict = closed(&mesh, params);
    assert!(
        strict.report.thin_offset_shells.is_empty(),
        "a limit of its own is the verdict's"
    );
    assert!(!verdict(&strict.mesh, Some(limit)).is_sound());
}

#[test]
fn thicknesses_that_are_not_positive_are_refused() {
    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(RepairParams::new().with_wall(length).check().is_err());
        assert!(RepairParams::new().with_min_wall(length).check().is_err());
        let mut params = CheckParams::default();
        params.min_wall = Some(length);
        assert!(params.check().is_err());
    }
}

#[test]
fn the_wall_of_a_flat_sheet_has_the_volume_of_a_plate() {
    let mesh = grid(20, 20, |u, v| DVec3::new(u, v, 0.0));
    let done = closed(&mesh, RepairParams::new().with_wall(0.1));
    assert_whole(&mesh, &done);
    assert!((volume(&done.mesh).abs() - 0.1).abs() < 1e-9);
}
