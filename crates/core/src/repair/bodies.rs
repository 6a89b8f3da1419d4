//! Union of closed bodies that touch or intersect, before anything is cut out.

use std::collections::HashSet;

use super::draft::Draft;
use super::filling::CAP;
use super::{
    Carried, Edge, RepairReport, RepairStep, Run, border, chains, clean, orient, sheets, union,
};
use crate::mend::FillError;
use crate::tuning::{Tunable, tunable};

/// Faces. With more intersecting faces than this, bodies are grown no further after a growth that changes nothing: each
/// takes as long as the union.
const GROWTH_FACES: Tunable<usize> = tunable("repair.growth_faces", 500);

/// A union of the mesh as given is gone on with if at most one of this many intersecting faces is left.
const FEW_LEFT: Tunable<usize> = tunable("repair.few_left", 20);

/// Lengths by which bodies are grown in turn, each twice the one before, at most.
const GROWTHS: Tunable<usize> = tunable("repair.growths", 3);

/// The draft and its report before the first step of the repair.
pub(super) type Given = (Draft, RepairReport);

impl Run<'_> {
    /// Unites closed bodies that touch or intersect, if fewer faces intersect others afterwards. If the exact union leaves
    /// intersecting faces, it is tried again on the mesh as `given`, with the bodies grown slightly where they touch.
    pub(super) fn unite(&mut self, given: &Given, carried: &Carried) -> Result<(), FillError> {
        if !self.intersects()? {
            return Ok(());
        }
        let plain = (self.draft.clone(), self.report.clone());
        let closing = chains::close(&mut self.draft)?;
        self.report.steps.closing_faces += closing;
        let crossing = self.draft.self_intersections()?;
        let before = (self.draft.clone(), self.report.clone());
        let turns = self.params.does(RepairStep::Orientation);
        let count = match crossing.len() {
            0 => self.draft.faults()?.intersecting_or_not_manifold(),
            count => count,
        };
        let left = union::unite(&mut self.draft, &mut self.report, crossing, (0.0, turns))?;
        let left = self.left_wrong(left)?.filter(|left| *left < count);
        if left.is_none() {
            (self.draft, self.report) = before;
        }
        // Vertices on faces are a reason only for intersections that a union left.
        let in_vertices = left.is_some() && !self.draft.self_intersections()?.is_empty();
        let mut left = left.unwrap_or(count);
        for growth in (0..GROWTHS.get()).map(|i| f64::from(1u32 << i.min(16))) {
            if left == 0 {
                break;
            }
            let Some(grown) = self.unite_grown(given, carried, (left, growth, in_vertices))? else {
                break;
            };
            if grown >= left && count > GROWTH_FACES.get() {
                break;
            }
            left = left.min(grown);
        }
        self.left = Some(self.left.map_or(left, |known| known.min(left)));
        if closing > 0 && self.report.steps.united_bodies == plain.1.steps.united_bodies {
            (self.draft, self.report) = plain;
        }
        if self.params.does(RepairStep::Duplicates) {
            clean::drop_duplicates(&mut self.draft, &mut self.report)?;
        }
        self.go_on()
    }

    /// Whether faces intersect others, or bodies touch in faces.
    pub(super) fn intersects(&mut self) -> Result<bool, FillError> {
        Ok(!self.draft.self_intersections()?.is_empty() || union::touch_at_edges(&mut self.draft)?)
    }

    /// Unites the bodies of the mesh before it is cleaned, since cleaning may take a face from one of two bodies that
    /// share it; then cleans it. Returns whether most intersections are gone.
    pub(super) fn unite_given(&mut self, carried: &Carried) -> Result<bool, FillError> {
        self.report.steps.closing_faces += chains::close(&mut self.draft)?;
        if self.params.does(RepairStep::Orientation) {
            self.report.steps.reoriented_faces += orient::orient(&mut self.draft)?;
        }
        let succeeds = self.are_closed()? && self.unite_closed(carried)?;
        if succeeds {
            self.clean(carried)?;
        }
        Ok(succeeds)
    }

    /// Whether all intersecting faces belong to closed bodies.
    fn are_closed(&mut self) -> Result<bool, FillError> {
        let crossing = self.draft.self_intersections()?;
        Ok(union::are_closed(&*self.draft.inspect()?, &crossing))
    }

    /// Unites bodies with their chosen holes closed by triangles, which are removed again. Returns whether all that intersect were
    /// closed then and most intersections are gone.
    pub(super) fn unite_capped(&mut self, carried: &Carried) -> Result<bool, FillError> {
        if self.are_closed()? {
            return self.unite_closed(carried);
        }
        let open = self.open_edges()?;
        self.cap()?;
        self.report.steps.closing_faces += chains::close(&mut self.draft)?;
        if !self.are_closed()? {
            return Ok(false);
        }
        let crossing = self.draft.self_intersections()?.len();
        let given = (self.draft.clone(), self.report.clone());
        self.unite(&given, carried)?;
        let is_cap: Vec<bool> = self.draft.region.iter().map(|r| *r == CAP).collect();
        self.draft.remove(&is_cap);
        // A body that passes through a hole that stays open would end at its cap.
        if self.keeps_holes() && !self.open_edges()?.is_subset(&open) {
            return Ok(false);
        }
        self.has_few_left(crossing)
    }

    /// The boundary edges between vertices of the input, and one for each vertex of the input whose edge ends at a new one.
    fn open_edges(&self) -> Result<HashSet<Edge>, FillError> {
        let origins = &self.draft.origins.vertices;
        let found = border(&*self.draft.inspect()?);
        let edges = found
            .iter()
            .map(|e| [e.0, e.1].map(|v| origins[v as usize]));
        Ok(edges.map(|[v, w]| (v.min(w), v.max(w))).collect())
    }

    /// Unites bodies that are closed, and so tell the solid that is meant. Returns whether most intersections are gone.
    fn unite_closed(&mut self, carried: &Carried) -> Result<bool, FillError> {
        self.meant = Some(self.draft.clone());
        let crossing = self.draft.self_intersections()?.len();
        let given = (self.draft.clone(), self.report.clone());
        self.unite(&given, carried)?;
        self.has_few_left(crossing)
    }

    /// Whether few of this many intersecting faces are left.
    fn has_few_left(&mut self, crossing: usize) -> Result<bool, FillError> {
        let left = self.draft.self_intersections()?.len();
        Ok(left * FEW_LEFT.get() <= crossing)
    }

    /// The number of defects after a union that left this many intersecting faces: these, or, if more, the intersecting faces and
    /// non-manifold edges and vertices that remain after separating the surfaces.
    fn left_wrong(&self, left: Option<usize>) -> Result<Option<usize>, FillError> {
        let Some(left) = left.filter(|_| self.params.does(RepairStep::NonManifold)) else {
            return Ok(left);
        };
        let mut trial = self.draft.clone();
        if trial.faults()?.is_manifold() {
            return Ok(Some(left));
        }
        sheets::separate(&mut trial, &mut self.report.clone(), !self.keeps_holes())?;
        let faults = trial.faults()?;
        Ok(Some(left.max(faults.intersecting_or_not_manifold())))
    }

    /// Unites bodies after growing them by `growth` times the smallest length where they touch in faces, or `in_vertices`. Keeps the
    /// result if fewer than `most` defects remain. Returns the number of defects; none if no bodies touch or none are united,
    /// however far they are grown.
    fn unite_grown(
        &mut self,
        (given, report): &Given,
        carried: &Carried,
        (most, growth, in_vertices): (usize, f64, bool),
    ) -> Result<Option<usize>, FillError> {
        let mut grown = given.clone();
        let Some(moved) = union::grow(&mut grown, growth, in_vertices)? else {
            return Ok(None);
        };
        let before = (
            std::mem::replace(&mut self.draft, grown),
            std::mem::replace(&mut self.report, report.clone()),
        );
        self.clean(carried)?;
        let crossing = self.draft.self_intersections()?;
        let reach = moved.reach();
        let left = union::unite(
            &mut self.draft,
            &mut self.report,
            crossing,
            (reach, self.params.does(RepairStep::Orientation)),
        )?;
        let left = self.left_wrong(left)?;
        log::debug!(
            "union with grown bodies: {} vertices moved by up to {:e}; {left:?} defects afterwards, {most} without growth",
            moved.vertices,
            moved.largest
        );
        if left.is_some_and(|left| left < most) {
            self.report.steps.moved_vertices = moved.vertices;
            self.report.steps.largest_move = moved.largest;
        } else {
            (self.draft, self.report) = before;
        }
        Ok(left)
    }
}
