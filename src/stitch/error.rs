use std::borrow::Cow;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::mesh::triangulate::TriangulationError;

/// Why a patch could not be made.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum StitchError {
    /// An index is beyond the vertices.
    #[error("{what} refers to vertex {vertex}, but there are only {len}; check the input")]
    Index {
        /// What holds the index.
        what: Cow<'static, str>,
        /// The index.
        vertex: u32,
        /// The number of vertices.
        len: usize,
    },
    /// A coordinate or a length is not a finite number, or not positive where it must be.
    #[error("{what} is not a usable number; check the input")]
    Number {
        /// What is wrong.
        what: Cow<'static, str>,
    },
    /// There are no rim loops.
    #[error("there is no rim loop to stitch to; give at least one loop with three edges")]
    NoLoops,
    /// A rim loop is not usable.
    #[error(
        "rim loop {rim} uses the edge {from}-{to} that is not on the border of the mesh in that direction; give loops in the direction of the patch's faces"
    )]
    NotOnBorder {
        /// Index of the loop.
        rim: usize,
        /// Start of the edge.
        from: u32,
        /// End of the edge.
        to: u32,
    },
    /// The extracted surface has no border near a rim loop.
    #[error("the extracted surface does not reach rim loop {rim}; use a finer grid there")]
    RimNotReached {
        /// Index of the loop in the input.
        rim: usize,
    },
    /// The extracted surface ends away from every rim.
    #[error(
        "the extracted surface ends near {position}, {distance} from the nearest rim; extract more cells there"
    )]
    OpenBorder {
        /// A point of the border.
        position: DVec3,
        /// Distance to the rim.
        distance: f64,
    },
    /// The border of the extracted surface runs against the rim.
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
    /// Remeshing made more faces than the rims account for.
    #[error(
        "remeshing came to {faces} faces for rims of {edges} edges and would make more; the edges there differ too much in \
         length, or the mesh has spikes: remesh or cut them first"
    )]
    TooManyFaces {
        /// Faces when it was given up.
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
        /// Faces whose normals are more than 60 degrees from that of the surface.
        tilted: usize,
        /// All faces.
        faces: usize,
    },
    /// The caller asked to stop.
    #[error("stopped before it was done")]
    Cancelled,
    /// The faces do not form a manifold.
    #[error("the patch is not a manifold near {position}; use a finer grid there")]
    NotManifold {
        /// The place.
        position: DVec3,
    },
}

impl StitchError {
    /// The same error with its vertices renumbered.
    pub(crate) fn renumbered(self, number: impl Fn(u32) -> u32) -> Self {
        match self {
            Self::NotOnBorder { rim, from, to } => Self::NotOnBorder {
                rim,
                from: number(from),
                to: number(to),
            },
            other => other,
        }
    }

    /// Whether another error is of the same kind, at the same rim or within `reach` of the same place.
    pub(crate) fn is_like(&self, other: &Self, reach: f64) -> bool {
        match (self, other) {
            (Self::RimNotReached { rim: a }, Self::RimNotReached { rim: b })
            | (Self::Orientation { rim: a }, Self::Orientation { rim: b }) => a == b,
            (Self::OpenBorder { position: a, .. }, Self::OpenBorder { position: b, .. })
            | (Self::NotManifold { position: a }, Self::NotManifold { position: b }) => {
                a.distance(*b) < reach
            }
            _ => self == other,
        }
    }

    /// The same error with its place moved by `by`.
    pub(super) fn moved(self, by: DVec3) -> Self {
        match self {
            Self::NotManifold { position } => Self::NotManifold {
                position: position + by,
            },
            other => other,
        }
    }
}
