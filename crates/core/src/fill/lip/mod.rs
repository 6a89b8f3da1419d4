//! Candidate: the rounded edge of a wall, continued between two places at which the rim crosses it. A rim that runs along one side of a
//! wall, over its edge, and back along the other side is the rim of a chip: the surface of least energy there is a bulb. (The same holds for
//! the bottom of a groove.) The profile of the edge is swept from the one place to the other; what is left open at both sides of the wall is
//! faired. Made only where that predicts the faces around the hole much better than a smooth patch; with an edge that predicts nothing where
//! nothing else closes the hole well.

mod curve;
mod ends;
mod strip;

use std::cell::{LazyCell, OnceCell};

use glam::DVec3;

use super::candidate::FinishedPatch;
use super::faired::{self, join};
use super::finish_step::Local;
use super::params::Finish;
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use super::sharp::{CLEARLY_BETTER, RINGS, WidenedHole};
use super::so_far::Made;
use crate::elementary::hypot;
use crate::finish::biharmonic;
use crate::mesh::{Hole, Mesh, Part, Topology, find_holes};
use crate::sdf::Sampler;
use crate::stitch::{Patch, count_intersecting, flipped};
use crate::tuning::{Tunable, tunable};
use curve::Course;
use ends::{Ends, Rim};
use strip::Strip;

/// Rings of faces around the rim, each of which is removed to find where the edge of the wall goes.
const PLACES: Tunable<u32> = tunable("fill.lip.places", 8);
/// Fewest of these places on each side.
const FEWEST_PLACES: usize = 2;
/// Root mean square distance of the places of the edge from the curve, over their distance from its ends, at most.
const MOST_OFF: Tunable<f64> = tunable("fill.lip.most_off", 0.25);
/// The same for an edge that predicts nothing.
const MOST_OFF_UNSURE: f64 = 0.5;
/// Thicknesses of the wall. Where a smooth patch cannot be made, the rings are predicted better than this.
const SURE: Tunable<f64> = tunable("fill.lip.sure", 0.15);
/// Thicknesses of the wall. Profiles reach this far beyond the last pair of opposite vertices, to where the sides are; the next where the
/// last gives no patch.
const BEYOND: [f64; 3] = [0.5, 0.25, 0.75];
/// Expected error of an edge that predicts nothing, by the distance from the rim.
const UNSURE: f64 = 0.5;

/// Expected cost: as the smooth patch that its prediction is compared with.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    faired::cost(problem)
}

/// Closes the region by the continued edge of a wall and its two sides.
pub(super) fn make(problem: &RegionProblem<'_>) -> Made {
    problem.lip().into()
}

/// Closes the region by an edge of the wall that predicts nothing, and its two sides.
pub(super) fn make_unsure(problem: &RegionProblem<'_>) -> Made {
    problem.unsure_lip().into()
}

/// A hole whose rim crosses the edge of a wall twice.
struct Crossing<'a> {
    mesh: &'a Mesh,
    hole: &'a Hole,
    rim: Rim<'a>,
    course: Course,
}

/// The same hole without the innermost rings of faces, which the continued edge must predict.
struct Test<'a> {
    widened: &'a WidenedHole,
    crossing: Crossing<'a>,
    /// The error of a smooth patch, once it is needed; none where that cannot be made.
    smooth: OnceCell<Option<f64>>,
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
        let (part, hole) = &self.around_crossing()?;
        let mesh = &part.mesh;
        let crossing = self.crossing(mesh, hole, MOST_OFF.get())?;
        let widened =
            RINGS.map(|rings| LazyCell::new(move || self.widened(mesh, &hole.rim, rings)));
        let tests = widened.each_ref().map(|widened| {
            LazyCell::new(move || {
                let widened = widened.as_ref()?;
                Some(Test {
                    widened,
                    crossing: self.crossing(&widened.mesh, &widened.hole, MOST_OFF.get())?,
                    smooth: OnceCell::new(),
                })
            })
        });
        BEYOND.into_iter().find_map(|beyond| {
            let tests = tests.iter().filter_map(|test| test.as_ref());
            let error = self.lip_error(tests, beyond)?;
            let lipped = self.lipped(&crossing, beyond, Finish::Auto)?;
            self.closed_by_lip(part.clone(), &hole.rim, lipped, Some(error))
        })
    }

    /// The same with an edge that goes on about as the edge around the hole does, or else straight, whatever it predicts.
    fn unsure_lip(&self) -> Option<RegionPatch> {
        let (part, hole) = &self.around_crossing()?;
        let about = self.crossing(&part.mesh, hole, MOST_OFF_UNSURE);
        let straight = Crossing {
            mesh: &part.mesh,
            hole,
            rim: Rim::new(&part.mesh, &hole.rim),
            course: Course::Straight,
        };
        about.iter().chain([&straight]).find_map(|crossing| {
            BEYOND.into_iter().find_map(|beyond| {
                let lipped = self.lipped(crossing, beyond, Finish::Auto)?;
                self.closed_by_lip(part.clone(), &hole.rim, lipped, None)
            })
        })
    }

    /// The part of the mesh around the only hole, and the hole in it; none where the rim crosses no edge of a wall.
    fn around_crossing(&self) -> Option<(Part, Hole)> {
        let [hole] = self.holes else {
            return None;
        };
        Rim::with_normals(self.mesh, &hole.rim, |v| self.known.normal(v)).ends(0.0)?;
        let part = self.wide_part(&Patch::default());
        let rim = hole.rim.iter().map(|&v| part.local(v)).collect();
        let hole = Hole {
            rim,
            ..(*hole).clone()
        };
        Some((part, hole))
    }

    /// The region closed by a patch of a part of the mesh, whose edge predicts rings of faces with an error, if it does; none if it
    /// intersects anything.
    fn closed_by_lip(
        &self,
        part: Part,
        rim: &[u32],
        lipped: Lipped,
        error: Option<f64>,
    ) -> Option<RegionPatch> {
        let patch = Patch {
            positions: lipped.positions,
            faces: lipped.faces,
            ..Patch::default()
        };
        // Where the rim runs along the edge of the wall, the strip has faces without area, which may lie on their backs.
        let patch = flipped(&part.mesh, rim, &patch);
        let shape = (&patch.positions[..], &patch.faces[..]);
        let at_rim: Vec<DVec3> = rim
            .iter()
            .map(|&v| part.mesh.positions[v as usize])
            .collect();
        let local = Local::of_part(part, self.mesh.positions.len(), shape, self.cancel);
        let closed = self.closed_by_sides(&local, patch, Vec::new(), &|_| Some(0.0));
        let mut region = closed.ok()?;
        let edge = edge_length(self.holes[0]);
        let from_rim = |p: &DVec3| {
            let all = at_rim.iter().map(|q| q.distance(*p));
            all.fold(f64::INFINITY, f64::min)
        };
        let all = region.expected_error.iter_mut().zip(&region.mesh.positions);
        // The curve of the edge is as wrong at the rings as it was found to be, and more the farther it goes on.
        let of_edge = |p: &DVec3| match error {
            Some(error) => error * f64::max(from_rim(p) / (f64::from(RINGS[0]) * edge), 1.0),
            None => UNSURE * from_rim(p),
        };
        for ((expected, p), of_side) in all.zip(lipped.errors) {
            *expected = expected.map(|_| hypot(of_edge(p), of_side.unwrap_or(0.0)));
        }
        Some(region)
    }

    /// The error with which the continued edge predicts the innermost rings of faces around the hole; none where a smooth patch predicts
    /// them about as well.
    fn lip_error<'t>(&self, tests: impl Iterator<Item = &'t Test<'t>>, beyond: f64) -> Option<f64> {
        let mut made = tests
            .filter_map(|test| Some((test, self.lipped(&test.crossing, beyond, Finish::None)?)));
        let (test, lipped) = made.next()?;
        let own = test.widened.distance(&lipped.positions, &lipped.faces)?;
        let smooth = test.smooth.get_or_init(|| self.smooth_error(test.widened));
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

    /// The patch of a hole with the edge of the wall that its rim crosses twice.
    fn lipped(&self, crossing: &Crossing<'_>, beyond: f64, finish: Finish) -> Option<Lipped> {
        let (mesh, hole) = (crossing.mesh, crossing.hole);
        let Ends { both, thickness } = crossing.rim.ends(beyond)?;
        let curve = crossing.course.curve([both[0].tip, both[1].tip])?;
        let strip = Strip::swept(mesh, &both, &curve, edge_length(hole))?;
        (count_intersecting(mesh, &strip.positions, &strip.faces) == 0).then_some(())?;
        let mut joined = Mesh::new(
            [&mesh.positions[..], &strip.positions].concat(),
            [&mesh.faces[..], &strip.faces].concat(),
        );
        let mut topology = Topology::new(&mut joined);
        let (holes, _) = find_holes(&joined, &mut topology);
        let is_new = |v: &u32| *v as usize >= mesh.positions.len();
        let open = holes.iter().filter(|h| h.rim.iter().any(is_new));
        let open: Vec<&Hole> = open.collect();
        (open.len() == 2).then_some(())?;
        let all = Sampler::new(&joined, &topology);
        let mut sides = Patch::default();
        let mut errors = vec![None; strip.positions.len()];
        for side in &open {
            let side = std::slice::from_ref(side);
            let one = self.of_hole(&joined, side, &all);
            let made = match finish {
                Finish::None => {
                    let (local, patch) = one.spanned(side[0], biharmonic)?;
                    FinishedPatch::unfinished(local.to_whole(patch))
                }
                _ => one.faired()?,
            };
            join(&mut sides, &made.patch, joined.positions.len() as u32);
            errors.extend(made.expected_error);
        }
        Some(Lipped {
            positions: [strip.positions, sides.positions].concat(),
            faces: [strip.faces, sides.faces].concat(),
            thickness,
            errors,
        })
    }

    /// A hole whose rim crosses the edge of a wall twice; none where it does not, or where the edge goes on nowhere. Places of the edge may
    /// be off the curve through them by a part of their distance.
    fn crossing<'b>(&self, mesh: &'b Mesh, hole: &'b Hole, most_off: f64) -> Option<Crossing<'b>> {
        let rim = Rim::new(mesh, &hole.rim);
        let mut last = rim.ends(0.0)?.both.map(|end| end.tip);
        let mut places = [Vec::new(), Vec::new()];
        for rings in 1..=PLACES.get() {
            let Some(widened) = self.widened(mesh, &hole.rim, rings) else {
                break;
            };
            let Some(next) = Rim::new(&widened.mesh, &widened.hole.rim).ends(0.0) else {
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
        (places[0].len() >= FEWEST_PLACES).then_some(Crossing {
            mesh,
            hole,
            rim,
            course: Course::Through { places, most_off },
        })
    }
}

/// Mean length of the edges of a rim.
fn edge_length(hole: &Hole) -> f64 {
    hole.length / hole.edges.max(1) as f64
}
