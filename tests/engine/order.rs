//! A patch does not depend on the order of vertices and faces, nor on orientation, handedness and scale of the mesh.

use glam::{DMat3, DVec3};
use isomend::{Closure, FillParams, Filled, Mesh, fill};

use crate::shapes::{cut, sphere};

/// Numbers from 0 to 1 that look random.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        let Self(state) = self;
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The numbers below `count` in any order.
    fn order(&mut self, count: usize) -> Vec<usize> {
        let mut keys: Vec<(f64, usize)> = (0..count).map(|i| (self.next(), i)).collect();
        keys.sort_by(|a, b| a.0.total_cmp(&b.0));
        keys.into_iter().map(|(_, i)| i).collect()
    }
}

/// A flattened ball with spikes and a hole with a ragged rim. On such meshes small differences grow.
fn spiky(seed: u64) -> Mesh {
    let mut numbers = Numbers(seed);
    let mut mesh = sphere(8);
    for p in &mut mesh.positions {
        *p *= (1.0 + 0.4 * numbers.next().powi(5)) * DVec3::new(1.0, 1.0, 0.7);
    }
    let ragged = |c: DVec3| 0.05 * (9.0 * c.x).sin() * (11.0 * c.y).sin();
    cut(&mesh, |c| {
        c.distance(DVec3::new(0.3, 0.2, 0.8)) < 0.6 + ragged(c)
    })
}

/// A mesh in another order: its faces start at other corners too.
fn reordered(mesh: &Mesh, seed: u64) -> Mesh {
    let mut numbers = Numbers(seed);
    let vertices = numbers.order(mesh.positions.len());
    let mut new_of = vec![0; vertices.len()];
    vertices
        .iter()
        .enumerate()
        .for_each(|(new, &old)| new_of[old] = new as u32);
    let faces = numbers.order(mesh.faces.len()).into_iter().map(|f| {
        let mut face = mesh.faces[f].map(|v| new_of[v as usize]);
        face.rotate_left((3.0 * numbers.next()) as usize % 3);
        face
    });
    let faces = faces.collect();
    Mesh::new(vertices.iter().map(|&v| mesh.positions[v]).collect(), faces)
}

fn mapped(mesh: &Mesh, map: impl Fn(DVec3) -> DVec3) -> Mesh {
    Mesh::new(
        mesh.positions.iter().map(|p| map(*p)).collect(),
        mesh.faces.clone(),
    )
}

/// Asserts that two meshes got the same new vertices, where `back` maps the other's positions.
fn assert_same(one: &Filled, other: &Filled, kept: usize, back: impl Fn(DVec3) -> DVec3) {
    let regions = |f: &Filled| -> Vec<_> {
        f.report
            .regions
            .iter()
            .map(|r| (r.closure.as_ref().map(Closure::key), r.new_faces))
            .collect()
    };
    assert_eq!(regions(one), regions(other));
    let new = &one.mesh.positions[kept..];
    assert!(!new.is_empty());
    let diameter = one.report.regions[0].diameter;
    for p in other.mesh.positions[kept..].iter().map(|p| back(*p)) {
        let nearest = new
            .iter()
            .map(|q| q.distance(p))
            .fold(f64::INFINITY, f64::min);
        assert!(
            nearest < 1e-6 * diameter,
            "{p} is {nearest} from the nearest new vertex"
        );
    }
}

#[test]
fn patches_do_not_depend_on_order_orientation_or_scale() {
    let params = FillParams::default();
    for seed in 1..4 {
        let mesh = spiky(seed);
        let filled = fill(&mesh, &params).unwrap();
        let kept = mesh.positions.len();
        let other = fill(&reordered(&mesh, seed), &params).unwrap();
        assert_same(&filled, &other, kept, |p| p);
        let scaled = fill(&mapped(&mesh, |p| 1000.0 * p), &params).unwrap();
        assert_same(&filled, &scaled, kept, |p| p / 1000.0);
        let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), seed as f64);
        let turned = fill(&mapped(&mesh, |p| turn * p), &params).unwrap();
        assert_same(&filled, &turned, kept, |p| turn.transpose() * p);
        let mirror = DVec3::new(-1.0, 1.0, 1.0);
        let mut mirrored = mapped(&mesh, |p| mirror * p);
        mirrored.faces.iter_mut().for_each(|f| f.swap(0, 1));
        assert_same(&filled, &fill(&mirrored, &params).unwrap(), kept, |p| {
            mirror * p
        });
    }
}
