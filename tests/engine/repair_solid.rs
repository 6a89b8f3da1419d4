//! The solid inside the outer skin: double skins with pinholes become solid bodies; sound bodies, cavities and vessels stay.

use std::collections::HashSet;

use crate::shapes::{joined, volume};
use glam::DVec3;
use isomend::{Carried, Control, Mesh, RepairParams, Repaired, Volume, level_surface, repair};

/// Nodes of the lattice along each axis.
const NODES: usize = 60;
/// Distance of its nodes.
pub(crate) const H: f64 = 2.8 / (NODES as f64 - 1.0);

/// The surface where a function on the lattice over the cube of half side 1.4 has a level, by marching cubes.
pub(crate) fn surface(level: f64, value: impl Fn(DVec3) -> f64) -> Mesh {
    let mut values = Vec::new();
    for k in 0..NODES {
        for j in 0..NODES {
            for i in 0..NODES {
                values.push(value(
                    DVec3::new(i as f64, j as f64, k as f64) * H - DVec3::splat(1.4),
                ));
            }
        }
    }
    let volume = Volume {
        dims: [NODES; 3],
        origin: DVec3::splat(-1.4),
        spacing: DVec3::splat(H),
        values,
    };
    level_surface(&volume, level, false).unwrap()
}

fn ball(p: DVec3) -> f64 {
    p.length() - 0.9
}

fn brick(p: DVec3) -> f64 {
    let q = p.abs() - DVec3::new(0.9, 0.6, 0.4);
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

fn ring(p: DVec3) -> f64 {
    (p.x.hypot(p.y) - 0.8).hypot(p.z) - 0.3
}

/// A ball with a rod through it.
fn rattle(p: DVec3) -> f64 {
    let rod = (p.x.hypot(p.y) - 0.25).max(p.z.abs() - 1.1);
    rod.min(p.length() - 0.6)
}

/// A disk with twelve teeth.
fn gear(p: DVec3) -> f64 {
    let tooth = 0.12 * (12.0 * p.y.atan2(p.x)).cos().clamp(-0.6, 0.6);
    (p.x.hypot(p.y) - 0.9 - tooth).max(p.z.abs() - 0.25)
}

type Field = fn(DVec3) -> f64;

/// A body, its name and points on its surface.
const BODIES: [(&str, Field, [DVec3; 5]); 4] = [
    (
        "ball",
        ball,
        [
            DVec3::new(0.9, 0.0, 0.0),
            DVec3::new(0.0, 0.9, 0.0),
            DVec3::new(0.0, 0.0, -0.9),
            DVec3::new(-0.52, -0.52, 0.52),
            DVec3::new(0.52, -0.52, -0.52),
        ],
    ),
    (
        "brick",
        brick,
        [
            DVec3::new(0.1, 0.2, 0.4),
            DVec3::new(0.9, 0.1, 0.1),
            DVec3::new(-0.5, -0.6, 0.4),
            DVec3::new(-0.9, 0.6, -0.4),
            DVec3::new(0.6, -0.3, -0.4),
        ],
    ),
    (
        "ring",
        ring,
        [
            DVec3::new(1.1, 0.0, 0.0),
            DVec3::new(0.0, 0.5, 0.0),
            DVec3::new(0.0, -0.8, 0.3),
            DVec3::new(-0.8, 0.0, -0.3),
            DVec3::new(-0.56, -0.56, 0.3),
        ],
    ),
    (
        "rattle",
        rattle,
        [
            DVec3::new(0.6, 0.0, 0.0),
            DVec3::new(0.0, -0.25, 0.9),
            DVec3::new(0.1, 0.0, -1.1),
            DVec3::new(-0.42, 0.42, 0.0),
            DVec3::new(0.0, 0.6, 0.0),
        ],
    ),
];

pub(crate) fn made_solid(mesh: &Mesh) -> Repaired {
    let params = RepairParams::new().with_solid(true);
    repair(mesh, &params, &Carried::default(), &Control::new()).unwrap()
}

/// The corners of each face as bits, in any order.
fn faces(mesh: &Mesh) -> HashSet<[[u64; 3]; 3]> {
    let corners = mesh.faces.iter().map(|f| {
        let mut corners = f.map(|v| mesh.positions[v as usize].to_array().map(f64::to_bits));
        corners.sort_unstable();
        corners
    });
    corners.collect()
}

#[test]
fn double_skins_with_pinholes_become_solid() {
    let half = 1.1 * H;
    for (name, body, places) in BODIES {
        let truth = surface(half, body);
        for count in [0, 2, places.len()] {
            let mesh = surface(half, |p| {
                let pinhole = |c: &DVec3| 3.2 * H - p.distance(*c);
                let holes = places[..count].iter().map(pinhole);
                holes.fold(body(p).abs(), f64::max)
            });
            let done = made_solid(&mesh);
            let after = done.report.after.clone();
            assert!(after.is_none_or(|v| v.is_sound()), "{name} {count}");
            assert_eq!(isomend::inspect(&done.mesh).unwrap().holes.len(), 0);
            assert_eq!(done.report.steps.pinholes, count, "{name}");
            assert_eq!(done.report.steps.inner_skins, 1, "{name} {count}");
            assert!(done.report.doubt.is_none(), "{name} {count}");
            let error = volume(&done.mesh) / volume(&truth) - 1.0;
            assert!(error.abs() < 0.01, "{name} {count}: {error}");
            // The outer skin's faces that no pinhole touches are there bit for bit.
            let outer = faces(&truth);
            let outer: HashSet<_> = outer.intersection(&faces(&mesh)).copied().collect();
            let kept = outer.intersection(&faces(&done.mesh)).count();
            let part = kept as f64 / outer.len() as f64;
            assert!(part > 0.95, "{name} {count}: {part}");
        }
    }
}

#[test]
fn sound_bodies_cavities_and_vessels_stay() {
    let shell = |d: f64, wall: f64| (d.abs()) - 0.5 * wall;
    let bottle = |p: DVec3| {
        let neck = (p.x.hypot(p.y) - 0.22).max(p.z.abs() - 1.5);
        let outside = neck
            .max(-p.z)
            .min((p - DVec3::new(0.0, 0.0, -0.4)).length() - 0.75);
        shell(outside, 0.12).max(p.z - 1.15)
    };
    let cup = |p: DVec3| {
        let d = (p.x.hypot(p.y) - 0.7).max(p.z.abs() - 0.8);
        shell(d, 0.12).max(p.z - 0.5)
    };
    let pipe = |p: DVec3| shell(p.x.hypot(p.y) - 0.15, 0.14).max(p.z.abs() - 1.1);
    let hollow = |p: DVec3| ball(p).max(0.4 - (p - DVec3::new(0.2, 0.1, 0.0)).length());
    let walled = |p: DVec3| {
        let q = (p - DVec3::new(0.02, 0.03, 0.05)).abs() - DVec3::new(0.8, 0.48, 0.22);
        let cavity = q.max(DVec3::ZERO).length() + q.max_element().min(0.0);
        brick(p).max(-cavity)
    };
    let sponge = |p: DVec3| {
        let q = 9.0 * p;
        let gyroid = q.x.sin() * q.y.cos() + q.y.sin() * q.z.cos() + q.z.sin() * q.x.cos();
        (gyroid / 12.0).max(p.abs().max_element() - 0.9)
    };
    let drilled = |p: DVec3| brick(p).max(0.1 - (p.x - 0.2).hypot(p.y));
    let hollow_with_neck = |p: DVec3| hollow(p).max(0.1 - p.y.hypot(p.z - 0.1).max(-p.x));
    let kinds: [(&str, &dyn Fn(DVec3) -> f64); 13] = [
        ("ball", &ball),
        ("brick", &brick),
        ("ring", &ring),
        ("rattle", &rattle),
        ("gear", &gear),
        ("cup", &cup),
        ("bottle", &bottle),
        ("pipe", &pipe),
        ("hollow ball", &hollow),
        ("hollow brick", &walled),
        ("sponge", &sponge),
        ("drilled brick", &drilled),
        ("ball with a cavity and a neck", &hollow_with_neck),
    ];
    for (name, field) in kinds {
        let mesh = surface(0.001, field);
        let done = made_solid(&mesh);
        let steps = &done.report.steps;
        assert_eq!(
            [steps.inner_skins, steps.inner_skin_faces],
            [0, 0],
            "{name}"
        );
        assert_eq!(done.mesh.faces.len(), mesh.faces.len(), "{name}");
        let error = volume(&done.mesh) / volume(&mesh) - 1.0;
        assert!(error.abs() < 1e-9, "{name}: {error}");
    }
}

#[test]
fn pinholes_are_numbered_after_the_holes_of_the_input_and_any_number_of_threads_writes_the_same() {
    let mesh = surface(1.1 * H, |p| {
        ball(p)
            .abs()
            .max(3.2 * H - p.distance(DVec3::new(0.9, 0.0, 0.0)))
    });
    // A hole in the outer skin.
    let mesh = crate::shapes::cut(&mesh, |p| p.distance(DVec3::new(-0.95, 0.0, 0.0)) < 0.1);
    assert_eq!(isomend::inspect(&mesh).unwrap().holes.len(), 1);
    let with_threads = |threads: usize| {
        let params = RepairParams::new().with_solid(true);
        let control = Control::new().threads(threads);
        repair(&mesh, &params, &Carried::default(), &control).unwrap()
    };
    let [one, two] = [1, 2].map(with_threads);
    assert_eq!(one.mesh, two.mesh);
    let numbers: HashSet<usize> = one.fill.holes.iter().map(|h| h.hole.id.get()).collect();
    assert_eq!(numbers, HashSet::from([1, 2]));
    assert_eq!(one.report.steps.pinholes, 1);
    assert_eq!(isomend::inspect(&one.mesh).unwrap().holes.len(), 0);
}

#[test]
fn generated_parts_that_overlap_or_lie_inside_others_become_one_outer_surface() {
    let half = 1.1 * H;
    let at = |x: f64, r: f64| move |p: DVec3| p.distance(DVec3::new(x, 0.01, 0.02)) - r;
    let skin = |d: &dyn Fn(DVec3) -> f64, hole: DVec3| {
        surface(half, |p| d(p).abs().max(3.2 * H - p.distance(hole)))
    };
    let head = at(-0.3, 0.8);
    for (name, x) in [("inside", -0.1), ("overlapping", 0.5)] {
        let eye = at(x, 0.35);
        let both = joined(
            &skin(&head, DVec3::new(-1.1, 0.0, 0.0)),
            &skin(&eye, DVec3::new(x + 0.35, 0.0, 0.0)),
        );
        let truth = surface(half, |p| head(p).min(eye(p)));
        let done = made_solid(&both);
        let error = volume(&done.mesh) / volume(&truth) - 1.0;
        assert!(error.abs() < 0.01, "{name}: {error}");
        let found = isomend::inspect(&done.mesh).unwrap();
        assert_eq!(found.topology.component_faces.len(), 1, "{name}");
        assert!(done.report.doubt.is_none(), "{name}");
    }
}
