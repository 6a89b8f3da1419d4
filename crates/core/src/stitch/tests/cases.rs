//! Tests: patches of holes in known surfaces must close them and be on the surface.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;

use super::shapes::*;
use crate::mesh::Mesh;
use crate::sdf::Surface;
use crate::stitch::{Patch, StitchInput, StitchParams, stitch};

pub struct Case {
    pub mesh: Mesh,
    pub loops: Vec<Vec<u32>>,
    pub surface: Analytic,
    pub voxel: f64,
}

impl Case {
    pub fn new(mesh: Mesh, loops: Vec<Vec<u32>>, surface: Analytic, voxel: f64) -> Self {
        let surface = surface.with_mesh(&mesh, &loops);
        Self {
            mesh,
            loops,
            surface,
            voxel,
        }
    }

    /// Stitches without facet compensation, so that vertices are on the surface.
    pub fn stitch_on_surface(&self) -> Patch {
        self.stitch(StitchParams {
            facet_compensation: 0.0,
            ..StitchParams::default()
        })
    }

    pub fn stitch(&self, params: StitchParams) -> Patch {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &v in self.loops.iter().flatten() {
            low = low.min(self.mesh.positions[v as usize]);
            high = high.max(self.mesh.positions[v as usize]);
        }
        let margin = DVec3::splat(0.6 * (high - low).max_element());
        let extracted = extract(&self.surface, low - margin, high + margin, self.voxel);
        let input = StitchInput {
            mesh: &self.mesh,
            loops: &self.loops,
            surface: &self.surface,
            extracted: &extracted,
            voxel: self.voxel,
            params,
        };
        stitch(&input).expect("the patch")
    }
}

/// Asserts that the mesh with the patch is manifold and oriented, and closed except for `open` boundary edges; returns it.
pub fn assert_joined(mesh: &Mesh, patch: &Patch, open: usize) -> Mesh {
    let mut whole = mesh.clone();
    whole.positions.extend(&patch.positions);
    whole.faces.extend(&patch.faces);
    let mut edges = HashMap::new();
    for f in &whole.faces {
        for k in 0..3 {
            assert_ne!(f[k], f[(k + 1) % 3]);
            let n = edges.entry((f[k], f[(k + 1) % 3])).or_insert(0);
            *n += 1;
            assert_eq!(*n, 1, "directed edge twice");
        }
    }
    let single = edges
        .keys()
        .filter(|(a, b)| !edges.contains_key(&(*b, *a)))
        .count();
    assert_eq!(single, open, "boundary edges");
    whole
}

pub fn euler(mesh: &Mesh) -> i64 {
    let mut edges = std::collections::HashSet::new();
    let mut used = std::collections::HashSet::new();
    for f in &mesh.faces {
        for k in 0..3 {
            edges.insert((f[k].min(f[(k + 1) % 3]), f[k].max(f[(k + 1) % 3])));
            used.insert(f[k]);
        }
    }
    used.len() as i64 - edges.len() as i64 + mesh.faces.len() as i64
}

pub fn sphere() -> Analytic {
    Analytic::new(|p| p.length() - 1.0)
}

pub fn ragged_cap(seed: u64, rag: f64, across: f64) -> Case {
    let mut noise = Noise(seed);
    let mut mesh = icosphere(4);
    jitter(&mut mesh, &sphere(), 0.015, &mut noise);
    let mesh = punch(&mesh, |c| c.normalize().z > 0.5 + rag * noise.next());
    let loops = boundary_loops(&mesh);
    Case::new(mesh, loops, sphere(), 1.7 / across)
}

pub fn torus(p: DVec3) -> f64 {
    let q = p.truncate().length() - 2f64.sqrt();
    (q * q + p.z * p.z).sqrt() - 1.0
}

pub fn catenoid(p: DVec3) -> f64 {
    (p.truncate().length() - p.z.cosh()) / p.z.cosh()
}

/// Stitches and asserts what holds for every patch. Without facet compensation the vertices must also be on the surface; returns
/// that patch.
fn check(case: &Case, wanted_euler: i64, open: usize) -> Patch {
    check_joined(
        case,
        &case.stitch(StitchParams::default()),
        wanted_euler,
        open,
    );
    let patch = case.stitch_on_surface();
    check_joined(case, &patch, wanted_euler, open);
    for &p in &patch.positions {
        let off = case
            .surface
            .project(p)
            .map_or(f64::INFINITY, |(q, _)| q.distance(p));
        assert!(off < 1e-7, "{p} is {off} from the surface");
    }
    patch
}

fn check_joined(case: &Case, patch: &Patch, wanted_euler: i64, open: usize) {
    let whole = assert_joined(&case.mesh, patch, open);
    assert_eq!(euler(&whole), wanted_euler);
    assert_eq!(
        whole.positions[..case.mesh.positions.len()],
        case.mesh.positions[..]
    );
    let report = &patch.report;
    assert_eq!(report.intersecting_faces, 0, "intersecting faces");
    assert!(
        report.quality_mean >= 0.85,
        "quality {}",
        report.quality_mean
    );
}

#[test]
fn ragged_caps() {
    for seed in 1..13 {
        let (rag, across) =
            [(0.05, 32.0), (0.2, 32.0), (0.1, 20.0), (0.3, 48.0)][seed as usize % 4];
        check(&ragged_cap(seed, rag, across), 2, 0);
    }
}

#[test]
fn torus_patch() {
    let mut mesh = grid(96, 64, [true, true], |u, v| {
        let (u, v) = (u * TAU, v * TAU);
        let w = 2f64.sqrt() + v.cos();
        DVec3::new(w * u.cos(), w * u.sin(), v.sin())
    });
    let mut noise = Noise(5);
    jitter(&mut mesh, &Analytic::new(torus), 0.02, &mut noise);
    for (centre, radius) in [
        (DVec3::new(2.414, 0.0, 0.0), 1.0),
        (DVec3::new(0.414, 0.0, 0.0), 0.5),
    ] {
        let mesh = punch(&mesh, |c| c.distance(centre) < radius);
        let loops = boundary_loops(&mesh);
        assert_eq!(loops.len(), 1);
        check(
            &Case::new(mesh, loops, Analytic::new(torus), radius / 16.0),
            0,
            0,
        );
    }
}

#[test]
fn catenoid_neck_joins_two_rims() {
    let mut mesh = grid(120, 40, [true, false], |u, v| {
        let z = 3.0 * v - 1.5;
        DVec3::new(z.cosh() * (u * TAU).cos(), z.cosh() * (u * TAU).sin(), z)
    });
    let outer = boundary_loops(&mesh).iter().map(Vec::len).sum::<usize>();
    let mut noise = Noise(6);
    jitter(&mut mesh, &Analytic::new(catenoid), 0.015, &mut noise);
    let mesh = punch(&mesh, |c| c.z.abs() < 0.7 + 0.05 * noise.next());
    let mut loops = boundary_loops(&mesh);
    loops.retain(|l| mesh.positions[l[0] as usize].z.abs() < 1.0);
    let patch = check(
        &Case::new(mesh, loops, Analytic::new(catenoid), 2.5 / 32.0),
        0,
        outer,
    );
    assert_eq!(patch.report.components, 1 + patch.report.filled_directly);
}

#[test]
fn island_in_a_hole() {
    let mut noise = Noise(8);
    let mut mesh = icosphere(4);
    jitter(&mut mesh, &sphere(), 0.015, &mut noise);
    let mesh = punch(&mesh, |c| (0.6..0.94).contains(&c.normalize().z));
    let loops = boundary_loops(&mesh);
    assert_eq!(loops.len(), 2);
    check(&Case::new(mesh, loops, sphere(), 1.6 / 32.0), 2, 0);
}

#[test]
fn small_islands_at_any_place() {
    let mut noise = Noise(9);
    let mut mesh = icosphere(4);
    jitter(&mut mesh, &sphere(), 0.015, &mut noise);
    for seed in 0..6 {
        let mut noise = Noise(seed);
        let mesh = punch(&mesh, |c| c.normalize().z > 0.6 && noise.next() > 0.02);
        let loops = boundary_loops(&mesh);
        check(&Case::new(mesh, loops, sphere(), 1.6 / 32.0), 2, 0);
    }
}

#[test]
fn plane_stays_flat() {
    let mut noise = Noise(10);
    let mut mesh = grid(40, 40, [false, false], |u, v| DVec3::new(u, v, 0.5));
    for p in &mut mesh.positions {
        let inside = (p.truncate() - 0.5).abs().max_element() < 0.49;
        *p += if inside {
            0.006 * noise.vector() * DVec3::new(1.0, 1.0, 0.0)
        } else {
            DVec3::ZERO
        };
    }
    let mesh = punch(&mesh, |c| {
        c.distance(DVec3::new(0.4, 0.5, 0.5)) < 0.25 + 0.03 * noise.next()
    });
    let mut loops = boundary_loops(&mesh);
    loops.retain(|l| !l.iter().any(|&v| mesh.positions[v as usize].x == 0.0));
    let case = Case::new(mesh, loops, Analytic::new(|p| p.z - 0.5), 0.5 / 32.0);
    let patch = check(&case, 1, 160);
    assert!(patch.report.seam_angle_max < 1e-4);
}

#[test]
fn far_from_the_origin() {
    let by = DVec3::new(1e6, -2e6, 5e5);
    let mut noise = Noise(11);
    let mut mesh = icosphere(4);
    jitter(&mut mesh, &sphere(), 0.015, &mut noise);
    let mut mesh = punch(&mesh, |c| c.normalize().z > 0.5);
    mesh.positions.iter_mut().for_each(|p| *p += by);
    let loops = boundary_loops(&mesh);
    let surface = Analytic::new(move |p| (p - by).length() - 1.0);
    let patch = Case::new(mesh.clone(), loops, surface, 1.7 / 32.0).stitch(StitchParams::default());
    assert_eq!(euler(&assert_joined(&mesh, &patch, 0)), 2);
    assert!(patch.report.quality_mean > 0.9 && patch.report.intersecting_faces == 0);
}

#[test]
fn uneven_rim() {
    let mut noise = Noise(12);
    for seed in 0..6 {
        let mut noise_mesh = Noise(seed + 50);
        let mut mesh = icosphere(3);
        jitter(&mut mesh, &sphere(), 0.04, &mut noise_mesh);
        let mesh = punch(&mesh, |c| c.normalize().z > 0.5 + 0.3 * noise.next());
        let loops = boundary_loops(&mesh);
        check(&Case::new(mesh, loops, sphere(), 1.7 / 40.0), 2, 0);
    }
}

#[test]
fn the_number_of_threads_does_not_show() {
    let case = ragged_cap(3, 0.2, 32.0);
    let run = |n| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build()
            .expect("a pool");
        pool.install(|| case.stitch(StitchParams::default()))
    };
    assert!(run(1) == run(3));
}
