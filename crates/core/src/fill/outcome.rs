//! Outcomes of holes, and the reasons why attempts and candidates fail. A reason prints as the second part of a sentence.

use std::fmt;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::mesh::triangulate::TriangulationError;
use crate::stitch::StitchError;

/// The outcome of a hole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HoleOutcome {
    /// Filled by the level set; with a rim of few edges by its faired triangulation; or by the smooth sides around it, continued
    /// to sharp edges.
    Filled,
    /// Closed by a triangulation of its rim, refined and faired, because the level set found no surface: the failure of the last
    /// attempt.
    Faired(AttemptFailure),
    /// Closed by a nearly flat cap, as requested.
    Flat,
    /// The outer border of a sheet, closed by a flat base with walls, as requested.
    Base,
    /// In a repair: the outer border of a sheet, closed by walls under the whole sheet because no flat cap closed it.
    Walls,
    /// Triangulated between the vertices of its rim, without new vertices.
    Triangulated(TriangulatedReason),
    /// Left open because the caller did not ask to fill it.
    Left(LeftReason),
    /// Still open although it was to be filled.
    Failed(FailedReason),
}

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

/// Why a hole was closed by triangles between the vertices of its rim.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum TriangulatedReason {
    /// It has no more than four edges.
    #[error("it has no more than four edges")]
    FewEdges,
    /// It is one side of a seam.
    #[error("it is one side of a seam")]
    Seam,
    /// A flat cap was requested, but could not be made or had more self-intersections.
    #[error("no flat cap could be made without more self-intersections")]
    Flat,
    /// In a repair: it was still open after the last steps, when no level set is solved any more.
    #[error("it was still open after the last steps of the repair")]
    LastSteps,
    /// The level set found no surface: the failure of the last attempt.
    #[error(transparent)]
    NoSurface(AttemptFailure),
}

/// Why a hole that was to be filled is open.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FailedReason {
    /// The run ended before this hole.
    #[error("not reached")]
    NotReached,
    /// Its rim could not be triangulated either.
    #[error("{after}; {error}")]
    NoTriangulation {
        /// Why it was to be triangulated.
        after: TriangulatedReason,
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

impl HoleOutcome {
    /// The identifier of the outcome in documents and style sheets.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Filled => "filled",
            Self::Faired(_) => "faired",
            Self::Flat => "flat",
            Self::Base => "base",
            Self::Walls => "walls",
            Self::Triangulated(_) => "triangulated",
            Self::Left(_) => "left",
            Self::Failed(_) => "failed",
        }
    }

    /// The identifier of the reason; none where the hole was closed as wished.
    pub fn cause(&self) -> Option<&'static str> {
        match self {
            Self::Filled | Self::Flat | Self::Base | Self::Walls => None,
            Self::Faired(why) => Some(why.key()),
            Self::Triangulated(why) => Some(why.key()),
            Self::Left(why) => Some(why.key()),
            Self::Failed(why) => Some(why.key()),
        }
    }

    /// Its name in lists and tables for people.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Filled => "filled",
            Self::Faired(_) => ClosedBy::Faired.name(),
            Self::Flat => ClosedBy::Flat.name(),
            Self::Base => ClosedBy::Base.name(),
            Self::Walls => "walls",
            Self::Triangulated(_) => ClosedBy::RimTriangles.name(),
            Self::Left(_) => "left open",
            Self::Failed(_) => "not filled",
        }
    }

    /// The reason in words; none where the hole was closed as wished.
    pub fn reason(&self) -> Option<String> {
        match self {
            Self::Filled | Self::Flat | Self::Base | Self::Walls => None,
            Self::Triangulated(TriangulatedReason::Seam) => {
                let why = TriangulatedReason::Seam;
                Some(format!("{why}, which was closed with thin triangles"))
            }
            Self::Triangulated(why) => Some(why.to_string()),
            Self::Faired(why) => Some(why.to_string()),
            Self::Left(why) => Some(why.to_string()),
            Self::Failed(why) => Some(why.to_string()),
        }
    }
}

/// Name and reason, such as `left open: asked to keep it open`.
impl fmt::Display for HoleOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.reason() {
            Some(reason) => write!(f, "{}: {reason}", self.name()),
            None => f.write_str(self.name()),
        }
    }
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

impl TriangulatedReason {
    /// The identifier of the reason in documents.
    pub fn key(&self) -> &'static str {
        match self {
            Self::FewEdges => "few_edges",
            Self::Seam => "seam",
            Self::Flat => "flat",
            Self::LastSteps => "last_steps",
            Self::NoSurface(why) => why.key(),
        }
    }
}

impl FailedReason {
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

/// The kind of surface that closed a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClosedBy {
    /// The surface of the level set.
    LevelSet,
    /// Triangulations of the rims, refined and faired.
    Faired,
    /// The smooth sides around it, continued until they meet in sharp or rounded edges.
    Sides,
    /// The part of a counterpart at the hole: of the mirrored mesh, or of a template.
    Counterpart,
    /// A nearly flat cap, the surface of least area, as requested.
    Flat,
    /// A flat base under a sheet, with walls down from its border, as requested.
    Base,
    /// Thin triangles between two rims that coincide.
    Seam,
    /// Triangles between the vertices of each rim.
    RimTriangles,
    /// In a repair: an offset shell under the surface around the rims. It ends where it can be closed, or covers the whole
    /// component.
    #[serde(alias = "lining")]
    OffsetShell,
    /// At least one of its rims is still open.
    Nothing,
}

impl ClosedBy {
    /// Its name in tables and sentences for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::LevelSet => "level set",
            Self::Faired => "smoothed triangles",
            Self::Sides => "continued sides",
            Self::Counterpart => "counterpart",
            Self::Flat => "flat cap",
            Self::Base => "flat base",
            Self::Seam => "seam triangles",
            Self::RimTriangles => "rim triangles",
            Self::OffsetShell => "offset shell",
            Self::Nothing => "-",
        }
    }
}

/// Number of holes with each outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Tally {
    /// Filled by the level set.
    pub filled: usize,
    /// Closed by faired triangulations of their rims because the level set found no surface.
    pub faired: usize,
    /// Closed by flat caps, as requested.
    pub flat: usize,
    /// Outer borders of sheets closed by flat bases with walls, as requested.
    pub bases: usize,
    /// Outer borders of sheets closed by walls under the sheets.
    pub walls: usize,
    /// Closed by triangles between the vertices of their rims.
    pub triangulated: usize,
    /// Left open because the caller did not ask to fill them.
    pub left: usize,
    /// Still open although they were to be filled.
    pub failed: usize,
    /// Boundary chains that do not close.
    pub open_chains: usize,
    /// Patches with faces that intersect other faces.
    pub intersecting_patches: usize,
    /// Faces of patches that intersect other faces.
    pub intersecting_faces: usize,
}
