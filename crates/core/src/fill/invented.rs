//! Reports of invented shape, which the surroundings do not predict: the counterpart of a patch, and its grain.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// The kind of a counterpart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CounterpartKind {
    /// The mesh mirrored in the plane through a point with a unit normal.
    Mirror([DVec3; 2]),
    /// A template, scaled by this factor.
    Template(f64),
}

/// Why a counterpart was refused.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum NotLike {
    /// The mesh has no plane of symmetry, or the template fits it in no pose.
    #[error("nothing fits the mesh: it has no plane of symmetry, or the template is another shape")]
    Nothing,
    /// The region has several rims.
    #[error("the region has several rims")]
    SeveralRims,
    /// The counterpart has a hole at the same place.
    #[error("it has a hole at the same place")]
    Open,
    /// The hole lies on the plane of symmetry, so the missing part is its own mirror image.
    #[error("the mirror image of the missing part is the hole itself")]
    Own,
    /// The counterpart does not fit the faces round the hole.
    #[error("it does not fit the faces round the hole")]
    Apart,
    /// A smooth patch predicts the faces round the hole better.
    #[error("a smooth patch predicts the faces round the hole better")]
    Predicted,
    /// The counterpart differs from a smooth patch in the hole hardly more than from the faces beside it.
    #[error("it differs from a smooth patch hardly more than from the faces beside the hole")]
    Alike,
    /// The prediction cannot be tested: there are no rings of faces to remove, or no smooth patch to compare with.
    #[error("there are no rings of faces round the hole to test its prediction")]
    Untested,
    /// The counterpart could not be joined to the rim.
    #[error("it could not be joined to the rim")]
    NotJoined,
    /// Number of faces of the patch that intersected others.
    #[error("{0} faces of its patch intersected others")]
    Intersects(usize),
}

impl NotLike {
    /// The identifier of the reason in documents.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::SeveralRims => "several_rims",
            Self::Open => "open",
            Self::Own => "own",
            Self::Apart => "apart",
            Self::Predicted => "predicted",
            Self::Alike => "alike",
            Self::Untested => "untested",
            Self::NotJoined => "not_joined",
            Self::Intersects(_) => "intersects",
        }
    }
}

/// The test of a counterpart at a hole; lengths in the mesh's unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CounterpartReport {
    /// Its kind; `None` if nothing fits the mesh.
    pub kind: Option<CounterpartKind>,
    /// Root mean square distance between the known vertices round the hole and the rigidly aligned counterpart.
    pub misfit: Option<f64>,
    /// Root mean square error with which the counterpart predicts the vertices of rings of faces removed round the hole.
    pub ring_error: Option<f64>,
    /// Root mean square error with which a smooth patch predicts them.
    pub smooth_ring_error: Option<f64>,
    /// Root mean square distance between a smooth patch of the hole and the counterpart: the size of a feature that the patch lacks.
    pub feature: Option<f64>,
    /// Its weight beside the smooth continuation, from 0 to 1, where both were used; `None` where only one was.
    pub weight: Option<f64>,
    /// Why the counterpart was refused; `None` if it was used.
    pub refused: Option<NotLike>,
}

/// The grain added to a patch; lengths in the mesh's unit. It is invented: the expected error does not include it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct GrainReport {
    /// Root mean square roughness of the known vertices round the hole.
    pub ring: f64,
    /// Root mean square roughness of the patch with its grain: measured with the whole grain, times `part`.
    pub patch: f64,
    /// The fraction of the grain's height that was added: below 1 if more faces would have intersected with the whole grain, and 0 if more
    /// would have with any.
    pub part: f64,
}
