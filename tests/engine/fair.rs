//! `isomend fair` removes noise, keeps the shape, and leaves unmarked faces unchanged.

use std::process::Output;

use crate::shapes;
use assert_cmd::Command;
use glam::{DVec2, DVec3};
use isomend::Attributes;
use isomend::io::{WriteOptions, read_path, write_path};
use isomend::{FairError, FairExtent, FairParams, Faired, Mesh, RestoreError, fair, inspect};
use isomend::{Mask, Selector};
use serde_json::Value;
use tempfile::TempDir;

/// A pseudo-random number from the standard normal distribution.
fn chance(i: usize, axis: usize) -> f64 {
    let uniform = |salt: f64| {
        let x = ((3 * i + axis) as f64 * 12.9898 + salt).sin() * 43_758.545_3;
        x - x.floor()
    };
    let (u, v) = (uniform(0.37).max(1e-12), uniform(4.11));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// The mesh with noise along its normals, of root mean square `noise`.
fn noisy(mesh: &Mesh, noise: f64, normal: impl Fn(DVec3) -> DVec3) -> Mesh {
    let mut mesh = mesh.clone();
    for (i, p) in mesh.positions.iter_mut().enumerate() {
        *p += noise * chance(i, 0) * normal(*p);
    }
    mesh
}

fn torus_normal(p: DVec3) -> DVec3 {
    let ring = shapes::BIG * DVec3::new(p.x, p.y, 0.0).normalize();
    (p - ring).normalize()
}

fn rms(mesh: &Mesh, distance: impl Fn(DVec3) -> f64) -> f64 {
    let square: f64 = mesh.positions.iter().map(|p| distance(*p).powi(2)).sum();
    (square / mesh.positions.len() as f64).sqrt()
}

/// A mesh, the distance from its true surface, and its Euler number.
type Case = (Mesh, fn(DVec3) -> f64, i64);

fn strength(length: f64) -> FairParams {
    let mut params = FairParams::default();
    params.extent = FairExtent::Strength(length);
    params
}

fn assert_closed(mesh: &Mesh, euler: i64) {
    let found = inspect(mesh).expect("a sound mesh");
    assert!(found.holes.is_empty() && found.topology.defects.non_manifold_edges == 0);
    let edges = mesh.faces.len() * 3 / 2;
    assert_eq!(
        mesh.positions.len() as i64 - edges as i64 + mesh.faces.len() as i64,
        euler
    );
}

fn assert_sound(faired: &Faired) {
    for region in &faired.fill.regions {
        assert!(region.converged && region.intersecting_faces == 0);
        let flow = &region.levels.last().expect("a level").flow;
        assert!(flow.energy_after < flow.energy_before, "{flow:?}");
    }
}

#[test]
fn noise_on_a_sphere_and_a_clifford_torus_falls_to_less_than_half() {
    let sphere = |p: DVec3| p.length() - 1.0;
    let cases: [Case; 2] = [
        (
            noisy(&shapes::sphere(12), 0.01, DVec3::normalize),
            sphere,
            2,
        ),
        (
            noisy(&shapes::torus(90, 60), 0.01, torus_normal),
            shapes::torus_distance,
            0,
        ),
    ];
    for (mesh, distance, euler) in cases {
        let before = rms(&mesh, distance);
        let faired = fair(&mesh, None, &FairParams::default()).expect("a faired mesh");
        let after = rms(&faired.mesh, distance);
        assert!(after < 0.5 * before, "{before} -> {after}");
        assert_closed(&faired.mesh, euler);
        assert_sound(&faired);
        let report = &faired.report;
        assert!(report.whole && faired.kept.is_none());
        let drift = report.volume_drift().expect("a volume");
        assert!(drift.abs() < 0.02, "{drift}");
        assert!(report.moved_max < 0.06 && report.moved_rms < 0.02);
    }
}

#[test]
fn a_sphere_keeps_its_shape_and_strength_converts_to_time() {
    let mesh = shapes::sphere(10);
    let length = 1.2;
    let by_strength = fair(&mesh, None, &strength(length)).expect("a faired mesh");
    assert!(rms(&by_strength.mesh, |p| p.length() - 1.0) < 4e-3);
    let time = (length / std::f64::consts::TAU).powi(4);
    assert!((by_strength.report.time / time - 1.0).abs() < 1e-12);
    let mut by_time = FairParams::default();
    by_time.extent = FairExtent::Time(time);
    let by_time = fair(&mesh, None, &by_time).expect("a faired mesh");
    assert!((by_time.report.strength / length - 1.0).abs() < 1e-12);
    let steps = |faired: &Faired| faired.fill.regions[0].levels[0].flow.steps.len();
    assert!(steps(&by_time) > steps(&by_strength));
}

fn ball(mesh: &Mesh, centre: DVec3, radius: f64) -> Vec<bool> {
    let mask = Mask {
        selectors: vec![Selector::Ball { centre, radius }],
        ..Mask::default()
    };
    mask.faces(mesh, &Attributes::default()).expect("a mask")
}

#[test]
fn fairing_a_marked_region_halves_its_noise_and_keeps_the_rest() {
    let centre = DVec3::new(0.3, 0.4, 0.5).normalize();
    let clean = shapes::sphere(16);
    let mut mesh = noisy(&clean, 0.01, DVec3::normalize);
    for (p, q) in mesh.positions.iter_mut().zip(&clean.positions) {
        if q.distance(centre) > 0.6 {
            *p = *q;
        }
    }
    let marked = ball(&mesh, centre, 0.7);
    let faired = fair(&mesh, Some(&marked), &strength(0.8)).expect("a faired mesh");
    assert_sound(&faired);
    let kept = faired.kept.expect("a part that is kept");
    let (vertices, faces) = (kept.mesh.positions.len(), kept.mesh.faces.len());
    assert_eq!(faired.mesh.positions[..vertices], kept.mesh.positions[..]);
    assert_eq!(faired.mesh.faces[..faces], kept.mesh.faces[..]);
    assert_closed(&faired.mesh, 2);
    let off = |p: &&DVec3| (p.length() - 1.0).powi(2);
    let part = |mesh: &Mesh, from: usize| {
        let near: Vec<DVec3> = mesh.positions[from..]
            .iter()
            .filter(|p| p.distance(centre) < 0.6)
            .copied()
            .collect();
        (near.iter().map(|p| off(&p)).sum::<f64>() / near.len() as f64).sqrt()
    };
    let (before, after) = (part(&mesh, 0), part(&faired.mesh, vertices));
    assert!(after < 0.5 * before, "{before} -> {after}");
}

#[test]
fn a_faired_band_round_a_tube_keeps_its_topology() {
    let mesh = noisy(&shapes::torus(90, 60), 0.005, torus_normal);
    let marked: Vec<bool> = mesh
        .faces
        .iter()
        .map(|f| {
            let p = f.map(|v| mesh.positions[v as usize]).iter().sum::<DVec3>() / 3.0;
            p.x > 0.0 && p.y.abs() < 1.2
        })
        .collect();
    let faired = fair(&mesh, Some(&marked), &FairParams::default()).expect("a faired mesh");
    assert_closed(&faired.mesh, 0);
    assert_sound(&faired);
    assert_eq!(faired.fill.regions.len(), 1);
}

#[test]
fn fairing_an_open_mesh_keeps_its_boundary_loop() {
    let mesh = noisy(&shapes::sphere(16), 0.01, DVec3::normalize);
    let mesh = shapes::cut(&mesh, |p| p.z < -0.75);
    let faired = fair(&mesh, None, &strength(0.5)).expect("a faired mesh");
    assert_sound(&faired);
    let (before, after) = (inspect(&mesh), inspect(&faired.mesh));
    let (before, after) = (before.expect("a mesh"), after.expect("a mesh"));
    assert_eq!((before.holes.len(), after.holes.len()), (1, 1));
    assert_eq!(before.holes[0].edges, after.holes[0].edges);
    assert_eq!(
        before.holes[0].length.to_bits(),
        after.holes[0].length.to_bits()
    );
    assert!(faired.report.volume_drift().is_none());
    let distance = |p: DVec3| if p.z > -0.3 { p.length() - 1.0 } else { 0.0 };
    assert!(rms(&faired.mesh, distance) < 0.5 * rms(&mesh, distance));
}

#[test]
fn a_thin_wall_opposite_a_boundary_loop_is_faired() {
    // Opposite the fixed strip round the hole, the lens is nearer to this strip than to any face that evolves.
    let mut lens = shapes::sphere(20);
    lens.positions.iter_mut().for_each(|p| p.z *= 0.25);
    let mesh = shapes::cut(&lens, |p| p.z < 0.0 && DVec2::new(p.x, p.y).length() < 0.25);
    let faired = fair(&mesh, None, &strength(0.5)).expect("a faired mesh");
    assert_sound(&faired);
    let found = inspect(&faired.mesh).expect("a sound mesh");
    assert_eq!(
        (found.holes.len(), found.topology.component_faces.len()),
        (1, 1)
    );
    assert!(
        faired.report.moved_max < 0.05,
        "{}",
        faired.report.moved_max
    );
    let kept = faired.kept.expect("what is kept");
    assert!(kept.mesh.positions.iter().all(|p| p.z < 0.0));
}

#[test]
fn invalid_masks_voxels_and_strengths_are_refused() {
    let mesh = shapes::sphere(6);
    let none = vec![false; mesh.faces.len()];
    let error = fair(&mesh, Some(&none), &FairParams::default()).unwrap_err();
    assert!(matches!(
        error,
        FairError::Restore(RestoreError::NothingMarked)
    ));
    let mut tiny = FairParams::default();
    tiny.voxel = isomend::VoxelSize::Length(1e-5);
    let error = fair(&mesh, None, &tiny).unwrap_err();
    assert!(matches!(error, FairError::TooFine { .. }), "{error}");
    let edge = 1.0 / 6.0;
    let error = fair(&mesh, None, &strength(edge)).unwrap_err();
    let FairError::TooWeak { fits, .. } = error else {
        panic!("{error}");
    };
    assert!((edge..2.0 * edge).contains(&fits), "{fits}");
    assert!(error.to_string().contains("the smallest strength"));
    assert!(fair(&mesh, None, &strength(1.001 * fits)).is_ok());
    let cap = shapes::cut(&mesh, |p| p.z < 0.8);
    let error = fair(&cap, None, &strength(2.0)).unwrap_err();
    assert!(matches!(error, FairError::OnlyBorder { .. }), "{error}");
}

struct Folder(TempDir);

impl Folder {
    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::cargo_bin("isomend").expect("the program");
        command.current_dir(self.0.path()).args(arguments);
        command.output().expect("an output")
    }
}

#[test]
fn the_command_fairs_and_reports() {
    let folder = Folder(TempDir::new().expect("a folder"));
    let mesh = noisy(&shapes::sphere(8), 0.01, DVec3::normalize);
    let path = folder.0.path().join("in.ply");
    write_path(&path, &mesh, None, &WriteOptions::default()).expect("a file");
    let whole = folder.run(&["fair", "in.ply", "-o", "out.ply", "--json", "-"]);
    assert!(whole.status.success(), "{whole:?}");
    let report: Value = serde_json::from_slice(&whole.stdout).expect("JSON");
    assert_eq!(report["command"], "fair");
    assert_eq!(report["whole"], true);
    assert!(report["volume_drift"].as_f64().expect("a number").abs() < 0.05);
    let said = String::from_utf8_lossy(&whole.stderr).into_owned();
    assert!(said.contains("the volume changed by"), "{said}");
    let ball = ["--ball", "0,0,1,0.7", "--strength", "0.6"];
    let files = ["fair", "in.ply", "-o", "part.ply", "--threads", "1"];
    assert!(folder.run(&[&files[..], &ball].concat()).status.success());
    let two = ["fair", "in.ply", "-o", "two.ply", "--threads", "2"];
    assert!(folder.run(&[&two[..], &ball].concat()).status.success());
    let read = |name: &str| std::fs::read(folder.0.path().join(name)).expect("a file");
    assert!(read("part.ply") == read("two.ply"));
    let back = read_path(&folder.0.path().join("part.ply"), None).expect("a mesh");
    assert_closed(&back.mesh, 2);
    let both = [
        "fair",
        "in.ply",
        "-o",
        "x.ply",
        "--time",
        "1",
        "--strength",
        "1",
    ];
    assert_eq!(folder.run(&both).status.code(), Some(2));
}
