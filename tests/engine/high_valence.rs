//! Vertices with thousands of faces, and meshes of long, thin faces, take no more than a few times the time of others.

use std::f64::consts::TAU;

use glam::DVec3;
use isomend::check::{CheckParams, DefectKind};
use isomend::{
    Carried, Closure, Control, FillParams, HoleOutcome, Inspection, Mesh, RepairParams, inspect,
    repair,
};

use crate::shapes;

/// Two fans of `n` faces around two vertices, joined along a circle.
fn bipyramid(n: u32) -> Mesh {
    let at = |i: u32| f64::from(i) * TAU / f64::from(n);
    let circle = (0..n).map(|i| DVec3::new(at(i).cos(), at(i).sin(), 0.0));
    let positions = circle.chain([DVec3::Z, -DVec3::Z]).collect();
    let sectors = (0..n).flat_map(|i| {
        let next = (i + 1) % n;
        [[i, next, n], [next, i, n + 1]]
    });
    let faces = sectors.collect();
    shapes::turned(Mesh::new(positions, faces))
}

/// CPU time of work on one thread, in seconds.
#[cfg(target_os = "linux")]
fn seconds<T>(work: impl FnOnce() -> T + Send) -> (T, f64)
where
    T: Send,
{
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.unwrap().install(|| {
        let own = crate::cpu::this_thread();
        let begun = crate::cpu::cpu(&own);
        let result = work();
        (result, crate::cpu::cpu(&own) - begun)
    })
}

#[cfg(target_os = "linux")]
#[test]
fn fans_of_ten_thousand_faces_are_checked_and_filled_in_seconds() {
    let mesh = bipyramid(10_000);
    let found = Inspection::new(&mesh).unwrap();
    let (verdict, check) = seconds(|| found.check(&CheckParams::default()));
    assert!(verdict.is_sound(), "{}", verdict.line());
    assert!(check < 3.0, "checked in {check} s");
    // Faces next to each other are missing, at one of the two vertices.
    let mut open = mesh;
    open.faces = open.faces.into_iter().skip(10).collect();
    let found = Inspection::new(&open).unwrap();
    let (filled, fill) = seconds(|| found.fill(&FillParams::default(), &Control::new()));
    let report = filled.unwrap().report;
    assert!(!report.incomplete());
    assert!(fill < 12.0, "filled in {fill} s");
}

/// A ring of faces round a hole of radius 1 with `n` edges of equal length.
fn ring(n: u32) -> Mesh {
    let row = |j: u32| {
        let point = move |i: u32| {
            let t = (f64::from(i) + 0.5 * f64::from(j % 2)) * TAU / f64::from(n);
            let r = 1.0 + f64::from(j) * TAU / f64::from(n);
            DVec3::new(r * t.cos(), r * t.sin(), 0.1 * r * (3.0 * t).cos())
        };
        (0..n).map(point)
    };
    let faces = (0..29).flat_map(|j| {
        (0..n).flat_map(move |i| {
            let (a, b) = (j * n + i, j * n + (i + 1) % n);
            let (c, d) = (a + n, b + n);
            match j % 2 {
                0 => [[a, b, c], [b, d, c]],
                _ => [[a, b, d], [a, d, c]],
            }
        })
    });
    Mesh::new((0..30).flat_map(row).collect(), faces.collect())
}

#[cfg(target_os = "linux")]
#[test]
fn a_hole_of_two_thousand_edges_takes_seconds_and_few_faces() {
    let mesh = ring(2000);
    let found = Inspection::new(&mesh).unwrap();
    let inner = found.holes.iter().find(|h| h.diameter < 2.1).unwrap();
    let params = FillParams::default().with_holes([inner.id]);
    let (filled, time) = seconds(|| found.fill(&params, &Control::new()));
    let filled = filled.unwrap();
    let outcome = &filled.report.holes[inner.id.get() - 1].outcome;
    assert_eq!(outcome.closure(), Some(&Closure::LevelSet));
    // Faces as small as those at the rim would be 0.3 n², a million.
    let new = filled.mesh.faces.len() - mesh.faces.len();
    assert!(new < 60_000, "{new} faces");
    assert!(time < 20.0, "filled in {time} s");
    // An edge ratio that is asked for is kept.
    let small = ring(400);
    let found = Inspection::new(&small).unwrap();
    let inner = found.holes.iter().find(|h| h.diameter < 2.1).unwrap();
    let params = FillParams::default()
        .with_holes([inner.id])
        .with_edge_ratio(1.0);
    let even = found.fill(&params, &Control::new()).unwrap();
    assert!(even.mesh.faces.len() - small.faces.len() > 20_000);
}

/// A ring of long faces between a circle of `n` edges round a hole and a wider one of `n / 100`, on a surface that undulates by `rise`.
fn needles(n: u32, rise: f64) -> Mesh {
    let outer = n / 100;
    let point = |r: f64, t: f64| DVec3::new(r * t.cos(), r * t.sin(), rise * r * (3.0 * t).cos());
    let circle = |r: f64, count: u32| {
        (0..count).map(move |i| point(r, f64::from(i) * TAU / f64::from(count)))
    };
    let positions = circle(1.0, n)
        .chain(circle(1.2, outer))
        .chain(circle(1.5, outer));
    let at = |row: u32, j: u32| n + row * outer + j % outer;
    let faces = (0..outer).flat_map(|j| {
        let fan = (100 * j..100 * (j + 1)).map(move |i| [i, at(0, j), (i + 1) % n]);
        let (a, b) = (at(0, j), at(0, j + 1));
        let (c, d) = (at(1, j), at(1, j + 1));
        fan.chain([[(100 * (j + 1)) % n, a, b], [b, a, c], [b, c, d]])
    });
    shapes::turned(Mesh::new(positions.collect(), faces.collect()))
}

#[cfg(target_os = "linux")]
#[test]
fn a_fine_rim_of_coarse_faces_takes_few_new_vertices() {
    for rise in [0.0, 0.05] {
        let mesh = needles(12_000, rise);
        let found = Inspection::new(&mesh).unwrap();
        let inner = found.holes.iter().find(|h| h.edges == 12_000).unwrap();
        let params = FillParams::default().with_holes([inner.id]);
        let (filled, time) = seconds(|| found.fill(&params, &Control::new()));
        let filled = filled.unwrap();
        let outcome = &filled.report.holes[inner.id.get() - 1].outcome;
        let is_smooth = |how: &Closure| how.cause().is_none();
        assert!(outcome.closure().is_some_and(is_smooth), "{outcome:?}");
        assert_eq!(filled.report.regions[0].intersecting_faces, 0);
        let new = filled.mesh.faces.len() - mesh.faces.len();
        let vertices = filled.mesh.positions.len() - mesh.positions.len();
        assert!(new < 60_000 && vertices < 24_000, "{new} {vertices}");
        assert!(time < 8.0, "filled in {time} s");
        // Every edge of the rim is used.
        let after = Inspection::new(&filled.mesh).unwrap();
        assert_eq!(after.holes.len(), found.holes.len() - 1);
    }
}

#[test]
fn faces_that_run_through_a_fan_are_found() {
    let mut mesh = bipyramid(2000);
    let at = mesh.positions.len() as u32;
    // From one of the two vertices through a few faces of the other fan, beside the other vertex.
    let (top, low) = (mesh.positions[2000], mesh.positions[2001]);
    let away = (mesh.positions[0] - mesh.positions[1000]).normalize();
    let beside = away.cross(top - low).normalize();
    let end = low + 0.3 * away;
    mesh.positions.extend([end, end + 0.01 * beside]);
    mesh.faces.push([2000, at, at + 1]);
    let found = Inspection::new(&mesh).unwrap();
    let verdict = found.check(&CheckParams::default());
    let count = verdict.count(DefectKind::SelfIntersection);
    assert!((2..200).contains(&count), "{count}");
    let listed = verdict.defects.iter();
    let listed = listed.filter(|d| d.kind == DefectKind::SelfIntersection);
    let faces: Vec<u32> = listed.flat_map(|d| d.faces.clone()).collect();
    assert!(faces.contains(&4000), "{faces:?}");
}

#[test]
fn a_hole_at_a_fan_is_closed_as_elsewhere() {
    let mut mesh = bipyramid(600);
    mesh.faces.drain(..20);
    let filled = isomend::fill(&mesh, &FillParams::default()).unwrap();
    let outcomes = filled.report.holes.iter().map(|h| &h.outcome);
    assert!(outcomes.clone().all(|o| !matches!(o, HoleOutcome::Open(_))));
    assert_eq!(outcomes.count(), 1);
}

/// A torus whose tube is thicker than its ring: near the axis it passes through itself in many sheets.
#[cfg(target_os = "linux")]
fn fat_torus(around: u32, across: u32) -> Mesh {
    let point = |i: u32, j: u32| {
        let [u, v] = [(i, around), (j, across)].map(|(k, n)| f64::from(k) * TAU / f64::from(n));
        let r = 1.0 + 1.1 * v.cos();
        DVec3::new(r * u.cos(), r * u.sin(), 1.1 * v.sin())
    };
    let all = || (0..around).flat_map(move |i| (0..across).map(move |j| (i, j)));
    let at = |i: u32, j: u32| i % around * across + j % across;
    let faces = all().flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    shapes::turned(Mesh::new(
        all().map(|(i, j)| point(i, j)).collect(),
        faces.collect(),
    ))
}

#[cfg(target_os = "linux")]
#[test]
fn many_sheets_of_one_body_through_one_place_are_moved_before_the_body_is_united() {
    let mesh = fat_torus(48, 24);
    let verdict = |mesh: &Mesh| inspect(mesh).unwrap().check(&CheckParams::default());
    assert!(verdict(&mesh).count(DefectKind::SelfIntersection) > 100);
    let params = RepairParams::default();
    let (done, time) = seconds(|| repair(&mesh, &params, &Carried::default(), &Control::new()));
    let done = done.unwrap();
    assert!(verdict(&done.mesh).is_sound());
    assert!(done.report.steps.relaxed_vertices > 0 && done.report.doubt.is_none());
    assert_eq!(done.mesh.faces, mesh.faces);
    assert!(time < 4.0, "repaired in {time} s");
}
