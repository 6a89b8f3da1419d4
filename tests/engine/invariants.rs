//! Invariants of fills on shapes with known exact surfaces: kept input, topology, face quality and error bounds.

use std::f64::consts::PI;

use glam::DVec3;
use isomend::io::{Format, Precision, WriteOptions, to_bytes};
use isomend::{
    Closure, FillParams, Filled, Finish, HoleOutcome, HoleReport, LeftReason, Mesh, VoxelSize,
    fill, inspect,
};

use crate::shapes::{self, bits, cut, polar, topology, turn, turned};

/// Fills all holes and checks the invariants of every result.
fn fill_all(mesh: &Mesh, euler: i64) -> Filled {
    // Without the finish: it has its own tests, and other errors on coarse triangles.
    let mut params = FillParams::default();
    params.finish = Finish::None;
    let filled = fill(mesh, &params).unwrap();
    for hole in &filled.report.holes {
        let how = hole.outcome.closure();
        assert_eq!(how, Some(&Closure::LevelSet), "hole {}", hole.hole.id);
    }
    assert_kept(mesh, &filled.mesh);
    assert_eq!(
        topology(&filled.mesh),
        (0, euler),
        "closed and oriented; Euler number"
    );
    assert_eq!(shapes::pinched_vertices(&filled.mesh), 0);
    assert!(inspect(&filled.mesh).unwrap().holes.is_empty());
    for region in &filled.report.regions {
        assert!(region.converged);
        assert_eq!(region.intersecting_faces, 0);
        assert!(
            region.quality_mean > 0.85,
            "quality {:.3}",
            region.quality_mean
        );
    }
    filled
}

fn assert_kept(mesh: &Mesh, filled: &Mesh) {
    let count = mesh.positions.len();
    assert_eq!(bits(&filled.positions[..count]), bits(&mesh.positions));
    assert_eq!(filled.faces[..mesh.faces.len()], mesh.faces);
}

/// Root mean square distance of points on the patch's faces to the exact surface, in per mille of the hole's diameter. It
/// includes the error of flat faces.
fn error(mesh: &Mesh, filled: &Filled, distance: impl Fn(DVec3) -> f64) -> f64 {
    let back = turn().transpose();
    let (mut sum, mut area) = (0.0, 0.0);
    for face in &filled.mesh.faces[mesh.faces.len()..] {
        let [a, b, c] = face.map(|v| back * filled.mesh.positions[v as usize]);
        let weight = (b - a).cross(c - a).length();
        for i in 0..5 {
            for j in 0..5 - i {
                let (s, t) = (
                    (f64::from(i) + 1.0 / 3.0) / 5.0,
                    (f64::from(j) + 1.0 / 3.0) / 5.0,
                );
                sum += weight * distance(a + (b - a) * s + (c - a) * t).powi(2);
                area += weight;
            }
        }
    }
    let error = 1e3 * (sum / area).sqrt() / filled.report.regions[0].diameter;
    println!("error {error:.3} per mille");
    error
}

fn assert_sphere(mesh: &Mesh, bound: f64) {
    let mesh = turned(mesh.clone());
    let filled = fill_all(&mesh, 2);
    let found = error(&mesh, &filled, |p| p.length() - 1.0);
    assert!(found < bound, "{found} against {bound}");
}

#[test]
fn a_sphere_cap_of_30_degrees_is_filled_accurately() {
    assert_sphere(&cut(&shapes::sphere(14), |p| polar(p) < 30.0), 0.55);
}

#[test]
fn a_sphere_cap_of_60_degrees_is_filled_accurately() {
    assert_sphere(&cut(&shapes::sphere(14), |p| polar(p) < 60.0), 0.55);
}

#[test]
fn a_sphere_cap_of_90_degrees_is_filled_accurately() {
    assert_sphere(&cut(&shapes::sphere(14), |p| polar(p) < 90.0), 0.75);
}

#[test]
fn a_hole_with_an_island_is_filled_accurately() {
    let mesh = cut(&shapes::sphere(16), |p| (20.0..55.0).contains(&polar(p)));
    assert_sphere(&mesh, 0.26);
}

#[test]
fn a_hole_on_the_outer_side_of_a_torus_is_filled_accurately() {
    let at = DVec3::X * (shapes::BIG + 1.0);
    let mesh = turned(cut(&shapes::torus(64, 46), |p| p.distance(at) < 0.8));
    let filled = fill_all(&mesh, 0);
    assert!(error(&mesh, &filled, shapes::torus_distance) < 1.25);
}

#[test]
fn a_hole_on_the_inner_side_of_a_torus_is_filled_accurately() {
    let at = DVec3::X * (shapes::BIG - 1.0);
    let mesh = turned(cut(&shapes::torus(80, 56), |p| p.distance(at) < 0.35));
    let filled = fill_all(&mesh, 0);
    assert!(error(&mesh, &filled, shapes::torus_distance) < 0.9);
}

#[test]
fn the_neck_of_a_catenoid_between_two_rims_is_filled_as_one_region() {
    let mesh = turned(shapes::catenoid_neck(0.16));
    assert_eq!(inspect(&mesh).unwrap().topology.component_faces.len(), 2);
    let filled = fill_all(&mesh, 2);
    assert_eq!(
        filled.report.regions.len(),
        1,
        "one region bridges both rims"
    );
    assert!(error(&mesh, &filled, shapes::catenoid_distance) < 0.65);
}

#[test]
fn a_hole_in_the_flat_side_of_a_box_is_filled_flat() {
    let mesh = cut(&shapes::slab(9), |p| {
        p.z > shapes::HALF - 1e-9 && p.truncate().length() < 0.4
    });
    let mesh = turned(mesh);
    let filled = fill_all(&mesh, 2);
    assert!(error(&mesh, &filled, |p| p.z - shapes::HALF) < 0.01);
}

#[test]
fn fills_far_from_the_origin_and_at_other_scales_have_as_many_faces() {
    let near = turned(cut(&shapes::sphere(10), |p| polar(p) < 50.0));
    let reference = fill_all(&near, 2).mesh.faces.len();
    for (scale, offset) in [(1e-3, DVec3::ZERO), (1e4, DVec3::new(3e5, -2e6, 5e5))] {
        let mut mesh = near.clone();
        mesh.positions
            .iter_mut()
            .for_each(|p| *p = *p * scale + offset);
        let filled = fill_all(&mesh, 2);
        let ratio = filled.mesh.faces.len() as f64 / reference as f64;
        assert!((0.9..1.1).contains(&ratio), "{ratio}");
    }
}

#[test]
fn the_outer_border_of_a_sheet_stays_open_by_default() {
    let mesh = cut(&shapes::sheet(24), |p| {
        p.distance(DVec3::new(0.2, 0.1, 0.0)) < 0.3
    });
    let filled = fill(&mesh, &FillParams::default()).unwrap();
    assert_kept(&mesh, &filled.mesh);
    let left: Vec<_> = inspect(&filled.mesh).unwrap().holes;
    assert_eq!(left.len(), 1);
    assert!(left[0].outer_boundary);
    let HoleOutcome::Left(why) = &filled.report.holes[0].outcome else {
        panic!("{:?}", filled.report.holes[0].outcome);
    };
    assert_eq!(*why, LeftReason::OuterBoundary);
    assert!(!filled.report.incomplete());
}

#[test]
fn a_fill_of_a_closed_mesh_changes_nothing() {
    let mesh = shapes::sphere(6);
    let filled = fill(&mesh, &FillParams::default()).unwrap();
    assert_eq!(filled.mesh, mesh);
    assert!(filled.report.holes.is_empty() && filled.report.regions.is_empty());
}

#[test]
fn one_and_two_threads_give_the_same_bytes() {
    let at = |s: f64| DVec3::X * (shapes::BIG + s);
    let mesh = turned(cut(&shapes::torus(64, 46), |p| {
        p.distance(at(1.0)) < 0.8 || p.distance(-at(-1.0)) < 0.4
    }));
    let bytes = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let filled = pool
            .install(|| fill(&mesh, &FillParams::default()))
            .unwrap();
        let options = WriteOptions {
            precision: Precision::F64,
            ascii: false,
        };
        to_bytes(&filled.mesh, Format::Ply, &options).unwrap().bytes
    };
    assert!(bytes(1) == bytes(2));
}

/// Mean angle across the edges of a mesh, in degrees.
fn mean_angle(mesh: &Mesh) -> f64 {
    let normal = |f: usize| {
        let [a, b, c] = mesh.faces[f].map(|v| mesh.positions[v as usize]);
        (b - a).cross(c - a)
    };
    let found = inspect(mesh).unwrap();
    let beside = |h: usize| found.topology.opposite[h] as usize / 3;
    let inner = (0..3 * mesh.faces.len()).filter(|&h| !found.topology.boundary[h]);
    let angles: Vec<f64> = inner
        .map(|h| normal(h / 3).angle_between(normal(beside(h))).to_degrees())
        .collect();
    angles.iter().sum::<f64>() / angles.len() as f64
}

#[test]
fn the_seam_of_a_bumpy_sphere_is_no_sharper_than_its_bumps() {
    let mut mesh = shapes::sphere(24);
    for p in &mut mesh.positions {
        let [x, y, z] = (16.0 * *p + DVec3::new(1.0, 2.0, 0.5)).to_array();
        *p *= 1.0 + 0.02 * x.sin() * y.sin() * z.sin();
    }
    let mesh = cut(&mesh, |p| p.z > 0.82);
    let filled = fill_all(&mesh, 2);
    let seam = filled.report.regions[0].seam_angle_mean.unwrap();
    let around = mean_angle(&mesh);
    println!("{seam:.2} degrees, {around:.2} between the faces of the mesh");
    assert!(seam < 1.1 * around, "{seam} against {around}");
}

#[test]
fn patches_of_holes_that_touch_twice_share_no_edge() {
    // A ring of triangles without two of them: its upper and lower boundary touch at two vertices, and both boundary loops
    // pass through both vertices. The loops face each other and are filled together.
    let around = 8u32;
    let mut mesh = Mesh::default();
    for z in [0.0, 0.5625] {
        mesh.positions.extend((0..around).map(|i| {
            let (y, x) = (PI * f64::from(i) / 4.0).sin_cos();
            DVec3::new(x, y, z)
        }));
    }
    for i in 0..around {
        let [a, b] = [i, (i + 1) % around];
        if i != 0 {
            mesh.faces.push([a, b, a + around]);
        }
        if i != 3 {
            mesh.faces.push([b, b + around, a + around]);
        }
    }
    // The voxel is too coarse for a level set to reach the rims, so they are triangulated.
    let mut params = FillParams::default();
    params.voxel = VoxelSize::Length(1.2);
    let filled = fill(&mesh, &params).unwrap();
    let triangulated =
        |h: &HoleReport| matches!(h.outcome.closure(), Some(Closure::RimTriangles(_)));
    assert!(filled.report.holes.len() == 2 && filled.report.holes.iter().all(triangulated));
    assert_eq!(topology(&filled.mesh).0, 0, "edges without two faces");
}
