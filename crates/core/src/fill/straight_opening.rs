//! Candidate: triangles between the rims on the two sides of a wall, as the straight edge of an opening.

use super::closure::{Closure, HoleOutcome};
use super::problem::RegionProblem;
use super::reasons::NotSmooth;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::so_far::Made;
use super::stitching::{local_rim, renumber};
use crate::mesh::{Hole, Mesh};
use crate::stitch::{OpeningRim, band, count_intersecting};
use crate::tuning::{Tunable, tunable};

/// Mean edges of both rims. A wall thinner than this is coarse: its edge has no vertices between the rims.
const COARSE_WALL: Tunable<f64> = tunable("fill.coarse_wall", 1.0);

/// Closes an opening by triangles between its two rims.
pub(super) fn make(problem: &RegionProblem<'_>) -> Made {
    problem.straight_edge().into()
}

impl RegionProblem<'_> {
    /// Whether its two rims are the sides of a wall that is flat at both, or that is thinner than its edges are long, or the ends of a bore.
    pub(super) fn is_straight_opening(&self) -> bool {
        let [a, b] = self.holes else {
            return false;
        };
        let may_be = self.reference.is_none() && self.params.closes_straight();
        let is_flat = || a.is_in_flat_side() && b.is_in_flat_side();
        may_be && (a.is_opposite(b) && (is_flat() || is_coarse(a, b)) || a.is_end_of_bore(b))
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

/// Whether the wall between two rims is thinner than their edges are long.
fn is_coarse(a: &Hole, b: &Hole) -> bool {
    let thickness = (a.centre - b.centre).dot(a.normal).abs();
    let edge = |h: &Hole| h.length / h.edges as f64;
    thickness < COARSE_WALL.get() * edge(a).min(edge(b))
}
