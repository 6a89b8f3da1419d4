//! Chips: holes that take away a part of the rounded edge of a wall.

use std::f64::consts::{PI, TAU};

use isomend::check::CheckParams;
use isomend::glam::{DVec2, DVec3};
use isomend::{Closure, FillParams, Mesh, Sharp, fill, inspect};

use crate::shapes::{Noise, cut, volume};

/// Half the thickness of the walls.
const HALF: f64 = 0.05;
/// Edges around the axis.
const AROUND: u32 = 150;

/// The middle of a wall, from the axis to its edge: a profile that is revolved about z.
type Middle = fn(f64) -> DVec2;

/// A bowl, a plate and a cup, and the lengths of their profiles.
const BODIES: [(&str, Middle, f64); 3] = [
    ("bowl", |s| DVec2::new(s.sin(), -s.cos()), 0.5 * PI),
    ("plate", |s| DVec2::new(s, 0.0), 1.0),
    ("cup", cup, 1.5),
];

/// Half a sphere of radius 0.5 under a cylinder.
fn cup(s: f64) -> DVec2 {
    let round = 0.25 * PI;
    let (t, z) = (2.0 * s.min(round), (s - round).max(0.0));
    DVec2::new(0.5 * t.sin(), z - 0.5 * t.cos())
}

/// The wall of a body: points at a distance of half the thickness from its middle.
fn body(middle: Middle, length: f64) -> Mesh {
    let rows = (length / 0.04).round() as u32;
    let normal = |s: f64| {
        let way = (middle(s + 1e-6) - middle(s - 1e-6)).normalize();
        DVec2::new(way.y, -way.x)
    };
    let along = |k: u32| length * f64::from(k) / f64::from(rows);
    let mut profile: Vec<DVec2> = Vec::new();
    profile.extend((0..rows).map(|k| middle(along(k)) + HALF * normal(along(k))));
    let way = normal(length).perp();
    profile.extend((0..=8).map(|k| {
        let t = PI * f64::from(k) / 8.0;
        middle(length) + HALF * (t.cos() * normal(length) + t.sin() * way)
    }));
    profile.extend(
        (0..rows)
            .rev()
            .map(|k| middle(along(k)) - HALF * normal(along(k))),
    );
    let count = profile.len() as u32 - 2;
    let mut mesh = Mesh::default();
    for i in 0..AROUND {
        let t = TAU * f64::from(i) / f64::from(AROUND);
        let ring = profile[1..profile.len() - 1].iter();
        mesh.positions
            .extend(ring.map(|p| DVec3::new(p.x * t.cos(), p.x * t.sin(), p.y)));
    }
    let ends = [0, profile.len() - 1].map(|k| {
        mesh.positions.push(DVec3::new(0.0, 0.0, profile[k].y));
        mesh.positions.len() as u32 - 1
    });
    for i in 0..AROUND {
        let at = |k: u32, i: u32| (i % AROUND) * count + k;
        mesh.faces.push([ends[0], at(0, i + 1), at(0, i)]);
        mesh.faces
            .push([ends[1], at(count - 1, i), at(count - 1, i + 1)]);
        for k in 0..count - 1 {
            let square = [at(k, i), at(k, i + 1), at(k + 1, i + 1), at(k + 1, i)];
            mesh.faces.push([square[0], square[1], square[2]]);
            mesh.faces.push([square[0], square[2], square[3]]);
        }
    }
    mesh
}

/// The distance of a point from the surface of a body.
fn distance(p: DVec3, middle: Middle, length: f64) -> f64 {
    let at = DVec2::new(p.x.hypot(p.y), p.z);
    let steps = 4000;
    let samples = (0..=steps).map(|k| middle(length * f64::from(k) / f64::from(steps)));
    let nearest = samples
        .map(|m| m.distance(at))
        .fold(f64::INFINITY, f64::min);
    (nearest - HALF).abs()
}

/// A body without the faces in a ball at its edge.
fn chipped(whole: &Mesh, middle: Middle, length: f64, radius: f64) -> Mesh {
    let edge = middle(length);
    let centre = DVec3::new(edge.x * 0.6, edge.x * 0.8, edge.y + 0.02);
    cut(whole, |p| p.distance(centre) < radius)
}

#[test]
fn the_edge_of_a_wall_goes_on_across_a_chip() {
    for (name, middle, length) in BODIES {
        let whole = body(middle, length);
        for radius in [0.2, 0.3] {
            let open = chipped(&whole, middle, length, radius);
            let filled = fill(&open, &FillParams::default()).unwrap();
            let what = format!("{name} {radius}");
            let region = &filled.report.regions[0];
            assert_eq!(region.closure, Some(Closure::Sides), "{what}");
            let verdict = inspect(&filled.mesh)
                .unwrap()
                .check(&CheckParams::default());
            assert!(verdict.is_sound(), "{what}: {}", verdict.line());
            let new = filled.mesh.positions[open.positions.len()..].iter();
            let errors: Vec<f64> = new.map(|p| distance(*p, middle, length)).collect();
            let largest = errors.iter().copied().fold(0.0, f64::max);
            assert!(largest < 0.6 * HALF, "{what}: {largest}");
            // What was lost is back, and not more.
            let part = (volume(&whole) - volume(&filled.mesh)) / volume(&whole);
            assert!(part.abs() < 0.02, "{what}: {part}");
            for (error, expected) in errors.iter().zip(&filled.expected_error) {
                let expected = expected.unwrap();
                assert!(
                    *error < 5.0 * expected + 1e-3,
                    "{what}: {error}, {expected}"
                );
            }
        }
    }
}

/// A body whose vertices are moved at random, and the same inside out.
fn rough(middle: Middle, length: f64) -> [Mesh; 2] {
    let mut rough = body(middle, length);
    let mut random = Noise(3);
    for p in &mut rough.positions {
        *p += 0.0015 * random.vector();
    }
    let mut inside_out = rough.clone();
    for f in &mut inside_out.faces {
        f.swap(1, 2);
    }
    [rough, inside_out]
}

#[test]
fn noise_and_orientation_do_not_keep_an_edge_from_going_on() {
    for (name, middle, length) in BODIES {
        for whole in rough(middle, length) {
            let open = chipped(&whole, middle, length, 0.25);
            let filled = fill(&open, &FillParams::default()).unwrap();
            let region = &filled.report.regions[0];
            assert_eq!(region.closure, Some(Closure::Sides), "{name}");
            for p in &filled.mesh.positions[open.positions.len()..] {
                let error = distance(*p, middle, length);
                assert!(error < 0.5 * HALF, "{name}: {error}");
            }
        }
    }
}

#[test]
fn half_of_a_bowl_and_of_a_cup_is_made_again() {
    for ((name, middle, length), radius) in [(BODIES[0], 1.0), (BODIES[2], 0.8)] {
        let [whole, _] = rough(middle, length);
        let open = chipped(&whole, middle, length, radius);
        let filled = fill(&open, &FillParams::default()).unwrap();
        let region = &filled.report.regions[0];
        assert_eq!(region.closure, Some(Closure::Sides), "{name}");
        let part = volume(&filled.mesh) / volume(&whole) - 1.0;
        assert!(part.abs() < 0.1, "{name}: {part}");
        for p in &filled.mesh.positions[open.positions.len()..] {
            let error = distance(*p, middle, length);
            assert!(error < 4.0 * HALF, "{name}: {error}");
        }
    }
}

#[test]
fn an_edge_goes_on_only_where_sharp_edges_do_and_a_wall_ends() {
    let (_, middle, length) = BODIES[0];
    let whole = body(middle, length);
    let open = chipped(&whole, middle, length, 0.25);
    let off = fill(&open, &FillParams::new().with_sharp(Sharp::Off)).unwrap();
    assert_ne!(off.report.regions[0].closure, Some(Closure::Sides));
    // A hole in one side of the wall, and one through it, meet no edge.
    let (_, middle, length) = BODIES[1];
    let plate = body(middle, length);
    for cut_out in [
        cut(&plate, |p| {
            p.z > 0.0 && p.distance(DVec3::new(0.5, 0.0, HALF)) < 0.2
        }),
        cut(&plate, |p| p.distance(DVec3::new(0.5, 0.0, 0.0)) < 0.2),
    ] {
        let filled = fill(&cut_out, &FillParams::default()).unwrap();
        let error = (volume(&filled.mesh) / volume(&plate) - 1.0).abs();
        let is_window = filled.report.regions[0].holes.len() == 2;
        assert!(is_window || error < 1e-3, "{error}");
    }
}
