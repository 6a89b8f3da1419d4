//! The results of a region that was solved in a frame of its own, in the mesh's units, coordinates and numbers.

use glam::DVec3;

use super::closure::{Closure, HoleOutcome};
use super::reasons::{AttemptFailure, NotSmooth, OpenReason};
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use crate::finish::FinishRecord;

/// The way from a region's frame to the mesh.
pub(crate) struct WayBack<'a> {
    /// For each hole in the region's order, its place in the caller's.
    pub(crate) places: &'a [usize],
    /// The length of the frame's unit, in the mesh's units.
    pub(crate) unit: f64,
    /// The mesh's coordinates of a point of the frame.
    pub(crate) point: &'a dyn Fn(DVec3) -> DVec3,
    /// The mesh's number of a vertex.
    pub(crate) vertex: &'a dyn Fn(u32) -> u32,
}

impl RegionPatch {
    /// The same result for the mesh. The patch itself is already in the mesh's coordinates and numbers.
    pub(crate) fn returned(mut self, way: &WayBack) -> Self {
        for error in self.expected_error.iter_mut().flatten() {
            *error *= way.unit;
        }
        self.report.return_to_mesh(way);
        let holes = self.report.holes.clone();
        let outcomes = std::mem::take(&mut self.outcomes);
        let mut in_order: Vec<_> = outcomes.into_iter().zip(holes).zip(way.places).collect();
        in_order.sort_by_key(|(_, place)| **place);
        for ((mut outcome, id), place) in in_order {
            outcome.return_to_mesh(way);
            self.outcomes.push(outcome);
            self.report.holes[*place] = id;
        }
        self
    }
}

impl HoleOutcome {
    fn return_to_mesh(&mut self, way: &WayBack) {
        match self {
            Self::Closed(how) => how.return_to_mesh(way),
            Self::Open(OpenReason::NoTriangulation {
                after: NotSmooth::NoSurface(failure),
                ..
            }) => failure.return_to_mesh(way),
            _ => {}
        }
    }
}

impl Closure {
    fn return_to_mesh(&mut self, way: &WayBack) {
        match self {
            Self::Faired(Some(failure)) | Self::RimTriangles(NotSmooth::NoSurface(failure)) => {
                failure.return_to_mesh(way);
            }
            _ => {}
        }
    }
}

impl AttemptFailure {
    fn return_to_mesh(&mut self, way: &WayBack) {
        if let Self::NotJoined(error) = self {
            *error = error
                .clone()
                .renumbered(way.vertex)
                .placed(way.unit, way.point, &|rim| {
                    way.places.get(rim).copied().unwrap_or(rim)
                });
        }
    }
}

impl RegionReport {
    fn return_to_mesh(&mut self, way: &WayBack) {
        let unit = way.unit;
        if let Some(how) = &mut self.closure {
            how.return_to_mesh(way);
        }
        self.diameter *= unit;
        scale(&mut self.voxel, unit);
        self.levels.iter_mut().for_each(|level| level.voxel *= unit);
        if let Some(quality) = &mut self.quality {
            scale(&mut quality.expected_error, unit);
        }
        scale(&mut self.largest_expected_error, unit);
        for record in self.finish.iter_mut().flat_map(|f| &mut f.components) {
            return_record(record, unit);
        }
        for crease in &mut self.creases {
            crease.length *= unit;
        }
        if let Some(like) = &mut self.counterpart {
            scale(&mut like.misfit, unit);
            scale(&mut like.ring_error, unit);
            scale(&mut like.smooth_ring_error, unit);
            scale(&mut like.feature, unit);
        }
        if let Some(grain) = &mut self.grain {
            grain.ring *= unit;
            grain.patch *= unit;
        }
        for failure in &mut self.failed_attempts {
            failure.return_to_mesh(way);
        }
    }
}

fn return_record(record: &mut FinishRecord, unit: f64) {
    record.diameter *= unit;
    record.edge *= unit;
    record.largest_move *= unit;
    scale(&mut record.mean_expected_error, unit);
    scale(&mut record.largest_expected_error, unit);
    for candidate in &mut record.candidates {
        scale(&mut candidate.ring_error, unit);
    }
}

fn scale(length: &mut Option<f64>, unit: f64) {
    *length = length.map(|length| length * unit);
}
