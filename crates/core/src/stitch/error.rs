//! Errors of stitching.

use std::borrow::Cow;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::mesh::triangulate::TriangulationError;

/// Why a patch could not be stitched.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum StitchError {
    /// An index is out of range.
    #[error("{what} refers to vertex {vertex}, but there are only {len}; check the input")]
    Index {
        /// The part of the input with the index.
        what: Cow<'static, str>,
        /// The index.
        vertex: u32,
        /// The number of vertices.
        len: usize,
    },
    /// A coordinate or a length is not finite, or not positive where it must be.
    #[error("{what} is not a usable number; check the input")]
    Number {
        /// The part of the input with the number.
        what: Cow<'static, str>,
    },
    /// There are no rim loops.
    #[error("there is no rim loop to stitch to; give at least one loop with three edges")]
    NoLoops,
    /// A rim loop has an edge that is not a boundary edge of the mesh in that direction.
    #[error(
        "rim loop {rim} uses the edge {from}-{to}, which is not a boundary edge of the mesh in that direction; \
         give loops in the direction of the patch's faces"
    )]
    #[serde(alias = "not_on_border")]
    NotOnBoundary {
        /// Index of the loop.
        rim: usize,
        /// Start of the edge.
        from: u32,
        /// End of the edge.
        to: u32,
    },
    /// The extracted surface has no boundary near a rim loop.
    #[error("the extracted surface does not reach rim loop {rim}; use a finer grid there")]
    RimNotReached {
        /// Index of the loop in the input.
        rim: usize,
    },
    /// A boundary of the extracted surface is far from every rim.
    #[error(
        "the extracted surface ends near {position}, {distance} from the nearest rim; extract more cells there"
    )]
    #[serde(alias = "open_border")]
    OpenBoundary {
        /// A point of the boundary.
        position: DVec3,
        /// Distance of that point from the nearest rim.
        distance: f64,
    },
    /// The boundary of the extracted surface runs against the rim.
    #[error(
        "the extracted surface faces the other way at rim loop {rim}; check the orientation of the loop and the sign of the field"
    )]
    Orientation {
        /// Index of the loop in the input.
        rim: usize,
    },
    /// A rim could not be triangulated.
    #[error(transparent)]
    Triangulation(#[from] TriangulationError),
    /// Remeshing makes more faces than plausible for the rims.
    #[error(
        "remeshing was stopped at {faces} faces for rims of {edges} edges; the edges there differ too much in \
         length, or the mesh has spikes: remesh or cut them first"
    )]
    TooManyFaces {
        /// Faces when remeshing was stopped.
        faces: usize,
        /// Edges of all rims.
        edges: usize,
    },
    /// Most of a large patch is folded.
    #[error(
        "{tilted} of {faces} faces of the patch are folded over; the mesh has spikes or edges that differ too much in \
         length there: remesh or cut them first"
    )]
    Folded {
        /// Faces whose normals differ by more than 60 degrees from the surface's.
        tilted: usize,
        /// All faces.
        faces: usize,
    },
    /// Cancelled by the caller.
    #[error("stitching was cancelled")]
    Cancelled,
    /// The faces do not form a manifold.
    #[error("the patch is not a manifold near {position}; use a finer grid there")]
    NotManifold {
        /// A position there.
        position: DVec3,
    },
}

impl StitchError {
    /// The same error with renumbered vertices.
    pub(crate) fn renumbered(self, number: impl Fn(u32) -> u32) -> Self {
        match self {
            Self::NotOnBoundary { rim, from, to } => Self::NotOnBoundary {
                rim,
                from: number(from),
                to: number(to),
            },
            other => other,
        }
    }

    /// The same error for a mesh in which `point` maps positions, `unit` is the length of a unit, and `rim` maps the indices of loops.
    pub(crate) fn placed(
        self,
        unit: f64,
        point: &dyn Fn(DVec3) -> DVec3,
        rim: &dyn Fn(usize) -> usize,
    ) -> Self {
        match self {
            Self::NotOnBoundary { rim: of, from, to } => Self::NotOnBoundary {
                rim: rim(of),
                from,
                to,
            },
            Self::RimNotReached { rim: of } => Self::RimNotReached { rim: rim(of) },
            Self::Orientation { rim: of } => Self::Orientation { rim: rim(of) },
            Self::OpenBoundary { position, distance } => Self::OpenBoundary {
                position: point(position),
                distance: unit * distance,
            },
            Self::NotManifold { position } => Self::NotManifold {
                position: point(position),
            },
            other => other,
        }
    }

    /// Whether another error is of the same kind, at the same rim or within `reach` of the same position.
    pub(crate) fn is_like(&self, other: &Self, reach: f64) -> bool {
        match (self, other) {
            (Self::RimNotReached { rim: a }, Self::RimNotReached { rim: b })
            | (Self::Orientation { rim: a }, Self::Orientation { rim: b }) => a == b,
            (Self::OpenBoundary { position: a, .. }, Self::OpenBoundary { position: b, .. })
            | (Self::NotManifold { position: a }, Self::NotManifold { position: b }) => {
                a.distance(*b) < reach
            }
            _ => self == other,
        }
    }

    /// The same error with its position moved by `by`.
    pub(super) fn moved(self, by: DVec3) -> Self {
        match self {
            Self::NotManifold { position } => Self::NotManifold {
                position: position + by,
            },
            other => other,
        }
    }
}
