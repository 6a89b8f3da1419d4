//! Tests on a sphere: distances from the jets of its vertices, and redistancing of a distorted level set function.

use glam::DVec3;

use super::{RimSet, Sampler, SearchArea, faces_at, redistance};
use crate::grid::{SparseGrid, as_point};
use crate::mesh::Topology;
use crate::mesh::shapes::icosphere;
use crate::spatial::Bounds;

/// Points spread evenly over the unit sphere.
fn directions(n: i32) -> impl Iterator<Item = DVec3> {
    (0..n).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
        let (s, c) = (2.399_963 * f64::from(i)).sin_cos();
        (DVec3::new(c, s, 0.0) * (1.0 - z * z).sqrt()).with_z(z)
    })
}

/// Largest errors of the smooth and of the faceted distance to the sphere, in edges.
fn sphere_errors(levels: usize) -> (f64, f64) {
    let mut mesh = icosphere(levels);
    let topology = Topology::new(&mut mesh);
    let sampler = Sampler::new(&mesh, &topology);
    let rims = RimSet::new(std::iter::empty());
    let [a, b, _] = mesh.faces[0].map(|v| mesh.positions[v as usize]);
    let edge = a.distance(b);
    let (mut smooth, mut faceted) = (0.0f64, 0.0f64);
    for d in directions(500) {
        for distance in [-2.0, -0.1, 0.0, 0.3, 3.0].map(|t| t * edge) {
            let x = (1.0 + distance) * d;
            let sample = sampler
                .sample(&rims, x, f64::INFINITY)
                .expect("a closest point");
            assert!(!sample.on_rim);
            smooth = smooth.max((sample.signed - distance).abs() / edge);
            faceted = faceted.max((sample.distance - distance.abs()).abs() / edge);
        }
    }
    (smooth, faceted)
}

#[test]
fn jets_give_the_distance_of_the_sphere_the_vertices_lie_on() {
    let ((coarse, faceted), (fine, _)) = (sphere_errors(4), sphere_errors(5));
    assert!(fine < 1e-4, "{fine:e}");
    assert!(fine < coarse / 6.0, "{coarse:e} {fine:e}");
    assert!(coarse < 0.05 * faceted, "{coarse:e} {faceted:e}");
}

#[test]
fn redistancing_mends_a_distorted_distance() {
    const REACH: f64 = 5.0;
    let grid = SparseGrid::new([40; 3], |_| true);
    let centre = DVec3::new(19.3, 19.6, 20.2);
    let at = |s: usize| as_point(grid.node(s));
    let exact: Vec<f64> = (0..grid.len())
        .map(|s| at(s).distance(centre) - 11.0)
        .collect();
    let distorted: Vec<f64> = exact
        .iter()
        .enumerate()
        .map(|(s, d)| d * (1.0 + 0.3 * (0.15 * at(s).x).sin()))
        .collect();
    let mask: Vec<bool> = (0..grid.len())
        .map(|s| grid.is_interior(grid.node(s), 3))
        .collect();
    let mended = redistance(&grid, &distorted, &mask, REACH);
    let mut worst: f64 = 0.0;
    for s in 0..grid.len() {
        if !mask[s] {
            assert_eq!(mended[s], distorted[s]);
        } else if exact[s].abs() < REACH {
            worst = worst.max((mended[s] - exact[s]).abs());
        } else {
            assert!(mended[s] * exact[s] > 0.0 && mended[s].abs() >= REACH - 0.1);
        }
    }
    assert!(worst < 1e-3, "{worst:e}");
}

#[test]
fn what_is_near_a_place_is_what_is_near_in_all() {
    let mut mesh = icosphere(4);
    mesh.positions
        .iter_mut()
        .for_each(|p| *p *= 1.0 + 0.1 * (9.0 * p.x).sin());
    let topology = Topology::new(&mut mesh);
    let at = |size: f64| Bounds::of_ball(DVec3::X, size);
    let faces = faces_at(&mesh, &topology, &[at(0.4)], usize::MAX).unwrap();
    assert!(faces_at(&mesh, &topology, &[at(0.4)], faces[0].len() - 1).is_none());
    assert!((20..mesh.faces.len() / 4).contains(&faces[0].len()));
    let all = Sampler::new(&mesh, &topology);
    let near = all.at(SearchArea {
        boxes: [0.4, 0.6, 1.0].map(at),
        faces: faces[0].clone(),
    });
    let rims = RimSet::new(std::iter::empty());
    // Points inside the usual box (some with their closest point outside it), in the wider boxes, and beyond.
    for i in 0..400 {
        let t = f64::from(i);
        let way = DVec3::new((1.3 * t).sin(), (2.1 * t).cos(), (3.7 * t).sin());
        let x = DVec3::X + way * (0.004 * t);
        for limit in [f64::INFINITY, 0.3, 0.01] {
            let [a, b] = [&all, &near].map(|s| s.sample(&rims, x, limit));
            assert_eq!(a.is_some(), b.is_some(), "{i}");
            let Some((a, b)) = a.zip(b) else { continue };
            assert_eq!(a.distance.to_bits(), b.distance.to_bits(), "{i}");
            assert_eq!(a.signed.signum(), b.signed.signum(), "{i}");
        }
    }
    for size in [0.1, 0.39, 0.7, 3.0] {
        let [low, high] = [at(size).low, at(size).high];
        let [a, b] = [&all, &near].map(|s| s.part(low, high, std::iter::once(7)));
        assert_eq!(a.mesh, b.mesh, "{size}");
    }
}
