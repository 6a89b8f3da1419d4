//! Candidate: the part of a counterpart (the mirrored mesh or a template) at the hole, joined to the rim by a smooth field of offsets. It
//! is used only if it predicts the faces round the hole.

mod align;
mod find;
mod judge;
mod motion;
pub(super) mod placed;
mod surface;
pub(super) mod weighed;

use glam::DVec3;

use super::candidate::FinishedPatch;
use super::closure::Closure;
use super::faired;
use super::invented::{CounterpartReport, NotLike};
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::sharp::{RINGS, WidenedHole};
use super::so_far::{Made, SoFar};
use crate::cancel::Cancel;
use crate::elementary::hypot;
use crate::mesh::{DisjointSets, Mesh, Part};
use crate::stitch::Patch;
use crate::tuning::{Tunable, tunable};

pub(crate) use placed::{Counterpart, PlacedPart};

use judge::{Collar, Fitted};
use surface::CounterpartSurface;

/// Upper bound of the counterpart's error on the rings over a smooth patch's error, if the counterpart has a feature in the hole: its
/// vertices are as noisy as the rings', which alone gives √2.
const NOT_WORSE: Tunable<f64> = tunable("fill.counterpart.not_worse", 1.6);
/// The same bound without a feature: then it must be clearly better.
const CLEARLY_BETTER: Tunable<f64> = tunable("fill.counterpart.clearly_better", 0.6);
/// Distance of the counterpart from a smooth patch in the hole, over its error on the rings: up to the first it has no feature, from the
/// second on it has one. Between them the bound is interpolated.
const FEATURE: [f64; 2] = [1.2, 2.5];
/// Upper bound of the fraction of the patch's vertices that are off the counterpart by more than its error on the rings and an edge.
const MOST_OFF: Tunable<f64> = tunable("fill.counterpart.most_off", 0.05);
/// Lower bound of that distance over the smooth misfit beside the hole. Dissimilar surfaces differ as much beside the hole as in it.
const BEYOND_MISFIT: Tunable<f64> = tunable("fill.counterpart.beyond_misfit", 3.0);
/// Upper bound of the fraction of a smooth patch's vertices whose closest points on the counterpart are on a boundary: small holes of it
/// are closed when it is joined.
const MOST_OPEN: Tunable<f64> = tunable("fill.counterpart.most_open", 0.02);

/// Expected cost: of two smooth patches to compare with, of the hole and of the hole without some rings of faces.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    2.0 * faired::cost(problem)
}

/// The region closed by the counterpart, or nothing if it is refused. Stores the report of the test.
pub(super) fn make(problem: &RegionProblem<'_>, so_far: &mut SoFar<'_>) -> Made {
    let (report, made) = problem.like();
    if let Some(why) = report.refused {
        log::debug!("region {}: no counterpart: {why}", problem.id);
    }
    so_far.counterpart = Some(report);
    made.map_or(Made::Nothing, Made::Region)
}

/// A part of the counterpart fitted to the hole, and the result of its test.
struct Tested {
    fitted: Fitted,
    report: CounterpartReport,
}

impl RegionProblem<'_> {
    /// Whether a counterpart that the caller asked for is a candidate.
    pub(super) fn has_counterpart(&self) -> bool {
        let is_surface = self.decided.is_none() && self.is_finished();
        is_surface && self.params.like.is_some() && self.counterparts.is_some()
    }

    /// The region closed by the counterpart that predicts the rings round the hole best, and the report of its test.
    fn like(&self) -> (CounterpartReport, Option<RegionPatch>) {
        let refused = |why| {
            let refused = Some(why);
            let report = CounterpartReport {
                refused,
                ..CounterpartReport::default()
            };
            (report, None)
        };
        let parts = self.counterparts.unwrap_or_default();
        if self.holes.len() != 1 {
            return refused(NotLike::SeveralRims);
        }
        if parts.is_empty() {
            return refused(NotLike::Nothing);
        }
        // Vertices of a smooth patch, and rings of faces for the test of prediction.
        let smooth = self.faired().map(|finished| finished.patch.positions);
        let Some(smooth) = smooth.filter(|points| !points.is_empty()) else {
            return refused(NotLike::Untested);
        };
        let around = self.wide_part(&Patch::default());
        let rings = RINGS.iter().find_map(|&n| self.rings(&around, n));
        // Of several planes or poses, choose the one with the least error on the rings; refused ones rank last.
        let mut best: Option<Tested> = None;
        let (mut first_refusal, mut other_refusal) = (None, None);
        for (number, part) in parts.iter().enumerate() {
            match self.tested(part, &around, rings.as_ref(), &smooth) {
                Ok(tested) => {
                    let order = |t: &Tested| (t.report.refused.is_some(), t.report.ring_error);
                    if best.as_ref().is_none_or(|b| order(&tested) < order(b)) {
                        best = Some(tested);
                    }
                }
                Err(report) if number == 0 => first_refusal = Some(*report),
                Err(report) => other_refusal = other_refusal.or(Some(*report)),
            }
        }
        // If none is used, the report is of the first one, which fits the whole mesh best, if that cannot be fitted to the hole; otherwise
        // of the one with the least error.
        let (fitted, mut report) = match (best, first_refusal) {
            (Some(best), first) if best.report.refused.is_some() => {
                return (first.unwrap_or(best.report), None);
            }
            (Some(best), _) => (best.fitted, best.report),
            (None, first) => return (first.or(other_refusal).unwrap_or_default(), None),
        };
        match self.closed_like(&fitted, &report) {
            Ok(region) => (report, Some(region)),
            Err(why) => {
                report.refused = Some(why);
                (report, None)
            }
        }
    }

    /// Fits a part of the counterpart to the hole and tests its prediction of the rings. `smooth` are the vertices of a smooth patch of
    /// the hole. An error is the report if it cannot be fitted.
    fn tested(
        &self,
        part: &PlacedPart,
        around: &Part,
        rings: Option<&Rings>,
        smooth: &[DVec3],
    ) -> Result<Tested, Box<CounterpartReport>> {
        let mut report = CounterpartReport {
            kind: Some(part.kind),
            ..CounterpartReport::default()
        };
        let hole = self.holes[0];
        let rim: Vec<u32> = hole.rim.iter().map(|&v| around.local(v)).collect();
        let collar = Collar::new(&around.mesh, &rim, hole.diameter);
        let fitted = collar.fitted(part, self.cancel).and_then(|fitted| {
            fitted.covers(part, smooth)?;
            Ok(fitted)
        });
        let fitted = fitted.map_err(|why| {
            Box::new(CounterpartReport {
                refused: Some(why),
                ..report.clone()
            })
        })?;
        // The feature: the distance of the smooth patch from the counterpart.
        report.misfit = Some(fitted.misfit);
        let squares: f64 = smooth.iter().map(|p| fitted.distance(*p).powi(2)).sum();
        let feature = (squares / smooth.len() as f64).sqrt();
        report.feature = Some(feature);
        // The errors with which the counterpart and a smooth patch predict the rings.
        let own = rings.and_then(|rings| Some([rings.error(part, self.cancel)?, rings.smooth]));
        let Some([own, other]) = own else {
            report.refused = Some(NotLike::Untested);
            return Ok(Tested { fitted, report });
        };
        (report.ring_error, report.smooth_ring_error) = (Some(own), Some(other));
        log::debug!(
            "region {}: counterpart {:?}: misfit {:.3e}, smooth {:.3e}, feature {feature:.3e}, rings {own:.3e}, smooth patch {other:.3e}",
            self.id,
            part.kind,
            fitted.misfit,
            fitted.smooth_misfit
        );
        // The test.
        let part = (feature / own - FEATURE[0]) / (FEATURE[1] - FEATURE[0]);
        let part = if part.is_finite() {
            part.clamp(0.0, 1.0)
        } else {
            1.0
        };
        let most = CLEARLY_BETTER.get() + part * (NOT_WORSE.get() - CLEARLY_BETTER.get());
        report.refused = if own > most * other {
            Some(NotLike::Predicted)
        } else if feature < BEYOND_MISFIT.get() * fitted.smooth_misfit {
            Some(NotLike::Alike)
        } else {
            None
        };
        Ok(Tested { fitted, report })
    }

    /// The hole without some of the innermost rings of faces round it; `None` if that leaves no single hole, or no smooth patch of it can
    /// be made.
    fn rings(&self, around: &Part, rings: u32) -> Option<Rings> {
        let rim: Vec<u32> = self.holes[0].rim.iter().map(|&v| around.local(v)).collect();
        let widened = self.widened(&around.mesh, &rim, rings)?;
        let hole = &widened.hole;
        Some(Rings {
            collar: Collar::new(&widened.mesh, &hole.rim, hole.diameter),
            smooth: self.smooth_error(&widened)?,
            widened,
        })
    }

    /// The region closed by a fitted counterpart, remeshed at the density of the surroundings.
    fn closed_like(
        &self,
        fitted: &Fitted,
        found: &CounterpartReport,
    ) -> Result<RegionPatch, NotLike> {
        let surface = CounterpartSurface::new(self, fitted);
        let rim = &self.holes[0].rim;
        let edge = self.holes[0].length / rim.len().max(1) as f64;
        let own = fitted.at_rim(rim.iter().map(|&v| self.mesh.positions[v as usize]));
        let patch = self.stitch_exact(edge, &surface, &own);
        let patch = patch.map_err(|error| {
            log::debug!("region {}: counterpart: {error}", self.id);
            NotLike::NotJoined
        })?;
        if patch.report.intersecting_faces > 0 {
            return Err(NotLike::Intersects(patch.report.intersecting_faces));
        }
        let ring = found.ring_error.unwrap_or(0.0);
        let is_off = |p: &&DVec3| fitted.distance(**p) > ring + edge;
        let off = patch.positions.iter().filter(is_off).count();
        if off as f64 > MOST_OFF.get() * patch.positions.len() as f64 {
            log::debug!("region {}: {off} vertices are off the counterpart", self.id);
            return Err(NotLike::NotJoined);
        }
        let report = RegionReport {
            diameter: self.diameter(),
            ..RegionReport::default()
        };
        // Combine the error on the rings with the standard deviation of the field.
        let error = |p: &DVec3| Some(hypot(ring, fitted.field.deviation(*p)));
        let expected_error = patch.positions.iter().map(error).collect();
        let mut finished = FinishedPatch::unfinished(patch);
        finished.expected_error = expected_error;
        Ok(self.all_finished(finished, report, Closure::Counterpart))
    }
}

/// A hole widened by removing rings of faces, whose vertices are to be predicted.
struct Rings {
    widened: WidenedHole,
    collar: Collar,
    /// Root mean square error with which a smooth patch predicts the removed vertices.
    smooth: f64,
}

impl Rings {
    /// Root mean square error of a part of a counterpart that is fitted to the faces round the widened hole.
    fn error(&self, part: &PlacedPart, cancel: &Cancel) -> Option<f64> {
        let fitted = self.collar.fitted(part, cancel).ok()?;
        self.widened.root_mean_square(|p| fitted.distance(p))
    }
}

impl Fitted {
    /// The connected components that are nearest to vertices of the rim: without the opposite walls of hollow bodies.
    fn at_rim(&self, rim: impl Iterator<Item = DVec3>) -> Mesh {
        let mut sets = DisjointSets::new(self.mesh.positions.len());
        for &[a, b, c] in &self.mesh.faces {
            sets.join(a, b);
            sets.join(a, c);
        }
        let nearest = rim.filter_map(|p| self.bvh.closest(p, f64::INFINITY));
        let mut found: Vec<u32> = nearest
            .map(|c| sets.find(self.mesh.faces[c.face as usize][0]))
            .collect();
        found.sort_unstable();
        found.dedup();
        let faces = self.mesh.faces.iter();
        let is_found = |f: &&[u32; 3]| found.contains(&sets.find(f[0]));
        Mesh::new(
            self.mesh.positions.clone(),
            faces.filter(is_found).copied().collect(),
        )
    }

    /// Refuses a counterpart that has a hole where the patch is needed.
    fn covers(&self, part: &PlacedPart, smooth: &[DVec3]) -> Result<(), NotLike> {
        let (mut open, mut own) = (0, 0);
        for p in smooth {
            let Some(closest) = self.bvh.closest(*p, f64::INFINITY) else {
                return Err(NotLike::Apart);
            };
            let face = self.mesh.faces[closest.face as usize];
            let used = (0..3).filter(|&k| closest.barycentric[k] != 0.0);
            let used: Vec<usize> = used.map(|k| face[k] as usize).collect();
            if used.len() < 3 && used.iter().all(|&v| part.border[v]) {
                open += 1;
                own += usize::from(used.iter().any(|&v| part.own_rim[v]));
            }
        }
        match (open as f64) < MOST_OPEN.get() * smooth.len() as f64 {
            true => Ok(()),
            false if 2 * own > open => Err(NotLike::Own),
            false => Err(NotLike::Open),
        }
    }
}
