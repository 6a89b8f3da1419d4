//! How holes and the tries at their regions end. Reasons print as the rest of a sentence.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::mesh::triangulate::TriangulationError;
use crate::stitch::StitchError;

/// What happened to a hole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum HoleOutcome {
    /// Filled by the level set, a rim of few edges by its faired triangulation, or by the smooth sides round it, continued to sharp
    /// edges.
    Filled,
    /// Closed by a triangulation of its rim, refined and faired: the level set found no surface. What its last try failed with.
    Faired(TryFailure),
    /// Closed by a nearly flat cap, as was asked.
    Flat,
    /// The outer border of a sheet, closed by a flat base with walls, as was asked.
    Base,
    /// In a repair: the outer border of a sheet, closed by walls under all of the sheet, where no flat cap closed it.
    Walls,
    /// Triangulated on its own, without new vertices.
    Triangulated(TriangulatedReason),
    /// Left as it was because it was not asked for.
    Left(LeftReason),
    /// It was to be filled but could not be.
    Failed(FailedReason),
}

/// Why a hole is left as it is.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LeftReason {
    /// The caller asked to keep it open.
    #[error("asked to keep it open")]
    KeptOpen,
    /// The caller named others.
    #[error("not asked for")]
    NotChosen,
    /// It is wider than the largest diameter asked for.
    #[error("wider than the largest diameter asked for")]
    TooWide,
    /// It is the outer border of an open sheet, which is filled only when it is named.
    #[error("the outer border of an open sheet, which is filled only when it is named")]
    OuterBorder,
    /// It bounds a component of one or two triangles that lies in no hole.
    #[error("the border of a component of one or two triangles")]
    SmallComponent,
    /// It lies outside the marked region.
    #[error("not in the marked region")]
    NotMarked,
}

/// Why a hole is closed by triangles between the vertices of its rim.
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
    /// It was to get a flat cap, which could not be had or crossed more.
    #[error("it was to be closed flat")]
    Flat,
    /// In a repair: its last steps left it, after which no level set is solved.
    #[error("the last steps of the repair left it open")]
    LastSteps,
    /// The level set found no surface: what the last try failed with.
    #[error(transparent)]
    NoSurface(TryFailure),
}

/// Why a hole that was to be filled is open.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FailedReason {
    /// The run did not come to it.
    #[error("not reached")]
    NotReached,
    /// Its rim cannot be triangulated either.
    #[error("{after}; {error}")]
    NoTriangulation {
        /// Why it was to be triangulated.
        after: TriangulatedReason,
        /// What stands in the way.
        error: TriangulationError,
    },
    /// It was to stand on a flat base: why it cannot.
    #[error("{0}")]
    NoBase(String),
    /// In a repair: every patch crossed other faces; that of the last try with so many.
    #[error("whatever would close it crosses other faces: {0} of a patch did")]
    Crossing(usize),
    /// In a repair: its last steps left the hole open, and every triangulation of its rim intersects other faces.
    #[error("whatever would close it crosses other faces")]
    NothingFits,
}

/// Why a try at a region failed.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum TryFailure {
    /// The run was stopped before the first one ended.
    #[error("stopped")]
    Stopped,
    /// The data round it contradict each other: the flow runs away.
    #[error("the data round it contradict each other; no steady surface was found")]
    Contradiction,
    /// The flow did not become steady on this grid.
    #[error("the flow did not become steady on this grid")]
    NotSteady,
    /// The surface reached the side of its box.
    #[error("the surface reached the side of its box")]
    ReachedBox,
    /// The surface could not be joined to the rims.
    #[error(transparent)]
    NotJoined(StitchError),
    /// So many faces of the patch intersect others.
    #[error("{0} faces of the patch intersected others")]
    Crossing(usize),
}

/// Why sharp edges that end at a rim were not continued across its hole.
#[derive(Clone, Debug, Error, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum NotContinued {
    /// The smooth sides round the rim have no continuation that closes the hole: why.
    #[error("{0}")]
    Declined(String),
    /// Number of faces of the continued sides that intersect others.
    #[error("{0} faces of the continued sides intersected others")]
    Intersects(usize),
    /// A smooth patch predicts the rings of faces round the hole about as well as the continued sides.
    #[error("a smooth patch predicts the faces round the hole as well")]
    Predicted,
    /// No ring of faces can be taken out to be predicted, and the sides are too far from their fitted surfaces to be continued unseen.
    #[error("the sides round the hole are too rough")]
    Rough,
    /// No ring of faces can be taken out to be predicted, and the edges may be rounded ones.
    #[error("the edges may be rounded")]
    Rounded,
}

/// What closed a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ClosedBy {
    /// The surface of the level set.
    LevelSet,
    /// Triangulations of the rims, refined and faired.
    Faired,
    /// The smooth sides round it, continued until they meet in sharp or rounded edges.
    Sides,
    /// The part of a counterpart that lies there: of the mirrored mesh, or of a template.
    Counterpart,
    /// A nearly flat cap, the surface of least area, because the caller asked for it.
    Flat,
    /// A flat base under a sheet, with walls down from its border, because the caller asked for it.
    Base,
    /// Thin triangles between two rims that lie on each other.
    Seam,
    /// Triangles between the vertices of each rim.
    RimTriangles,
    /// In a repair: a second layer under the surface round the rims, which ends where it can be closed, or goes on until it lines all of
    /// the component.
    Lining,
    /// Some rim of it is still open.
    Nothing,
}

/// How many holes ended in which way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Tally {
    /// Filled by the level set.
    pub filled: usize,
    /// Closed by faired triangulations of their rims.
    pub faired: usize,
    /// Closed by flat caps, as was asked.
    pub flat: usize,
    /// Outer borders of sheets closed by flat bases with walls, as was asked.
    pub bases: usize,
    /// Outer borders of sheets closed by walls under the sheets.
    pub walls: usize,
    /// Closed by triangles between the vertices of their rims.
    pub triangulated: usize,
    /// Left as they were because they were not asked for.
    pub left: usize,
    /// To be filled but still open.
    pub failed: usize,
    /// Boundary chains that do not close.
    pub open_chains: usize,
    /// Patches with faces that intersect other faces.
    pub crossing_patches: usize,
    /// Those faces.
    pub crossing_faces: usize,
}
