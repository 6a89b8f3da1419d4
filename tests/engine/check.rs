//! `isomend check`: one verdict, and every defect with its count and place.

use crate::desk::{Desk, assert_code, text};
use crate::repair_union::verdict;
use crate::shapes::{Noise, cut, joined, moved, polar, sphere, torus, turned};
use glam::DVec3;
use isomend::check::{CheckParams, DefectKind};
use isomend::io::Format;
use isomend::{Mesh, inspect};

/// The defects of a mesh by kind, with their counts.
fn counts(mesh: &Mesh) -> Vec<(DefectKind, usize)> {
    let verdict = verdict(mesh);
    verdict.defects.iter().map(|d| (d.kind, d.count)).collect()
}

fn flipped(mesh: &Mesh) -> Mesh {
    let faces = mesh.faces.iter().map(|f| [f[0], f[2], f[1]]);
    Mesh::new(mesh.positions.clone(), faces.collect())
}

#[test]
fn good_meshes_have_no_defect() {
    let ball = turned(sphere(6));
    let cavity = joined(&ball, &flipped(&moved(&ball, 0.5, DVec3::ZERO)));
    let two = joined(&ball, &moved(&ball, 1.0, 3.0 * DVec3::X));
    for mesh in [ball, cavity, two, turned(torus(24, 12))] {
        assert_eq!(counts(&mesh), []);
        assert!(verdict(&mesh).line().ends_with("yes"));
    }
}

/// Seen from the cavity the opening covers up to a third of all directions.
#[test]
fn a_cavity_of_a_half_ball_is_not_inside_out() {
    let half = cut(&sphere(12), |p| p.z > 0.01);
    let with_ball_at = |z: f64| {
        let ball = moved(&flipped(&sphere(4)), 0.12, DVec3::new(0.1, -0.1, z));
        counts(&joined(&half, &ball))
    };
    let is_inside_out = |z| with_ball_at(z).contains(&(DefectKind::InsideOut, 1));
    assert!(!is_inside_out(-0.5));
    assert!(!is_inside_out(-0.3));
    // Ones that look out of the opening, or are outside.
    assert!(is_inside_out(0.0));
    assert!(is_inside_out(0.3));
    assert!(is_inside_out(-1.5));
}

#[test]
fn each_defect_is_reported_with_its_count_and_place() {
    let ball = turned(sphere(6));
    let top = |p: DVec3| polar(p) < 30.0;
    let open = cut(&ball, top);
    let found = verdict(&open);
    assert_eq!((found.holes, found.is_watertight()), (1, false));
    assert_eq!(found.defects[0].kind, DefectKind::BoundaryEdge);
    assert!(polar(found.defects[0].places[0]) < 10.0);

    let mut one_turned = ball.clone();
    one_turned.faces[7].swap(1, 2);
    assert_eq!(counts(&one_turned), [(DefectKind::Misoriented, 3)]);
    assert_eq!(counts(&flipped(&ball)), [(DefectKind::InsideOut, 1)]);

    let mut twice = ball.clone();
    twice.faces.push(ball.faces[5]);
    let found = counts(&twice);
    assert!(found.contains(&(DefectKind::Duplicate, 1)));
    assert!(found.contains(&(DefectKind::NonManifoldEdge, 3)));

    let mut degenerate = ball.clone();
    let [a, b, _] = ball.faces[5];
    degenerate.faces.push([a, b, a]);
    assert_eq!(counts(&degenerate), [(DefectKind::Degenerate, 1)]);

    let crossing = joined(&ball, &moved(&ball, 0.3, DVec3::new(0.95, 0.1, 0.05)));
    let found = verdict(&crossing);
    assert_eq!(found.defects.len(), 1);
    let crossing = &found.defects[0];
    assert_eq!(crossing.kind, DefectKind::SelfIntersection);
    assert!(crossing.places[0].distance(DVec3::X) < 0.3);
    assert!(
        found
            .marks()
            .values()
            .all(|k| *k == DefectKind::SelfIntersection)
    );
}

#[test]
fn surfaces_that_touch_in_a_vertex_are_reported() {
    // Two tetrahedra with a common vertex.
    let p = DVec3::new;
    let mesh = Mesh::new(
        vec![
            p(0.0, 0.0, 0.0),
            p(1.0, 0.0, 0.0),
            p(0.0, 1.0, 0.0),
            p(0.0, 0.0, 1.0),
            p(-1.0, 0.0, 0.0),
            p(0.0, -1.0, 0.0),
            p(0.0, 0.0, -1.0),
        ],
        vec![
            [0, 2, 1],
            [0, 1, 3],
            [0, 3, 2],
            [1, 2, 3],
            [0, 4, 5],
            [0, 6, 4],
            [0, 5, 6],
            [4, 6, 5],
        ],
    );
    assert_eq!(counts(&mesh), [(DefectKind::NonManifoldVertex, 1)]);
    assert!(verdict(&mesh).is_watertight());
}

#[test]
fn components_are_measured_and_nested() {
    let ball = turned(sphere(6));
    let inner = moved(&ball, 0.2, DVec3::new(0.1, 0.0, 0.0));
    let mesh = joined(&joined(&ball, &inner), &moved(&ball, 0.01, 2.0 * DVec3::X));
    let found = verdict(&mesh);
    let [outer, inside, debris] = &found.components[..] else {
        panic!("{:?}", found.components)
    };
    assert!((outer.volume / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 0.05);
    assert_eq!((inside.inside, inside.depth, outer.depth), (Some(0), 1, 0));
    assert_eq!([outer.debris, debris.debris], [false, true]);
    assert_eq!((found.debris(), found.inside()), (1, 1));
}

#[test]
fn parts_thinner_than_the_given_length_are_reported() {
    // A flattened ball, at most 0.1 thick.
    let slab = moved(&sphere(12), 1.0, DVec3::ZERO);
    let slab = Mesh::new(
        slab.positions
            .iter()
            .map(|p| DVec3::new(p.x, p.y, 0.05 * p.z.signum() * p.z.abs().sqrt()))
            .collect(),
        slab.faces,
    );
    let thin = |length: f64| {
        let mut params = CheckParams::default();
        params.thin = Some(length);
        inspect(&slab)
            .unwrap()
            .check(&params)
            .count(DefectKind::Thin)
    };
    assert_eq!(thin(0.02), 0);
    assert!(thin(0.11) > slab.faces.len() / 2, "{}", thin(0.11));
}

#[test]
fn the_command_says_yes_or_no_first_and_by_its_exit_code() {
    let desk = Desk::new();
    desk.save("whole.ply", &sphere(6), Format::Ply);
    let done = desk.run(&["check", "whole.ply"]);
    assert_code(&done, 0);
    assert!(text(&done.stdout).starts_with("watertight and printable: yes\n"));
    let done = desk.run(&["check", "ball.ply", "--json", "-"]);
    assert_code(&done, 3);
    let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(document["command"], "check");
    assert_eq!(document["sound"], false);
    assert_eq!(document["holes"], 2);
    assert_eq!(document["defects"][0]["kind"], "boundary_edge");
    let done = desk.run(&["check", "ball.ply", "-q"]);
    assert_code(&done, 3);
    assert!(done.stdout.is_empty());
}

#[test]
fn the_picture_and_the_page_mark_the_places() {
    let desk = Desk::new();
    let ball = sphere(6);
    let pierced = joined(&ball, &moved(&ball, 0.3, DVec3::new(0.95, 0.1, 0.05)));
    desk.save("pierced.ply", &pierced, Format::Ply);
    let done = desk.run(&[
        "check",
        "pierced.ply",
        "--picture",
        "p.png",
        "--report",
        "p.html",
        "-q",
    ]);
    assert_code(&done, 3);
    let decoder = png::Decoder::new(std::io::Cursor::new(
        std::fs::read(desk.path("p.png")).unwrap(),
    ));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    let red = |p: &&[u8]| p[0] > 100 && i32::from(p[0]) > 2 * i32::from(p[1]) && p[1] < 80;
    let marked = pixels.chunks(3).filter(red).count();
    assert!(marked > 2000, "{marked}");
    let page = std::fs::read_to_string(desk.path("p.html")).unwrap();
    assert!(page.contains("faces intersect others") && page.contains("class=\"swatch\""));
}

#[test]
fn invalid_coordinates_and_lengths_are_refused() {
    let desk = Desk::new();
    desk.text("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n");
    let done = desk.run(&["check", "nan.obj"]);
    assert_code(&done, 1);
    let done = desk.run(&["check", "ball.ply", "--thin", "-1"]);
    assert_code(&done, 2);
}

#[test]
fn coincident_faces_are_checked_in_time() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]; 60_000]);
    let begun = std::time::Instant::now();
    assert!(!verdict(&mesh).is_sound());
    // Comparing each face with every other face took a minute.
    assert!(begun.elapsed().as_secs() < 20);
}

/// Measured: 21 times the time for eight times the triangles, because more boundary edges are near each edge. Quadratic growth would be 64
/// times; it was measured when each end of an edge was compared with all boundary vertices within a tenth of the edge.
#[test]
#[cfg(target_os = "linux")]
fn the_check_of_long_random_triangles_takes_less_than_quadratic_time() {
    use crate::cpu::{cpu, this_thread};
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.unwrap();
    let own = pool.install(this_thread);
    let time = |count: u32| {
        let mut noise = Noise(3);
        let corners = (0..3 * count).map(|_| 0.5 + 0.5 * noise.vector());
        let faces = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]);
        let soup = Mesh::new(corners.collect(), faces.collect());
        let begun = cpu(&own);
        pool.install(|| drop(verdict(&soup)));
        cpu(&own) - begun
    };
    let [few, many] = [2500, 20_000].map(time);
    assert!(many < 40.0 * few, "{few} s, {many} s");
}
