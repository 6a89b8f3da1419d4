//! Reasons why holes stay open, and why attempts and candidates fail. A reason prints as the second part of a sentence.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::mesh::triangulate::TriangulationError;
use crate::stitch::StitchError;

/// Why a hole was left open.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LeftReason {
    /// The caller asked to keep it open.
    #[error("asked to keep it open")]
    KeptOpen,
    /// The caller chose other holes.
    #[error("not asked for")]
    NotChosen,
    /// It is wider than the largest diameter that the caller allows.
    #[error("wider than the largest diameter asked for")]
    TooWide,
    /// It is the outer border of an open sheet, which is filled only if the caller names it.
    #[error("the outer border of an open sheet, which is filled only when it is named")]
    OuterBoundary,
    /// It bounds a component of one or two triangles outside all holes.
    #[error("the border of a component of one or two triangles")]
    SmallComponent,
    /// It is outside the marked region.
    #[error("not in the marked region")]
    NotMarked,
}

/// Why a hole was closed without a smooth surface: by triangles between the vertices of its rim, or by an offset shell.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum NotSmooth {
    /// It has no more than four edges.
    #[error("it has no more than four edges")]
    FewEdges,
    /// A flat cap was requested, but could not be made or had more self-intersections.
    #[error("no flat cap could be made without more self-intersections")]
    Flat,
    /// It is one side of a flat or coarse wall, of which the other side is open too: the edge of the opening is straight.
    #[error("the edge of an opening in a flat or coarse wall is straight")]
    StraightEdge,
    /// In a repair: it was still open after the last steps, when no level set is solved any more.
    #[error("it was open until the last steps of the repair")]
    LastSteps,
    /// The level set found no surface: the failure of the last attempt.
    #[error(transparent)]
    NoSurface(AttemptFailure),
}

/// Why a hole that was to be filled is open.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum OpenReason {
    /// The run ended before this hole.
    #[error("not reached")]
    NotReached,
    /// Its rim could not be triangulated either.
    #[error("{after}; {error}")]
    NoTriangulation {
        /// Why it was to get rim triangles.
        after: NotSmooth,
        /// Why the triangulation failed.
        error: TriangulationError,
    },
    /// It was to get a flat base: why that failed.
    #[error("{0}")]
    NoBase(String),
    /// In a repair: every patch intersected other faces; the number of those faces of the last patch.
    #[error("every patch intersects other faces (last patch: {0} faces)")]
    #[serde(alias = "crossing")]
    Intersects(usize),
    /// In a repair: it was still open after the last steps, and every triangulation of its rim intersects other faces.
    #[error("every triangulation of its rim intersects other faces")]
    #[serde(alias = "nothing_fits")]
    EveryTriangulationIntersects,
}

/// Why an attempt at a region failed.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum AttemptFailure {
    /// The run was stopped before the first attempt ended.
    #[error("stopped")]
    Stopped,
    /// The surrounding faces are inconsistent: the flow diverges.
    #[error("the faces around it are inconsistent: the level set diverged")]
    #[serde(alias = "contradiction")]
    Diverged,
    /// The flow did not converge on this grid.
    #[error("the level set did not converge on this grid")]
    #[serde(alias = "not_steady")]
    NotConverged,
    /// The surface reached the side of its box.
    #[error("the surface reached the side of its grid")]
    ReachedBox,
    /// The surface could not be joined to the rims.
    #[error(transparent)]
    NotJoined(StitchError),
    /// Number of faces of the patch that intersect others.
    #[error("{0} faces of the patch intersected others")]
    #[serde(alias = "crossing")]
    Intersects(usize),
}

/// Why sharp edges that end at a rim were not continued across its hole.
#[derive(Clone, Debug, Error, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum NotContinued {
    /// The continuation of the smooth sides does not close the hole: why.
    #[error("{0}")]
    Declined(String),
    /// Number of faces of the continued sides that intersect others.
    #[error("{0} faces of the continued sides intersected others")]
    Intersects(usize),
    /// A smooth patch predicts the rings of faces around the hole about as well as the continued sides.
    #[error("a smooth patch predicts the faces around the hole about as well")]
    Predicted,
    /// No ring of faces can be removed for a test, and the sides deviate too far from their fitted surfaces to be continued
    /// without one.
    #[error("the sides around the hole are too rough")]
    Rough,
    /// No ring of faces can be removed for a test, and the edges may be rounded.
    #[error("the edges may be rounded")]
    Rounded,
}

impl LeftReason {
    /// The identifier of the reason in documents.
    pub fn key(self) -> &'static str {
        match self {
            Self::KeptOpen => "kept_open",
            Self::NotChosen => "not_chosen",
            Self::TooWide => "too_wide",
            Self::OuterBoundary => "outer_boundary",
            Self::SmallComponent => "small_component",
            Self::NotMarked => "not_marked",
        }
    }
}

impl NotSmooth {
    /// The identifier of the reason in documents.
    pub fn key(&self) -> &'static str {
        match self {
            Self::FewEdges => "few_edges",
            Self::Flat => "flat",
            Self::StraightEdge => "straight_edge",
            Self::LastSteps => "last_steps",
            Self::NoSurface(why) => why.key(),
        }
    }
}

impl OpenReason {
    /// The identifier of the reason in documents.
    pub fn key(&self) -> &'static str {
        match self {
            Self::NotReached => "not_reached",
            Self::NoTriangulation { .. } => "no_triangulation",
            Self::NoBase(_) => "no_base",
            Self::Intersects(_) | Self::EveryTriangulationIntersects => "intersects",
        }
    }
}

impl AttemptFailure {
    /// The identifier of the reason in documents.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Stopped => "stopped",
            Self::Diverged => "diverged",
            Self::NotConverged => "not_converged",
            Self::ReachedBox => "reached_box",
            Self::NotJoined(_) => "not_joined",
            Self::Intersects(_) => "intersects",
        }
    }
}

impl NotContinued {
    /// The identifier of the reason in documents.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Declined(_) => "declined",
            Self::Intersects(_) => "intersects",
            Self::Predicted => "predicted",
            Self::Rough => "rough",
            Self::Rounded => "rounded",
        }
    }
}
