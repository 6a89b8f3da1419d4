//! The body that is meant: random unions as solids, as double skins and with cavities; handles, sponges, clothes over bodies.

use std::collections::HashSet;

use crate::repair_plans::reversed;
use crate::repair_solid::{H, made_solid, surface};
use crate::repair_union::{repaired, single};
use crate::shapes::{Noise, cube, cut, joined, moved, sphere, topology, torus, volume};
use glam::{DMat3, DVec3, EulerRot};
use isomend::check::{CheckParams, DefectKind};
use isomend::{Carried, Control, Mesh, RepairParams, RepairStep, inspect, repair};

/// Half the distance of two skins.
const HALF: f64 = 1.1 * H;

/// The distance to a ball, a brick, a rod or a ring of pseudo-random size and place, turned at random.
fn part(noise: &mut Noise) -> impl Fn(DVec3) -> f64 + use<> {
    let mut between = |low: f64, high: f64| low + 0.5 * (high - low) * (1.0 + noise.next());
    let centre = DVec3::new(between(-0.5, 0.5), between(-0.5, 0.5), between(-0.5, 0.5));
    let angles = [between(0.0, 6.0), between(0.0, 3.0), between(0.0, 6.0)];
    let turn = DMat3::from_euler(EulerRot::ZXZ, angles[0], angles[1], angles[2]);
    let kind = between(0.0, 4.0) as usize;
    let sizes = [between(0.0, 1.0), between(0.0, 1.0), between(0.0, 1.0)];
    move |p| {
        let q = turn * (p - centre);
        let [a, b, c] = sizes;
        match kind {
            0 => q.length() - (0.3 + 0.3 * a),
            1 => {
                let q = q.abs() - DVec3::new(0.25 + 0.25 * a, 0.25 + 0.25 * b, 0.25 + 0.25 * c);
                q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
            }
            2 => (q.x.hypot(q.y) - (0.18 + 0.12 * a)).max(q.z.abs() - (0.4 + 0.3 * b)),
            _ => (q.x.hypot(q.y) - (0.35 + 0.2 * a)).hypot(q.z) - (0.14 + 0.06 * b),
        }
    }
}

fn components(mesh: &Mesh) -> usize {
    inspect(mesh).unwrap().topology.component_faces.len()
}

/// Two skins at a distance on both sides of the zero level of a function, joined by pinholes at some places.
fn double_skin(body: &dyn Fn(DVec3) -> f64, places: &[DVec3]) -> Mesh {
    surface(HALF, |p| {
        let pinhole = |c: &DVec3| 3.2 * H - p.distance(*c);
        places.iter().map(pinhole).fold(body(p).abs(), f64::max)
    })
}

/// Vertices of the zero level of a function, chosen at random.
fn places(body: &dyn Fn(DVec3) -> f64, count: usize, noise: &mut Noise) -> Vec<DVec3> {
    let skin = surface(0.0, body).positions;
    let any = |noise: &mut Noise| (0.5 * (1.0 + noise.next()) * skin.len() as f64) as usize;
    (0..count).map(|_| skin[any(noise)]).collect()
}

/// The point where a function is least, of those on a coarse lattice, and its value there.
fn deepest(body: &dyn Fn(DVec3) -> f64) -> (DVec3, f64) {
    let axis = || (-12..=12).map(|i| 0.1 * f64::from(i));
    let points = axis().flat_map(|x| axis().map(move |y| (x, y)));
    let points = points.flat_map(|(x, y)| axis().map(move |z| DVec3::new(x, y, z)));
    let values = points.map(|p| (p, body(p)));
    values.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

/// Asserts that a mesh becomes one closed body of this volume, up to a hundredth.
fn assert_meant(mesh: &Mesh, truth: f64, what: &str) -> Mesh {
    let done = made_solid(mesh);
    let error = volume(&done.mesh) / truth - 1.0;
    assert!(error.abs() < 0.01, "{what}: {error}");
    assert_eq!(inspect(&done.mesh).unwrap().holes.len(), 0, "{what}");
    assert!(done.report.doubt.is_none(), "{what}");
    assert!(done.report.after.is_none_or(|v| v.is_sound()), "{what}");
    done.mesh
}

#[test]
fn random_unions_become_the_body_that_was_meant() {
    let mut noise = Noise(5);
    let (mut bodies, mut hollow) = (0, 0);
    while bodies < 18 {
        let parts: Vec<_> = (0..2 + bodies % 3).map(|_| part(&mut noise)).collect();
        let body = |p: DVec3| parts.iter().map(|d| d(p)).fold(f64::INFINITY, f64::min);
        let truth = surface(HALF, body);
        if components(&truth) != 1 || components(&surface(-HALF, body)) != 1 {
            continue;
        }
        let what = format!("body {bodies}");
        // The body itself stays.
        let alone = assert_meant(&truth, volume(&truth), &what);
        assert_eq!(alone.faces, truth.faces, "{what}");
        // Of its double skin the outer one stays.
        let places = places(&body, bodies % 6, &mut noise);
        let mesh = double_skin(&body, &places);
        let skins = format!("{what} with {} pinholes", places.len());
        assert_meant(&mesh, volume(&truth), &skins);
        // A cavity of the body stays.
        let (centre, depth) = deepest(&body);
        if depth < -6.0 * H {
            let with_cavity = |p: DVec3| (body(p) - HALF).max(-0.5 * depth - p.distance(centre));
            let mesh = surface(0.0, with_cavity);
            assert_eq!(components(&mesh), 2, "{what}");
            let kept = assert_meant(&mesh, volume(&mesh), &format!("{what} with a cavity"));
            assert_eq!(kept.faces.len(), mesh.faces.len(), "{what}");
            hollow += 1;
        }
        bodies += 1;
    }
    assert!(hollow > 7, "{hollow}");
}

type Field = fn(DVec3) -> f64;

/// A cup with a thick wall.
fn cup(p: DVec3) -> f64 {
    let r = p.x.hypot(p.y);
    let outside = (r - 0.95).max(p.z.abs() - 0.9);
    outside.max(-(r - 0.6).max(-0.5 - p.z))
}

/// A bottle with a thick wall and a neck.
fn bottle(p: DVec3) -> f64 {
    let r = p.x.hypot(p.y);
    let at_belly = (p + DVec3::new(0.0, 0.0, 0.35)).length();
    let outside = (at_belly - 0.85).min((r - 0.45).max(-p.z).max(p.z - 1.1));
    outside.max(-(at_belly - 0.5).min((r - 0.3).max(-p.z)))
}

/// A disk with twelve teeth and a bore.
fn gear(p: DVec3) -> f64 {
    let r = p.x.hypot(p.y);
    let tooth = 0.12 * (12.0 * p.y.atan2(p.x)).cos().clamp(-0.6, 0.6);
    (r - 0.95 - tooth).max(p.z.abs() - 0.35).max(0.3 - r)
}

#[test]
fn vessels_and_gears_become_the_body_that_was_meant() {
    let mut noise = Noise(11);
    let bodies: [(&str, Field); 3] = [("cup", cup), ("bottle", bottle), ("gear", gear)];
    for (name, body) in bodies {
        let truth = surface(HALF, body);
        assert_eq!(components(&truth), 1, "{name}");
        let alone = assert_meant(&truth, volume(&truth), name);
        assert_eq!(alone.faces, truth.faces, "{name}");
        // Random unions have the numbers between.
        for count in [0, 1, 5] {
            let places = places(&body, count, &mut noise);
            let mesh = double_skin(&body, &places);
            let what = format!("{name} with {count} pinholes");
            let made = assert_meant(&mesh, volume(&truth), &what);
            assert_eq!(topology(&made), topology(&truth), "{what}");
        }
        let (centre, depth) = deepest(&body);
        let with_cavity = |p: DVec3| (body(p) - HALF).max(-0.6 * depth - p.distance(centre));
        let mesh = surface(0.0, with_cavity);
        assert_eq!(components(&mesh), 2, "{name}");
        let kept = assert_meant(&mesh, volume(&mesh), &format!("{name} with a cavity"));
        assert_eq!(kept.faces.len(), mesh.faces.len(), "{name}");
    }
}

#[test]
fn a_handle_that_runs_back_into_its_body_becomes_one_outer_surface() {
    // As the neck of a Klein bottle: out of the body at one end, through its wall at the other.
    let body = |p: DVec3| (p + DVec3::new(0.25, 0.0, 0.0)).length() - 0.6;
    let handle = |p: DVec3| {
        let q = p - DVec3::new(0.35, 0.01, 0.02);
        (q.x.hypot(q.y) - 0.5).hypot(q.z) - 0.17
    };
    let hole = DVec3::new(1.02, 0.01, 0.02);
    let far = DVec3::new(-0.85, 0.0, 0.0);
    let both = joined(&double_skin(&body, &[far]), &double_skin(&handle, &[hole]));
    let truth = surface(HALF, |p| body(p).min(handle(p)));
    let mesh = assert_meant(&both, volume(&truth), "handle");
    assert_eq!(components(&mesh), 1);
    assert_eq!(topology(&mesh), topology(&truth));
}

#[test]
fn the_double_skin_of_a_sponge_becomes_the_sponge() {
    // Four channels along each axis run through a cube.
    let channels = |a: f64, b: f64| 0.2 - (a.abs() - 0.42).hypot(b.abs() - 0.42);
    let sponge = |p: DVec3| {
        let cube = p.abs().max_element() - 0.9;
        let along = [channels(p.x, p.y), channels(p.y, p.z), channels(p.z, p.x)];
        along.into_iter().fold(cube, f64::max)
    };
    let truth = surface(HALF, sponge);
    assert_eq!(components(&truth), 1);
    let mut noise = Noise(3);
    for count in [0, 2, 5] {
        let places = places(&sponge, count, &mut noise);
        let mesh = double_skin(&sponge, &places);
        assert_meant(&mesh, volume(&truth), &format!("{count} pinholes"));
    }
}

#[test]
fn clothes_that_cross_the_body_under_them_become_one_outer_surface() {
    let body = |p: DVec3| p.length() - 0.8 - 0.04 * (3.0 * p.x).sin() * (4.0 * p.y).cos();
    for (name, offset, wave) in [("tight", 0.01, 5.0), ("loose", 0.03, 3.0)] {
        let cloth = |p: DVec3| body(p) - offset - 0.035 * (wave * (p.x + p.z)).sin();
        let [inner, outer] = [surface(0.0, body), surface(0.0, cloth)];
        let both = joined(&inner, &outer);
        let params = RepairParams::new();
        let done = repair(&both, &params, &Carried::default(), &Control::new()).unwrap();
        let truth = volume(&surface(0.0, |p| body(p).min(cloth(p))));
        let error = volume(&done.mesh) / truth - 1.0;
        assert!(error.abs() < 5e-3, "{name}: {error}");
        assert!(done.report.after.is_none_or(|v| v.is_sound()), "{name}");
        assert!(done.report.doubt.is_none(), "{name}");
        assert_eq!(components(&done.mesh), 1, "{name}");
    }
}

#[test]
fn wide_clothes_that_cross_a_double_skin_do_not_hide_it() {
    let body = |p: DVec3| p.length() - 0.8;
    let cloth = |p: DVec3| {
        let wave = (9.0 * p.x + 1.0).sin() * (7.0 * p.z).cos();
        let sheet = (body(p) - HALF - H * (1.2 + 2.2 * wave)).abs() - 0.9 * HALF;
        sheet.max((p.z - 0.1).abs() - 0.9)
    };
    let skin = double_skin(&body, &[DVec3::new(0.0, 0.8, 0.0)]);
    let cloth = surface(0.0, cloth);
    let solid = joined(&surface(HALF, body), &cloth);
    let params = RepairParams::new();
    let united = repair(&solid, &params, &Carried::default(), &Control::new()).unwrap();
    assert_meant(&joined(&skin, &cloth), volume(&united.mesh), "cloth");
}

/// A cube with a square missing in the side x = -1, and a smaller one that passes through its side x = 1.
fn cubes_with_a_hole() -> Mesh {
    let far = |p: DVec3| p.x < -0.99 && p.y.abs() < 0.5 && p.z.abs() < 0.5;
    let large = cut(&moved(&cube(8), 0.25, DVec3::NEG_ONE), far);
    joined(&large, &moved(&cube(2), 0.5, DVec3::new(0.6, -0.4, -0.37)))
}

#[test]
fn a_body_whose_hole_stays_open_is_united_with_what_it_crosses() {
    let mesh = cubes_with_a_hole();
    let keep = RepairParams::new().with_skip([RepairStep::Holes]);
    let done = repair(&mesh, &keep, &Carried::default(), &Control::new()).unwrap();
    assert_eq!(done.report.steps.united_bodies, 2);
    let found = inspect(&done.mesh).unwrap();
    assert_eq!(found.holes.len(), 1);
    let after = found.check(&CheckParams::default());
    assert_eq!(after.count(DefectKind::SelfIntersection), 0);
    // Closed, it has the volume of the union.
    let closed = repair(
        &done.mesh,
        &RepairParams::new(),
        &Carried::default(),
        &Control::new(),
    );
    let error = volume(&closed.unwrap().mesh) / (8.0 + 0.6) - 1.0;
    assert!(error.abs() < 1e-9, "{error}");
}

/// A band round a unit ball, with a wavy inner side that crosses the ball, and rims turned the wrong way.
fn band_of(ball: &Mesh) -> Mesh {
    let is_near = |v: &u32| ball.positions[*v as usize].z.abs() < 0.5;
    let faces = ball.faces.iter().filter(|f| f.iter().all(is_near));
    let faces: Vec<[u32; 3]> = faces.copied().collect();
    let count = ball.positions.len() as u32;
    let wave = |p: &DVec3| 1.0 + 0.06 * (7.0 * p.x + 3.0 * p.y).sin();
    let inner = ball.positions.iter().map(|p| *p * wave(p));
    let outer = ball.positions.iter().map(|p| *p * (wave(p) + 0.06));
    let edges = |f: &[u32; 3]| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]];
    let all: HashSet<[u32; 2]> = faces.iter().flat_map(edges).collect();
    let rims = all.iter().filter(|[a, b]| !all.contains(&[*b, *a]));
    let mut rims: Vec<[u32; 2]> = rims.copied().collect();
    rims.sort_unstable();
    let mut band: Vec<[u32; 3]> = faces.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    band.extend(faces.iter().map(|f| f.map(|v| v + count)));
    for [a, b] in rims {
        band.extend([[b, a, a + count], [b, a + count, b + count]]);
    }
    Mesh::new(inner.chain(outer).collect(), band)
}

#[test]
fn faces_that_a_union_keeps_stay_in_their_order() {
    let ball = sphere(24);
    let mesh = joined(&ball, &band_of(&ball));
    let params = RepairParams::new();
    let done = repair(&mesh, &params, &Carried::default(), &Control::new()).unwrap();
    assert!(done.report.steps.united_bodies > 1);
    let faces = done.mesh.faces.iter().zip(&done.origins.faces);
    let kept = faces.filter(|(face, origin)| {
        let old = mesh.faces[origin.face as usize];
        let same = |k: usize| {
            let place = done.mesh.positions[face[k] as usize];
            place == mesh.positions[old[k] as usize]
        };
        origin.corners == [0, 1, 2] && (0..3).all(same)
    });
    let kept: Vec<u32> = kept.map(|(_, origin)| origin.face).collect();
    assert!(kept.len() > 100);
    assert!(kept.is_sorted(), "faces that stay have changed their order");
}

#[test]
fn faces_turned_the_wrong_way_on_bodies_that_are_united_keep_their_origin() {
    let body = joined(&cube(4), &moved(&sphere(4), 1.3, DVec3::splat(4.0)));
    let intended = repair(
        &body,
        &RepairParams::default(),
        &Carried::default(),
        &Control::new(),
    )
    .unwrap();
    // Faces of the cube far from the ball, next to each other and apart.
    let is_far = |f: &usize| {
        let centre = body.faces[*f].map(|v| body.positions[v as usize]);
        centre
            .iter()
            .all(|p| p.max_element() <= 4.0 && p.min_element() <= 1.0)
    };
    let far: Vec<usize> = (0..body.faces.len()).filter(is_far).collect();
    for wrong in [
        vec![far[0]],
        vec![far[0], far[9], far[20]],
        vec![far[2], far[3]],
    ] {
        let mut mesh = body.clone();
        wrong.iter().for_each(|f| mesh.faces[*f].swap(1, 2));
        let done = repair(
            &mesh,
            &RepairParams::default(),
            &Carried::default(),
            &Control::new(),
        )
        .unwrap();
        let steps = &done.report.steps;
        assert!(steps.united_bodies >= 2);
        assert_eq!(
            [steps.closing_faces, steps.reoriented_faces],
            [0, wrong.len()]
        );
        assert!((volume(&done.mesh) / volume(&intended.mesh) - 1.0).abs() < 1e-12);
        // All faces come from the input, and the wrong ones are there, turned.
        assert_eq!(done.origins.faces.len(), done.mesh.faces.len());
        for f in &wrong {
            let own = done.origins.faces.iter().zip(&done.mesh.faces);
            let own: Vec<_> = own.filter(|(o, _)| o.face as usize == *f).collect();
            let [(origin, face)] = own[..] else {
                panic!("{f}: {own:?}");
            };
            let before = mesh.faces[*f].map(|v| mesh.positions[v as usize]);
            let now = face.map(|v| done.mesh.positions[v as usize]);
            assert_eq!(now, origin.corners.map(|k| before[usize::from(k)]));
            let [a, b, c] = origin.corners;
            assert!([[0, 2, 1], [2, 1, 0], [1, 0, 2]].contains(&[a, b, c]));
        }
        assert_eq!(done.report.lost_faces, intended.report.lost_faces);
    }
}

/// The mesh at a pseudo-random place, turned.
pub fn placed(mesh: &Mesh, noise: &mut Noise) -> Mesh {
    let angles = 3.0 * noise.vector();
    let turn = DMat3::from_euler(EulerRot::ZXZ, angles.x, angles.y, angles.z);
    let by = 20.0 * noise.vector();
    let mut mesh = mesh.clone();
    mesh.positions.iter_mut().for_each(|p| *p = turn * *p + by);
    mesh
}

#[test]
fn bodies_with_vertices_in_planes_of_others_are_united_however_they_are_turned() {
    // The plane of a ring's axis circle is a side of a box.
    let block = moved(&cube(1), 20.0, DVec3::splat(-10.0));
    let ring = moved(&torus(16, 8), 2.5, DVec3::new(0.0, 0.0, 10.0));
    let truth = volume(&block) + 0.5 * volume(&ring);
    let both = joined(&block, &ring);
    let mut noise = Noise(3);
    for round in 0..8 {
        let done = repaired(&single(&placed(&both, &mut noise)));
        let relative = volume(&done.mesh) / truth - 1.0;
        assert!(relative.abs() < 1e-5, "{round}: {relative}");
        assert_eq!(done.report.steps.relaxed_vertices, 0, "{round}");
        assert!(done.report.after.is_none_or(|v| v.is_sound()), "{round}");
    }
}

#[test]
fn a_cavity_without_some_faces_stays_a_cavity() {
    let block = moved(&cube(1), 4.0, DVec3::splat(-2.0));
    let mut inner = moved(&cube(1), 3.0, DVec3::splat(-1.5));
    let hollow = [volume(&inner), volume(&sphere(6))].map(|own| volume(&block) - own);
    inner.faces.pop();
    let ball = cut(&sphere(6), |p| p.z > 0.95);
    assert!(ball.faces.len() < sphere(6).faces.len());
    for (mesh, truth) in [inner, ball].iter().zip(hollow) {
        let done = repaired(&joined(&block, &reversed(mesh)));
        let relative = volume(&done.mesh) / truth - 1.0;
        assert!(relative.abs() < 1e-3, "{relative}");
        assert_eq!(done.report.steps.inside_components, 0);
    }
}
