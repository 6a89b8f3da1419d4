//! What a repair does before it cuts faces out: it moves the vertices of folds and noise, merges chains of collinear faces, and unites
//! sheets that are open inside a body.

use crate::repair_union::repaired;
use crate::shapes::{Noise, bits, cut, joined, moved, sheet, sphere, topology};
use glam::DVec3;
use isomend::check::{CheckParams, DefectKind};
use isomend::{Mesh, Repaired, inspect};

/// The number of faces that intersect others.
fn intersecting(mesh: &Mesh) -> usize {
    let verdict = inspect(mesh).unwrap().check(&CheckParams::default());
    verdict.count(DefectKind::SelfIntersection)
}

/// A sheet of 2 by 2 with cells of 0.05, pulled over itself round a point.
fn folded_sheet(at: DVec3) -> Mesh {
    let mut mesh = sheet(40);
    let mut random = Noise(5);
    for p in &mut mesh.positions {
        let near = (-(p.distance(at) / 0.15).powi(2)).exp();
        let wave = 0.05 * (4.0 * p.x).sin() * (3.0 * p.y).cos();
        *p += near * DVec3::new(0.3, 0.0, 0.05 * random.next()) + wave * DVec3::Z;
    }
    mesh
}

/// Checks that no face was removed or added, and that vertices farther than `reach` from `at` kept their bits.
fn assert_moved_near(mesh: &Mesh, done: &Repaired, at: DVec3, reach: f64) {
    assert_eq!(done.mesh.faces, mesh.faces);
    let (before, after) = (bits(&mesh.positions), bits(&done.mesh.positions));
    let moved: Vec<usize> = (0..before.len())
        .filter(|v| before[*v] != after[*v])
        .collect();
    assert_eq!(moved.len(), done.report.steps.relaxed_vertices);
    let by = |v: &usize| mesh.positions[*v].distance(done.mesh.positions[*v]);
    let largest = moved.iter().map(by).fold(0.0, f64::max);
    assert_eq!(largest, done.report.steps.largest_relaxation);
    assert!(
        moved
            .iter()
            .all(|v| mesh.positions[*v].distance(at) < reach)
    );
}

#[test]
fn a_fold_of_a_sheet_is_mended_by_moving_its_vertices() {
    for at in [DVec3::ZERO, DVec3::new(0.1, 0.87, 0.0)] {
        let mesh = folded_sheet(at);
        assert!(intersecting(&mesh) > 0);
        let done = repaired(&mesh);
        assert_eq!(intersecting(&done.mesh), 0);
        assert_eq!(done.report.lost_faces, 0);
        assert!(done.report.steps.intersection_passes.is_empty());
        assert_moved_near(&mesh, &done, at, 0.5);
        assert!(
            done.report.steps.largest_relaxation < 0.1,
            "{}",
            done.report.steps.largest_relaxation
        );
    }
}

#[test]
fn noise_of_a_closed_body_makes_no_handles() {
    let mut mesh = sphere(16);
    let edge = mesh.positions[mesh.faces[0][0] as usize]
        .distance(mesh.positions[mesh.faces[0][1] as usize]);
    let mut random = Noise(3);
    for p in &mut mesh.positions {
        *p += 1.1 * edge * random.vector();
    }
    let before = intersecting(&mesh);
    assert!(before > 500, "{before}");
    let done = repaired(&mesh);
    assert_eq!(done.mesh.faces, mesh.faces);
    assert_eq!(intersecting(&done.mesh), 0);
    assert_eq!(done.report.lost_faces, 0);
    assert!(done.report.steps.largest_relaxation < 2.0 * edge);
}

#[test]
fn noise_wider_than_the_cells_of_a_sheet_is_moved_and_its_border_stays_where_it_was() {
    for amount in [0.8, 1.2] {
        let mut mesh = sheet(30);
        let mut random = Noise(7);
        let cell = 2.0 / 30.0;
        for p in &mut mesh.positions {
            *p += amount * cell * random.vector();
        }
        assert!(intersecting(&mesh) > 50);
        let done = repaired(&mesh);
        assert_eq!(intersecting(&done.mesh), 0);
        assert_eq!(done.report.lost_faces, 0);
        // Border vertices may slide along the border, by one edge at most.
        let rim = inspect(&mesh).unwrap().holes[0].rim.clone();
        assert_eq!(rim.len(), 120);
        let at = |k: usize| mesh.positions[rim[k % rim.len()] as usize];
        for (k, v) in rim.iter().enumerate() {
            let p = done.mesh.positions[*v as usize];
            let off = |a: DVec3, b: DVec3| {
                let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                p.distance(a + along * (b - a))
            };
            let k = k + rim.len();
            assert!(off(at(k - 1), at(k)).min(off(at(k), at(k + 1))) < 1e-12);
        }
        assert!(done.report.doubt.is_none());
    }
}

#[test]
fn an_open_ball_with_strong_noise_keeps_its_faces() {
    let mut mesh = cut(&sphere(7), |p| p.z > 0.75);
    let mut random = Noise(11);
    for p in &mut mesh.positions {
        *p += 0.3 * random.vector();
    }
    let crossing = intersecting(&mesh);
    assert!(
        3 * crossing > mesh.faces.len(),
        "{crossing} of {}",
        mesh.faces.len()
    );
    let done = repaired(&mesh);
    assert_eq!(topology(&done.mesh).0, 0);
    assert_eq!(intersecting(&done.mesh), 0);
    assert!(done.report.doubt.is_none());
    assert!(20 * done.report.lost_faces < mesh.faces.len());
}

#[test]
fn sheets_that_pass_through_each_other_are_not_moved() {
    let mut mesh = sheet(20);
    let count = mesh.positions.len() as u32;
    let upright = mesh.positions.clone();
    mesh.positions.extend(
        upright
            .iter()
            .map(|p| DVec3::new(0.013 + p.z, 0.5 * p.y, 0.5 * p.x + 0.017)),
    );
    let faces = mesh.faces.clone();
    mesh.faces
        .extend(faces.iter().map(|f| f.map(|v| v + count)));
    assert!(intersecting(&mesh) > 0);
    assert_eq!(repaired(&mesh).report.steps.relaxed_vertices, 0);
}

/// A triangle below a line of `n` edges, triangles above it, and on the line faces without area that join the two.
fn collinear_chain(n: u32, faces: Vec<[u32; 3]>) -> Mesh {
    let mut mesh = Mesh::default();
    let line = (0..=n).map(|i| DVec3::new(f64::from(i * i), 0.0, 0.0));
    mesh.positions.extend(line);
    let (below, above) = (n + 1, n + 2);
    mesh.positions
        .extend([DVec3::new(3.0, -4.0, 0.0), DVec3::new(5.0, 6.0, 1.0)]);
    mesh.faces.push([below, n, 0]);
    mesh.faces.extend(faces);
    mesh.faces.extend((0..n).map(|i| [above, i, i + 1]));
    mesh
}

#[test]
fn chains_of_collinear_faces_are_merged_into_their_neighbours() {
    let n = 7;
    let fan: Vec<[u32; 3]> = (1..n).map(|i| [0, i + 1, i]).collect();
    // Alternately from both ends.
    let (mut low, mut high, mut zigzag) = (0, n, Vec::new());
    while low + 1 < high {
        zigzag.push([low, high, low + 1]);
        low += 1;
        if low + 1 < high {
            zigzag.push([low, high, high - 1]);
            high -= 1;
        }
    }
    for faces in [fan, zigzag] {
        let mesh = collinear_chain(n, faces);
        let area = |mesh: &Mesh| -> Vec<f64> {
            let corners = mesh
                .faces
                .iter()
                .map(|f| f.map(|v| mesh.positions[v as usize]));
            corners
                .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
                .collect()
        };
        let done = repaired(&mesh).mesh;
        assert_eq!(done.faces.len(), mesh.faces.len());
        assert!(area(&done).iter().all(|a| *a > 0.1), "{:?}", area(&done));
        let (before, after): (f64, f64) = (area(&mesh).iter().sum(), area(&done).iter().sum());
        assert!((before - after).abs() < 1e-9 * before);
        assert_eq!(intersecting(&done), 0);
    }
}

#[test]
fn an_open_sheet_whose_border_is_inside_a_body_is_united_with_it() {
    // A ball with a hole, and an eye: half of a smaller ball that shows through the ball and is open inside it.
    let ball = cut(&sphere(9), |p| p.y < -0.95);
    let half = cut(&sphere(6), |p| p.z < 0.0);
    let eye = moved(&half, 0.37, DVec3::new(0.013, 0.021, 0.78));
    let mesh = joined(&ball, &eye);
    assert!(intersecting(&mesh) > 0);
    let done = repaired(&mesh);
    assert_eq!(intersecting(&done.mesh), 0);
    assert_eq!(topology(&done.mesh), (0, 2));
    assert!(done.report.doubt.is_none() && done.report.steps.intersection_passes.is_empty());
    // The faces of the ball away from the eye are there.
    let far = |p: DVec3| p.z < 0.5;
    let count = |mesh: &Mesh| {
        let centre =
            |f: &[u32; 3]| f.iter().map(|v| mesh.positions[*v as usize]).sum::<DVec3>() / 3.0;
        mesh.faces.iter().filter(|f| far(centre(f))).count()
    };
    assert!(count(&done.mesh) >= count(&ball));
    // The eye shows.
    let top = done.mesh.positions.iter().map(|p| p.z).fold(0.0, f64::max);
    assert!((top - 1.15).abs() < 0.01, "{top}");
}
