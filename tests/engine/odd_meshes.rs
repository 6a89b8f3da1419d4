//! Restoring and fairing meshes that are not manifold, one-sided or tiny: a result without torn holes, or a refusal with its reason.

use glam::DVec3;
use isomend::check::{CheckParams, DefectKind};
use isomend::{
    Control, FairError, FairExtent, FairParams, FillError, FillParams, Inspection, Mesh,
    RestoreError, RestoreParams, VoxelSize, fair, inspect, restore,
};

use crate::shapes;

/// Marks the faces whose centres are within `radius` of a point.
fn near(mesh: &Mesh, centre: DVec3, radius: f64) -> Vec<bool> {
    let at = |v: u32| mesh.positions[v as usize];
    let middle = |f: &[u32; 3]| f.iter().map(|&v| at(v)).sum::<DVec3>() / 3.0;
    let faces = mesh.faces.iter();
    faces.map(|f| middle(f).distance(centre) < radius).collect()
}

fn octahedron() -> Mesh {
    let positions = [DVec3::X, DVec3::Y, DVec3::Z].into_iter();
    let positions = positions.flat_map(|p| [p, -p]).collect();
    let mut faces = Vec::new();
    for (x, y, z) in (0..8).map(|i| (i & 1, i >> 1 & 1, i >> 2 & 1)) {
        let face = [x, 2 + y, 4 + z];
        faces.push(match (x + y + z) % 2 {
            0 => face,
            _ => [face[0], face[2], face[1]],
        });
    }
    Mesh::new(positions, faces)
}

/// A closed one-sided surface: a grid whose sides are glued, one pair of them in reverse, with a self-intersection in space.
fn klein_bottle(n: u32) -> Mesh {
    let turn = |i: u32| f64::from(i) * std::f64::consts::TAU / f64::from(n);
    let mut mesh = Mesh::default();
    for i in 0..n {
        for j in 0..n {
            let (u, v) = (turn(i), turn(j));
            let reach = 3.0 + (0.5 * u).cos() * v.sin() - (0.5 * u).sin() * (2.0 * v).sin();
            let height = (0.5 * u).sin() * v.sin() + (0.5 * u).cos() * (2.0 * v).sin();
            let at = DVec3::new(reach * u.cos(), reach * u.sin(), height);
            mesh.positions.push(at);
        }
    }
    let vertex = |i: u32, j: u32| match i < n {
        true => i * n + j % n,
        false => (n - j % n) % n,
    };
    for i in 0..n {
        for j in 0..n {
            let [a, b] = [vertex(i, j), vertex(i + 1, j)];
            let [c, d] = [vertex(i, j + 1), vertex(i + 1, j + 1)];
            mesh.faces.extend([[a, b, d], [a, d, c]]);
        }
    }
    mesh
}

#[test]
fn a_cut_beside_a_face_that_is_given_twice_leaves_no_torn_hole() {
    let ball = shapes::sphere(12);
    for twice in [40, 77, 160] {
        let mut mesh = ball.clone();
        mesh.faces.push(mesh.faces[twice]);
        for corner in mesh.faces[twice] {
            let centre = mesh.positions[corner as usize];
            // Masks whose rims pass at different places of the face that is there twice.
            for radius in [0.12, 0.2, 0.3] {
                let marked = near(&mesh, centre + DVec3::splat(0.05), radius);
                if !marked.contains(&true) {
                    continue;
                }
                let done = restore(&mesh, &marked, &RestoreParams::default());
                let Ok(done) = done else { continue };
                let found = inspect(&done.mesh).unwrap();
                let is_whole = found.holes.is_empty() && found.open_chains.is_empty();
                let is_reported = done.fill.incomplete();
                assert!(is_whole || is_reported, "face {twice}, radius {radius}");
            }
        }
    }
}

#[test]
fn a_cut_across_a_seam_of_three_surfaces_is_refused() {
    // A wall stands on a closed box, along a line of its edges.
    let mut mesh = shapes::cube(16);
    let of_box = mesh.faces.len();
    let is_on_line = |v: &usize| (mesh.positions[*v].x, mesh.positions[*v].z) == (8.0, 16.0);
    let on_line = (0..mesh.positions.len()).filter(is_on_line);
    let mut on_line: Vec<usize> = on_line.collect();
    on_line.sort_by(|a, b| mesh.positions[*a].y.total_cmp(&mesh.positions[*b].y));
    assert!(on_line.len() > 4);
    let first = mesh.positions.len() as u32;
    for v in &on_line {
        let above = mesh.positions[*v] + DVec3::Z;
        mesh.positions.push(above);
    }
    for i in 0..on_line.len() - 1 {
        let [a, b] = [on_line[i] as u32, on_line[i + 1] as u32];
        let [c, d] = [first + i as u32, first + i as u32 + 1];
        mesh.faces.extend([[a, b, d], [a, d, c]]);
    }
    let found = inspect(&mesh).unwrap();
    assert!(found.topology.defects.non_manifold_edges > 0);
    let centre = mesh.positions[on_line[on_line.len() / 2]];
    let mut marked = near(&mesh, centre, 1.2);
    marked[of_box..].fill(false);
    let error = restore(&mesh, &marked, &RestoreParams::default()).unwrap_err();
    assert!(matches!(error, RestoreError::OpenRim { .. }), "{error}");
}

#[test]
fn fairing_what_has_no_inside_is_refused_and_ends() {
    let mut params = FairParams::default();
    let mut flipped = octahedron();
    flipped.faces[0].swap(1, 2);
    let mut finned = octahedron();
    finned.positions.push(DVec3::splat(2.0));
    let fin = finned.positions.len() as u32 - 1;
    finned.faces.extend([[0, 2, fin], [2, 0, fin]]);
    let mut twice = octahedron();
    twice.faces.extend(octahedron().faces);
    let pillow = Mesh::new(octahedron().positions, vec![[0, 2, 4], [0, 4, 2]]);
    for (name, mesh) in [
        ("a flipped face", flipped),
        ("a fin", finned),
        ("every face twice", twice),
        ("a pillow", pillow),
        ("a Klein bottle", klein_bottle(12)),
    ] {
        for strength in [None, Some(0.5), Some(2.0)] {
            params.extent = strength.map_or(FairExtent::Auto, FairExtent::Strength);
            let Ok(done) = fair(&mesh, None, &params) else {
                continue;
            };
            let found = inspect(&done.mesh).unwrap();
            assert!(found.holes.is_empty(), "{name}, {strength:?}");
            assert_eq!(found.topology.defects.non_manifold_edges, 0, "{name}");
        }
    }
    let error = fair(&klein_bottle(24), None, &FairParams::default()).unwrap_err();
    assert!(matches!(error, FairError::NoSides { .. }), "{error}");
}

#[test]
fn a_spike_that_vanishes_counts_as_moved() {
    let mut mesh = shapes::sphere(16);
    let tip = (0..mesh.positions.len()).max_by(|a, b| {
        let z = |v: &usize| mesh.positions[*v].z;
        z(a).total_cmp(&z(b))
    });
    let tip = tip.unwrap();
    let before = mesh.positions[tip];
    mesh.positions[tip] = 1.8 * before;
    let mut params = FairParams::default();
    params.extent = FairExtent::Strength(1.0);
    let done = fair(&mesh, None, &params).unwrap();
    let left = done.mesh.positions.iter().map(|p| p.length());
    let left = left.fold(0.0, f64::max);
    let gone = 1.8 * before.length() - left;
    assert!(gone > 0.2, "{gone}");
    assert!(
        done.report.moved_max > 0.8 * gone,
        "{}",
        done.report.moved_max
    );
}

#[test]
fn the_flanks_of_a_spike_that_vanishes_count_as_moved() {
    // The tip is pulled in until near the other side; half-way the flanks are far from both.
    let mut mesh = shapes::sphere(16);
    let z = |v: &usize| mesh.positions[*v].z;
    let tip = (0..mesh.positions.len()).max_by(|a, b| z(a).total_cmp(&z(b)));
    mesh.positions[tip.unwrap()] = DVec3::new(0.0, 0.0, -0.7);
    let done = fair(&mesh, None, &FairParams::default()).unwrap();
    let left = done.mesh.positions.iter().map(|p| p.length());
    let left = left.fold(f64::INFINITY, f64::min);
    assert!(left > 0.8, "{left}");
    assert!(done.report.moved_max > 0.7, "{}", done.report.moved_max);
}

#[test]
fn a_star_that_would_vanish_is_refused() {
    // Five arms of 0.2 in thickness.
    let mut mesh = Mesh::new(vec![0.2 * DVec3::Z, -0.2 * DVec3::Z], Vec::new());
    for i in 0..10u32 {
        let angle = f64::from(i) * std::f64::consts::PI / 5.0;
        let reach = if i.is_multiple_of(2) { 1.0 } else { 0.4 };
        let at = DVec3::new(reach * angle.cos(), reach * angle.sin(), 0.0);
        mesh.positions.push(at);
        let [a, b] = [2 + i, 2 + (i + 1) % 10];
        mesh.faces.extend([[a, b, 0], [b, a, 1]]);
    }
    let mut params = FairParams::default();
    params.extent = FairExtent::Strength(0.8);
    params.voxel = VoxelSize::Length(0.1);
    let error = fair(&mesh, None, &params).unwrap_err();
    assert!(matches!(error, FairError::Collapsed { .. }), "{error}");
}

#[test]
fn patches_that_meet_each_other_are_counted_in_full_precision() {
    // Two balls whose removed caps would overlap; what is left of them does not.
    let ball = shapes::sphere(24);
    let lower = shapes::cut(&ball, |p| p.z > 0.88);
    let upper = shapes::cut(&ball, |p| p.z < -0.88);
    for (shift, meet) in [(1.95, true), (1.9, true), (2.6, false)] {
        let by = DVec3::new(0.2 + 1e-3 / 3.0, 0.01, shift);
        let mesh = shapes::joined(&lower, &shapes::moved(&upper, 1.0, by));
        let filled = isomend::fill(&mesh, &FillParams::default()).unwrap();
        assert_eq!(filled.report.regions.len(), 2);
        let counted: usize = filled
            .report
            .regions
            .iter()
            .map(|r| r.intersecting_faces)
            .sum();
        let found = inspect(&filled.mesh).unwrap();
        let exact = found.check(&CheckParams::default());
        assert_eq!(
            counted,
            exact.count(DefectKind::SelfIntersection),
            "{shift}"
        );
        assert_eq!(counted > 0, meet, "{shift}");
        assert_eq!(filled.report.flawless(), !meet, "{shift}");
    }
}

#[test]
fn a_voxel_larger_than_the_widest_hole_is_refused() {
    let mesh = shapes::cut(&shapes::sphere(16), |p| p.z > 0.6);
    let found = Inspection::new(&mesh).unwrap();
    let mut params = FillParams::default();
    // The second is smaller than the model.
    for length in [100.0, 1.75] {
        params.voxel = VoxelSize::Length(length);
        let error = found.fill(&params, &Control::new()).unwrap_err();
        assert!(matches!(error, FillError::TooCoarse { .. }), "{error}");
    }
    params.voxel = VoxelSize::Length(0.25);
    assert!(found.fill(&params, &Control::new()).is_ok());
}

#[test]
fn a_hole_narrower_than_the_voxel_gets_an_automatic_one() {
    let holes = |p: DVec3| p.z > 0.6 || p.z < -0.95;
    let mesh = shapes::cut(&shapes::sphere(16), holes);
    let mut params = FillParams::default();
    params.voxel = VoxelSize::Length(0.8);
    let filled = isomend::fill(&mesh, &params).unwrap();
    let [wide, narrow] = &filled.report.regions[..] else {
        panic!("two regions");
    };
    assert!(wide.diameter > 0.8 && (wide.voxel.unwrap() / 0.8 - 1.0).abs() < 1e-9);
    assert!(narrow.diameter < 0.8);
    assert!(
        narrow
            .voxel
            .is_none_or(|voxel| voxel < 0.2 * narrow.diameter)
    );
}

#[test]
fn a_mesh_of_floats_is_the_mesh_of_the_same_doubles() {
    let floats = vec![[0.1_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.3]];
    let doubles = floats.iter().map(|p| p.map(f64::from)).collect();
    let faces = vec![[0, 1, 2]];
    assert_eq!(
        Mesh::from_f32(floats, faces.clone()),
        Mesh::from((doubles, faces))
    );
    // Numbers without a type are doubles.
    assert_eq!(
        Mesh::from((vec![[0.5, 0.0, 0.0]], Vec::new()))
            .positions
            .len(),
        1
    );
}
