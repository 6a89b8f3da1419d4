//! The finish of a candidate's patch on its own triangles: a step that all candidates share.

use glam::DVec3;

use super::RIM_REACH;
use super::candidate::{FinishReport, FinishedPatch, PatchInitialisation};
use super::params::Finish;
use super::problem::RegionProblem;
use super::so_far::{Made, SoFar};
use crate::cancel::Cancel;
use crate::finish::{FinishMethod, FinishParams, FinishRecord, Surroundings, finish};
use crate::mesh::{Mesh, Part, VertexFaces, bounds, vertex_normal};
use crate::stitch::{Patch, count_intersecting};
use crate::tuning::{Tunable, tunable};

/// Unknowns times steps, per face. Expected cost of a finish: 0.13 ms on 274 holes of scans and models.
const FINISH_COST: Tunable<f64> = tunable("fill.finish_cost", 21.0);

/// The part of the mesh around a patch, with the patch appended.
pub(super) struct Local {
    pub(super) part: Part,
    /// Number of vertices of the whole mesh.
    pub(super) count: usize,
    /// The part's vertices and faces, then the patch's.
    joined: Mesh,
    cancel: Cancel,
}

impl Local {
    /// From a patch whose faces use the whole mesh's vertex numbers.
    pub(super) fn new(part: Part, count: usize, patch: &Patch, cancel: &Cancel) -> Self {
        let local = |f: &[u32; 3]| f.map(|v| part.local_or_new(v, count));
        let faces: Vec<[u32; 3]> = patch.faces.iter().map(local).collect();
        Self::of_part(part, count, (&patch.positions, &faces), cancel)
    }

    /// From a patch whose faces use the part's vertex numbers.
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

    /// Replaces the patch.
    pub(super) fn set_patch(&mut self, positions: &[DVec3], faces: &[[u32; 3]]) {
        let own = &self.part.mesh;
        self.joined.positions.truncate(own.positions.len());
        self.joined.faces.truncate(own.faces.len());
        self.joined.positions.extend_from_slice(positions);
        self.joined.faces.extend_from_slice(faces);
    }

    /// The joined mesh for the finish; the part's vertices are known, the patch's are not.
    pub(super) fn around(&self) -> Surroundings<'_> {
        let own = self.part.mesh.positions.len();
        Surroundings::new(&self.joined, |v| (v as usize) < own).stopped_by(&self.cancel)
    }

    /// The numbers of the patch's own vertices.
    pub(super) fn new_vertices(&self) -> Vec<u32> {
        (self.part.mesh.positions.len() as u32..self.joined.positions.len() as u32).collect()
    }

    /// The patch's vertices and their normals.
    pub(super) fn vertices(&self) -> Vec<(DVec3, DVec3)> {
        let around = VertexFaces::new(&self.joined);
        let vertex = |v: u32| (self.at(v), vertex_normal(&self.joined, &around, v));
        self.new_vertices().into_iter().map(vertex).collect()
    }

    /// New positions of the patch's vertices: each at the mean of its neighbours.
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

    /// The patch alone, in the joined mesh's vertex numbers.
    pub(super) fn patch(&self) -> Mesh {
        Mesh::new(self.joined.positions.clone(), self.new_faces().to_vec())
    }

    fn at(&self, vertex: u32) -> DVec3 {
        self.joined.positions[vertex as usize]
    }

    pub(super) fn new_faces(&self) -> &[[u32; 3]] {
        &self.joined.faces[self.part.mesh.faces.len()..]
    }

    /// Number of the patch's faces that intersect others if its vertices are at these positions.
    pub(super) fn count_intersecting(&self, positions: &[DVec3]) -> usize {
        count_intersecting(&self.part.mesh, positions, self.new_faces())
    }

    /// Converts a patch of the part to the whole mesh's vertex numbers.
    pub(super) fn to_whole(&self, mut patch: Patch) -> Patch {
        for f in &mut patch.faces {
            *f = f.map(|v| self.part.original(v, self.count));
        }
        patch
    }
}

/// Expected cost of the finish of a patch with this number of faces, in unknowns times steps.
pub(super) fn cost(faces: usize) -> f64 {
    FINISH_COST.get() * faces as f64
}

/// Finishes the best joined patch of the level sets.
pub(super) fn make(problem: &RegionProblem<'_>, so_far: &SoFar<'_>) -> Made {
    let patch = so_far.best_joined().map(|(patch, _)| patch.clone());
    let patch = patch.unwrap_or_default();
    Made::Finished(match problem.is_finished() {
        true => problem.finished(patch, PatchInitialisation::LevelSet),
        false => FinishedPatch::unfinished(patch),
    })
}

impl RegionProblem<'_> {
    /// Whether the region's patch is finished.
    pub(super) fn is_finished(&self) -> bool {
        self.params.finishes() && self.reference.is_none()
    }

    /// The parameters of the finish.
    fn finish_params(&self) -> FinishParams {
        let mut params = FinishParams::default();
        if self.params.finish == Finish::Willmore {
            params.method = FinishMethod::Willmore;
        }
        params
    }

    /// Finishes a patch. A result that intersects more faces than the patch did is refused: the minimum of the energy replaces
    /// the blend, the original patch replaces the minimum.
    pub(super) fn finished(&self, mut patch: Patch, start: PatchInitialisation) -> FinishedPatch {
        // The patch and the part of the mesh around it that the finish uses.
        let count = self.mesh.positions.len();
        let local = Local::new(self.wide_part(&patch), count, &patch, self.cancel);
        let own = local.part.mesh.positions.len();
        let around = local.around();
        let params = self.finish_params();
        // Two results: the blend with what the surroundings predict, and the minimum of the energy. Components of the patch are
        // finished one by one.
        let (mut blend, mut minimum) = (patch.positions.clone(), patch.positions.clone());
        let mut expected_error = vec![None; patch.positions.len()];
        let mut report = FinishReport {
            initialisation: start,
            components: Vec::new(),
        };
        for vertices in around.patches(local.new_faces()) {
            let done = finish(&around, &vertices, &params);
            for (i, &v) in done.vertices.iter().enumerate() {
                let at = v as usize - own;
                blend[at] = done.positions[i];
                minimum[at] = *done.minimum.get(i).unwrap_or(&done.positions[i]);
                let error = done.expected_error.get(i).copied();
                expected_error[at] = error.filter(|s| s.is_finite());
            }
            report.components.push(done.found);
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
        // The first of the two results that intersects no more faces than the patch did before is taken.
        let before = patch.report.intersecting_faces;
        let fits = |positions: &[DVec3]| {
            let intersecting = local.count_intersecting(positions);
            (intersecting <= before).then_some(intersecting)
        };
        let taken = match fits(&blend) {
            Some(intersecting) => Some((blend, intersecting)),
            None => {
                report.refuse(FinishRecord::refuse_blend);
                fits(&minimum).map(|intersecting| (minimum, intersecting))
            }
        };
        // Quality and seam angles are measured at the new positions. If both results were refused, the patch stays.
        let taken = taken.filter(|_| !self.cancel.is_cancelled());
        if let Some((positions, intersecting)) = taken {
            patch.positions = positions;
            patch.report.intersecting_faces = intersecting;
            let whole = |f: &[u32; 3]| f.map(|v| local.part.original(v, local.count));
            patch.measure(self.mesh, local.part.mesh.faces.iter().map(whole));
        } else {
            report.refuse(FinishRecord::refuse_all);
            expected_error.fill(None);
        }
        FinishedPatch {
            patch,
            report: Some(report),
            expected_error,
        }
    }

    /// The part of the mesh around the rims and a patch, wide enough for the finish.
    pub(super) fn wide_part(&self, patch: &Patch) -> Part {
        let rim = || self.holes.iter().flat_map(|h| &h.rim).copied();
        let (low, high) = bounds(rim().map(|v| self.mesh.positions[v as usize]));
        let margin = DVec3::splat(RIM_REACH.get() * low.distance(high));
        let (lowest, highest) = bounds(patch.positions.iter().copied());
        let (low, high) = (low - margin, high + margin);
        self.all.part(low.min(lowest), high.max(highest), rim())
    }
}
