//! The step that candidates share: their patch finished on its own triangles.

use glam::DVec3;

use super::candidate::{FinishReport, FinishedPatch, PatchStart};
use super::params::Finish;
use super::problem::RegionProblem;
use super::so_far::{Made, SoFar};
use crate::cancel::Cancel;
use crate::finish::{FinishFound, FinishMethod, FinishParams, Surroundings, finish};
use crate::mesh::{Mesh, Part, bounds};
use crate::stitch::{Patch, count_intersecting};
use crate::tuning::tuning;

/// The part of the mesh round a patch, with the patch in it.
pub(super) struct Local {
    pub(super) part: Part,
    /// Number of vertices of the whole mesh.
    pub(super) count: usize,
    /// The part and the patch's faces and vertices behind its own.
    joined: Mesh,
    cancel: Cancel,
}

impl Local {
    /// With a patch whose faces have the whole mesh's numbers.
    pub(super) fn new(part: Part, count: usize, patch: &Patch, cancel: &Cancel) -> Self {
        let local = |f: &[u32; 3]| f.map(|v| part.local_or_new(v, count));
        let faces: Vec<[u32; 3]> = patch.faces.iter().map(local).collect();
        Self::of_part(part, count, (&patch.positions, &faces), cancel)
    }

    /// With a patch whose faces have the part's numbers.
    pub(super) fn of_part(
        part: Part,
        count: usize,
        (positions, faces): (&[DVec3], &[[u32; 3]]),
        cancel: &Cancel,
    ) -> Self {
        let joined = part.mesh.clone();
        let mut local = Self {
            part,
            count,
            joined,
            cancel: cancel.clone(),
        };
        local.set_patch(positions, faces);
        local
    }

    /// Takes another patch in the place of its own.
    pub(super) fn set_patch(&mut self, positions: &[DVec3], faces: &[[u32; 3]]) {
        let own = &self.part.mesh;
        self.joined.positions.truncate(own.positions.len());
        self.joined.faces.truncate(own.faces.len());
        self.joined.positions.extend_from_slice(positions);
        self.joined.faces.extend_from_slice(faces);
    }

    /// What is round the patch, and which vertices are not its own.
    pub(super) fn around(&self) -> Surroundings<'_> {
        let own = self.part.mesh.positions.len();
        Surroundings::new(&self.joined, |v| (v as usize) < own).stopped_by(&self.cancel)
    }

    /// The numbers of the patch's own vertices.
    pub(super) fn new_vertices(&self) -> Vec<u32> {
        (self.part.mesh.positions.len() as u32..self.joined.positions.len() as u32).collect()
    }

    /// The patch's own vertices, each in the middle of its neighbours.
    pub(super) fn evened(&self) -> Vec<(u32, DVec3)> {
        let own = self.part.mesh.positions.len();
        let mut sums = vec![(DVec3::ZERO, 0.0); self.joined.positions.len() - own];
        for f in self.new_faces() {
            for k in 0..3 {
                if let Some(at) = (f[k] as usize).checked_sub(own) {
                    sums[at].0 += self.at(f[(k + 1) % 3]) + self.at(f[(k + 2) % 3]);
                    sums[at].1 += 2.0;
                }
            }
        }
        let all = (own as u32..).zip(sums);
        all.map(|(v, (sum, count))| (v, sum / f64::max(count, 1.0)))
            .collect()
    }

    fn at(&self, vertex: u32) -> DVec3 {
        self.joined.positions[vertex as usize]
    }

    pub(super) fn new_faces(&self) -> &[[u32; 3]] {
        &self.joined.faces[self.part.mesh.faces.len()..]
    }

    /// Number of the patch's faces that intersect others, were its vertices there.
    pub(super) fn crossing(&self, positions: &[DVec3]) -> usize {
        count_intersecting(&self.part.mesh, positions, self.new_faces())
    }

    /// Gives a patch of the part the whole mesh's numbers.
    pub(super) fn to_whole(&self, mut patch: Patch) -> Patch {
        for f in &mut patch.faces {
            *f = f.map(|v| self.part.original(v, self.count));
        }
        patch
    }
}

/// Expected cost of the finish of a patch with so many faces.
pub(super) fn cost(faces: usize) -> f64 {
    tuning().fill.finish_cost * faces as f64
}

/// Finishes the best patch of a level set.
pub(super) fn make(problem: &RegionProblem<'_>, so_far: &SoFar<'_>) -> Made {
    let patch = so_far.best_joined().map(|(patch, _)| patch.clone());
    let patch = patch.unwrap_or_default();
    Made::Finished(match problem.is_finished() {
        true => problem.finished(patch, PatchStart::LevelSet),
        false => FinishedPatch::unfinished(patch),
    })
}

impl RegionProblem<'_> {
    /// Whether its patch is finished.
    pub(super) fn is_finished(&self) -> bool {
        self.params.finishes() && self.reference.is_none()
    }

    /// Moves the vertices of a patch to where the finish has them. What crosses more than before is not taken, but the step
    /// before.
    pub(super) fn finished(&self, mut patch: Patch, start: PatchStart) -> FinishedPatch {
        // The patch and as much of the mesh round it as the finish looks at.
        let count = self.mesh.positions.len();
        let local = Local::new(self.wide_part(&patch), count, &patch, self.cancel);
        let own = local.part.mesh.positions.len();
        let around = local.around();
        let mut params = FinishParams::default();
        if self.params.finish == Finish::Willmore {
            params.method = FinishMethod::Willmore;
        }
        // Two results: the blend with what the surroundings predict, and the minimum of the energy, which replaces it if
        // the blend intersects more faces. Connected components of the patch are finished one by one.
        let (mut blend, mut minimum) = (patch.positions.clone(), patch.positions.clone());
        let mut expected_error = vec![None; patch.positions.len()];
        let mut report = FinishReport {
            start,
            pieces: Vec::new(),
        };
        for piece in around.pieces(local.new_faces()) {
            let done = finish(&around, &piece, &params);
            for (i, &v) in done.vertices.iter().enumerate() {
                let at = v as usize - own;
                blend[at] = done.positions[i];
                minimum[at] = *done.minimum.get(i).unwrap_or(&done.positions[i]);
                expected_error[at] = done
                    .expected_error
                    .get(i)
                    .copied()
                    .filter(|s| s.is_finite());
            }
            report.pieces.push(done.found);
        }
        // After a cancellation the patch keeps its positions and has no expected errors.
        if self.cancel.is_cancelled() {
            expected_error.fill(None);
            let report = Some(report);
            return FinishedPatch {
                patch,
                report,
                expected_error,
            };
        }
        // The first of the two that intersects no more faces than the patch did before is taken.
        let before = patch.report.intersecting_faces;
        let fits = |positions: &[DVec3]| {
            let crossing = local.crossing(positions);
            (crossing <= before).then_some(crossing)
        };
        let taken = match fits(&blend) {
            Some(crossing) => Some((blend, crossing)),
            None => {
                report.pieces.iter_mut().for_each(FinishFound::refuse_blend);
                fits(&minimum).map(|crossing| (minimum, crossing))
            }
        };
        // Quality and seam angles are measured at the new positions; if both results were refused, the patch stays.
        if let Some((positions, crossing)) = taken {
            patch.positions = positions;
            patch.report.intersecting_faces = crossing;
            let whole = |f: &[u32; 3]| f.map(|v| local.part.original(v, local.count));
            patch.measure(self.mesh, local.part.mesh.faces.iter().map(whole));
        } else {
            report.pieces.iter_mut().for_each(FinishFound::refuse_all);
            expected_error.fill(None);
        }
        FinishedPatch {
            patch,
            report: Some(report),
            expected_error,
        }
    }

    /// The part of the mesh round the rims and a patch.
    pub(super) fn wide_part(&self, patch: &Patch) -> Part {
        let rim = || self.holes.iter().flat_map(|h| &h.rim).copied();
        let (low, high) = bounds(rim().map(|v| self.mesh.positions[v as usize]));
        let margin = DVec3::splat(tuning().fill.rim_reach * low.distance(high));
        let (lowest, highest) = bounds(patch.positions.iter().copied());
        let (low, high) = (low - margin, high + margin);
        self.all.part(low.min(lowest), high.max(highest), rim())
    }
}
