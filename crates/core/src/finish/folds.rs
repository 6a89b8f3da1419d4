//! Folded faces of a patch: found, moved until they unfold, and watched for during a minimisation.

use std::collections::BTreeMap;

use glam::DVec3;

use super::geometry::{corners, vertex_normals};
use super::patch::Patch;
use crate::mesh::area_vector;
use crate::tuning::{Tunable, tunable};

/// Steps. A large patch may stay folded for this many steps in a row.
const MOST_FOLDED_STEPS: Tunable<usize> = tunable("finish.most_folded_steps", 3);

/// Times that the vertices of folded faces are moved to unfold them, at most.
const UNFOLDINGS: Tunable<usize> = tunable("finish.unfoldings", 10);

/// Cosine. A face is folded when the cosines between its normal and the normals at its corners are all below this. On
/// patches of scans this found all self-intersecting patches and no others.
const FOLDED_COSINE: Tunable<f64> = tunable("finish.folded_cosine", -0.2);

/// The number of folded faces of a patch: faces that point against the normals at all three of their vertices.
pub(super) fn folds(patch: &Patch, shape: &[DVec3]) -> usize {
    folded(patch, &patch.closure_points(shape)).len()
}

/// The folded faces, given the points of the closure.
fn folded(patch: &Patch, points: &[DVec3]) -> Vec<[u32; 3]> {
    let normals = vertex_normals(points, &patch.closure.faces);
    let is_folded = |face: &&[u32; 3]| {
        let normal = area_vector(corners(points, **face)).normalize_or_zero();
        face.iter()
            .all(|&v| normal.dot(normals[v as usize]) < FOLDED_COSINE.get())
    };
    let faces = patch.closure.patch_faces.iter().filter(is_folded);
    faces.copied().collect()
}

/// Moves the vertices of folded faces to the mean of their neighbours, repeatedly, until at most `allowed` faces are folded.
/// `None` if that does not succeed.
pub(super) fn unfolded(patch: &Patch, shape: &[DVec3], allowed: usize) -> Option<Vec<DVec3>> {
    let closure = &patch.closure;
    let mut points = patch.closure_points(shape);
    for _ in 0..UNFOLDINGS.get() {
        let folded = folded(patch, &points);
        if folded.len() <= allowed {
            return Some(closure.moved(&points));
        }
        let moves = |v: &u32| closure.moving.binary_search(v).is_ok();
        let vertices = folded.into_iter().flatten().filter(moves);
        let mut sums: BTreeMap<u32, (DVec3, f64)> =
            vertices.map(|v| (v, Default::default())).collect();
        for face in &closure.faces {
            for v in face {
                let Some((sum, count)) = sums.get_mut(v) else {
                    continue;
                };
                let others = face.iter().filter(|w| *w != v);
                others.for_each(|&w| *sum += points[w as usize]);
                *count += 2.0;
            }
        }
        for (v, (sum, count)) in sums {
            points[v as usize] = sum / count;
        }
    }
    None
}

/// Detects folds during the minimisation of a large patch, whose steps are expensive: after some consecutive steps with too many
/// folds it stops the minimisation, and the last shape without them is used.
pub(super) struct FoldWatch<'a> {
    pub(super) patch: &'a Patch,
    pub(super) allowed: usize,
    /// Consecutive steps with too many folds.
    pub(super) in_a_row: usize,
    /// The last shape without them, as points of the closure, and its energy.
    pub(super) best: (Vec<DVec3>, f64),
}

impl FoldWatch<'_> {
    /// Whether to continue after a step to these points with this energy.
    pub(super) fn goes_on(&mut self, points: &[DVec3], energy: f64) -> bool {
        if folds(self.patch, &self.patch.closure.moved(points)) <= self.allowed {
            self.in_a_row = 0;
            self.best = (points.to_vec(), energy);
            return true;
        }
        self.in_a_row += 1;
        self.in_a_row < MOST_FOLDED_STEPS.get()
    }
}
