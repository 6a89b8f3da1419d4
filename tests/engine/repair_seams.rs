//! Seams in a repair: boundaries that coincide up to rounding are welded, T-junctions are stitched, and `check` recommends a weld length.

use crate::repair_union::{repaired, single, verdict};
use crate::shapes::{Noise, cube, cut, joined, moved, sphere, turned, volume};
use glam::DVec3;
use isomend::check::{CheckParams, Verdict};
use isomend::{Carried, Control, Mesh, RepairParams, inspect, repair};

/// A mesh in which each triangle has its own vertices.
fn loose(triangles: impl IntoIterator<Item = [DVec3; 3]>) -> Mesh {
    let positions: Vec<DVec3> = triangles.into_iter().flatten().collect();
    let faces = (0..positions.len() as u32).step_by(3);
    let faces = faces.map(|first| [first, first + 1, first + 2]).collect();
    Mesh::new(positions, faces)
}

/// Each face with its own vertices, moved by `by` of the face's number.
fn torn(mesh: &Mesh, by: impl Fn(usize) -> DVec3) -> Mesh {
    let faces = mesh.faces.iter().enumerate();
    loose(faces.map(|(f, face)| face.map(|v| mesh.positions[v as usize] + by(f))))
}

/// A cube with one side divided twice as finely as the others.
fn with_t_junctions() -> Mesh {
    let coarse = cube(4);
    let top = |p: DVec3| p.x > 3.999;
    let is_top = |m: &Mesh, f: &[u32; 3]| f.iter().all(|v| top(m.positions[*v as usize]));
    let fine = moved(&cube(8), 0.5, DVec3::ZERO);
    let side = |m: &Mesh, wanted: bool| {
        let faces = m.faces.iter().filter(|f| is_top(m, f) == wanted);
        Mesh::new(m.positions.clone(), faces.copied().collect())
    };
    joined(&side(&coarse, false), &side(&fine, true))
}

#[test]
fn vertices_that_differ_by_rounding_are_welded_by_default() {
    let good = turned(sphere(4));
    let tiny = |f: usize| DVec3::splat(if f.is_multiple_of(2) { 0.0 } else { 3e-16 });
    let last_place = |f: usize| DVec3::splat(if f.is_multiple_of(2) { 0.0 } else { 1e-7 });
    let text = |m: Mesh| {
        let mut m = m;
        for p in &mut m.positions {
            *p = DVec3::from_array((*p * 1e5).to_array().map(|x| x.round() / 1e5));
        }
        m
    };
    let last_digit = |f: usize| DVec3::splat(if f.is_multiple_of(2) { 0.0 } else { 1e-5 });
    let all = [
        torn(&good, tiny),
        single(&torn(&single(&good), last_place)),
        text(torn(&text(good.clone()), last_digit)),
    ];
    for bad in all {
        let before = verdict(&bad);
        assert!(
            before.holes > 0 && before.weld_by_default,
            "{}",
            before.line()
        );
        let done = repaired(&bad);
        let after = verdict(&done.mesh);
        assert!(after.is_sound(), "{}", after.line());
        assert_eq!(after.components.len(), 1);
        assert_eq!(done.report.lost_faces, 0);
        assert!(done.report.steps.welded_vertices > 0);
        assert_eq!(done.mesh.faces.len(), bad.faces.len());
    }
}

#[test]
fn sheets_and_vertices_at_a_small_distance_are_not_welded() {
    let bowl = cut(&turned(sphere(4)), |p| p.z > 0.1);
    let pair = joined(&bowl, &moved(&bowl, 1.0, DVec3::Z * 1e-3));
    // Squares of side 1e-4 near 1: their vertices differ by one unit of the last decimal.
    let squares = moved(&cut(&cube(3), |p| p.x > 2.5), 1e-4, DVec3::ONE);
    for mesh in [pair, squares] {
        let done = repaired(&mesh);
        assert_eq!(done.report.steps.welded_vertices, 0);
        assert_eq!(done.report.steps.stitched_junctions, 0);
    }
}

#[test]
fn the_check_recommends_the_weld_length_that_closes_most_edges() {
    let ball = turned(sphere(6));
    let upper = cut(&ball, |p| p.z < 0.0);
    let lower = cut(&ball, |p| p.z > 0.0);
    // Both halves of the ball, each with its own vertices; the lower half is moved by 2e-4.
    assert!(upper.faces.len() + lower.faces.len() <= ball.faces.len());
    let rest = {
        let centre = |f: &[u32; 3]| f.map(|v| ball.positions[v as usize].z).iter().sum::<f64>();
        let faces = |above: bool| {
            let own = ball.faces.iter().filter(|f| (centre(f) > 0.0) == above);
            Mesh::new(ball.positions.clone(), own.copied().collect())
        };
        joined(&faces(true), &moved(&faces(false), 1.0, DVec3::X * 2e-4))
    };
    let torn = verdict(&rest);
    let (length, edges) = torn.weld.unwrap();
    assert!((2e-4..2.2e-4).contains(&length), "{length}");
    assert!(torn.weld_by_default && edges > 10);
    let mut params = RepairParams::default();
    params.weld = Some(length);
    let done = repair(&rest, &params, &Carried::default(), &Control::new()).unwrap();
    let after = verdict(&done.mesh);
    assert!(after.is_sound(), "{}", after.line());
    assert_eq!(done.report.lost_faces, 0);
    assert_eq!(after.components.len(), 1);
    // A mesh with ordinary holes gets no recommendation.
    assert_eq!(verdict(&upper).weld, None);
}

#[test]
fn t_junctions_are_counted_and_stitched_and_no_face_is_lost() {
    let exact = with_t_junctions();
    let oblique = moved(
        &turned(exact.clone()),
        1.0 / 3.0,
        DVec3::new(0.1, 7.3, -2.9),
    );
    let flipped = {
        let mut mesh = oblique.clone();
        mesh.faces.iter_mut().step_by(3).for_each(|f| f.swap(1, 2));
        mesh
    };
    for bad in [exact, oblique.clone(), single(&oblique), flipped] {
        let before = verdict(&bad);
        assert_eq!(before.t_junctions, 16);
        let line = before.line();
        assert!(
            line.contains("16 vertices lie on edges") && !line.contains("holes"),
            "{line}"
        );
        let done = repaired(&bad);
        let after = verdict(&done.mesh);
        assert!(after.is_sound(), "{}", after.line());
        let r = &done.report;
        assert_eq!((r.lost_faces, r.steps.stitched_junctions), (0, 16));
        // Sixteen edges are split, and nothing else is added.
        assert_eq!(done.mesh.faces.len(), bad.faces.len() + 16);
        let left = bad.positions.len() - r.steps.merged_vertices;
        assert_eq!(done.mesh.positions.len(), left);
        assert!(done.fill.regions.is_empty());
    }
}

#[test]
fn partly_overlapping_edges_and_several_vertices_on_one_edge_are_stitched() {
    // Three strips along two common lines: the middle one is shifted by half an edge, and the last one is four times as fine.
    let row = |y: f64, step: f64, from: f64| {
        let n = ((3.0 - from) / step).round() as u32;
        let mut mesh = Mesh::default();
        for i in 0..=n {
            let x = from + step * f64::from(i);
            mesh.positions
                .extend([DVec3::new(x, y, 0.0), DVec3::new(x, y + 1.0, 0.0)]);
        }
        for i in 0..n {
            let [a, b, c, d] = [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1];
            mesh.faces.extend([[a, b, c], [a, c, d]]);
        }
        mesh
    };
    let strips = joined(
        &joined(&row(0.0, 1.0, 0.0), &row(1.0, 1.0, -0.5)),
        &row(2.0, 0.25, 0.0),
    );
    let before = inspect(&strips).unwrap();
    let done = repaired(&strips);
    let after = inspect(&done.mesh).unwrap();
    let components = |v: &Verdict| v.components.len();
    let params = CheckParams::default();
    assert_eq!(components(&before.check(&params)), 3);
    let after = after.check(&params);
    assert_eq!((components(&after), after.t_junctions), (1, 0));
    assert_eq!(done.report.lost_faces, 0);
}

/// A heap of the triangles of a mesh, each corner moved by up to `by`. Some triangles are divided at a point of an edge, of which
/// some parts are slivers, and some are there twice, in either orientation.
fn heap(mesh: &Mesh, by: f64, noise: &mut Noise) -> Mesh {
    let mut faces: Vec<[DVec3; 3]> = Vec::new();
    for (f, face) in mesh.faces.iter().enumerate() {
        let [a, b, c] = face.map(|v| mesh.positions[v as usize]);
        if f % 60 == 7 {
            let p = a.lerp(b, if f % 180 == 7 { 0.002 } else { 0.4 });
            faces.extend([[a, p, c], [p, b, c]]);
        } else {
            faces.push([a, b, c]);
        }
        match f % 80 {
            11 => faces.push([a, b, c]),
            51 => faces.push([a, c, b]),
            _ => {}
        }
    }
    let mut moved = |p| p + by * noise.vector();
    single(&loose(faces.into_iter().map(|f| f.map(&mut moved))))
}

#[test]
fn heaps_of_triangles_with_corners_apart_are_welded() {
    let bodies = [turned(cube(12)), turned(sphere(12))];
    for (k, body) in bodies.iter().enumerate() {
        for by in [1e-6, 1e-5, 1e-4] {
            let size = body
                .positions
                .iter()
                .map(|p| p.length())
                .fold(0.0, f64::max);
            let heap = heap(body, by * size, &mut Noise(3 + k as u64));
            assert_eq!(verdict(&heap).holes, heap.faces.len());
            assert!(verdict(&heap).weld_by_default);
            let done = repaired(&heap);
            let after = verdict(&done.mesh);
            assert!(after.is_sound(), "{k}, {by}: {}", after.line());
            assert_eq!(after.components.len(), 1, "{k}, {by}");
            let (made, truth) = (volume(&done.mesh), volume(body));
            assert!(
                (made / truth - 1.0).abs() < 10.0 * by,
                "{k}, {by}: {made}, {truth}"
            );
        }
    }
}

#[test]
fn flakes_on_a_surface_do_not_become_bodies() {
    for body in [turned(cube(4)), turned(sphere(5))].map(|m| single(&m)) {
        let [a, b, _] = body.faces[40].map(|v| body.positions[v as usize]);
        let flake = Mesh::new(vec![a, 0.5 * (a + b), b], vec![[0, 1, 2]]);
        let mut open = body.clone();
        open.faces.pop();
        let done = repaired(&single(&joined(&open, &flake)));
        let after = verdict(&done.mesh);
        assert!(after.is_sound(), "{}", after.line());
        assert_eq!(after.components.len(), 1);
        assert_eq!(done.report.steps.duplicate_faces, 1);
    }
}

#[test]
fn a_flake_across_a_hole_is_no_sheet() {
    let body = single(&turned(cube(4)));
    let [a, b, c] = body.faces[40];
    let shares = |f: &[u32; 3]| [a, b].iter().all(|v| f.contains(v)) && !f.contains(&c);
    let mut open = body.clone();
    open.faces.retain(|f| *f != [a, b, c] && !shares(f));
    assert_eq!(open.faces.len() + 2, body.faces.len());
    let [a, b] = [a, b].map(|v| body.positions[v as usize]);
    let flake = Mesh::new(vec![a, 0.5 * (a + b), b], vec![[0, 1, 2]]);
    let done = repaired(&single(&joined(&open, &flake)));
    let after = verdict(&done.mesh);
    assert!(after.is_sound(), "{}", after.line());
    assert_eq!(done.mesh.faces.len(), body.faces.len());
}
