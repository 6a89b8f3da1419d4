//! `isomend restore` replaces marked regions and keeps the rest of the mesh.

use std::fs;
use std::process::Output;

use crate::shapes;
use assert_cmd::Command;
use glam::DVec3;
use isomend::Attributes;
use isomend::LabelKind;
use isomend::io::{WriteOptions, read_path, write_path};
use isomend::{FillError, FillParams, HoleId, Mesh, RestoreError, RestoreParams, fill, restore};
use isomend::{Mask, Selector};
use serde_json::Value;
use tempfile::TempDir;

/// A mesh of an exact surface, and a ball round the part that gets damaged.
struct Case {
    name: &'static str,
    mesh: Mesh,
    distance: fn(DVec3) -> f64,
    centre: DVec3,
    radius: f64,
}

fn cases() -> Vec<Case> {
    let catenoid = |p: DVec3| shapes::catenoid_distance(p);
    vec![
        Case {
            name: "sphere",
            mesh: shapes::sphere(20),
            distance: |p| p.length() - 1.0,
            centre: DVec3::new(0.3, 0.4, 0.5).normalize(),
            radius: 0.5,
        },
        Case {
            name: "torus",
            mesh: shapes::torus(120, 80),
            distance: shapes::torus_distance,
            centre: DVec3::new(shapes::BIG + 1.0, 0.0, 0.0),
            radius: 0.6,
        },
        Case {
            name: "catenoid",
            mesh: catenoid_band(),
            distance: catenoid,
            centre: DVec3::new(0.8, 0.6, 0.0),
            radius: 0.45,
        },
    ]
}

/// The catenoid of waist 1 for |z| < 0.95.
fn catenoid_band() -> Mesh {
    let (around, up) = (80u32, 26u32);
    let mut mesh = Mesh::default();
    for j in 0..=up {
        let z = 0.95 * (2.0 * f64::from(j) / f64::from(up) - 1.0);
        for i in 0..around {
            let angle =
                std::f64::consts::TAU * (f64::from(i) + 0.5 * f64::from(j % 2)) / f64::from(around);
            let (s, c) = angle.sin_cos();
            mesh.positions
                .push(DVec3::new(z.cosh() * c, z.cosh() * s, z));
        }
    }
    for j in 0..up {
        for i in 0..around {
            let at = |i: u32, j: u32| j * around + i % around;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
            if j % 2 == 0 {
                mesh.faces.extend([[a, b, c], [b, d, c]]);
            } else {
                mesh.faces.extend([[a, d, c], [a, b, d]]);
            }
        }
    }
    mesh
}

fn ball(centre: DVec3, radius: f64, mesh: &Mesh) -> Vec<bool> {
    let mask = Mask {
        selectors: vec![Selector::Ball { centre, radius }],
        ..Mask::default()
    };
    mask.faces(mesh, &Attributes::default()).unwrap()
}

/// A pseudo-random number between −1 and 1; `k` is the seed.
fn chance(i: usize, k: u64) -> f64 {
    let mut x = (i as u64)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(k.wrapping_mul(0xd1b5_4a32_d192_ed03));
    x = (x ^ (x >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((x ^ (x >> 29)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// The mesh with a dent, a bump or noise inside 0.75 of the ball's radius.
fn damaged(case: &Case, kind: &str) -> Mesh {
    let mut mesh = case.mesh.clone();
    for (i, p) in mesh.positions.iter_mut().enumerate() {
        let t = p.distance(case.centre) / (0.75 * case.radius);
        if t >= 1.0 {
            continue;
        }
        let step = |axis: DVec3| {
            ((case.distance)(*p + 1e-5 * axis) - (case.distance)(*p - 1e-5 * axis)) / 2e-5
        };
        let normal = DVec3::new(step(DVec3::X), step(DVec3::Y), step(DVec3::Z)).normalize();
        let hat = (1.0 - t * t).powi(2) * 0.3 * case.radius;
        *p += normal
            * match kind {
                "dent" => -hat,
                "bump" => hat,
                _ => 0.03 * case.radius * chance(i, 1),
            };
    }
    mesh
}

fn rms(case: &Case, mesh: &Mesh, first: usize) -> f64 {
    let new = &mesh.positions[first..];
    assert!(!new.is_empty());
    let sum: f64 = new.iter().map(|p| (case.distance)(*p).powi(2)).sum();
    (sum / new.len() as f64).sqrt()
}

/// Kept vertices and faces come first in the result, in order and bit for bit.
fn assert_kept(input: &Mesh, restored: &isomend::Restored) {
    let kept = &restored.kept;
    let positions: Vec<DVec3> = (0..input.positions.len())
        .filter(|&v| kept.vertices[v])
        .map(|v| input.positions[v])
        .collect();
    let out = &restored.mesh;
    assert_eq!(
        shapes::bits(&out.positions[..positions.len()]),
        shapes::bits(&positions)
    );
    let corners = |mesh: &Mesh, f: [u32; 3]| f.map(|v| mesh.positions[v as usize]);
    let faces: Vec<[DVec3; 3]> = (0..input.faces.len())
        .filter(|&f| kept.faces[f])
        .map(|f| corners(input, input.faces[f]))
        .collect();
    let first: Vec<[DVec3; 3]> = out.faces[..faces.len()]
        .iter()
        .map(|f| corners(out, *f))
        .collect();
    assert_eq!(first, faces);
}

#[test]
fn a_restored_region_is_as_accurate_as_a_filled_hole() {
    for case in cases() {
        let marked = ball(case.centre, case.radius, &case.mesh);
        let hole = shapes::cut(&case.mesh, |p| p.distance(case.centre) <= case.radius);
        let mut params = FillParams::default();
        params.holes = Some(holes_in(&hole, &case));
        let filled = fill(&hole, &params).unwrap();
        let floor = rms(&case, &filled.mesh, hole.positions.len());
        for kind in ["dent", "bump", "noise"] {
            let mesh = damaged(&case, kind);
            let restored = restore(&mesh, &marked, &RestoreParams::default()).unwrap();
            let report = &restored.report;
            assert!(!restored.fill.incomplete() && report.removed_faces >= report.marked_faces);
            assert_kept(&mesh, &restored);
            let error = rms(&case, &restored.mesh, restored.kept.mesh.positions.len());
            let region = &restored.fill.regions[0];
            println!(
                "{} {kind}: {error:.3e} against {floor:.3e} of fill, seam {:.2?}",
                case.name, region.seam_angle_mean
            );
            // A restoration also removes single faces that stick into the cut, so that the holes differ slightly; and a finish ends
            // when its steps are shorter than 3e-4 diameters.
            assert!(error <= 1.2 * floor + 1e-4, "{} {kind}", case.name);
            assert_eq!(restored.fill.regions.len(), 1);
            let (lone, _) = shapes::topology(&restored.mesh);
            assert_eq!(lone, shapes::topology(&mesh).0);
            let pinched = shapes::pinched_vertices(&restored.mesh);
            assert_eq!(pinched, shapes::pinched_vertices(&mesh));
        }
    }
}

fn holes_in(hole: &Mesh, case: &Case) -> Vec<HoleId> {
    let found = isomend::inspect(hole).unwrap();
    let near = |h: &&isomend::Hole| h.centre.distance(case.centre) < case.radius;
    found.holes.iter().filter(near).map(|h| h.id).collect()
}

#[test]
fn keep_shape_keeps_a_bump_and_removes_noise() {
    let case = &cases()[0];
    let marked = ball(case.centre, case.radius, &case.mesh);
    let error = |kind: &str, keep_shape: f64| {
        let mesh = damaged(case, kind);
        let mut params = RestoreParams::default();
        params.keep_shape = keep_shape;
        let restored = restore(&mesh, &marked, &params).unwrap();
        assert_kept(&mesh, &restored);
        rms(case, &restored.mesh, restored.kept.mesh.positions.len())
    };
    let before = |kind: &str| {
        let mesh = damaged(case, kind);
        let inside = mesh.positions.iter().enumerate();
        let values: Vec<f64> = inside
            .filter(|(v, _)| case.mesh.positions[*v].distance(case.centre) < 0.75 * case.radius)
            .map(|(_, p)| (case.distance)(*p).powi(2))
            .collect();
        (values.iter().sum::<f64>() / values.len() as f64).sqrt()
    };
    let [replaced, half, kept] = [0.0, 0.6, 0.9].map(|w| error("bump", w));
    println!("bump {}: {replaced} {half} {kept}", before("bump"));
    assert!(replaced < 0.05 * before("bump") && replaced < half && half < kept);
    assert!(kept > 0.5 * before("bump"));
    let [replaced, half, kept] = [0.0, 0.5, 0.8].map(|w| error("noise", w));
    println!("noise {}: {replaced} {half} {kept}", before("noise"));
    assert!(half < 0.4 * before("noise") && kept < before("noise"));
}

/// Masks with holes, spikes and stray faces: the result is as closed and manifold as the input.
#[test]
fn results_of_ragged_masks_are_closed_and_manifold() {
    let mesh = shapes::sphere(14);
    for seed in 0..6 {
        let mut marked = ball(DVec3::new(0.2, -0.3, 0.9), 0.55, &mesh);
        let part = 0.2 * f64::from(seed) - 0.9;
        for (f, mark) in marked.iter_mut().enumerate() {
            *mark &= chance(f, 2 + seed as u64) > part;
            *mark |= chance(f, 20 + seed as u64) > 0.998;
        }
        let restored = restore(&mesh, &marked, &RestoreParams::default()).unwrap();
        assert_kept(&mesh, &restored);
        let report = &restored.report;
        println!(
            "{} marked, {} cut out, {} holes",
            report.marked_faces,
            report.removed_faces,
            restored.fill.holes.len()
        );
        assert!(!restored.fill.incomplete());
        assert!(
            marked
                .iter()
                .zip(&restored.kept.faces)
                .all(|(m, k)| !(*m && *k))
        );
        assert_eq!(shapes::topology(&restored.mesh), (0, 2), "seed {seed}");
        assert_eq!(shapes::pinched_vertices(&restored.mesh), 0, "seed {seed}");
    }
}

#[test]
fn holes_in_the_marked_region_are_closed_and_others_stay_open() {
    let whole = shapes::sphere(16);
    let mesh = shapes::cut(&whole, |p| {
        p.z > 0.97 || p.x > 0.97 || p.distance(DVec3::new(0.0, 0.4, 0.9)) < 0.12
    });
    // One hole inside the ball, one across its surface, one elsewhere.
    let marked = ball(DVec3::new(0.0, 0.1, 1.0), 0.45, &mesh);
    let restored = restore(&mesh, &marked, &RestoreParams::default()).unwrap();
    assert_kept(&mesh, &restored);
    let report = &restored.fill;
    assert_eq!((report.holes.len(), report.regions.len()), (2, 1));
    let before = isomend::inspect(&mesh).unwrap();
    let joined = before.holes.iter().filter(|hole| hole.centre.x < 0.9);
    let joined: Vec<_> = joined.map(|hole| hole.id).collect();
    assert_eq!((joined.len(), &restored.report.joined_holes), (2, &joined));
    let after = isomend::inspect(&restored.mesh).unwrap();
    assert_eq!(after.holes.len(), 1);
    assert!(after.holes[0].centre.x > 0.9);
    for p in &restored.mesh.positions {
        assert!((p.length() - 1.0).abs() < 0.01);
    }
}

#[test]
fn one_or_two_faces_of_a_component_are_not_left_with_an_open_rim() {
    // An octahedron: two neighbouring faces, or two single faces, would remain.
    let mesh = shapes::sphere(1);
    let octahedron = Mesh::new(
        [1.0, -1.0]
            .map(|s| [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| s * axis))
            .concat(),
        vec![
            [0, 1, 2],
            [1, 3, 2],
            [3, 4, 2],
            [4, 0, 2],
            [1, 0, 5],
            [3, 1, 5],
            [4, 3, 5],
            [0, 4, 5],
        ],
    );
    for left in [[0, 1], [0, 6]] {
        let marked: Vec<bool> = (0..8).map(|f| !left.contains(&f)).collect();
        let error = restore(&octahedron, &marked, &RestoreParams::default()).unwrap_err();
        let is_refused = matches!(error, RestoreError::WholeComponent { faces: 8 });
        assert!(is_refused, "{error}");
    }
    // The rest of another body is kept.
    let mut both = shapes::joined(&mesh, &octahedron);
    both.positions[mesh.positions.len()..]
        .iter_mut()
        .for_each(|p| *p += DVec3::splat(5.0));
    let first = mesh.faces.len();
    let marked: Vec<bool> = (0..both.faces.len()).map(|f| f > first + 1).collect();
    assert!(restore(&both, &marked, &RestoreParams::default()).is_err());
}

#[test]
fn masks_that_cannot_be_restored_are_refused() {
    let mesh = shapes::sphere(6);
    let count = mesh.faces.len();
    let params = RestoreParams::default();
    let refused = |mesh: &Mesh, marked: &[bool]| restore(mesh, marked, &params).unwrap_err();
    let none = refused(&mesh, &vec![false; count]);
    assert!(matches!(none, RestoreError::NothingMarked), "{none}");
    let all = refused(&mesh, &vec![true; count]);
    assert!(
        matches!(all, RestoreError::WholeComponent { faces } if faces == count),
        "{all}"
    );
    assert!(matches!(
        refused(&mesh, &[true]),
        RestoreError::Marks { .. }
    ));
    let sheet = shapes::sheet(12);
    let border = refused(&sheet, &ball(DVec3::X, 0.4, &sheet));
    assert!(matches!(border, RestoreError::Border { .. }), "{border}");
    let mut keep_shape = RestoreParams::default();
    keep_shape.keep_shape = 1.5;
    let marked = ball(DVec3::Z, 0.4, &mesh);
    let part = restore(&mesh, &marked, &keep_shape).unwrap_err();
    assert!(
        matches!(part, RestoreError::Fill(FillError::Bounds(_))),
        "{part}"
    );
    let empty = refused(&Mesh::default(), &[]);
    assert!(empty.to_string().contains("no faces"), "{empty}");
}

struct Desk(TempDir);

impl Desk {
    /// With `ball.ply`, a unit sphere of 2880 faces.
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        let path = desk.0.path().join("ball.ply");
        write_path(&path, &shapes::sphere(12), None, &WriteOptions::default()).unwrap();
        desk
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::cargo_bin("isomend").unwrap();
        command.current_dir(self.0.path()).arg("restore");
        command.args(arguments).output().unwrap()
    }

    fn done(&self, arguments: &[&str]) -> Output {
        let output = self.run(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        output
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.0.path().join(name)).unwrap()
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let desk = Desk::new();
    let run = |out: &str, threads: &str| {
        let mask = ["--ball", "0,0,1,0.5", "--keep-shape", "0.5"];
        desk.done(&[&["ball.ply", "-o", out, "--threads", threads], &mask[..]].concat());
        desk.bytes(out)
    };
    assert_eq!(run("one.ply", "1"), run("two.ply", "2"));
}

#[test]
fn masks_combine_and_the_report_counts_removed_faces() {
    let desk = Desk::new();
    let mask = ["--ball", "0,0,1,0.3", "--box=-2,-2,-2,2,2,-0.95"];
    let arguments = ["ball.ply", "-o", "out.obj", "--json", "-", "-q"];
    let output = desk.done(&[&arguments[..], &mask[..]].concat());
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["command"], "restore");
    assert_eq!(report["complete"], true);
    assert_eq!(report["input"]["faces"], 2880);
    assert_eq!(report["holes"].as_array().unwrap().len(), 2);
    assert!(report["removed_faces"].as_u64() >= report["marked_faces"].as_u64());
    let written = read_path(&desk.0.path().join("out.obj"), None).unwrap();
    assert_eq!(shapes::topology(&written.mesh), (0, 2));
}

#[test]
fn attributes_are_kept_and_continued_on_patches() {
    let desk = Desk::new();
    let sphere = shapes::sphere(10);
    let mut text = String::from("mtllib skin.mtl\n");
    for p in &sphere.positions {
        let red = 0.5 + 0.5 * p.x;
        text += &format!("v {} {} {} {red} 0.25 0\n", p.x, p.y, p.z);
    }
    for (i, f) in sphere.faces.iter().enumerate() {
        if i % 500 == 0 {
            text += &format!("usemtl m{}\n", i / 500);
        }
        text += &format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1);
    }
    fs::write(desk.0.path().join("paint.obj"), text).unwrap();
    desk.done(&["paint.obj", "-o", "out.obj", "--ball", "0,1,0,0.5"]);
    let after = read_path(&desk.0.path().join("out.obj"), None).unwrap();
    let colours = &after.attributes.vertex[0];
    for (v, p) in after.mesh.positions.iter().enumerate() {
        let colour = colours.get(v).unwrap();
        let wanted = 0.5 + 0.5 * p.x;
        assert!((colour[0] - wanted).abs() < 0.02 && (colour[1] - 0.25).abs() < 1e-6);
    }
    assert!(!after.attributes.labels.is_empty());
    let groups = after.attributes.labels_of(LabelKind::Group);
    assert!(groups.is_some_and(|g| g.names.iter().any(|n| n == "isomend_patch")));
}

#[test]
fn a_restored_glb_file_is_closed() {
    let desk = Desk::new();
    let path = desk.0.path().join("ball.glb");
    write_path(&path, &shapes::sphere(12), None, &WriteOptions::default()).unwrap();
    desk.done(&["ball.glb", "-o", "out.glb", "--ball", "0,0,1,0.5"]);
    let after = read_path(&desk.0.path().join("out.glb"), None).unwrap();
    let (mut welded, _) = isomend_core::mesh::welded(&after.mesh);
    let used: Vec<u32> = welded.faces.iter().flatten().copied().collect();
    assert!(!used.is_empty());
    assert_eq!(shapes::topology(&welded), (0, 2));
    welded.positions.retain(|p| p.is_finite());
    for &v in &used {
        assert!((welded.positions[v as usize].length() - 1.0).abs() < 0.01);
    }
}

#[test]
fn wrong_usage_is_refused() {
    let desk = Desk::new();
    let refused = |arguments: &[&str], code: i32, word: &str| {
        let output = desk.run(&[&["ball.ply", "-o", "out.ply"], arguments].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(word), "'{word}' is not in: {said}");
        assert!(!desk.0.path().join("out.ply").exists());
    };
    refused(&[], 2, "--ball");
    refused(&["--ball", "9,9,9,1"], 1, "marks no face");
    refused(&["--ball", "0,0,0,2"], 1, "a whole component");
    refused(&["--ball", "0,0,1,0.5", "--keep-shape", "2"], 2, "0 to 1");
    refused(&["--ball", "0,0,1,0.5", "--edge-ratio", "0"], 2, "0.05");
}
