//! Candidate: flat sides round a rim with rounded edges between them, the rounding continued across the hole; made only where that predicts
//! the faces round the hole much better than a smooth patch does.

use super::candidate::FinishedPatch;
use super::faired;
use super::outcome::{ClosedBy, HoleOutcome};
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use super::sharp::{CLEARLY_BETTER, RINGS, SURE, WidenedHole};
use super::so_far::Made;
use crate::creases::Rounded;
use crate::finish::biharmonic;
use crate::mesh::{Part, VertexFaces};
use crate::stitch::Patch;

/// How often a patch is moved onto the surface and its vertices evened out on it.
const ROUNDS: usize = 10;

/// Expected cost: that of the smooth patch with which its prediction is compared.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    faired::cost(problem)
}

/// The region closed by rounded edges between its sides.
pub(super) fn make(problem: &RegionProblem<'_>) -> Made {
    problem.rounded().into()
}

impl RegionProblem<'_> {
    /// The region closed by rounded edges between its sides; none where there are none, a smooth patch predicts the faces round the hole as well,
    /// or the patch intersects anything.
    fn rounded(&self) -> Option<RegionPatch> {
        let [hole] = self.holes else {
            return None;
        };
        let part = self.wide_part(&Patch::default());
        let rim: Vec<u32> = hole.rim.iter().map(|&v| part.local(v)).collect();
        let model = Rounded::find(&part.mesh, &VertexFaces::new(&part.mesh), &rim)?;
        let error = self.rounded_error(&part, &rim);
        let is_better = match error {
            Some([own, smooth]) => own < CLEARLY_BETTER * smooth,
            None => model.residual < SURE,
        };
        log::debug!(
            "hole {}: rounded edges of radius {:.4}, residual {:.3}, predicted {error:.4?}",
            hole.id.get(),
            model.radius,
            model.residual
        );
        is_better.then_some(())?;
        let (mut local, mut patch) = self.spanned(hole, biharmonic)?;
        for _ in 0..ROUNDS {
            let own = local.part.mesh.positions.len();
            for (v, p) in local.evened() {
                patch.positions[v as usize - own] = model.onto(p);
            }
            local.set_patch(&patch.positions, &patch.faces);
        }
        patch.report.intersecting_faces = local.crossing(&patch.positions);
        (patch.report.intersecting_faces == 0).then_some(())?;
        patch.report.components = 1;
        let count = self.mesh.positions.len();
        let mut patch = local.to_whole(patch);
        let whole = |f: &[u32; 3]| f.map(|v| local.part.original(v, count));
        patch.measure(self.mesh, local.part.mesh.faces.iter().map(whole));
        let report = RegionReport {
            diameter: self.diameter(),
            closed_by: Some(ClosedBy::Sides),
            ..RegionReport::default()
        };
        let mut finished = FinishedPatch::unfinished(patch);
        finished.sigma.fill(error.map(|[own, _]| own));
        Some(self.all_finished(finished, report, HoleOutcome::Filled))
    }

    /// The errors with which rounded edges and a smooth patch predict the rings of faces round the hole; none where no ring can be taken out.
    fn rounded_error(&self, part: &Part, rim: &[u32]) -> Option<[f64; 2]> {
        RINGS.into_iter().find_map(|rings| {
            let widened = self.widened(part, rim, rings)?;
            let around = VertexFaces::new(&widened.mesh);
            let model = Rounded::find(&widened.mesh, &around, &widened.hole.rim)?;
            Some([distance(&model, &widened)?, self.smooth_error(&widened)?])
        })
    }
}

/// Root mean square distance of the vertices that were taken out from rounded edges; none where there are none.
fn distance(model: &Rounded, widened: &WidenedHole) -> Option<f64> {
    let squares = widened
        .points
        .iter()
        .map(|p| model.onto(*p).distance_squared(*p));
    let mean = squares.sum::<f64>() / widened.points.len() as f64;
    (!widened.points.is_empty()).then(|| mean.sqrt())
}
