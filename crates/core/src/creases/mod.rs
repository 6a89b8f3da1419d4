//! Creases across a hole: continues sharp edges from the rim as intersections of smooth sides, and fills the parts between them.

mod collar;
mod curve;
mod given_pairs;
mod labels;
mod network;
mod parts;
mod patch;
mod residuals;
mod rim_sides;
mod rings;
mod rounded;
mod rounding;
mod segment;
mod sheet;
#[cfg(test)]
mod tests;

use glam::DVec3;
use thiserror::Error;

pub(crate) use parts::{circle, is_well_inside};
pub(crate) use rim_sides::{RimSides, SharpEnd};
pub(crate) use rings::without_rings;
pub(crate) use rounded::Rounded;

/// Why no creases are continued across a hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub(crate) enum CreaseRefusal {
    /// The rim is not a single loop of edges with one face each.
    #[error("the rim is not a simple loop")]
    Rim,
    /// No smooth side reaches the rim.
    #[error("no smooth side reaches the rim")]
    NoSide,
    /// There are more smooth sides around the rim than are searched.
    #[error("there are too many smooth sides around the rim")]
    ManySides,
    /// The rim is not on the sheets of its edges.
    #[error("the rim is not on the smooth sides around it")]
    RimOff,
    /// The whole rim is on one curved side and does not run along a crease.
    #[error("the rim is on one curved side, without a crease")]
    OneSide,
    /// Two sides meet at an angle too small for a crease.
    #[error("sides meet smoothly, without a crease")]
    Smooth,
    /// Two sides face each other.
    #[error("sides fold back on each other")]
    Folds,
    /// More than three sides meet, and no three consecutive ones have a common corner.
    #[error("{0} sides meet without a common corner")]
    Arcs(usize),
    /// Three sheets have no common point near the hole.
    #[error("three sides have no common corner near the hole")]
    NoCorner,
    /// A crease misses the rim vertex at which it should end.
    #[error("a crease does not reach the rim")]
    EndOffCrease,
    /// Two sheets do not intersect between two ends.
    #[error("two sides do not meet across the hole")]
    NoCrease,
    /// A crease is too long for its ends.
    #[error("a crease is too long")]
    LongCrease,
    /// A part of the patch turns too far to be unrolled.
    #[error("a part of the patch turns too far to be unrolled")]
    Turns,
    /// A part of the patch has the wrong orientation.
    #[error("a part of the patch has reversed orientation")]
    Reversed,
    /// The outline of a part intersects itself.
    #[error("the outline of a part of the patch intersects itself")]
    Crosses,
    /// A part is too large for the edge length at the rim.
    #[error("a part of the patch is too large for the edge length at the rim")]
    TooLarge,
    /// Two parts have the same edge, or a part has an edge of the mesh.
    #[error("the parts of the patch do not join to a manifold")]
    NotManifold,
}

impl CreaseRefusal {
    /// Whether shifting the ends of creases along the rim may help.
    fn may_shift(self) -> bool {
        matches!(self, Self::Crosses | Self::NotManifold | Self::Reversed)
    }
}

/// A patch with creases.
#[derive(Clone, Debug)]
pub(crate) struct Continued {
    /// Positions of the new vertices, which are numbered after the mesh's vertices.
    pub(crate) positions: Vec<DVec3>,
    pub(crate) faces: Vec<[u32; 3]>,
    pub(crate) creases: Vec<Crease>,
    /// Whether it is a single flat side.
    pub is_flat: bool,
    /// The largest residual of the sheets of its parts, in edges.
    pub(crate) residual: f64,
    /// The side of each part, and the part's new vertices, as indices of `positions`.
    parts: Vec<(usize, Vec<usize>)>,
}

/// How far a patch with creases is determined by the data of its sheets.
#[derive(Clone, Debug)]
pub(crate) struct Determined {
    /// The largest noise of the data of a sheet, in edges.
    pub(crate) noise: f64,
    /// Standard deviation of the sheets at each new vertex, from the noise of their data, in the mesh's units; the largest where
    /// sheets meet.
    pub(crate) deviations: Vec<f64>,
}

/// A crease across a hole.
#[derive(Clone, Debug)]
pub(crate) struct Crease {
    /// Length in the mesh's units.
    pub(crate) length: f64,
    /// Mean angle between the normals of both sides along it, in degrees.
    pub(crate) angle: f64,
}
