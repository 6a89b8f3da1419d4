//! `isomend repair` unites closed bodies that touch or intersect, and splits only faces that intersect others.

use std::collections::HashSet;

use crate::desk::{Desk, assert_code, text};
use crate::shapes::{bits, cut, joined, moved, sphere, turn, turned, volume};
use glam::DVec3;
use isomend::check::{CheckParams, DefectKind, Verdict};
use isomend::io::{Format, read_path};
use isomend::{Carried, Control, Mesh, RepairParams, Repaired, inspect, repair};

/// The mesh after a repair with the default parameters.
pub fn repaired(mesh: &Mesh) -> Repaired {
    let params = RepairParams::default();
    repair(mesh, &params, &Carried::default(), &Control::new()).unwrap()
}

/// The verdict of `check` with the default parameters.
pub fn verdict(mesh: &Mesh) -> Verdict {
    inspect(mesh).unwrap().check(&CheckParams::default())
}

/// A box with its sides divided along one diagonal or the other.
fn block(low: [f64; 3], high: [f64; 3], other: bool) -> Mesh {
    let corner = |i: usize| {
        let at = |k: usize| if i >> k & 1 == 1 { high[k] } else { low[k] };
        DVec3::new(at(0), at(1), at(2))
    };
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let halves = |[a, b, c, d]: [u32; 4]| match other {
        true => [[a, b, d], [b, c, d]],
        false => [[a, b, c], [a, c, d]],
    };
    Mesh::new(
        (0..8).map(corner).collect(),
        sides.into_iter().flat_map(halves).collect(),
    )
}

/// A prism over a regular polygon, between two heights.
fn post(sides: u32, radius: f64, low: f64, high: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for z in [low, high] {
        for i in 0..sides {
            let t = std::f64::consts::TAU * f64::from(i) / f64::from(sides);
            mesh.positions
                .push(DVec3::new(radius * t.cos(), radius * t.sin(), z));
        }
    }
    for i in 0..sides {
        let (a, b) = (i, (i + 1) % sides);
        mesh.faces
            .extend([[a, b, b + sides], [a, b + sides, a + sides]]);
        if i > 1 {
            mesh.faces
                .extend([[0, i, i - 1], [sides, sides + i - 1, sides + i]]);
        }
    }
    mesh
}

fn all(bodies: &[Mesh]) -> Mesh {
    bodies
        .iter()
        .fold(Mesh::default(), |all, m| joined(&all, m))
}

/// The mesh rotated so that no face is parallel to an axis.
fn askew(mesh: &Mesh) -> Mesh {
    let mut mesh = mesh.clone();
    mesh.positions.iter_mut().for_each(|p| *p = turn() * *p);
    mesh
}

/// The mesh with positions rounded to 32-bit floats.
pub fn single(mesh: &Mesh) -> Mesh {
    let mut mesh = mesh.clone();
    for p in &mut mesh.positions {
        *p = p.as_vec3().as_dvec3();
    }
    mesh
}

/// Faces as the positions of their corners, independent of which corner comes first.
fn keys(mesh: &Mesh) -> Vec<[[u64; 3]; 3]> {
    let at = bits(&mesh.positions);
    let key = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| at[v as usize]);
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap()
    };
    mesh.faces.iter().map(key).collect()
}

/// Repairs bodies, each of which touches or intersects another one. The result must be sound and have this volume, and each of its faces
/// must be part of an input face.
#[track_caller]
fn assert_united(name: &str, bodies: &[Mesh], wanted: f64) -> Repaired {
    let bad = all(bodies);
    assert!(!verdict(&bad).is_sound(), "{name}");
    let done = repaired(&bad);
    let after = verdict(&done.mesh);
    assert!(after.is_sound(), "{name}: {}", after.line());
    // Separated vertices move by a thousandth of an edge.
    let own = volume(&done.mesh);
    assert!((own - wanted).abs() < 2e-3 * wanted, "{name}: {own}");
    assert_eq!(done.report.steps.united_bodies, bodies.len(), "{name}");
    assert_eq!(
        done.origins.faces.len(),
        done.mesh.faces.len(),
        "{name}: patches"
    );
    assert!(
        done.report.steps.intersection_passes.is_empty(),
        "{name}: cut out"
    );
    done
}

#[test]
fn blocks_that_touch_are_united() {
    let unit = |x: f64, y: f64, z: f64| block([x, y, z], [x + 1.0, y + 1.0, z + 1.0], false);
    let cube = block([0.0; 3], [1.0; 3], false);
    let slabs: Vec<Mesh> = (0..8)
        .map(|i| f64::from(i) / 8.0)
        .map(|z| block([0.0, 0.0, z], [1.0, 1.0, z + 0.125], z > 0.3))
        .collect();
    let plate = block([-1.0, -1.0, -1.0], [1.0, 1.0, 0.0], false);
    let boss = post(24, 0.3, 0.0, 0.5);
    let top = volume(&boss);
    let cases: Vec<(&str, Vec<Mesh>, f64)> = vec![
        (
            "other diagonals",
            vec![cube.clone(), block([1.0, 0.0, 0.0], [2.0, 1.0, 1.0], true)],
            2.0,
        ),
        (
            "same diagonals",
            vec![cube.clone(), unit(1.0, 0.0, 0.0)],
            2.0,
        ),
        (
            "part of a side",
            vec![cube.clone(), unit(1.0, 0.5, 0.25)],
            2.0,
        ),
        (
            "within a side",
            vec![
                cube.clone(),
                block([1.0, 0.25, 0.25], [2.0, 0.75, 0.75], true),
            ],
            1.25,
        ),
        ("slabs", slabs, 1.0),
        ("boss on a plate", vec![plate, boss], 4.0 + top),
        (
            "inside, at a side",
            vec![block([0.0; 3], [4.0; 3], false), unit(1.0, 1.0, 0.0)],
            64.0,
        ),
        (
            "inside, in a corner",
            vec![block([0.0; 3], [4.0; 3], false), cube.clone()],
            64.0,
        ),
        (
            "in one plane",
            vec![
                block([0.0; 3], [2.0, 2.0, 1.0], false),
                block([1.0, 0.0, 0.0], [3.0, 2.0, 1.0], true),
                block([0.0, 1.0, 0.0], [2.0, 3.0, 1.0], false),
            ],
            8.0,
        ),
        (
            "through each other",
            vec![
                block([-2.0, -0.3, -0.3], [2.0, 0.3, 0.3], false),
                block([-0.3, -2.0, -0.3], [0.3, 2.0, 0.3], true),
                block([-0.3, -0.3, -2.0], [0.3, 0.3, 2.0], false),
            ],
            3.0 * 1.44 - 2.0 * 0.216,
        ),
        (
            "round an edge",
            vec![cube.clone(), unit(1.0, 0.0, 0.0), unit(1.0, 1.0, 0.0)],
            3.0,
        ),
    ];
    for (name, bodies, wanted) in cases {
        assert_united(name, &bodies, wanted);
    }
    // In general position.
    let beams = [[2.0, 0.3, 0.3], [0.3, 2.0, 0.3], [0.3, 0.3, 2.0]];
    let beams = beams.map(|size| askew(&block(size.map(|x: f64| -x), size, false)));
    assert_united("askew", &beams, 3.0 * 1.44 - 2.0 * 0.216);
}

#[test]
fn heaps_of_blocks_on_a_grid_have_the_volume_of_their_cells() {
    let mut state = 7u64;
    let mut number = |most: u64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) % most
    };
    for _ in 0..4 {
        let mut cells = HashSet::new();
        let mut bodies = Vec::new();
        for i in 0..60 {
            let low = [0; 3].map(|_| number(7));
            let high = low.map(|x| x + 1 + number(3));
            for x in low[0]..high[0] {
                for y in low[1]..high[1] {
                    cells.extend((low[2]..high[2]).map(|z| [x, y, z]));
                }
            }
            let corner = |p: [u64; 3]| p.map(|x| x as f64);
            bodies.push(block(corner(low), corner(high), i % 2 == 0));
        }
        let done = repaired(&all(&bodies));
        let after = verdict(&done.mesh);
        assert!(after.is_sound(), "{}", after.line());
        let wanted = cells.len() as f64;
        let own = volume(&done.mesh);
        assert!((own - wanted).abs() < 2e-3 * wanted, "{own} of {wanted}");
    }
}

#[test]
fn faces_that_intersect_no_other_body_stay_bit_for_bit_and_in_order() {
    let ball = turned(sphere(8));
    let bad = joined(&ball, &moved(&ball, 0.7, DVec3::new(0.9, 0.3, 0.2)));
    let before = verdict(&bad);
    let crossing: HashSet<u32> = before
        .defects
        .iter()
        .filter(|d| d.kind == DefectKind::SelfIntersection)
        .flat_map(|d| d.faces.iter().copied())
        .collect();
    let done = assert_united(
        "balls",
        &[ball.clone(), moved(&ball, 0.7, DVec3::new(0.9, 0.3, 0.2))],
        volume_of_two(),
    );
    let report = &done.report;
    assert_eq!(report.steps.split_faces, crossing.len());
    assert_eq!(report.steps.inner_faces, report.lost_faces);
    // Faces that are not split and outside the other ball.
    let outside = |(i, f): (usize, &[u32; 3])| {
        let centre = f.iter().map(|v| bad.positions[*v as usize]).sum::<DVec3>() / 3.0;
        let (at, size) = match i < ball.faces.len() {
            true => (DVec3::new(0.9, 0.3, 0.2), 0.7),
            false => (DVec3::ZERO, 1.0),
        };
        !crossing.contains(&(i as u32)) && centre.distance(at) > size
    };
    let kept: Vec<[u32; 3]> = bad
        .faces
        .iter()
        .enumerate()
        .filter(|f| outside(*f))
        .map(|(_, f)| *f)
        .collect();
    let kept = Mesh::new(bad.positions.clone(), kept);
    assert!(keys(&done.mesh).starts_with(&keys(&kept)));
    assert_eq!(
        kept.faces.len() + report.steps.inner_faces + crossing.len(),
        bad.faces.len()
    );
    // All vertices of a face are in the plane of its original face.
    for (face, origin) in done.mesh.faces.iter().zip(&done.origins.faces) {
        let [a, b, c] = bad.corners(origin.face);
        let normal = (b - a).cross(c - a).normalize();
        for v in face {
            let height = normal.dot(done.mesh.positions[*v as usize] - a);
            assert!(height.abs() < 1e-14, "{height}");
        }
    }
}

/// The volume of the union of the two balls of the test above: their sum minus the lens that is in both.
fn volume_of_two() -> f64 {
    let ball = turned(sphere(8));
    let other = moved(&ball, 0.7, DVec3::new(0.9, 0.3, 0.2));
    let (d, r, s) = (DVec3::new(0.9, 0.3, 0.2).length(), 1.0, 0.7);
    // Volume of the lens: pi (r + s - d)^2 (d^2 + 2 d (r + s) - 3 (r - s)^2) / (12 d).
    let lens = std::f64::consts::PI
        * (r + s - d).powi(2)
        * (d * d + 2.0 * d * (r + s) - 3.0 * (r - s) * (r - s))
        / (12.0 * d);
    volume(&ball) + volume(&other) - lens
}

#[test]
fn a_self_intersecting_body_is_united_with_itself_and_cavities_stay() {
    let ball = turned(sphere(6));
    let mut inner = moved(&ball, 0.5, DVec3::ZERO);
    inner.faces.iter_mut().for_each(|f| f.swap(1, 2));
    // A ball half in the cavity, half in the wall.
    let bad = all(&[
        ball.clone(),
        inner,
        moved(&ball, 0.2, DVec3::new(0.45, 0.0, 0.0)),
    ]);
    let done = repaired(&bad);
    let after = verdict(&done.mesh);
    assert!(after.is_sound(), "{}", after.line());
    assert_eq!(after.components.len(), 2);
    let shell = volume(&ball) * (1.0 - 0.125);
    assert!(volume(&done.mesh) > shell + 0.01);
    assert!(volume(&done.mesh) < shell + 0.03);

    let mut dented = ball.clone();
    let pushed = |p: &DVec3| DVec3::new(p.x, p.y, -1.3 - 0.2 * p.z);
    for p in dented.positions.iter_mut().filter(|p| p.z > 0.8) {
        *p = pushed(p);
    }
    assert!(verdict(&dented).count(DefectKind::SelfIntersection) > 0);
    let done = repaired(&dented);
    assert!(verdict(&done.mesh).is_sound());
    assert_eq!(done.report.steps.united_bodies, 1);
    assert!(done.report.steps.intersection_passes.is_empty());
}

#[test]
fn duplicate_bodies_become_one_and_open_ones_are_closed_and_united() {
    let ball = turned(sphere(6));
    let done = repaired(&joined(&ball, &ball));
    assert_eq!(keys(&done.mesh), keys(&ball));
    let open = cut(&ball, |p| p.z < -0.9);
    let bad = joined(&open, &moved(&ball, 0.5, DVec3::new(0.9, 0.1, 0.3)));
    let done = repaired(&bad);
    assert_eq!(done.report.steps.united_bodies, 2);
    assert!(done.report.steps.intersection_passes.is_empty());
    assert!(verdict(&done.mesh).is_sound());
}

#[test]
fn the_union_of_32_bit_positions_has_32_bit_positions() {
    let mut bad = Mesh::default();
    for i in 0..5 {
        let t = f64::from(i);
        let centre = DVec3::new((1.3 * t).sin(), (0.7 * t).cos(), 0.3 * t) * 0.6;
        bad = joined(
            &bad,
            &moved(
                &askew(&block([-0.5; 3], [0.5; 3], false)),
                1.0 + 0.1 * t,
                centre,
            ),
        );
    }
    let single = |p: &DVec3| p.as_vec3().as_dvec3();
    bad.positions.iter_mut().for_each(|p| *p = single(p));
    let done = repaired(&bad);
    assert!(verdict(&done.mesh).is_sound());
    assert!(done.mesh.positions.iter().all(|p| single(p) == *p));
}

#[test]
fn the_union_is_the_same_for_any_number_of_threads() {
    let ball = turned(sphere(6));
    let bad = all(&[
        ball.clone(),
        moved(&ball, 0.8, DVec3::new(0.9, 0.2, 0.1)),
        block([-0.2, -2.0, -0.2], [0.2, 2.0, 0.2], false),
    ]);
    let run = |threads| {
        let control = Control::new().threads(threads);
        let params = RepairParams::default();
        repair(&bad, &params, &Carried::default(), &control).unwrap()
    };
    let (one, many) = (run(1), run(5));
    assert!(one.report.steps.united_bodies > 0);
    assert_eq!(bits(&one.mesh.positions), bits(&many.mesh.positions));
    assert_eq!(one.mesh.faces, many.mesh.faces);
    assert_eq!(one.origins, many.origins);
}

#[test]
fn the_command_says_how_many_bodies_were_united() {
    let desk = Desk::new();
    let ball = turned(sphere(6));
    let bad = joined(&ball, &moved(&ball, 0.5, DVec3::new(0.9, 0.1, 0.3)));
    for (format, name) in [
        (Format::Ply, "ply"),
        (Format::Stl, "stl"),
        (Format::Obj, "obj"),
    ] {
        let (from, to) = (format!("bad.{name}"), format!("out.{name}"));
        desk.save(&from, &bad, format);
        let done = desk.run(&["repair", &from, "-o", &to, "--json", "out.json"]);
        assert_code(&done, 0);
        let said = text(&done.stderr);
        assert!(
            said.contains("2 touching or intersecting bodies united"),
            "{said}"
        );
        let document = desk.json("out.json");
        assert_eq!(document["steps"]["united_bodies"], 2);
        assert!(document["steps"]["split_faces"].as_u64().unwrap() > 0);
        assert!(document["steps"]["inner_faces"].as_u64().unwrap() > 0);
        let written = read_path(&desk.path(&to), None).unwrap().mesh;
        assert!(verdict(&written).is_sound());
    }
}

#[test]
fn new_vertices_get_interpolated_colours_and_texture_coordinates() {
    let desk = Desk::new();
    let bad = joined(
        &block([0.0; 3], [2.0; 3], false),
        &block([1.0, 0.5, 0.5], [3.0, 1.5, 1.25], true),
    );
    // Colours and texture coordinates are linear functions of the position.
    let mut text = String::new();
    for p in &bad.positions {
        let [r, g, b] = (*p / 4.0).to_array();
        text += &format!("v {} {} {} {r} {g} {b}\nvt {r} {b}\n", p.x, p.y, p.z);
    }
    for f in &bad.faces {
        let corners = f.map(|v| format!(" {0}/{0}", v + 1));
        text += &format!("f{}\n", corners.concat());
    }
    desk.text("bad.obj", &text);
    let done = desk.run(&["repair", "bad.obj", "-o", "out.obj", "-q"]);
    assert_code(&done, 0);
    let out = read_path(&desk.path("out.obj"), None).unwrap();
    assert!(out.mesh.positions.len() > bad.positions.len());
    let colours = out.attributes.vertex_role(isomend::Role::Colour).unwrap();
    for (v, p) in out.mesh.positions.iter().enumerate() {
        let own = DVec3::from_slice(&colours.get(v).unwrap()[..3]);
        assert!(own.distance(*p / 4.0) < 1e-6, "{p}: {own}");
    }
    let uv = &out.attributes.corner[0];
    for (f, face) in out.mesh.faces.iter().enumerate() {
        for (k, v) in face.iter().enumerate() {
            let p = out.mesh.positions[*v as usize] / 4.0;
            let own = uv.get(f, k).unwrap();
            assert!((own[0] - p.x).hypot(own[1] - p.z) < 1e-6, "{p}: {own:?}");
        }
    }
}

#[test]
fn turned_blocks_with_faces_that_coincide_up_to_rounding_keep_their_volume() {
    // Corners at whole numbers, so that blocks share faces, parts of faces, edges and volume.
    let lows = [
        [0, 0, 0],
        [2, 0, 0],
        [0, 2, 0],
        [1, 1, 2],
        [3, 1, 1],
        [0, 0, 2],
        [2, 2, 0],
        [4, 0, 0],
        [1, 3, 1],
    ];
    let sizes = [[2, 2, 2], [2, 2, 1], [3, 1, 2], [2, 2, 2], [1, 2, 3]];
    let mut filled = std::collections::BTreeSet::new();
    let mut blocks = Vec::new();
    for (i, low) in lows.into_iter().enumerate() {
        let high: [i32; 3] = std::array::from_fn(|k| low[k] + sizes[i % sizes.len()][k]);
        let [l, h] = [low, high].map(|p| p.map(f64::from));
        blocks.push(block(l, h, i % 2 == 1));
        for x in low[0]..high[0] {
            for y in low[1]..high[1] {
                filled.extend((low[2]..high[2]).map(|z| [x, y, z]));
            }
        }
    }
    let wanted = filled.len() as f64;
    for (name, bad) in [
        ("64 bits", askew(&all(&blocks))),
        ("32 bits", single(&askew(&all(&blocks)))),
    ] {
        let done = repaired(&bad);
        let after = verdict(&done.mesh);
        assert!(after.is_sound(), "{name}: {}", after.line());
        let own = volume(&done.mesh);
        assert!(
            (own - wanted).abs() < 1e-4 * wanted,
            "{name}: {own} for {wanted}"
        );
        assert!(
            done.report.steps.intersection_passes.is_empty(),
            "{name}: cut out"
        );
        let largest = done.report.steps.largest_move;
        assert!(
            done.report.steps.moved_vertices > 0 && largest > 0.0 && largest < 1e-4,
            "{name}: {largest}"
        );
    }
}
