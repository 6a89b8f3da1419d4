//! Grain: adds random roughness to the patch of a region, as rough as its surroundings.

use super::finish_step::Local;
use super::invented::GrainReport;
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use crate::finish::grain;
use crate::stitch::Patch;

/// Upper bound of the number of times that the grain is halved because more faces would intersect; after that it is omitted.
const HALVINGS: usize = 3;

impl RegionProblem<'_> {
    /// Adds grain to the patch of a region if it is requested and the patch is a computed smooth surface.
    pub(super) fn with_grain(&self, mut filled: RegionPatch) -> RegionPatch {
        let is_smooth = self.decided.is_none() && self.is_finished();
        if !self.params.grain || !is_smooth || filled.mesh.positions.is_empty() {
            return filled;
        }
        if filled
            .report
            .counterpart
            .as_ref()
            .is_some_and(|c| c.refused.is_none())
        {
            // A counterpart has its own roughness.
            return filled;
        }
        let patch = Patch {
            positions: filled.mesh.positions.clone(),
            faces: filled.mesh.faces.clone(),
            ..Patch::default()
        };
        let count = self.mesh.positions.len();
        let local = Local::new(self.wide_part(&patch), count, &patch, self.cancel);
        let own = local.part.mesh.positions.len();
        let around = local.around();
        // Grain for each component, and the mean squares of roughness of rings and patches.
        let mut shifts = Vec::new();
        let mut squares = [0.0; 2];
        for component in around.patches(local.new_faces()) {
            if let Some(found) = grain(&around, &component) {
                let weight = component.len() as f64;
                (0..2).for_each(|k| squares[k] += weight * found.roughness[k].powi(2));
                shifts.extend(found.shifts);
            }
        }
        if shifts.is_empty() || self.cancel.is_cancelled() {
            return filled;
        }
        let [ring, rough] = squares.map(|s| (s / shifts.len() as f64).sqrt());
        // Halve the grain until no more faces intersect than without it.
        let before = local.count_intersecting(&patch.positions);
        let mut part = 1.0;
        for _ in 0..=HALVINGS {
            let mut positions = patch.positions.clone();
            for (v, shift) in &shifts {
                positions[*v as usize - own] += part * *shift;
            }
            if local.count_intersecting(&positions) <= before {
                filled.mesh.positions = positions;
                filled.report.grain = Some(GrainReport {
                    ring,
                    patch: part * rough,
                    part,
                });
                return filled;
            }
            part *= 0.5;
        }
        filled.report.grain = Some(GrainReport {
            ring,
            ..GrainReport::default()
        });
        filled
    }
}
