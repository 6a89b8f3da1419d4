//! Candidate: flat sides round a rim with rounded edges between them, the rounding continued across the hole; made only where that predicts
//! the faces round the hole much better than a smooth patch does.

use super::faired;
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use super::sharp::{CLEARLY_BETTER, RINGS, SURE};
use super::sides_error::of_rounded;
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
        let error = error.map(|[own, _]| of_rounded(own, hole.diameter));
        self.closed_by_sides(&local, patch, Vec::new(), error).ok()
    }

    /// The errors with which rounded edges and a smooth patch predict the rings of faces round the hole; none where no ring can be taken out.
    fn rounded_error(&self, part: &Part, rim: &[u32]) -> Option<[f64; 2]> {
        RINGS.into_iter().find_map(|rings| {
            let widened = self.widened(part, rim, rings)?;
            let around = VertexFaces::new(&widened.mesh);
            let model = Rounded::find(&widened.mesh, &around, &widened.hole.rim)?;
            let own = widened.root_mean_square(|p| model.onto(p).distance(p))?;
            Some([own, self.smooth_error(&widened)?])
        })
    }
}
