//! Parts of a patch that its surroundings do not predict: the counterpart that it was made after, and its grain.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What a counterpart is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum CounterpartKind {
    /// The mesh mirrored in the plane through a point with a unit normal.
    Mirror([DVec3; 2]),
    /// A template, scaled by this factor.
    Template(f64),
}

/// Why a counterpart was not used.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum NotLike {
    /// No plane of symmetry, or no pose of the template, fits the mesh.
    #[error("nothing fits the mesh: it has no plane of symmetry, or the template is another shape")]
    Nothing,
    /// The region has several rims.
    #[error("the region has several rims")]
    SeveralRims,
    /// The counterpart has a hole where this one is.
    #[error("it has a hole there itself")]
    Open,
    /// The hole lies on the plane of symmetry: what is missing is its own mirror image.
    #[error("the mirrored part lies in the hole itself")]
    Own,
    /// It does not fit the faces round the hole.
    #[error("it does not fit the faces round the hole")]
    Apart,
    /// A smooth patch predicts the faces round the hole better.
    #[error("a smooth patch predicts the faces round the hole better")]
    Predicted,
    /// It differs from a smooth patch in the hole hardly more than from the faces beside it.
    #[error("it differs from a smooth patch no more than from the faces beside the hole")]
    Alike,
    /// There is no ring of faces that could be predicted.
    #[error("there are no rings of faces round the hole that it could predict")]
    Untested,
    /// It could not be joined to the rim.
    #[error("it could not be joined to the rim")]
    NotJoined,
    /// Number of faces of the patch that intersected others.
    #[error("{0} faces of its patch intersected others")]
    Intersects(usize),
}

/// How a counterpart fits beside a hole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CounterpartReport {
    /// What it is; none where nothing fits the mesh.
    pub kind: Option<CounterpartKind>,
    /// Root mean square distance of the known vertices round the hole from it, after a rigid motion, in the mesh's units.
    pub misfit: Option<f64>,
    /// Root mean square distance from it of vertices of rings round the hole that were taken out, in the mesh's units.
    pub ring_error: Option<f64>,
    /// The same of a smooth patch.
    pub smooth_ring_error: Option<f64>,
    /// Root mean square distance of a smooth patch of the hole from it: what it knows that the patch does not.
    pub feature: Option<f64>,
    /// Why it was not used; none where it was.
    pub refused: Option<NotLike>,
}

/// The grain that was added to a patch. It is invented: the expected error does not count it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct GrainReport {
    /// Root mean square roughness of the known vertices round the hole, in the mesh's units.
    pub ring: f64,
    /// The same of the patch with its grain; 0 where it got none.
    pub patch: f64,
    /// The part of its height that was added: less than 1 where the patch would have intersected faces, and 0 where it would have with any.
    pub part: f64,
}
