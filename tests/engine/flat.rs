//! Planar caps on request (`flat`), and the remark on patches that rise far above their rims.

use crate::desk::{Desk, assert_code, text};
use crate::shapes::{bits, cut, polar, sphere, topology, volume};
use glam::DVec3;
use isomend::io::Format;
use isomend::{Closure, FillParams, HoleOutcome, Inspection, Mesh, fill};

/// Half a ball: the sphere that continues it rises above the rim by half the diameter.
fn half() -> Mesh {
    cut(&sphere(14), |p| polar(p) < 90.0)
}

fn flat(holes: &[usize]) -> FillParams {
    FillParams::new().with_flat(holes.iter().copied())
}

#[test]
fn a_flat_cap_is_in_the_plane_of_its_rim() {
    let mesh = half();
    let filled = fill(&mesh, &flat(&[1])).unwrap();
    assert_eq!(topology(&filled.mesh), (0, 2));
    let n = mesh.positions.len();
    assert_eq!(bits(&filled.mesh.positions[..n]), bits(&mesh.positions));
    assert_eq!(filled.mesh.faces[..mesh.faces.len()], mesh.faces);
    let hole = &filled.report.holes[0];
    assert_eq!(hole.outcome, HoleOutcome::Closed(Closure::Flat));
    assert_eq!(filled.report.tally().flat, 1);
    assert!(filled.report.flawless());
    let rim = hole.hole.rim.iter().map(|&v| mesh.positions[v as usize].z);
    let (low, high) = rim.fold((1.0f64, -1.0f64), |(l, h), z| (l.min(z), h.max(z)));
    let new = &filled.mesh.positions[n..];
    assert!(new.len() > 100, "{}", new.len());
    let inside = |p: &&DVec3| p.z > low - 1e-9 && p.z < high + 1e-9 && p.truncate().length() < 1.0;
    assert_eq!(new.iter().filter(inside).count(), new.len());
    let region = &filled.report.regions[0];
    assert!(region.rise.unwrap() < 1e-9 && !region.balloons());
    assert_eq!(region.intersecting_faces, 0);
    // The mean face area is similar to the mesh's.
    let area = |mesh: &Mesh, faces: &[[u32; 3]]| {
        let of = |f: &[u32; 3]| {
            let [a, b, c] = f.map(|v| mesh.positions[v as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        faces.iter().map(of).sum::<f64>() / faces.len() as f64
    };
    let (own, new) = (
        area(&mesh, &mesh.faces),
        area(&filled.mesh, &filled.mesh.faces[mesh.faces.len()..]),
    );
    assert!(new < 1.5 * own && new > 0.15 * own, "{own} {new}");
}

#[test]
fn a_patch_that_rises_far_above_its_rim_is_reported() {
    let filled = fill(&half(), &FillParams::default()).unwrap();
    let region = &filled.report.regions[0];
    let rise = region.rise.unwrap();
    assert!((rise - 0.5).abs() < 0.03 && region.balloons(), "{rise}");
    // Half of the rim's own height counts.
    let wavy = cut(&sphere(14), |p| {
        polar(p) < 90.0 + 25.0 * (2.0 * p.y.atan2(p.x)).cos()
    });
    let filled = fill(&wavy, &FillParams::default()).unwrap();
    let region = &filled.report.regions[0];
    let rise = region.rise.unwrap();
    assert!((0.35..0.45).contains(&rise) && region.balloons(), "{rise}");
    let small = cut(&sphere(14), |p| polar(p) < 30.0);
    let filled = fill(&small, &FillParams::default()).unwrap();
    assert!(!filled.report.regions[0].balloons());
}

#[test]
fn a_flat_cap_does_not_depend_on_other_holes_and_is_in_the_plan() {
    let two = cut(&sphere(14), |p| polar(p) < 40.0 || polar(p) > 150.0);
    let both = fill(&two, &flat(&[1, 2])).unwrap();
    let mixed = fill(&two, &flat(&[1]).with_holes([2])).unwrap();
    assert_eq!(topology(&both.mesh), (0, 2));
    assert_eq!(topology(&mixed.mesh), (0, 2));
    let outcomes = |report: &isomend::FillReport| -> Vec<HoleOutcome> {
        report.holes.iter().map(|h| h.outcome.clone()).collect()
    };
    assert_eq!(
        outcomes(&mixed.report),
        [
            HoleOutcome::Closed(Closure::Flat),
            HoleOutcome::Closed(Closure::LevelSet)
        ]
    );
    let planned = Inspection::new(&two)
        .unwrap()
        .plan(&flat(&[1]).with_holes([2]))
        .unwrap();
    let plans: Vec<_> = planned.holes.into_iter().map(|h| h.outcome).collect();
    assert_eq!(plans, [Some(HoleOutcome::Closed(Closure::Flat)), None]);
    let caps = |report: &isomend::FillReport, hole: usize| {
        let of = |r: &&isomend::RegionReport| r.holes == [isomend::HoleId::from(hole)];
        report.regions.iter().find(of).unwrap().new_vertices
    };
    assert_eq!(caps(&both.report, 1), caps(&mixed.report, 1));
}

/// A square block of side 4 and height 1 with a round hole through it, without its top. `n` edges round the hole, a multiple of four.
fn topless_block(n: u32) -> Mesh {
    let angle = |k: u32, of: u32| std::f64::consts::TAU * f64::from(k) / f64::from(of);
    let ring = (0..n).map(|k| DVec3::new(angle(k, n).cos(), angle(k, n).sin(), 0.0));
    let corners = (0..4).map(|k| {
        let a = angle(2 * k + 1, 8);
        DVec3::new(2.0 * a.cos().signum(), 2.0 * a.sin().signum(), 0.0)
    });
    let low: Vec<DVec3> = ring.chain(corners).collect();
    let count = n + 4;
    let positions = [0.0, 1.0]
        .iter()
        .flat_map(|z| low.iter().map(move |p| *p + *z * DVec3::Z));
    let mut faces = Vec::new();
    for k in 0..n {
        let (a, b) = (k, (k + 1) % n);
        let corner = n + 4 * k / n;
        faces.extend([[a, b, corner], [a, a + count, b], [b, a + count, b + count]]);
    }
    for k in 0..4 {
        let (a, b) = (n + k, n + (k + 1) % 4);
        let shared = (k + 1) * n / 4 % n;
        faces.extend([[a, shared, b], [a, b, a + count], [b, b + count, a + count]]);
    }
    Mesh::new(positions.collect(), faces)
}

/// A round box without its bottom, of 48 sides, whose vertices are moved by at most a part of an edge.
fn noisy_box(noise: f64) -> Mesh {
    let (sides, rings) = (48u32, 16u32);
    let edge = std::f64::consts::TAU / f64::from(sides);
    let moved = |i: u32| {
        let random = |k: u32| (f64::from(3 * i + k) * 12.9898).sin() * 43758.5453;
        let offset = [0, 1, 2].map(|k| 2.0 * random(k).rem_euclid(1.0) - 1.0);
        noise * edge * DVec3::from(offset)
    };
    let mut positions = vec![DVec3::new(0.0, 0.0, f64::from(rings) * edge)];
    let mut faces = Vec::new();
    for (ring, side) in (0..=rings).flat_map(|r| (0..sides).map(move |s| (r, s))) {
        let (sine, cosine) = (f64::from(side) * edge).sin_cos();
        let height = f64::from(rings - ring) * edge;
        positions.push(DVec3::new(cosine, sine, height) + moved(ring * sides + side));
        let at = |r: u32, s: u32| 1 + r * sides + s % sides;
        match ring {
            0 => faces.push([0, at(0, side), at(0, side + 1)]),
            r => {
                let [a, b] = [at(r - 1, side), at(r - 1, side + 1)];
                let [c, d] = [at(r, side), at(r, side + 1)];
                faces.extend([[a, c, b], [b, c, d]]);
            }
        }
    }
    Mesh::new(positions, faces)
}

#[test]
fn a_missing_flat_side_of_noisy_walls_is_flat() {
    let whole = std::f64::consts::PI * 16.0 * std::f64::consts::TAU / 48.0;
    for noise in [0.0, 1e-3, 5e-3] {
        let filled = fill(&noisy_box(noise), &FillParams::default()).unwrap();
        assert_eq!(topology(&filled.mesh), (0, 2));
        let part = volume(&filled.mesh) / whole;
        assert!(
            (part - 1.0).abs() < 0.01,
            "noise {noise}: {part} of the volume"
        );
        assert!(filled.report.flawless());
    }
}

#[test]
fn a_missing_side_round_a_hole_is_a_cap_with_a_hole_however_few_edges_its_outline_has() {
    let block = topless_block(24);
    let filled = fill(&block, &FillParams::default()).unwrap();
    assert_eq!(topology(&filled.mesh), (0, 0));
    assert_eq!(filled.report.tally().flat, 2);
    assert_eq!(filled.report.tally().intersecting_faces, 0);
    let hole = 12.0 * (std::f64::consts::TAU / 24.0).sin();
    assert!((volume(&filled.mesh) - (16.0 - hole)).abs() < 1e-9);
}

/// A ring of 16 sides with chamfered edges, without its bottom, or with it if `closed`; the inner rim is lower than the outer one.
fn chamfered_ring(closed: bool) -> Mesh {
    let profile = [
        (1.7, -0.03),
        (1.7, 0.2),
        (1.75, 0.27),
        (1.9, 0.27),
        (2.0, 0.2),
        (2.0, 0.0),
    ];
    let (sides, count) = (16u32, profile.len() as u32);
    let at = |side: u32| std::f64::consts::TAU * f64::from(side) / f64::from(sides);
    let positions = (0..sides).flat_map(|side| {
        let (sine, cosine) = at(side).sin_cos();
        profile.map(|(r, z)| DVec3::new(r * cosine, r * sine, z))
    });
    let mut faces = Vec::new();
    for (side, k) in (0..sides).flat_map(|s| (0..count - u32::from(!closed)).map(move |k| (s, k))) {
        let vertex = |side: u32, k: u32| side % sides * count + k % count;
        let [a, b] = [vertex(side, k), vertex(side, k + 1)];
        let [c, d] = [vertex(side + 1, k), vertex(side + 1, k + 1)];
        faces.extend([[a, c, b], [b, c, d]]);
    }
    Mesh::new(positions.collect(), faces)
}

#[test]
fn a_ring_whose_rims_are_not_quite_in_one_plane_gets_a_flat_bottom() {
    let filled = fill(&chamfered_ring(false), &FillParams::default()).unwrap();
    assert_eq!(topology(&filled.mesh), (0, 0));
    assert_eq!(filled.report.tally().flat, 2);
    assert!(filled.report.flawless());
    let whole = volume(&chamfered_ring(true));
    assert!((volume(&filled.mesh) / whole - 1.0).abs() < 0.01);
}

#[test]
fn the_command_line_suggests_flat_caps_and_refuses_invalid_ones() {
    let desk = Desk::new();
    desk.save("half.ply", &half(), Format::Ply);
    let done = desk.run(&["fill", "half.ply", "-o", "round.ply"]);
    assert_code(&done, 0);
    assert!(text(&done.stderr).contains("--flat 1"));
    let done = desk.run(&[
        "fill",
        "half.ply",
        "-o",
        "flat.ply",
        "--flat",
        "1",
        "--json",
        "flat.json",
    ]);
    assert_code(&done, 0);
    let said = text(&done.stderr);
    assert!(
        said.contains("1 by flat caps") && !said.contains("--flat"),
        "{said}"
    );
    let document = desk.json("flat.json");
    assert_eq!(document["holes"][0]["closed_by"], "flat");
    assert_eq!(document["regions"][0]["closed_by"], "flat");
    assert_eq!(document["outcomes"]["flat"], 1);
    let wrong = desk.run(&["fill", "half.ply", "-o", "no.ply", "--flat", "7"]);
    assert_code(&wrong, 1);
    assert!(text(&wrong.stderr).contains("no hole 7"));
    let both = desk.run(&[
        "fill", "ball.ply", "-o", "no.ply", "--flat", "1", "--bridge", "1+2",
    ]);
    assert_code(&both, 2);
    assert!(text(&both.stderr).contains("bridged"));
    let none = desk.run(&["fill", "half.ply", "-o", "no.ply", "--flat", "one"]);
    assert_code(&none, 2);
    assert!(text(&none.stderr).contains("'one' is not a hole number"));
    assert!(!desk.path("no.ply").exists());
}
