//! `isomend repair` keeps parts of bodies that are inside out, and cavities.

use crate::repair_union::{repaired, verdict};
use crate::shapes::{cube, cut, joined, moved, sphere, volume};
use glam::DVec3;
use isomend::{Carried, Control, Mesh, RepairParams, repair};

#[test]
fn a_cavity_that_shares_an_edge_with_something_stays() {
    let outer = cube(4);
    let mut cavity = moved(&cube(1), 1.0, DVec3::ONE);
    cavity.faces.iter_mut().for_each(|f| f.swap(1, 2));
    let mut mesh = joined(&outer, &cavity);
    // Two faces on each other, beside an edge of the cavity.
    let [a, b, _] = mesh.faces[outer.faces.len()];
    let middle = 0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]);
    let c = mesh.positions.len() as u32;
    mesh.positions
        .push(middle + 0.2 * (middle - DVec3::splat(1.5)));
    mesh.faces.extend([[a, b, c], [b, a, c]]);
    let repaired = repaired(&mesh);
    assert!(verdict(&repaired.mesh).is_sound());
    assert!((volume(&repaired.mesh) - 63.0).abs() < 1e-9);
    assert_eq!(repaired.report.doubt, None);
}

#[test]
fn a_body_that_is_partly_inside_out_keeps_its_parts() {
    // A bar whose two sides pass through each other between its ends.
    let (steps, crossing) = (4, 1.8);
    let mut mesh = Mesh::default();
    for i in 0..=steps {
        let x = 3.0 * f64::from(i) / f64::from(steps);
        let half = 1.0 - x / crossing;
        let section = [(-half, -1.0), (half, -1.0), (half, 1.0), (-half, 1.0)];
        let points = section.map(|(y, z)| DVec3::new(x, y, z));
        mesh.positions.extend(points);
    }
    for i in 0..steps {
        for k in 0..4 {
            let [a, b] = [k, (k + 1) % 4].map(|k| (4 * i + k) as u32);
            mesh.faces.extend([[a, b + 4, b], [a, a + 4, b + 4]]);
        }
    }
    let end = 4 * steps as u32;
    mesh.faces.extend([
        [0, 1, 2],
        [0, 2, 3],
        [end, end + 2, end + 1],
        [end, end + 3, end + 2],
    ]);
    let repaired = repaired(&mesh);
    assert!(verdict(&repaired.mesh).is_sound());
    // Two wedges.
    let wedges = 2.0 * (crossing + (3.0 - crossing).powi(2) / crossing);
    assert!(
        (volume(&repaired.mesh) - wedges).abs() < 1e-3,
        "{}",
        volume(&repaired.mesh)
    );
    assert_eq!(repaired.report.doubt, None);
}

#[test]
fn a_sheet_of_two_equal_sides_stays() {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let positions = corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
    let mesh = Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]]);
    let repaired = repaired(&mesh);
    assert!(!repaired.mesh.faces.is_empty());
    assert!(!verdict(&repaired.mesh).is_sound());
}

#[test]
fn only_faces_of_the_input_count_as_reversed() {
    // A bowl shows its inside; its outside is known once its mouth is closed.
    let mut bowl = cut(&sphere(8), |p| p.z > -0.2);
    bowl.faces.iter_mut().for_each(|f| f.swap(1, 2));
    let mut params = RepairParams::default();
    params.borders = true;
    let done = repair(&bowl, &params, &Carried::default(), &Control::new()).unwrap();
    assert!(done.mesh.faces.len() > bowl.faces.len() && volume(&done.mesh) > 0.0);
    assert_eq!(done.report.steps.reoriented_faces, bowl.faces.len());
}

#[test]
fn skins_that_are_inside_out_are_reversed_together_with_holes_in_either() {
    let (skin, core) = (
        sphere(8),
        moved(&sphere(8), 0.5, DVec3::new(0.1, 0.0, -0.1)),
    );
    let inner = cut(&core, |p| p.z < -0.55);
    for outer in [
        cut(&skin, |p| p.z > 0.9),
        cut(&skin, |p| p.x > 0.95),
        skin.clone(),
    ] {
        let mut body = outer.clone();
        body.faces.iter_mut().for_each(|f| f.swap(1, 2));
        let done = repaired(&joined(&body, &inner));
        assert!(verdict(&done.mesh).is_sound());
        let wanted = volume(&skin) - volume(&core);
        assert!(
            (volume(&done.mesh) / wanted - 1.0).abs() < 0.02,
            "{}",
            volume(&done.mesh)
        );
    }
}
