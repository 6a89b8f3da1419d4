//! Candidate: flat sides around a rim, with the rounded edges between them continued across the hole. Made only where that
//! predicts the faces around the hole much better than a smooth patch.

use super::faired;
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use super::sharp::{CLEARLY_BETTER, RINGS, SURE};
use super::sides_error::of_rounded;
use super::so_far::{Made, SoFar};
use crate::creases::Rounded;
use crate::finish::biharmonic;
use crate::mesh::{Part, VertexFaces};
use crate::stitch::Patch;
use crate::tuning::{Tunable, tunable};

/// Rounds in which the patch's vertices are evened out and projected onto the surface.
const ROUNDS: Tunable<usize> = tunable("fill.rounded.rounds", 10);

/// Edges. Where the smooth sides around a rim have larger residuals, no model is fitted. On 135 holes of solids the sides around accepted
/// models had residuals of at most 0.061; on half of 141 holes of scans they have more than 0.11.
const MOST_NOISE: Tunable<f64> = tunable("fill.rounded.most_noise", 0.1);

/// Expected cost: as the smooth patch that its prediction is compared with.
pub(super) fn cost(problem: &RegionProblem<'_>) -> f64 {
    faired::cost(problem)
}

/// Closes the region by rounded edges between its flat sides.
pub(super) fn make(problem: &RegionProblem<'_>, so_far: &SoFar<'_>) -> Made {
    match so_far.noise < MOST_NOISE.get() {
        true => problem.rounded().into(),
        false => Made::Nothing,
    }
}

impl RegionProblem<'_> {
    /// The region closed by rounded edges between its flat sides; none where there are none, a smooth patch predicts the faces
    /// around the hole about as well, or the patch intersects anything.
    fn rounded(&self) -> Option<RegionPatch> {
        let [hole] = self.holes else {
            return None;
        };
        let part = self.wide_part(&Patch::default());
        let rim: Vec<u32> = hole.rim.iter().map(|&v| part.local(v)).collect();
        let model = Rounded::find(&part.mesh, &VertexFaces::new(&part.mesh), &rim, self.cancel)?;
        // On 135 holes of solids accepted models had residuals of at most 0.042 edges; on scans and noisy surfaces models had at least
        // 0.05, and were refused.
        (model.residual < SURE.get()).then_some(())?;
        let error = self.rounded_error(&part, &rim);
        let is_better = error.is_none_or(|[own, smooth]| own < CLEARLY_BETTER.get() * smooth);
        log::debug!(
            "hole {}: rounded edges of radius {:.4}, residual {:.3}, predicted {error:.4?}",
            hole.id.get(),
            model.radius,
            model.residual
        );
        is_better.then_some(())?;
        let (mut local, mut patch) = self.spanned(hole, biharmonic)?;
        for _ in 0..ROUNDS.get() {
            let own = local.part.mesh.positions.len();
            for (v, p) in local.evened() {
                patch.positions[v as usize - own] = model.onto(p);
            }
            local.set_patch(&patch.positions, &patch.faces);
        }
        let error = error.map(|[own, _]| of_rounded(own, hole.diameter));
        self.closed_by_sides(&local, patch, Vec::new(), &|_| error)
            .ok()
    }

    /// The errors with which rounded edges and a smooth patch predict the rings of faces around the hole; none where no ring can
    /// be removed.
    fn rounded_error(&self, part: &Part, rim: &[u32]) -> Option<[f64; 2]> {
        RINGS.into_iter().find_map(|rings| {
            let widened = self.widened(&part.mesh, rim, rings)?;
            let around = VertexFaces::new(&widened.mesh);
            let model = Rounded::find(&widened.mesh, &around, &widened.hole.rim, self.cancel)?;
            let own = widened.root_mean_square(|p| model.onto(p).distance(p))?;
            Some([own, self.smooth_error(&widened)?])
        })
    }
}
