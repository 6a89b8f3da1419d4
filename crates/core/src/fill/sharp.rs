//! Candidate: the smooth sides around a rim, continued until they meet in sharp edges (creases). Made only where that predicts
//! the faces around the hole much better than a smooth patch.

use glam::DVec3;

use super::candidate::FinishedPatch;
use super::closure::Closure;
use super::finish_step::Local;
use super::params::{FillParams, Sharp};
use super::problem::RegionProblem;
use super::reasons::NotContinued;
use super::region_patch::RegionPatch;
use super::report::{CreaseReport, RegionReport};
use super::sides_error::{Predicted, with_rounding};
use super::so_far::{Made, SoFar};
use super::{FEW_EDGES, faired};
use crate::creases::{Continued, CreaseRefusal, RimSides, Rounded, without_rings};
use crate::mesh::{Hole, Mesh, Part, Topology, VertexFaces, find_holes};
use crate::sdf::Sampler;
use crate::spatial::Bvh;
use crate::stitch::Patch;
use crate::tuning::{Tunable, tunable};

/// Edges. Longer rims are not examined: the triangulation of a part takes time proportional to their number of edges times its
/// area.
const MOST_EDGES: Tunable<usize> = tunable("fill.sharp.most_edges", 1000);
/// Numbers of rings that are removed for the test; the second where the first leaves no hole across which the sides can be
/// continued.
pub(super) const RINGS: [u32; 2] = [2, 1];
/// Ratio of errors. The sides must predict the removed rings with less than this fraction of a smooth patch's error. On 73 holes
/// of solids this refused 2 correct patches, and took 1 that was worse than the smooth one.
pub(super) const CLEARLY_BETTER: Tunable<f64> = tunable("fill.sharp.clearly_better", 0.6);
/// Ratio of errors. The same bound where no crease of the mesh is found to end at the rim and the sides are rough: on holes of
/// scans wrong creases had 0.27 and more.
const FAR_BETTER: Tunable<f64> = tunable("fill.sharp.far_better", 0.25);
/// Edges. Where no ring can be removed, the sides are accepted if their residual is below this. On holes of scans wrong patches
/// had residuals of at least 0.077, correct ones of at most 0.065, except for two.
pub(super) const SURE: Tunable<f64> = tunable("fill.sharp.sure", 0.06);
/// Edges. The same bound where, in addition, no crease is found to end at the rim.
const EXACT: Tunable<f64> = tunable("fill.sharp.exact", 0.02);
/// Fraction of the rim's vertices. A hole of the widened mesh is the widened one if more than this fraction of its rim's vertices
/// belong to removed faces.
const SAME_RIM: Tunable<f64> = tunable("fill.sharp.same_rim", 0.9);

/// How well continued sides, and a smooth patch, predict the removed rings.
struct Prediction {
    /// Root mean square distance of the removed vertices from the continued sides, in the mesh's units.
    sides: f64,
    /// Whether these sides include the correction by the residuals of their fit.
    is_refined: bool,
    /// Root mean square distance of the removed vertices from a smooth patch, in the mesh's units.
    smooth: f64,
}

/// Expected cost: as the smooth patch that its prediction is compared with.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    faired::cost(problem)
}

/// The region closed by its continued sides; nothing where there are no creases, or a smooth patch predicts the faces around the
/// hole about as well. Records how many creases end at the rim, and why they are not continued.
pub(super) fn make(problem: &RegionProblem<'_>, so_far: &mut SoFar<'_>) -> Made {
    let [hole] = problem.holes else {
        return Made::Nothing;
    };
    let part = problem.wide_part(&Patch::default());
    let rim: Vec<u32> = hole.rim.iter().map(|&v| part.local(v)).collect();
    let sides = RimSides::new(
        &part.mesh,
        &VertexFaces::new(&part.mesh),
        &rim,
        problem.cancel,
    );
    let ends = sides.as_ref().map_or(0, |sides| sides.ends().len());
    so_far.crease_ends = ends;
    so_far.noise = sides.as_ref().map_or(0.0, RimSides::noise);
    let made = sides
        .map_err(declined)
        .and_then(|mut sides| problem.sides(part, &rim, &mut sides, ends));
    match made {
        Ok(region) => Made::Region(region),
        Err(why) => {
            log::debug!("hole {}: no sharp edges: {why}", hole.id.get());
            // A single end is often no crease, but the deepest point of a smooth valley.
            let is_lost = so_far.crease_ends > 1 || !problem.joined.is_empty();
            so_far.not_continued = is_lost.then_some(why);
            Made::Nothing
        }
    }
}

fn declined(why: CreaseRefusal) -> NotContinued {
    NotContinued::Declined(why.to_string())
}

/// Whether creases that end at the rim of a hole are searched: not at the longest rims, and not where few triangles close it.
pub(crate) fn may_have_crease_ends(hole: &Hole) -> bool {
    hole.edges > FEW_EDGES.get() && hole.edges <= MOST_EDGES.get()
}

impl RegionProblem<'_> {
    /// Whether creases are searched: at a single rim, where patches are finished.
    pub(super) fn may_be_sharp(&self) -> bool {
        let is_one = matches!(self.holes, [hole] if may_have_crease_ends(hole));
        is_one && self.params.sharp == Sharp::Auto && self.is_finished()
    }

    /// The region closed by its continued sides. `ends` is the number of creases found to end at its rim.
    fn sides(
        &self,
        part: Part,
        rim: &[u32],
        sides: &mut RimSides,
        ends: usize,
    ) -> Result<RegionPatch, NotContinued> {
        let count = part.mesh.positions.len();
        let joined = self.joined.iter().map(|pair| pair.map(|v| part.local(v)));
        let joined: Vec<[u32; 2]> = joined.collect();
        let (continued, expected) = match joined.is_empty() {
            true => {
                let continued = sides.continued(count).map_err(declined)?;
                let (error, is_refined) = self.predicted(&part, rim, &continued, ends > 1)?;
                let expected = error.map(|error| self.expected(error, sides, &continued));
                let refined = (is_refined && sides.refine()).then(|| sides.continued(count).ok());
                match refined.flatten() {
                    Some(refined) => {
                        let expected = error.map(|error| self.expected(error, sides, &refined));
                        (refined, expected)
                    }
                    None => (continued, expected),
                }
            }
            // The caller knows that these creases exist: no test.
            false => (
                sides.continued_with(count, &joined).map_err(declined)?,
                None,
            ),
        };
        let shape = (&continued.positions[..], &continued.faces[..]);
        let local = Local::of_part(part, self.mesh.positions.len(), shape, self.cancel);
        let creases = continued.creases.iter().map(|c| CreaseReport {
            length: c.length,
            angle: c.angle,
        });
        let creases = creases.collect();
        let patch = Patch {
            positions: continued.positions,
            faces: continued.faces,
            ..Patch::default()
        };
        let expected = |i: usize| expected.as_ref().map(|all| all[i]);
        self.closed_by_sides(&local, patch, creases, &expected)
    }

    /// The expected errors of the vertices of continued sides that predict the faces round the hole with an error.
    fn expected(&self, error: f64, sides: &RimSides, continued: &Continued) -> Vec<f64> {
        let hole = self.holes[0];
        let edge = hole.length / hole.edges.max(1) as f64;
        let determined = sides.determined(continued);
        let predicted = Predicted {
            error,
            residual: continued.residual * edge,
            noise: determined.noise * edge,
        };
        let all = determined.deviations.iter();
        all.map(|d| predicted.expected(*d)).collect()
    }

    /// The error with which the continued sides predict the faces around the hole, if it can be measured, and whether their
    /// sheets are to be refined. Refused where a smooth patch predicts the faces about as well. Creases between rough sides that
    /// are not found to end at the rim must be far better.
    fn predicted(
        &self,
        part: &Part,
        rim: &[u32],
        continued: &Continued,
        is_seen: bool,
    ) -> Result<(Option<f64>, bool), NotContinued> {
        let prediction = RINGS.iter().find_map(|&n| self.prediction(part, rim, n));
        let predicted = prediction
            .as_ref()
            .map(|p| (p.sides, p.is_refined, p.smooth));
        log::debug!(
            "region {}: residual {:.3}, predicted {predicted:.4?}",
            self.id,
            continued.residual
        );
        let is_rounded = || {
            let around = VertexFaces::new(&part.mesh);
            Rounded::find(&part.mesh, &around, rim, self.cancel).is_some()
        };
        let is_likely = is_seen || continued.creases.is_empty() || continued.residual < SURE.get();
        let clearly_better = if is_likely {
            CLEARLY_BETTER.get()
        } else {
            FAR_BETTER.get()
        };
        let is_refined = prediction.as_ref().is_none_or(|p| p.is_refined);
        let error = match prediction {
            // A flat side is simpler: it is taken if it predicts as well as the smooth patch.
            Some(p) if continued.is_flat && p.sides <= p.smooth => Ok(Some(p.sides)),
            Some(p) if p.sides < clearly_better * p.smooth => Ok(Some(p.sides)),
            Some(_) => Err(NotContinued::Predicted),
            None if continued.residual >= if is_seen { SURE.get() } else { EXACT.get() } => {
                Err(NotContinued::Rough)
            }
            None if is_rounded() => Err(NotContinued::Rounded),
            None => Ok(None),
        };
        Ok((error?, is_refined))
    }

    /// The region closed by a patch on its continued sides, in the part's vertex numbers, with the expected error of each new vertex.
    /// Refused where the patch intersects anything.
    pub(super) fn closed_by_sides(
        &self,
        local: &Local,
        mut patch: Patch,
        creases: Vec<CreaseReport>,
        expected: &dyn Fn(usize) -> Option<f64>,
    ) -> Result<RegionPatch, NotContinued> {
        match local.count_intersecting(&patch.positions) {
            0 => patch.report.intersecting_faces = 0,
            faces => return Err(NotContinued::Intersects(faces)),
        }
        patch.report.components = 1;
        let mut patch = local.to_whole(patch);
        let whole = |f: &[u32; 3]| f.map(|v| local.part.original(v, local.count));
        patch.measure(self.mesh, local.part.mesh.faces.iter().map(whole));
        let report = RegionReport {
            diameter: self.diameter(),
            creases,
            ..RegionReport::default()
        };
        let mut finished = FinishedPatch::unfinished(patch);
        let at = finished
            .expected_error
            .iter_mut()
            .zip(&finished.patch.positions);
        for (i, (own, p)) in at.enumerate() {
            *own = expected(i).map(|error| with_rounding(error, *p));
        }
        Ok(self.all_finished(finished, report, Closure::Sides))
    }

    /// How well the sides, and a smooth patch, predict the innermost rings of faces when these are removed; none where the
    /// removal leaves no single hole, or either patch fails.
    fn prediction(&self, part: &Part, rim: &[u32], rings: u32) -> Option<Prediction> {
        let widened = self.widened(&part.mesh, rim, rings)?;
        let around = VertexFaces::new(&widened.mesh);
        let mut sides =
            RimSides::new(&widened.mesh, &around, &widened.hole.rim, self.cancel).ok()?;
        let error = |sides: &RimSides| {
            let continued = sides.continued(widened.mesh.positions.len()).ok()?;
            widened.distance(&continued.positions, &continued.faces)
        };
        let plain = error(&sides)?;
        let refined = sides.refine().then(|| error(&sides)).flatten();
        let is_refined = refined.is_some_and(|r| r < plain);
        Some(Prediction {
            sides: refined.filter(|_| is_refined).unwrap_or(plain),
            is_refined,
            smooth: self.smooth_error(&widened)?,
        })
    }

    /// The mesh without the innermost rings of faces around its hole; none where that leaves no single hole, or the token is set.
    pub(super) fn widened(&self, mesh: &Mesh, rim: &[u32], rings: u32) -> Option<WidenedHole> {
        (!self.cancel.is_cancelled()).then_some(())?;
        let widened = without_rings(mesh, rim, rings)?;
        let rest = Part::new(mesh, &widened.kept, std::iter::empty());
        let mut left = rest.mesh.clone();
        let mut topology = Topology::new(&mut left);
        let (holes, _) = find_holes(&left, &mut topology);
        let hole = widened_hole(holes, &rest, &widened.removed)?;
        let is_inner = |v: &&u32| !hole.rim.iter().any(|&r| rest.vertices()[r as usize] == **v);
        let inner = widened.removed.iter().filter(is_inner);
        Some(WidenedHole {
            points: inner.map(|&v| mesh.positions[v as usize]).collect(),
            mesh: left,
            topology,
            hole,
        })
    }

    /// The problem of a hole of another mesh, whose faces `all` has.
    pub(super) fn of_hole<'b>(
        &'b self,
        mesh: &'b Mesh,
        holes: &'b [&'b Hole],
        all: &'b Sampler<'b>,
    ) -> RegionProblem<'b> {
        RegionProblem {
            mesh,
            holes,
            decided: None,
            known: all,
            all,
            joined: &[],
            ..*self
        }
    }

    /// Root mean square distance of the removed vertices from a smooth patch.
    pub(super) fn smooth_error(&self, widened: &WidenedHole) -> Option<f64> {
        let params = FillParams {
            sharp: Sharp::Off,
            ..self.params.clone()
        };
        let all = Sampler::new(&widened.mesh, &widened.topology);
        let holes = [&widened.hole];
        let problem = RegionProblem {
            params: &params,
            ..self.of_hole(&widened.mesh, &holes, &all)
        };
        let smooth = problem.faired()?.patch;
        widened.distance(&smooth.positions, &smooth.faces)
    }
}

/// The hole of a widened mesh whose rim consists almost only of vertices of removed faces; none unless there is exactly one.
fn widened_hole(holes: Vec<Hole>, rest: &Part, removed: &[u32]) -> Option<Hole> {
    let is_removed = |v: &&u32| {
        removed
            .binary_search(&rest.vertices()[**v as usize])
            .is_ok()
    };
    let is_it = |h: &Hole| {
        let own = h.rim.iter().filter(is_removed).count();
        own as f64 > SAME_RIM.get() * h.rim.len() as f64
    };
    let mut own = holes.into_iter().filter(is_it);
    match (own.next(), own.next()) {
        (Some(hole), None) => Some(hole),
        _ => None,
    }
}

/// A hole with the faces around it removed.
pub(super) struct WidenedHole {
    pub(super) mesh: Mesh,
    topology: Topology,
    pub(super) hole: Hole,
    /// Positions of the removed vertices.
    points: Vec<DVec3>,
}

impl WidenedHole {
    /// Root mean square distance of the removed vertices from a patch; none where no vertex was removed.
    pub(super) fn distance(&self, new: &[DVec3], faces: &[[u32; 3]]) -> Option<f64> {
        let patch = Mesh::new([&self.mesh.positions, new].concat(), faces.to_vec());
        let tree = Bvh::new(&patch, 0..faces.len() as u32);
        self.root_mean_square(|p| {
            tree.closest(p, f64::INFINITY)
                .map_or(f64::INFINITY, |c| c.distance)
        })
    }

    /// Root mean square of a distance of the removed vertices; none where no vertex was removed.
    pub(super) fn root_mean_square(&self, distance: impl Fn(DVec3) -> f64) -> Option<f64> {
        let sum: f64 = self.points.iter().map(|p| distance(*p).powi(2)).sum();
        (!self.points.is_empty()).then(|| (sum / self.points.len() as f64).sqrt())
    }
}
