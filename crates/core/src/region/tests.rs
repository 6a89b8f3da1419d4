//! Tests of the grouping of holes.

use std::f64::consts::TAU;

use glam::DVec3;

use super::group_holes;
use crate::mesh::shapes::{grid, icosphere, punch};
use crate::mesh::{Hole, Mesh, Topology, find_holes};

/// The groups of the chosen holes, largest first.
fn groups(
    mut mesh: Mesh,
    chosen: impl Fn(&Hole) -> bool,
    forced: &[Vec<usize>],
) -> Vec<Vec<usize>> {
    let mut topology = Topology::new(&mut mesh);
    let (holes, _) = find_holes(&mesh, &mut topology);
    let chosen: Vec<usize> = (0..holes.len()).filter(|&h| chosen(&holes[h])).collect();
    group_holes(&mesh, &holes, &chosen, forced, &|_| false)
}

fn inner(hole: &Hole) -> bool {
    !hole.outer_boundary
}

/// A sheet with two round holes of radius 0.1, `apart` from rim to rim.
fn two_holes(apart: f64) -> Mesh {
    let sheet = grid(80, 80, [false, false], |u, v| DVec3::new(u, v, 0.0));
    let centres = [-1.0, 1.0].map(|s| DVec3::new(0.5 + s * (0.1 + 0.5 * apart), 0.5, 0.0));
    punch(&sheet, |c| centres.iter().any(|p| p.distance(c) < 0.1))
}

#[test]
fn an_island_goes_with_the_hole_round_it() {
    let mesh = punch(&icosphere(4), |c| (0.6..0.94).contains(&c.normalize().z));
    assert_eq!(groups(mesh, |_| true, &[]), [[0, 1]]);
}

#[test]
fn rims_that_face_each_other_across_a_gap_go_together() {
    let tube = grid(48, 60, [true, false], |u, v| {
        DVec3::new((TAU * u).cos(), (TAU * u).sin(), 12.0 * v - 6.0)
    });
    let at_gap = |h: &Hole| h.centre.z.abs() < 4.0;
    let near = punch(&tube, |c| c.z.abs() < 0.6);
    assert_eq!(groups(near, at_gap, &[]).len(), 1);
    let far = punch(&tube, |c| c.z.abs() < 2.0);
    assert_eq!(groups(far, at_gap, &[]).len(), 2);
}

#[test]
fn holes_side_by_side_are_filled_alone() {
    assert_eq!(groups(two_holes(0.1), inner, &[]).len(), 2);
    // The rims' own numbers: the outer border is the first.
    assert_eq!(groups(two_holes(0.1), inner, &[vec![1, 2]]), [[1, 2]]);
}

#[test]
fn holes_that_share_a_vertex_go_together() {
    let sheet = grid(10, 10, [false, false], |u, v| {
        DVec3::new(10.0 * u, 10.0 * v, 0.0)
    });
    let in_square = |c: DVec3, i: f64| c.x.floor() == i && c.y.floor() == i;
    let mesh = punch(&sheet, |c| in_square(c, 4.0) || in_square(c, 5.0));
    assert_eq!(groups(mesh, inner, &[]), [[1, 2]]);
}
