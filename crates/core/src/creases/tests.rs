//! Tests of creases on solids whose shape is known.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3, IVec3};

use super::*;
use crate::cancel::Cancel;
use crate::mesh::shapes::{grid, icosphere, punch};
use crate::mesh::{Mesh, Topology, VertexFaces, area_vector, find_holes};

/// Continues the creases that end at a rim, or fills a rim that runs along creases with its one side.
fn continue_creases(mesh: &Mesh, rim: &[u32]) -> Result<Continued, CreaseRefusal> {
    RimSides::new(mesh, &VertexFaces::new(mesh), rim, &Cancel::new())?
        .continued(mesh.positions.len())
}

/// The boundary of the union of unit cells in a box for which `is_in` is true; a cell is given by its lowest corner.
fn cells(size: IVec3, is_in: impl Fn(IVec3) -> bool) -> Mesh {
    let is_in = |c: IVec3| c.cmpge(IVec3::ZERO).all() && c.cmplt(size).all() && is_in(c);
    let (mut mesh, mut number) = (Mesh::default(), HashMap::new());
    for cell in 0..size.element_product() {
        let cell = IVec3::new(
            cell % size.x,
            cell / size.x % size.y,
            cell / (size.x * size.y),
        );
        for axis in 0..3 {
            for side in [0, 1] {
                let outwards = IVec3::AXES[axis] * (2 * side - 1);
                if !is_in(cell) || is_in(cell + outwards) {
                    continue;
                }
                let [u, v] = [IVec3::AXES[(axis + 1) % 3], IVec3::AXES[(axis + 2) % 3]];
                let low = cell + IVec3::AXES[axis] * side;
                let mut corners = [low, low + u, low + u + v, low + v];
                if side == 0 {
                    corners.reverse();
                }
                let [a, b, c, d] = corners.map(|p| {
                    *number.entry(p).or_insert_with(|| {
                        mesh.positions.push(p.as_dvec3());
                        mesh.positions.len() as u32 - 1
                    })
                });
                mesh.faces.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

/// The mesh without the faces in a ball, and the rim of that hole.
fn with_hole(mesh: &Mesh, centre: DVec3, radius: f64) -> (Mesh, Vec<u32>) {
    rim_of(punch(mesh, |c| c.distance(centre) < radius))
}

fn rim_of(mut mesh: Mesh) -> (Mesh, Vec<u32>) {
    let mut topology = Topology::new(&mut mesh);
    let (holes, _) = find_holes(&mesh, &mut topology);
    (mesh, holes[0].rim.clone())
}

fn joined(mesh: &Mesh, patch: &Continued) -> Mesh {
    let positions = [&mesh.positions[..], &patch.positions].concat();
    Mesh::new(positions, [&mesh.faces[..], &patch.faces].concat())
}

fn volume(mesh: &Mesh) -> f64 {
    let corners = (0..mesh.faces.len() as u32).map(|f| mesh.corners(f));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

fn area(mesh: &Mesh) -> f64 {
    let corners = (0..mesh.faces.len() as u32).map(|f| mesh.corners(f));
    corners.map(|c| area_vector(c).length()).sum()
}

/// Checks that a solid of cells with a hole regains its volume and area; returns the creases.
fn check_restored(solid: &Mesh, centre: DVec3, radius: f64) -> Vec<Crease> {
    let (mesh, rim) = with_hole(solid, centre, radius);
    let patch = continue_creases(&mesh, &rim).unwrap();
    let whole = joined(&mesh, &patch);
    assert!((volume(&whole) - volume(solid)).abs() < 1e-9 * volume(solid));
    assert!((area(&whole) - area(solid)).abs() < 1e-9 * area(solid));
    let edges = Topology::new(&mut whole.clone());
    assert!(edges.boundary.iter().all(|open| !open));
    patch.creases
}

fn cube() -> Mesh {
    cells(IVec3::splat(12), |_| true)
}

#[test]
fn edges_and_corners_of_solids_come_back() {
    let centre = DVec3::new(6.0, 0.0, 12.0);
    let edge = check_restored(&cube(), centre, 3.2);
    assert_eq!(edge.len(), 1);
    assert!((edge[0].angle - 90.0).abs() < 1e-6 && (edge[0].length - 6.0).abs() < 1.5);
    assert_eq!(
        check_restored(&cube(), DVec3::new(0.0, 0.0, 12.0), 3.2).len(),
        3
    );
    // A concave edge, its end at a flat side, and a slot with two convex and two concave edges.
    let step = cells(IVec3::splat(12), |c| c.x < 6 || c.z < 6);
    assert_eq!(
        check_restored(&step, DVec3::new(6.0, 6.0, 6.0), 3.2).len(),
        1
    );
    assert_eq!(
        check_restored(&step, DVec3::new(6.0, 0.0, 6.0), 3.2).len(),
        3
    );
    let slot = cells(IVec3::new(16, 12, 8), |c| {
        c.z < 5 || !(6..10).contains(&c.x)
    });
    assert_eq!(
        check_restored(&slot, DVec3::new(8.0, 6.0, 5.0), 3.2).len(),
        2
    );
}

#[test]
fn a_hole_beside_an_edge_is_filled_in_its_own_side() {
    let own = |c: DVec3| c.z > 11.9 && c.y < 3.0 && (4.0..8.0).contains(&c.x);
    let (mesh, rim) = rim_of(punch(&cube(), own));
    let patch = continue_creases(&mesh, &rim).unwrap();
    assert!(patch.creases.is_empty());
    assert!(patch.positions.iter().all(|p| (p.z - 12.0).abs() < 1e-12));
    // Far from edges the flat side is continued.
    let (mesh, rim) = with_hole(&cube(), DVec3::new(6.0, 6.0, 12.0), 2.2);
    let patch = continue_creases(&mesh, &rim).unwrap();
    assert!(patch.is_flat && patch.creases.is_empty());
    assert!(patch.positions.iter().all(|p| (p.z - 12.0).abs() < 1e-12));
}

/// Size of a block with rounded edges.
const BLOCK: DVec3 = DVec3::new(24.0, 12.0, 12.0);

/// The block with rounded edges and corners, and noise.
fn rounded_block(radius: f64, noise_part: f64) -> Mesh {
    let mut mesh = cells(IVec3::new(48, 24, 24), |_| true);
    for (i, p) in mesh.positions.iter_mut().enumerate() {
        let at = 0.5 * *p;
        let inner = at.clamp(DVec3::splat(radius), BLOCK - radius);
        let noise = DVec3::new(noise(3 * i), noise(3 * i + 1), noise(3 * i + 2)) - 0.5;
        *p = inner + radius * (at - inner).normalize() + noise_part * noise;
    }
    mesh
}

/// Distance of a point from the surface of the rounded block.
fn off_rounded_block(p: DVec3, radius: f64) -> f64 {
    let inner = p.clamp(DVec3::splat(radius), BLOCK - radius);
    (p.distance(inner) - radius).abs()
}

#[test]
fn rounded_edges_and_corners_are_found_with_their_radius() {
    for (centre, noise) in [
        (DVec3::new(12.0, 0.0, 12.0), 0.0),
        (DVec3::new(0.6, 0.6, 11.4), 0.0),
        (DVec3::new(12.0, 0.0, 12.0), 0.02),
        (DVec3::new(0.6, 0.6, 11.4), 0.02),
    ] {
        let (mesh, rim) = with_hole(&rounded_block(2.5, noise), centre, 2.4);
        let model = Rounded::find(&mesh, &VertexFaces::new(&mesh), &rim, &Cancel::new()).unwrap();
        assert!(
            (model.radius - 2.5).abs() < 1e-6 + noise,
            "{}",
            model.radius
        );
        let far = centre + 0.2 * (centre - 0.5 * BLOCK);
        let on = [far, centre, centre + DVec3::X].map(|p| model.onto(p));
        for p in on {
            let off = off_rounded_block(p, 2.5);
            assert!(off < 1e-5 + noise, "{centre} {noise} {off}");
        }
    }
}

#[test]
fn sharp_and_smooth_shapes_have_no_rounded_edges() {
    let smooth = rim_of_ball(&icosphere(4), DVec3::X, 0.5);
    let sharp = with_hole(&cube(), DVec3::new(6.0, 0.0, 12.0), 3.2);
    let flat = with_hole(&cube(), DVec3::new(6.0, 6.0, 12.0), 2.2);
    for (mesh, rim) in [smooth, sharp, flat] {
        assert!(Rounded::find(&mesh, &VertexFaces::new(&mesh), &rim, &Cancel::new()).is_none());
    }
}

#[test]
fn smooth_surfaces_have_no_creases() {
    let tube = grid(48, 24, [true, false], |u, v| {
        DVec3::new((TAU * u).cos(), (TAU * u).sin(), 3.0 * v)
    });
    let solids = [
        (icosphere(4), DVec3::X, 0.5),
        (tube, DVec3::new(1.0, 0.0, 1.5), 0.5),
    ];
    for (mesh, centre, radius) in solids {
        let (mesh, rim) = rim_of_ball(&mesh, centre, radius);
        let why = continue_creases(&mesh, &rim).unwrap_err();
        assert!(
            matches!(why, CreaseRefusal::OneSide | CreaseRefusal::Smooth),
            "{why:?}"
        );
    }
}

/// The mesh with a hole from a ball, and the rim of that hole among the rims of an open mesh.
fn rim_of_ball(mesh: &Mesh, centre: DVec3, radius: f64) -> (Mesh, Vec<u32>) {
    nearest_rim(punch(mesh, |c| c.distance(centre) < radius), centre)
}

fn nearest_rim(mut mesh: Mesh, centre: DVec3) -> (Mesh, Vec<u32>) {
    let mut topology = Topology::new(&mut mesh);
    let (holes, _) = find_holes(&mesh, &mut topology);
    let nearest = holes.iter().min_by(|a, b| {
        let away = |h: &crate::mesh::Hole| h.centre.distance(centre);
        away(a).total_cmp(&away(b))
    });
    let rim = nearest.unwrap().rim.clone();
    (mesh, rim)
}

#[test]
fn the_end_edge_of_a_cylinder_is_a_circle() {
    // A cylinder of radius 1: its side, then rings of its end face.
    let mesh = grid(96, 40, [true, false], |u, v| {
        let (radius, z) = if v <= 0.5 {
            (1.0, 4.0 * v - 2.0)
        } else {
            (2.0 - 2.0 * v, 0.0)
        };
        let angle = TAU * u;
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    });
    let (mesh, rim) = rim_of_ball(&mesh, DVec3::X, 0.4);
    let patch = continue_creases(&mesh, &rim).unwrap();
    assert_eq!(patch.creases.len(), 1);
    // About the length of the arc, 2 · 2 asin(0.2).
    assert!(
        (patch.creases[0].length - 0.81).abs() < 0.12,
        "{:?}",
        patch.creases
    );
    for p in &patch.positions {
        let off = if p.z < -1e-3 {
            p.truncate().length() - 1.0
        } else {
            p.z
        };
        assert!(off.abs() < 3e-3, "{p} {off}");
    }
}

#[test]
fn a_hole_beside_the_base_of_a_cone_is_filled_on_the_cone() {
    // A truncated cone whose radius falls from 1 to 0.2, then rings of its base.
    let mesh = grid(96, 48, [true, false], |u, v| {
        let (radius, z) = if v <= 0.75 {
            (0.2 + 0.8 * v / 0.75, 0.75 - v)
        } else {
            (4.0 - 4.0 * v, 0.0)
        };
        let angle = TAU * u;
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    });
    let on_cone = |c: DVec3| c.z > 1e-3 && c.distance(DVec3::X) < 0.4;
    let centre = DVec3::new(0.8, 0.0, 0.15);
    let (mesh, rim) = nearest_rim(punch(&mesh, on_cone), centre);
    let patch = continue_creases(&mesh, &rim).unwrap();
    assert!(patch.creases.is_empty() && patch.positions.len() > 20);
    // Along a line of the cone the radius falls by 0.8 / 0.75 of the height; chords of the grid are 5e-4 inside the cone.
    let off = |p: &DVec3| (p.truncate().length() + 0.8 / 0.75 * p.z - 1.0).abs();
    let off = patch.positions.iter().map(off).fold(0.0, f64::max);
    assert!(off < 2e-3, "{off}");
}

/// Largest distance along z of a patch's points from a surface z(x, y).
fn off_graph(patch: &Continued, z: impl Fn(f64, f64) -> f64) -> f64 {
    let off = patch.positions.iter().map(|p| (p.z - z(p.x, p.y)).abs());
    off.fold(0.0, f64::max)
}

#[test]
fn sides_that_are_no_quadrics_are_continued_with_the_residuals_of_their_vertices() {
    // A ridge along x = 0 with a wavy side.
    let z = |x: f64, y: f64| match x > 0.0 {
        true => -0.8 * x + 0.015 * (2.0 * y).sin() * x,
        false => x,
    };
    let mesh = grid(40, 40, [false, false], |u, v| {
        let (x, y) = (4.0 * u - 2.0, 4.0 * v - 2.0);
        DVec3::new(x, y, z(x, y))
    });
    let (mesh, rim) = rim_of_ball(&mesh, DVec3::ZERO, 0.7);
    let mut sides = RimSides::new(&mesh, &VertexFaces::new(&mesh), &rim, &Cancel::new()).unwrap();
    let count = mesh.positions.len();
    let plain = off_graph(&sides.continued(count).unwrap(), z);
    assert!(sides.refine());
    let refined = off_graph(&sides.continued(count).unwrap(), z);
    assert!(refined < 0.5 * plain, "{plain} {refined}");
    // Flat sides have no residuals.
    let (mesh, rim) = with_hole(&cube(), DVec3::new(6.0, 0.0, 12.0), 3.2);
    let mut flat = RimSides::new(&mesh, &VertexFaces::new(&mesh), &rim, &Cancel::new()).unwrap();
    assert!(!flat.refine());
}

#[test]
fn a_crease_that_turns_back_is_followed_round() {
    // A bowl z = 0.35 (r² − 1) in the plane z = 0, and a hole over most of its circular edge.
    let z = |x: f64, y: f64| f64::min(0.0, 0.35 * (x * x + y * y - 1.0));
    let mesh = grid(80, 40, [true, false], |u, v| {
        let (angle, r) = (TAU * u, 0.05 + 1.9 * v);
        let (x, y) = (r * angle.cos(), r * angle.sin());
        DVec3::new(x, y, z(x, y))
    });
    let is_out = |c: DVec3| (0.65..1.35).contains(&c.truncate().length()) && c.y.abs() > 0.7 * c.x;
    let (mesh, rim) = nearest_rim(punch(&mesh, is_out), DVec3::NEG_X);
    let patch = continue_creases(&mesh, &rim).unwrap();
    assert_eq!(patch.creases.len(), 1, "{:?}", patch.creases);
    assert!(patch.creases[0].length > 3.5, "{:?}", patch.creases);
    let off = off_graph(&patch, z);
    assert!(off < 0.03, "{off}");
}

/// A pseudo-random number from 0 to 1.
fn noise(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43_758.545;
    x - x.floor()
}

/// An outline that touches itself is cut into loops.
#[test]
fn loops_of_an_outline_are_simple() {
    let loops = super::network::simple_loops(&[0, 1, 2, 3, 4, 2, 5, 1]);
    assert_eq!(loops, [vec![2, 3, 4], vec![1, 2, 5]]);
    assert_eq!(super::network::simple_loops(&[4, 5, 6]), [vec![4, 5, 6]]);
}

/// A hole whose rim runs along an edge of the cube and then into both of its sides.
#[test]
fn a_crease_may_touch_the_rim() {
    let is_out = |c: DVec3| {
        let top = c.z > 11.9 && c.y < 3.0 && (3.0..9.0).contains(&c.x);
        let front = c.y < 0.1 && c.z > 9.0 && (c.x > 3.0 && c.x < 5.0 || c.x > 7.0 && c.x < 9.0);
        top || front
    };
    let (mesh, rim) = rim_of(punch(&cube(), is_out));
    let patch = continue_creases(&mesh, &rim).unwrap();
    let whole = joined(&mesh, &patch);
    assert!((volume(&whole) - volume(&cube())).abs() < 1e-6);
    assert!((area(&whole) - area(&cube())).abs() < 1e-6);
}

#[test]
fn noise_moves_an_edge_by_less_than_its_own_size() {
    let mut solid = cube();
    for (i, p) in solid.positions.iter_mut().enumerate() {
        *p += 0.1 * (DVec3::new(noise(3 * i), noise(3 * i + 1), noise(3 * i + 2)) - 0.5);
    }
    let (mesh, rim) = with_hole(&solid, DVec3::new(6.0, 0.0, 12.0), 3.2);
    let patch = continue_creases(&mesh, &rim).unwrap();
    assert_eq!(patch.creases.len(), 1);
    for p in &patch.positions {
        assert!(f64::max(-p.y, p.z - 12.0).abs() < 0.05, "{p}");
    }
}

#[test]
fn it_does_not_depend_on_place_size_or_where_the_rim_begins() {
    let (mesh, rim) = with_hole(&cube(), DVec3::new(0.0, 0.0, 12.0), 3.2);
    let plain = continue_creases(&mesh, &rim).unwrap();
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.3 * PI);
    for (scale, shift) in [(1.0, 0.0), (1e-3, 0.0), (1e3, 5e6)] {
        let move_by = |p: DVec3| turn * p * scale + DVec3::splat(shift);
        let positions = mesh.positions.iter().map(|p| move_by(*p)).collect();
        let moved = Mesh::new(positions, mesh.faces.clone());
        let mut turned = rim.clone();
        turned.rotate_left(5);
        let patch = continue_creases(&moved, &turned).unwrap();
        assert_eq!(patch.creases.len(), 3);
        let all = joined(&moved, &patch);
        let restored = joined(&mesh, &plain);
        let ratio = area(&all) / area(&restored) / (scale * scale);
        assert!((ratio - 1.0).abs() < 1e-8, "{scale} {shift} {ratio}");
    }
}
