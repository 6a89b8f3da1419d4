//! Candidate: triangles between the rims on the two sides of a wall, as the straight edge of an opening.

use glam::DVec3;

use super::closure::{Closure, HoleOutcome};
use super::params::Sharp;
use super::problem::RegionProblem;
use super::reasons::NotSmooth;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::so_far::Made;
use super::stitching::{local_rim, renumber};
use crate::mesh::{Hole, Mesh};
use crate::region::VoxelSize;
use crate::stitch::{OpeningRim, band, count_intersecting};
use crate::tuning::{Tunable, tunable};

/// Mean edges of both rims. A wall thinner than this is coarse: its edge has no vertices between the rims.
const COARSE_WALL: Tunable<f64> = tunable("fill.coarse_wall", 1.0);

/// Cosine. The conormals of a rim in a flat side deviate from the rim's plane by less.
const FLAT_SIDE: Tunable<f64> = tunable("fill.flat_side", 0.02);

/// Diameters. The vertices of such a rim deviate from its plane by less.
const FLAT_OPENING: Tunable<f64> = tunable("fill.flat_opening", 1e-3);

/// Closes an opening by triangles between its two rims.
pub(super) fn make(problem: &RegionProblem<'_>) -> Made {
    problem.straight_edge().into()
}

impl RegionProblem<'_> {
    /// Whether its two rims are the sides of a wall that is flat at both, or that is thinner than its edges are long.
    pub(super) fn is_straight_opening(&self) -> bool {
        let [a, b] = self.holes else {
            return false;
        };
        let may_be = self.reference.is_none()
            && self.params.sharp == Sharp::Auto
            && self.params.voxel == VoxelSize::Auto
            && self.is_finished();
        may_be && a.is_opposite(b) && (is_flat(a) && is_flat(b) || is_coarse(a, b))
    }

    fn straight_edge(&self) -> Option<RegionPatch> {
        let &[a, b] = self.holes else {
            return None;
        };
        let part = self.all.part_round(&[a.rim.clone(), b.rim.clone()]);
        let rims = [a, b].map(|hole| local_rim(&part, hole));
        let sides = [(a, &rims[0]), (b, &rims[1])].map(|(hole, rim)| OpeningRim {
            rim,
            conormals: &hole.conormals,
        });
        let mut faces = band(&part.mesh, sides)?;
        let report = RegionReport {
            diameter: self.diameter(),
            components: 1,
            intersecting_faces: count_intersecting(&part.mesh, &[], &faces),
            ..RegionReport::default()
        };
        renumber(&mut faces, &part, self.mesh.positions.len());
        let outcome = HoleOutcome::Closed(Closure::RimTriangles(NotSmooth::StraightEdge));
        Some(self.all(Mesh::new(Vec::new(), faces), report, outcome))
    }
}

/// Whether a rim is planar and the side that it bounds is flat there.
fn is_flat(hole: &Hole) -> bool {
    let leaves = |c: &DVec3| c.dot(hole.normal).abs() > FLAT_SIDE.get();
    hole.height <= FLAT_OPENING.get() * hole.diameter && !hole.conormals.iter().any(leaves)
}

/// Whether the wall between two rims is thinner than their edges are long.
fn is_coarse(a: &Hole, b: &Hole) -> bool {
    let thickness = (a.centre - b.centre).dot(a.normal).abs();
    let edge = |h: &Hole| h.length / h.edges as f64;
    thickness < COARSE_WALL.get() * edge(a).min(edge(b))
}
