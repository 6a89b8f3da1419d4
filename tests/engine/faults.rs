//! Inputs on which a fill was once slow, endless or wrongly reported: each must end in time with a correct report.

use std::time::{Duration, Instant};

use crate::desk::{Desk, ball, bytes};
use crate::shapes::{cut, polar, sphere};
use glam::DVec3;
use isomend::ChainReason;
use isomend::io::Format;
use isomend::{FillParams, HoleOutcome, Mesh, fill, inspect};

/// Upper bound of the run time: far more than these fills take, and far less than they once took.
const SOON: Duration = Duration::from_secs(20);

fn soup(count: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let mut state = 1u64;
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 33) as f64 / f64::from(u32::MAX)
    };
    for i in 0..count {
        let corner = DVec3::new(random(), random(), random());
        let mut near = || corner + 0.2 * DVec3::new(random(), random(), random());
        mesh.positions.extend([near(), near(), near()]);
        mesh.faces.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

#[test]
fn loose_triangles_are_distinguished_from_holes_in_time() {
    let begun = Instant::now();
    let filled = fill(&soup(20_000), &FillParams::default()).unwrap();
    assert!(begun.elapsed() < SOON, "{:?}", begun.elapsed());
    let left = |o: &HoleOutcome| matches!(o, HoleOutcome::Left(_));
    assert!(filled.report.holes.iter().all(|h| left(&h.outcome)));
}

#[test]
fn coincident_faces_are_handled_in_time() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let mut mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]; 60_000]);
    let begun = Instant::now();
    let filled = fill(&mesh, &FillParams::default()).unwrap();
    assert_eq!(filled.mesh, mesh);
    // With a hole in the mesh, a hierarchy is built.
    let base = mesh.positions.len() as u32;
    let holed = cut(&sphere(8), |p| polar(p) < 35.0);
    mesh.positions
        .extend(holed.positions.iter().map(|p| *p + 9.0 * DVec3::X));
    mesh.faces
        .extend(holed.faces.iter().map(|f| f.map(|v| v + base)));
    let filled = fill(&mesh, &FillParams::default()).unwrap();
    assert!(begun.elapsed() < SOON, "{:?}", begun.elapsed());
    assert_eq!(filled.report.tally().closed, 1);
}

#[test]
fn an_inside_out_mesh_gets_the_mirror_image_of_the_fill() {
    let mesh = cut(&sphere(12), |p| polar(p) < 40.0);
    let turned = Mesh::new(
        mesh.positions.clone(),
        mesh.faces.iter().map(|&[a, b, c]| [a, c, b]).collect(),
    );
    let [right, inverse] = [&mesh, &turned].map(|m| fill(m, &FillParams::default()).unwrap());
    let seam = |f: &isomend::Filled| f.report.regions[0].seam_angle_mean.unwrap();
    assert_eq!(inverse.report.tally().closed, 1);
    assert!((seam(&right) - seam(&inverse)).abs() < 0.05 * seam(&right));
    for new in &inverse.mesh.positions[mesh.positions.len()..] {
        assert!((new.length() - 1.0).abs() < 0.01, "{new}");
    }
    // The patch has the orientation of its surroundings.
    let volume = |m: &Mesh| -> f64 {
        let six = |f: &[u32; 3]| {
            let [a, b, c] = f.map(|v| m.positions[v as usize]);
            a.dot(b.cross(c))
        };
        m.faces.iter().map(six).sum::<f64>() / 6.0
    };
    let sum = volume(&right.mesh) + volume(&inverse.mesh);
    assert!(sum.abs() < 1e-3 * volume(&right.mesh), "{sum}");
}

#[test]
fn files_with_shifted_bytes_are_filled_in_time() {
    // Floats read from shifted bytes give spikes of any length.
    let stl = bytes(&ball(), Format::Stl);
    for place in [384, 391, 400, 413, 434, 521, 1034, 2222] {
        let mut shifted = stl.clone();
        shifted.remove(place);
        let nothing = &isomend::io::no_side_files;
        let Ok(loaded) = isomend::io::read_bytes(&shifted, Format::Stl, nothing) else {
            continue;
        };
        let begun = Instant::now();
        if let Ok(filled) = fill(&loaded.mesh, &FillParams::default()) {
            let faces = loaded.mesh.faces.len();
            assert_eq!(filled.mesh.faces[..faces], loaded.mesh.faces);
        }
        assert!(begun.elapsed() < SOON, "{place}: {:?}", begun.elapsed());
    }
}

/// A Möbius band of `n` squares.
fn moebius(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..n {
        let turn = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let (sin, cos) = turn.sin_cos();
        let across = |t: f64| {
            let (up, out) = (0.5 * turn).sin_cos();
            let radius = 1.0 + t * out;
            DVec3::new(radius * cos, radius * sin, t * up)
        };
        mesh.positions.extend([across(-0.3), across(0.3)]);
        let (a, b) = (2 * i, 2 * i + 1);
        let (c, d) = if i + 1 < n { (a + 2, b + 2) } else { (1, 0) };
        mesh.faces.extend([[a, c, b], [b, c, d]]);
    }
    mesh
}

#[test]
fn boundary_chains_of_a_one_sided_surface_do_not_close() {
    let band = moebius(40);
    let found = inspect(&band).unwrap();
    assert!(!found.open_chains.is_empty());
    let edges: usize = found.open_chains.iter().map(|c| c.edges).sum();
    let closed: usize = found.holes.iter().map(|h| h.edges).sum();
    assert_eq!(edges + closed, 80);
    assert!(
        found
            .open_chains
            .iter()
            .all(|c| c.reason == ChainReason::OneSided)
    );
    let desk = Desk::new();
    desk.save("band.ply", &band, Format::Ply);
    let done = desk.run(&["fill", "band.ply", "-o", "out.ply", "--json", "out.json"]);
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(3), "{said}");
    assert!(said.contains("one-sided"), "{said}");
    let document = desk.json("out.json");
    assert_eq!(document["complete"], false);
    assert_eq!(document["open_chains"][0]["reason"], "one_sided");
}

#[test]
fn a_duplicate_face_is_reported_as_the_reason_of_an_open_chain() {
    let mut mesh = cut(&sphere(6), |p| polar(p) < 50.0);
    let rim = inspect(&mesh).unwrap().holes[0].rim.clone();
    let edge = [rim[0], rim[1]];
    let twice = mesh
        .faces
        .iter()
        .find(|f| edge.iter().all(|v| f.contains(v)));
    let twice = *twice.unwrap();
    mesh.faces.push(twice);
    let found = inspect(&mesh).unwrap();
    assert!(
        found
            .open_chains
            .iter()
            .any(|c| c.reason == ChainReason::NonManifold),
        "{:?} {:?}",
        found.open_chains,
        found.holes
    );
}

#[test]
fn meshes_too_large_or_too_small_to_measure_are_refused() {
    for (scale, words) in [
        (1e80, "too large to measure"),
        (1e-168, "too small to measure"),
    ] {
        let mut mesh = cut(&sphere(6), |p| polar(p) < 50.0);
        mesh.positions.iter_mut().for_each(|p| *p *= scale);
        let error = inspect(&mesh).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn small_rims_far_apart_share_a_lattice_that_fits() {
    // Two small spheres far apart, each with a hole; a bridge joins the holes.
    let small = cut(&sphere(6), |p| polar(p) < 40.0);
    let mut mesh = Mesh::default();
    for away in [0.0, 1e9] {
        let base = mesh.positions.len() as u32;
        let there = small.positions.iter().map(|p| *p + away * DVec3::Z);
        mesh.positions.extend(there);
        mesh.faces
            .extend(small.faces.iter().map(|f| f.map(|v| v + base)));
    }
    let params = FillParams::new().with_bridges([[1, 2]]);
    let plan = inspect(&mesh).unwrap().plan(&params).unwrap();
    let dims = plan.regions[0].dims.unwrap();
    let nodes: f64 = dims.iter().map(|&n| n as f64).product();
    assert!(nodes > 0.0 && nodes < 3e10, "{dims:?}");
}
