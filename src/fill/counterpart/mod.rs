//! Candidate: the part of a counterpart, the mirrored mesh or a template, that lies where the hole is; joined to the rim by a smooth field of
//! offsets, and made only where it predicts the faces round the hole.

mod align;
mod find;
mod judge;
mod motion;
mod placed;
mod surface;

use glam::DVec3;

use super::candidate::FinishedPatch;
use super::faired;
use super::invented::{CounterpartReport, NotLike};
use super::outcome::{ClosedBy, HoleOutcome};
use super::problem::{RegionPlan, RegionProblem};
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::sharp::{RINGS, WidenedHole};
use super::so_far::{Made, SoFar};
use crate::cancel::Cancel;
use crate::mesh::Part;
use crate::stitch::Patch;

pub(crate) use placed::{Counterpart, PlacedPart};

use judge::{Collar, Fitted};
use surface::CounterpartSurface;

/// Upper bound of the ratio of its error on the rings to the error of a smooth patch, where the counterpart has in the hole what a smooth patch
/// has not: its own vertices are as noisy as the rings' vertices, which makes 1.4.
const NOT_WORSE: f64 = 1.6;
/// The same where it has not: then it must be clearly better.
const CLEARLY_BETTER: f64 = 0.6;
/// What the counterpart has in the hole that a smooth patch has not, over its error on the rings: the least.
const FEATURE: f64 = 2.5;
/// The same over the smooth part of its misfit beside the hole. Surfaces that are not alike differ as much beside the hole as in it.
const BEYOND_MISFIT: f64 = 3.0;

/// Expected cost: the cost of the smooth patches with which it is compared, one of the hole and one of the hole with rings taken out.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    2.0 * faired::cost(problem)
}

/// The region closed by the counterpart; nothing where it does not prove itself. Keeps what was found.
pub(super) fn make(problem: &RegionProblem<'_>, so_far: &mut SoFar<'_>) -> Made {
    let (report, made) = problem.like();
    if let Some(why) = report.refused {
        log::debug!("region {}: no counterpart: {why}", problem.id);
    }
    so_far.counterpart = Some(report);
    made.map_or(Made::Nothing, Made::Region)
}

/// A part of the counterpart that was fitted to the hole.
struct Tested {
    fitted: Fitted,
    report: CounterpartReport,
}

impl RegionProblem<'_> {
    /// Whether a counterpart is looked for.
    pub(super) fn has_counterpart(&self) -> bool {
        let is_surface = self.plan == RegionPlan::Solve && self.is_finished();
        is_surface && self.counterparts.is_some()
    }

    /// The region closed by the counterpart that predicts the rings round the hole best, and what was found.
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
        let smooth = self.faired().map(|finished| finished.patch.positions);
        let Some(smooth) = smooth.filter(|points| !points.is_empty()) else {
            return refused(NotLike::Untested);
        };
        let around = self.wide_part(&Patch::default());
        let rings = RINGS.iter().find_map(|&n| self.rings(&around, n));
        // Of several planes or poses the one with the least error on the rings; those that are refused count last.
        let mut best: Option<Tested> = None;
        let (mut why, mut rest) = (None, None);
        for (number, part) in parts.iter().enumerate() {
            match self.tested(part, &around, rings.as_ref(), &smooth) {
                Ok(tested) => {
                    let order = |t: &Tested| (t.report.refused.is_some(), t.report.ring_error);
                    if best.as_ref().is_none_or(|b| order(&tested) < order(b)) {
                        best = Some(tested);
                    }
                }
                Err(report) if number == 0 => why = Some(*report),
                Err(report) => rest = rest.or(Some(*report)),
            }
        }
        // Where none is used, the reason given is the first one's, which fits the whole mesh best.
        let (fitted, mut report) = match (best, why) {
            (Some(best), None) if best.report.refused.is_some() => return (best.report, None),
            (Some(best), why) if best.report.refused.is_some() => {
                return (why.unwrap_or(best.report), None);
            }
            (Some(best), _) => (best.fitted, best.report),
            (None, why) => return (why.or(rest).unwrap_or_default(), None),
        };
        match self.closed_like(&fitted, &report) {
            Ok(region) => (report, Some(region)),
            Err(why) => {
                report.refused = Some(why);
                (report, None)
            }
        }
    }

    /// How well a part of the counterpart fits the hole; `smooth` are vertices of a smooth patch of it.
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
        report.misfit = Some(fitted.misfit);
        let squares: f64 = smooth.iter().map(|p| fitted.distance(*p).powi(2)).sum();
        let feature = (squares / smooth.len() as f64).sqrt();
        report.feature = Some(feature);
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
        let most = match feature > FEATURE * own {
            true => NOT_WORSE,
            false => CLEARLY_BETTER,
        };
        report.refused = if own > most * other {
            Some(NotLike::Predicted)
        } else if feature < BEYOND_MISFIT * fitted.smooth_misfit {
            Some(NotLike::Alike)
        } else {
            None
        };
        Ok(Tested { fitted, report })
    }

    /// The hole with a number of its innermost rings of faces taken out; none where that leaves no single hole, or no smooth patch of it can
    /// be made.
    fn rings(&self, around: &Part, rings: u32) -> Option<Rings> {
        let rim: Vec<u32> = self.holes[0].rim.iter().map(|&v| around.local(v)).collect();
        let widened = self.widened(around, &rim, rings)?;
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
        let patch = self.stitch_exact(edge, &surface, &fitted.mesh);
        let patch = patch.map_err(|error| {
            log::debug!("region {}: counterpart: {error}", self.id);
            NotLike::NotJoined
        })?;
        if patch.report.intersecting_faces > 0 {
            return Err(NotLike::Intersects(patch.report.intersecting_faces));
        }
        let report = RegionReport {
            diameter: self.diameter(),
            closed_by: Some(ClosedBy::Counterpart),
            ..RegionReport::default()
        };
        // Beside its error on the rings, what the field may be off.
        let ring = found.ring_error.unwrap_or(0.0);
        let error = |p: &DVec3| Some(ring.hypot(fitted.field.deviation(*p)));
        let expected_error = patch.positions.iter().map(error).collect();
        let mut finished = FinishedPatch::unfinished(patch);
        finished.expected_error = expected_error;
        Ok(self.all_finished(finished, report, HoleOutcome::Filled))
    }
}

/// A hole with rings of faces taken out, which are to be predicted.
struct Rings {
    widened: WidenedHole,
    collar: Collar,
    /// Root mean square error with which a smooth patch predicts them.
    smooth: f64,
}

impl Rings {
    /// The same of a part of a counterpart, which is fitted to what is left round the hole.
    fn error(&self, part: &PlacedPart, cancel: &Cancel) -> Option<f64> {
        let fitted = self.collar.fitted(part, cancel).ok()?;
        self.widened.root_mean_square(|p| fitted.distance(p))
    }
}

impl Fitted {
    /// Whether it has no hole of its own where the patch is to be.
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
        match (open as f64) < MOST_OPEN * smooth.len() as f64 {
            true => Ok(()),
            false if 2 * own > open => Err(NotLike::Own),
            false => Err(NotLike::Open),
        }
    }
}

/// Part of a smooth patch's vertices whose nearest points on the counterpart may lie on a border of it: its small holes are closed when it is
/// joined.
const MOST_OPEN: f64 = 0.02;
