//! Candidate: the rounded edge of a wall, continued between two places at which the rim crosses it. A rim that runs along one side of a wall, over
//! its edge, and back along the other side is the rim of a chip: the surface of least energy there is a bulb. (The same with the bottom of a groove.) The profile of the edge is
//! swept from the one place to the other; what is left open at both sides of the wall is faired. Made only where that predicts the faces
//! around the hole much better than a smooth patch.

mod ends;
mod strip;

use glam::DVec3;

use super::candidate::FinishedPatch;
use super::faired;
use super::finish_step::Local;
use super::params::Finish;
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use super::sharp::{CLEARLY_BETTER, RINGS};
use super::so_far::Made;
use crate::elementary::hypot;
use crate::finish::biharmonic;
use crate::mesh::{Hole, Mesh, Part, Topology, find_holes};
use crate::sdf::Sampler;
use crate::stitch::{Patch, count_intersecting, flipped};
use crate::tuning::{Tunable, tunable};
use ends::{End, Ends, ends};
use strip::Strip;

/// Rings of faces around the rim, each of which is removed to find where the edge of the wall goes.
const PLACES: Tunable<u32> = tunable("fill.lip.places", 8);
/// Fewest of these places on each side.
const FEWEST_PLACES: usize = 2;
/// Thicknesses of the wall. Where a smooth patch cannot be made, the rings are predicted better than this.
const SURE: Tunable<f64> = tunable("fill.lip.sure", 0.15);
/// Distances from an end at which the profile of the edge is upright, over how far it leans there: the second where faces intersect with the
/// first.
const REACHES: [f64; 2] = [2.0, 4.0];
/// Thicknesses of the wall. Profiles reach this far beyond the last pair of opposite vertices, to where the sides are; the second where the
/// first gives no patch.
const BEYOND: [f64; 2] = [0.5, 0.25];

/// Expected cost: as the smooth patch that its prediction is compared with.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    faired::cost(problem)
}

/// Closes the region by the continued edge of a wall and its two sides.
pub(super) fn make(problem: &RegionProblem<'_>) -> Made {
    problem.lip().into()
}

/// A patch with the continued edge of a wall, in the vertex numbers of a mesh.
struct Lipped {
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// Thickness of the wall.
    thickness: f64,
    /// Expected error of each vertex within its side; none at the edge.
    errors: Vec<Option<f64>>,
}

impl RegionProblem<'_> {
    /// The region closed by the continued edge of a wall; none where the rim crosses no edge of a wall, a smooth patch predicts the faces
    /// around the hole about as well, or the patch intersects anything.
    fn lip(&self) -> Option<RegionPatch> {
        let [hole] = self.holes else {
            return None;
        };
        BEYOND.into_iter().find_map(|beyond| {
            let part = self.wide_part(&Patch::default());
            self.lip_from(hole, part, beyond)
        })
    }

    /// The same with profiles of the edge that reach a number of thicknesses beyond the last pair of opposite vertices.
    fn lip_from(&self, hole: &Hole, part: Part, beyond: f64) -> Option<RegionPatch> {
        let rim: Vec<u32> = hole.rim.iter().map(|&v| part.local(v)).collect();
        let own = Hole {
            rim: rim.clone(),
            ..hole.clone()
        };
        let error = self.lip_error(&part, &rim, beyond)?;
        let lipped = self.lipped(&part.mesh, &own, beyond, Finish::Auto)?;
        let patch = Patch {
            positions: lipped.positions,
            faces: lipped.faces,
            ..Patch::default()
        };
        // Where the rim runs along the edge of the wall, the strip has faces without area, which may lie on their backs.
        let patch = flipped(&part.mesh, &rim, &patch);
        let shape = (&patch.positions[..], &patch.faces[..]);
        let local = Local::of_part(part, self.mesh.positions.len(), shape, self.cancel);
        let closed = self.closed_by_sides(&local, patch, Vec::new(), Some(error));
        let mut region = closed.ok()?;
        let edge = hole.length / hole.edges.max(1) as f64;
        let at_rim = |p: &DVec3| {
            let all = hole.rim.iter().map(|&v| self.mesh.positions[v as usize]);
            all.map(|q| q.distance(*p)).fold(f64::INFINITY, f64::min)
        };
        let all = region.expected_error.iter_mut().zip(&region.mesh.positions);
        for ((expected, p), of_side) in all.zip(lipped.errors) {
            // The curve of the edge is as wrong at the rings as it was found to be, and more the farther it goes on.
            let farther = f64::max(at_rim(p) / (f64::from(RINGS[0]) * edge), 1.0);
            *expected = expected.map(|e| hypot(e * farther, of_side.unwrap_or(0.0)));
        }
        Some(region)
    }

    /// The error with which the continued edge predicts the innermost rings of faces around the hole; none where a smooth patch predicts
    /// them about as well.
    fn lip_error(&self, part: &Part, rim: &[u32], beyond: f64) -> Option<f64> {
        let (widened, lipped) = RINGS.into_iter().find_map(|rings| {
            let widened = self.widened(part, rim, rings)?;
            let lipped = self.lipped(&widened.mesh, &widened.hole, beyond, Finish::None)?;
            Some((widened, lipped))
        })?;
        let own = widened.distance(&lipped.positions, &lipped.faces)?;
        let smooth = self.smooth_error(&widened);
        log::debug!(
            "region {}: edge of a wall, predicted {own:.4}, smooth {smooth:.4?}",
            self.id
        );
        let most = match smooth {
            Some(smooth) => CLEARLY_BETTER.get() * smooth,
            None => SURE.get() * lipped.thickness,
        };
        (own < most).then_some(own)
    }

    /// The patch of a hole of a mesh with the edge of the wall that its rim crosses twice.
    fn lipped(&self, mesh: &Mesh, hole: &Hole, beyond: f64, finish: Finish) -> Option<Lipped> {
        let Ends { both, thickness } = ends(mesh, &hole.rim, beyond)?;
        let places = self.places(mesh, &hole.rim, &both)?;
        let edge = hole.length / hole.edges.max(1) as f64;
        let strip = REACHES.into_iter().find_map(|reach| {
            let strip = Strip::swept(mesh, &both, &places, edge, reach)?;
            let crossing = count_intersecting(mesh, &strip.positions, &strip.faces);
            (crossing == 0).then_some(strip)
        })?;
        let mut joined = Mesh::new(
            [&mesh.positions[..], &strip.positions].concat(),
            [&mesh.faces[..], &strip.faces].concat(),
        );
        let mut topology = Topology::new(&mut joined);
        let (holes, _) = find_holes(&joined, &mut topology);
        let is_new = |v: &u32| *v as usize >= mesh.positions.len();
        let sides = holes.iter().filter(|h| h.rim.iter().any(is_new));
        let sides: Vec<&Hole> = sides.collect();
        (sides.len() == 2).then_some(())?;
        let all = Sampler::new(&joined, &topology);
        let mut lipped = Lipped {
            thickness,
            errors: vec![None; strip.positions.len()],
            positions: strip.positions,
            faces: strip.faces,
        };
        for side in sides {
            let one = RegionProblem {
                mesh: &joined,
                holes: &[side],
                known: &all,
                all: &all,
                decided: None,
                joined: &[],
                base: None,
                counterparts: None,
                reference: None,
                extent: None,
                ..*self
            };
            let made = match finish {
                Finish::None => {
                    let (local, patch) = one.spanned(side, biharmonic)?;
                    FinishedPatch::unfinished(local.to_whole(patch))
                }
                _ => one.faired()?,
            };
            let (count, base) = (joined.positions.len(), mesh.positions.len());
            let base = (base + lipped.positions.len()) as u32;
            let moved = |v: u32| match (v as usize).checked_sub(count) {
                Some(new) => base + new as u32,
                None => v,
            };
            let faces = made.patch.faces.iter().map(|f| f.map(moved));
            lipped.faces.extend(faces);
            lipped.positions.extend(made.patch.positions);
            lipped.errors.extend(made.expected_error);
        }
        Some(lipped)
    }

    /// Places of the edge of the wall that go on from its two ends, away from the hole.
    fn places(&self, mesh: &Mesh, rim: &[u32], from: &[End; 2]) -> Option<[Vec<DVec3>; 2]> {
        let all: Vec<u32> = (0..mesh.faces.len() as u32).collect();
        let whole = Part::new(mesh, &all, std::iter::empty());
        let rim: Vec<u32> = rim.iter().map(|&v| whole.local(v)).collect();
        let mut places = [Vec::new(), Vec::new()];
        let mut last = [from[0].tip, from[1].tip];
        for rings in 1..=PLACES.get() {
            let Some(widened) = self.widened(&whole, &rim, rings) else {
                break;
            };
            let Some(next) = ends(&widened.mesh, &widened.hole.rim, 0.0) else {
                break;
            };
            let tips = next.both.map(|end| end.tip);
            let cost = |[a, b]: [DVec3; 2]| last[0].distance(a) + last[1].distance(b);
            let swapped = [tips[1], tips[0]];
            last = if cost(tips) <= cost(swapped) {
                tips
            } else {
                swapped
            };
            places[0].push(last[0]);
            places[1].push(last[1]);
        }
        (places[0].len() >= FEWEST_PLACES).then_some(places)
    }
}
