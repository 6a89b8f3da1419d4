//! Tests of wall thickness on bodies of known thickness.

use glam::DVec3;

use crate::check::{CheckParams, DefectKind, Verdict, WallMap};
use crate::mend::Inspection;
use crate::mesh::Mesh;
use crate::mesh::shapes::{cube, grid, icosphere};

fn verdict(mesh: &Mesh, min_wall: Option<f64>) -> Verdict {
    let params = CheckParams {
        min_wall,
        ..CheckParams::default()
    };
    Inspection::new(mesh).unwrap().check(&params)
}

/// The least and the mean wall.
fn walls(mesh: &Mesh) -> [Option<f64>; 2] {
    let component = verdict(mesh, None).components[0];
    [component.least_wall, component.mean_wall]
}

/// The mesh with each face divided into four, `times` times.
fn divided(mesh: &Mesh, times: usize) -> Mesh {
    let mut mesh = mesh.clone();
    for _ in 0..times {
        let mut next = Mesh::new(mesh.positions.clone(), Vec::new());
        let mut middles = std::collections::HashMap::new();
        for face in &mesh.faces {
            let middle = [0, 1, 2].map(|k| {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let [p, q] = [a, b].map(|v| mesh.positions[v as usize]);
                    next.positions.push(0.5 * (p + q));
                    next.positions.len() as u32 - 1
                })
            });
            let [a, b, c] = *face;
            let [m, n, o] = middle;
            next.faces
                .extend([[a, m, o], [m, b, n], [o, n, c], [m, n, o]]);
        }
        mesh = next;
    }
    mesh
}

/// A box of these sides.
fn cuboid(sides: DVec3) -> Mesh {
    let mut mesh = cube();
    let (low, high) = crate::mesh::bounds(mesh.positions.iter().copied());
    mesh.positions
        .iter_mut()
        .for_each(|p| *p = (*p - low) / (high - low) * sides);
    mesh
}

/// A prism of length 3. Its cross-section is a triangle with two sides of length 1 and this angle between them.
fn wedge(degrees: f64) -> Mesh {
    let half = 0.5 * degrees.to_radians();
    let at = |y: f64| {
        [
            DVec3::new(0.0, y, 0.0),
            DVec3::new(half.cos(), y, -half.sin()),
            DVec3::new(half.cos(), y, half.sin()),
        ]
    };
    let positions = [at(0.0), at(3.0)].concat();
    let mut faces = vec![[0, 1, 2], [3, 5, 4]];
    for [a, b] in [[0, 1], [1, 2], [2, 0]] {
        faces.extend([[b, a, a + 3], [b, a + 3, b + 3]]);
    }
    Mesh::new(positions, faces)
}

#[test]
fn walls_of_boxes_are_as_thick_as_they_are() {
    for (sides, least) in [
        (DVec3::ONE, 1.0),
        (DVec3::new(1.0, 1.0, 0.1), 0.1),
        (DVec3::new(4.0, 0.2, 0.2), 0.2),
    ] {
        for times in 0..4 {
            let [found, mean] = walls(&divided(&cuboid(sides), times));
            assert!((found.unwrap() - least).abs() < 1e-12, "{sides}: {found:?}");
            assert!(mean.unwrap() >= least && mean.unwrap() < 4.0);
        }
    }
}

#[test]
fn a_sharp_edge_is_no_thin_wall() {
    for times in 0..5 {
        let mesh = divided(&wedge(20.0), times);
        let [least, _] = walls(&mesh);
        // The end faces are 3 apart, which is the only wall.
        assert!(least.is_none_or(|l| l > 2.9), "{times}: {least:?}");
        assert!(verdict(&mesh, Some(0.1)).is_sound());
    }
}

#[test]
fn the_tip_of_a_cone_is_no_thin_wall() {
    let tip = 0.4;
    let mut mesh = grid(60, 40, [true, false], |u, v| {
        let (a, r) = (std::f64::consts::TAU * u, tip * v);
        DVec3::new(r * a.cos(), r * a.sin(), -v)
    });
    // The surface has a degenerate ring at the tip and an open base, which a fan closes.
    let base: Vec<u32> = (0..mesh.positions.len() as u32)
        .filter(|v| mesh.positions[*v as usize].z < -1.0 + 1e-9)
        .collect();
    let middle = mesh.positions.len() as u32;
    mesh.positions.push(DVec3::new(0.0, 0.0, -1.0));
    let edges: Vec<[u32; 2]> = mesh
        .faces
        .iter()
        .flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]])
        .filter(|e| e.iter().all(|v| base.contains(v)))
        .collect();
    mesh.faces
        .extend(edges.iter().map(|[a, b]| [*b, *a, middle]));
    let found = verdict(&mesh, Some(0.02));
    assert!(found.components[0].closed, "{}", found.line());
    assert_eq!(found.count(DefectKind::ThinWall), 0, "{}", found.line());
}

#[test]
fn a_ball_is_as_thick_as_it_is_wide_and_a_hollow_one_as_its_wall() {
    let ball = icosphere(4);
    let [least, mean] = walls(&ball).map(Option::unwrap);
    assert!((least - 2.0).abs() < 0.02 && (mean - 2.0).abs() < 0.02);
    let mut hollow = ball.clone();
    let first = ball.positions.len() as u32;
    hollow
        .positions
        .extend(ball.positions.iter().map(|p| 0.9 * *p));
    hollow.faces.extend(
        ball.faces
            .iter()
            .map(|[a, b, c]| [a + first, c + first, b + first]),
    );
    let found = verdict(&hollow, None);
    for component in &found.components {
        let least = component.least_wall.unwrap();
        assert!((least - 0.1).abs() < 0.01, "{least}");
    }
}

#[test]
fn thin_walls_are_a_no_where_a_limit_is_given_and_only_then() {
    let plate = divided(&cuboid(DVec3::new(1.0, 1.0, 0.1)), 3);
    assert!(verdict(&plate, None).is_sound());
    assert!(verdict(&plate, Some(0.099)).is_sound());
    let no = verdict(&plate, Some(0.2));
    assert!(no.count(DefectKind::ThinWall) > 100);
    let line = no.line();
    assert!(
        line.contains("thinner than 0.2") && line.contains("component 1: 0.1"),
        "{line}"
    );
}

#[test]
fn a_map_has_the_walls_of_the_check_and_negative_values_at_wedges() {
    let plate = divided(&cuboid(DVec3::new(1.0, 1.0, 0.1)), 2);
    let values = WallMap::new(&plate).thickness(0..plate.faces.len() as u32);
    let thin = values.iter().filter(|t| (*t - 0.1).abs() < 1e-6).count();
    let found = verdict(&plate, Some(0.2));
    let marked = found
        .defects
        .iter()
        .find(|d| d.kind == DefectKind::ThinWall);
    assert_eq!(thin, marked.unwrap().count);
    assert!(values.iter().all(|t| *t > 0.09), "{values:?}");
    let wedge = divided(&wedge(20.0), 2);
    let map = WallMap::new(&wedge);
    let values = map.thickness(0..wedge.faces.len() as u32);
    assert!(
        values.iter().any(|t| *t < 0.0)
            && values.iter().all(|t| *t < 0.0 || *t > 2.9 || t.is_nan())
    );
    assert_eq!(map.thickness(5..7)[0].to_bits(), values[5].to_bits());
    // A sheet has no other side.
    let sheet = Mesh::new(plate.positions.clone(), plate.faces[..1].to_vec());
    assert!(WallMap::new(&sheet).thickness(0..1)[0].is_nan());
}
