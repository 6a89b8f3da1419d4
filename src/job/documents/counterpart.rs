//! The row of what a region was filled after.

use glam::DVec3;
use serde::Serialize;

use crate::fill::{CounterpartKind, CounterpartReport, NotLike};

/// The counterpart after which a region was to be filled.
#[derive(Serialize)]
pub(super) struct CounterpartRow {
    /// Whether its patch comes from the counterpart.
    used: bool,
    /// `mirror` or `template`; null where nothing fits the mesh.
    kind: Option<&'static str>,
    /// Point and normal of the mirror plane.
    plane: Option<[DVec3; 2]>,
    /// By what the template was scaled.
    scale: Option<f64>,
    /// Distance of the faces round the hole from it, root mean square, in the mesh's unit.
    misfit: Option<f64>,
    /// Error with which it, and a smooth patch, predict rings round the hole that were taken out.
    ring_error: Option<f64>,
    smooth_ring_error: Option<f64>,
    /// Distance of a smooth patch of the hole from it.
    feature: Option<f64>,
    /// Why it was not used: as a word for programs, and in words for people.
    cause: Option<&'static str>,
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
            cause: r.refused.as_ref().map(cause),
            reason: r.refused.as_ref().map(ToString::to_string),
        }
    }
}

fn cause(why: &NotLike) -> &'static str {
    match why {
        NotLike::Nothing => "nothing",
        NotLike::SeveralRims => "several_rims",
        NotLike::Open => "open",
        NotLike::Own => "own",
        NotLike::Apart => "apart",
        NotLike::Predicted => "predicted",
        NotLike::Alike => "alike",
        NotLike::Untested => "untested",
        NotLike::NotJoined => "not_joined",
        NotLike::Intersects(_) => "intersects",
    }
}
