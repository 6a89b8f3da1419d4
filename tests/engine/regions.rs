//! A patch depends on the surroundings of its hole only: not on distant parts, position, scale or orientation of the faces.

use glam::{DMat3, DVec3};
use isomend::{
    Closure, Control, FillParams, Filled, Finish, HoleId, Inspection, Mesh, RestoreParams, fill,
    inspect,
};

use crate::shapes::{cut, polar, sphere, topology};

/// Without and with the finish of the patch.
const FINISHES: [Finish; 2] = [Finish::None, Finish::Auto];

/// A bumpy ball without symmetries.
fn bumpy(n: u32) -> Mesh {
    let mut mesh = sphere(n);
    for p in &mut mesh.positions {
        *p *= 1.0 + 0.05 * (3.0 * p.x + 1.0).sin() * (4.0 * p.y).cos() * (2.0 * p.z + 0.5).sin();
    }
    mesh
}

/// The number of the hole whose centre is nearest to a direction.
fn hole_towards(mesh: &Mesh, direction: DVec3) -> HoleId {
    let holes = inspect(mesh).unwrap().holes;
    let along = |c: DVec3| c.normalize_or_zero().dot(direction);
    let nearest = holes
        .iter()
        .max_by(|a, b| along(a.centre).total_cmp(&along(b.centre)));
    nearest.expect("a hole").id
}

/// Fills the hole at the top; returns the patch's vertices and the result.
fn filled_at_top(mesh: &Mesh, finish: Finish) -> (Vec<DVec3>, Filled) {
    let mut params = FillParams::default();
    params.finish = finish;
    params.holes = Some(vec![hole_towards(mesh, DVec3::Z)]);
    let filled = fill(mesh, &params).unwrap();
    let regions = &filled.report.regions;
    assert!(regions.len() == 1 && regions[0].converged);
    assert_eq!(regions[0].intersecting_faces, 0);
    let patch = filled.mesh.positions[mesh.positions.len()..].to_vec();
    assert!(patch.len() > 20);
    (patch, filled)
}

/// The largest distance from points to a mesh.
fn apart(points: &[DVec3], other: &Mesh) -> f64 {
    let to_face = |p: DVec3, f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| other.positions[v as usize]);
        distance_to_triangle(p, a, b, c)
    };
    let nearest = |p: &DVec3| {
        let distances = other.faces.iter().map(|f| to_face(*p, f));
        distances.fold(f64::INFINITY, f64::min)
    };
    points.iter().map(nearest).fold(0.0, f64::max)
}

/// The distance of a point to a triangle: to its plane if the foot is inside, else to its sides.
fn distance_to_triangle(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside = |u: DVec3, v: DVec3| normal.dot((v - u).cross(p - u)) >= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) {
        return normal.dot(p - a).abs() / normal.length();
    }
    let to_side = |u: DVec3, v: DVec3| {
        let along = ((p - u).dot(v - u) / (v - u).length_squared()).clamp(0.0, 1.0);
        p.distance(u + along * (v - u))
    };
    to_side(a, b).min(to_side(b, c)).min(to_side(c, a))
}

/// The faces of a patch, as a mesh with all vertices of the result.
fn patch_of(mesh: &Mesh, filled: &Filled) -> Mesh {
    let faces = filled.mesh.faces[mesh.faces.len()..].to_vec();
    Mesh::new(filled.mesh.positions.clone(), faces)
}

/// Asserts that two meshes get the same patch at their top: up to `part` of the hole's diameter, and the energy up to 2 %.
fn assert_same_patch(one: &Mesh, other: &Mesh, part: f64) {
    for finish in FINISHES {
        let (_, of_one) = filled_at_top(one, finish);
        let (points, of_other) = filled_at_top(other, finish);
        let diameter = of_one.report.regions[0].diameter;
        let off = apart(&points, &patch_of(one, &of_one)) / diameter;
        assert!(off < part, "{finish:?}: {off:e} of the diameter");
        let energy = |f: &Filled| f.report.regions[0].levels.last().unwrap().flow.energy_after;
        let ratio = energy(&of_other) / energy(&of_one);
        assert!((ratio - 1.0).abs() < 0.02, "{finish:?}: {ratio}");
    }
}

#[test]
fn a_patch_does_not_depend_on_distant_parts() {
    let mesh = cut(&bumpy(14), |p| polar(p) < 25.0);
    assert_same_patch(&mesh, &cut(&mesh, |p| polar(p) > 100.0), 1e-6);
}

#[test]
fn a_patch_hardly_depends_on_another_open_hole() {
    let mesh = cut(&bumpy(16), |p| polar(p) < 25.0);
    let beside = cut(&mesh, |p| (40.0..75.0).contains(&polar(p)) && p.x > 0.0);
    assert_eq!(inspect(&beside).unwrap().holes.len(), 2);
    // The other hole removes a part of the surroundings, so that the patch differs slightly.
    assert_same_patch(&mesh, &beside, 0.01);
}

#[test]
fn a_mesh_and_its_inside_out_copy_get_the_same_surface() {
    // The patches have different vertices, so that their faces differ by about 1e-3; over half a ball the finish on these faces
    // differs too.
    for (top, part) in [(25.0, 3e-3), (90.0, 8e-3)] {
        let mesh = cut(&bumpy(14), |p| polar(p) < top);
        let mut turned = mesh.clone();
        turned.faces.iter_mut().for_each(|f| f.swap(1, 2));
        assert_same_patch(&mesh, &turned, part);
    }
}

#[test]
fn a_patch_does_not_depend_on_an_inner_wall() {
    // The wall between two nested surfaces: the winding number is 0 within the inner one.
    let mesh = cut(&bumpy(14), |p| polar(p) < 25.0);
    let mut nested = mesh.clone();
    let count = nested.positions.len() as u32;
    let inner = bumpy(6);
    nested
        .positions
        .extend(inner.positions.iter().map(|p| 0.3 * *p));
    nested.faces.extend(
        inner
            .faces
            .iter()
            .map(|&[a, b, c]| [a, c, b].map(|v| v + count)),
    );
    assert_same_patch(&mesh, &nested, 1e-6);
}

#[test]
fn the_patch_of_a_moved_and_scaled_mesh_is_moved_and_scaled() {
    let mesh = cut(&bumpy(14), |p| polar(p) < 25.0);
    let scale_and_move = [
        (1e-3, DVec3::splat(1e-3)),
        (1e3, DVec3::new(30.0, -20.0, 70.0)),
    ];
    for finish in FINISHES {
        let (_, reference) = filled_at_top(&mesh, finish);
        let diameter = reference.report.regions[0].diameter;
        for (scale, offset) in scale_and_move {
            let mut moved = mesh.clone();
            let positions = moved.positions.iter_mut();
            positions.for_each(|p| *p = *p * scale + offset);
            let mut params = FillParams::default();
            params.finish = finish;
            params.holes = Some(vec![1.into()]);
            let filled = fill(&moved, &params).unwrap();
            let points = filled.mesh.positions[mesh.positions.len()..].iter();
            let back: Vec<DVec3> = points.map(|p| (*p - offset) / scale).collect();
            let off = apart(&back, &patch_of(&mesh, &reference)) / diameter;
            assert!(off < 2e-3, "{finish:?}, scale {scale}: {off:e}");
        }
    }
}

/// Root mean square distance of new vertices from the unit sphere, and their mean radius minus 1.
fn off_the_sphere(positions: &[DVec3]) -> (f64, f64) {
    assert!(positions.len() > 20);
    let count = positions.len() as f64;
    let off = || positions.iter().map(|p| p.length() - 1.0);
    let square: f64 = off().map(|d| d * d).sum();
    ((square / count).sqrt(), off().sum::<f64>() / count)
}

#[test]
fn a_small_cap_is_completed_to_a_sphere() {
    // A cap of 30 degrees determines the sphere's radius poorly: normals at its rim are known to about a degree.
    for (top, most_rms, most_mean) in [(120.0, 5e-3, 0.01), (150.0, 0.04, 0.04)] {
        let mesh = cut(&sphere(16), |p| polar(p) < top);
        for inside_out in [false, true] {
            let mut mesh = mesh.clone();
            if inside_out {
                mesh.faces.iter_mut().for_each(|f| f.swap(1, 2));
            }
            let mut params = FillParams::default();
            params.holes = Some(vec![1.into()]);
            let filled = fill(&mesh, &params).unwrap();
            let how = filled.report.holes[0].outcome.closure();
            assert_eq!(how, Some(&Closure::LevelSet), "{top}");
            assert_eq!(topology(&filled.mesh), (0, 2));
            let (rms, mean) = off_the_sphere(&filled.mesh.positions[mesh.positions.len()..]);
            let rms = rms / filled.report.holes[0].hole.diameter;
            assert!(rms < most_rms, "{top}: {rms:e}");
            assert!(mean.abs() < most_mean, "{top}: {mean:e}");
        }
    }
}

#[test]
fn octants_and_half_caps_of_a_sphere_are_restored() {
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.7);
    let masks: [&dyn Fn(DVec3) -> bool; 2] =
        [&|c| c.min_element() > 0.0, &|c| c.z > 0.5 && c.x > 0.0];
    for (i, is_marked) in masks.iter().enumerate() {
        let mesh = sphere(16);
        let marked: Vec<bool> = mesh
            .faces
            .iter()
            .map(|f| {
                is_marked(
                    turn * (f.map(|v| mesh.positions[v as usize]).iter().sum::<DVec3>() / 3.0),
                )
            })
            .collect();
        let found = Inspection::new(&mesh).unwrap();
        let params = RestoreParams::default();
        let restored = found.restore(&marked, &params, &Control::new()).unwrap();
        let region = &restored.fill.regions[0];
        assert_eq!(region.intersecting_faces, 0, "mask {i}");
        assert_eq!(topology(&restored.mesh), (0, 2), "mask {i}");
        let kept = restored.kept.mesh.positions.len();
        let (rms, mean) = off_the_sphere(&restored.mesh.positions[kept..]);
        assert!(
            rms / region.diameter < 5e-3 && mean.abs() < 0.01,
            "mask {i}: {rms:e} {mean:e}"
        );
    }
}
