//! The counterpart of a region in JSON documents.

use glam::DVec3;
use serde::Serialize;

use isomend_core::fill::{CounterpartKind, CounterpartReport, NotLike};

/// The test of a counterpart; lengths in the mesh's unit, all root mean squares. See [`CounterpartReport`].
#[derive(Serialize)]
pub(super) struct CounterpartRow {
    /// Whether the patch was made from the counterpart.
    used: bool,
    /// `mirror` or `template`; null if nothing fits the mesh.
    kind: Option<&'static str>,
    /// Point and normal of the mirror plane.
    plane: Option<[DVec3; 2]>,
    /// Scale factor of the template.
    scale: Option<f64>,
    /// Distance between the vertices round the hole and the aligned counterpart.
    misfit: Option<f64>,
    /// Error with which the counterpart predicts removed rings of faces round the hole.
    ring_error: Option<f64>,
    /// The same error of a smooth patch.
    smooth_ring_error: Option<f64>,
    /// Distance between a smooth patch of the hole and the counterpart.
    feature: Option<f64>,
    /// Weight beside the smooth continuation, from 0 to 1, where both were used.
    weight: Option<f64>,
    /// Why it was refused, as an identifier.
    cause: Option<&'static str>,
    /// Why it was refused, as a sentence.
    reason: Option<String>,
}

impl CounterpartRow {
    pub(super) fn new(r: &CounterpartReport) -> Self {
        let (kind, plane, scale) = match r.kind {
            Some(CounterpartKind::Mirror(plane)) => (Some("mirror"), Some(plane), None),
            Some(CounterpartKind::Template(scale)) => (Some("template"), None, Some(scale)),
            None => (None, None, None),
        };
        Self {
            used: r.refused.is_none(),
            kind,
            plane,
            scale,
            misfit: r.misfit,
            ring_error: r.ring_error,
            smooth_ring_error: r.smooth_ring_error,
            feature: r.feature,
            weight: r.weight,
            cause: r.refused.as_ref().map(NotLike::key),
            reason: r.refused.as_ref().map(ToString::to_string),
        }
    }
}
