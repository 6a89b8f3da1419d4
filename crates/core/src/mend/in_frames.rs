//! Solves the regions of a fill in frames of their own, each on the part of the mesh that it may read.

use std::slice;
use std::sync::Arc;

use rayon::prelude::*;

use super::control::Watch;
use super::reach::{ReachQuery, faces_among, faces_of};
use super::regions::Regions;
use super::sources::{RegionSources, search_boxes};
use super::task::{RegionTask, is_framed};
use crate::fill::widest_growth;
use crate::fill::{PlacedPart, RegionPatch};
use crate::sdf::faces_at;
use crate::spatial::Bounds;
use crate::threads::CollectIndexed;

/// Regions whose faces are found in one pass over the mesh.
const FRAMED_AT_A_TIME: usize = 256;
/// Faces. If more are in the box that a region searches, those that it may read are selected, which takes as long as to copy
/// some thousand faces.
const MANY_NEAR: usize = 15_000;

impl<'a> Regions<'a> {
    /// The patches of those regions that are solved in a frame of their own, each on the part of the mesh that it needs.
    pub(super) fn framed(
        &self,
        regions: &[usize],
        sources: &RegionSources<'a>,
        counterparts: &[Option<Vec<PlacedPart>>],
        watch: &Watch,
    ) -> Vec<Option<RegionPatch>> {
        let is_plain = self.reference.is_none() && self.own.is_none();
        let mut patches = vec![None; regions.len()];
        let wanted = |at: &usize| is_plain && is_framed(self.groups[regions[*at]].decided.as_ref());
        let wanted: Vec<usize> = (0..regions.len()).filter(wanted).collect();
        for some in wanted.chunks(FRAMED_AT_A_TIME) {
            let query = |&at: &usize| {
                let counterparts = counterparts[at].clone();
                self.query(regions[at], sources, counterparts, widest_growth())
            };
            let queries: Vec<ReachQuery> = some.iter().map(query).collect();
            let faces = self.needed(&queries, sources);
            let solve = |(at, (query, faces)): (&usize, (&ReachQuery, Vec<u32>))| {
                let i = regions[*at];
                let faces = sources.with_rings(&faces);
                let centres = sources.centres(i);
                let task = RegionTask::new(i + 1, self.found, query, &faces, centres, &self.params);
                task.placed_patch(i, watch, self.before).ok()
            };
            let some_patches: Vec<Option<RegionPatch>> = some
                .par_iter()
                .zip(queries.par_iter().zip(faces))
                .map(solve)
                .collect_indexed();
            for (&at, patch) in some.iter().zip(some_patches) {
                patches[at] = patch;
            }
        }
        patches
    }

    /// For each region the faces that it may read, and more where these are few.
    fn needed(&self, queries: &[ReachQuery], sources: &RegionSources<'a>) -> Vec<Vec<u32>> {
        let (found, voxel) = (self.found, self.params.voxel);
        let degenerate = sources.degenerate();
        let around = |query: &ReachQuery| search_boxes(&found.mesh, &query.holes, voxel)[2];
        let boxes: Vec<Bounds> = queries.iter().map(around).collect();
        let faces = faces_at(&found.mesh, &found.topology, &boxes, usize::MAX);
        let faces = faces.unwrap_or_default();
        let needed = |((query, near), within): ((&ReachQuery, &Arc<[u32]>), &Bounds)| {
            if near.len() <= MANY_NEAR {
                return near.iter().chain(degenerate).copied().collect();
            }
            let among = faces_among(found, degenerate, query, voxel, (within, near));
            let of_all = || faces_of(found, degenerate, slice::from_ref(query), voxel).concat();
            among.unwrap_or_else(of_all)
        };
        let near = queries.par_iter().zip(&faces).zip(&boxes);
        near.map(needed).collect_indexed()
    }
}
