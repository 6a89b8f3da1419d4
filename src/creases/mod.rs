//! Sharp edges continued across a hole: the smooth sides round the rim, where their continuations meet, and the parts between.

mod collar;
mod curve;
mod joined;
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

pub(crate) use rim_sides::{CreaseEnd, RimSides};
pub(crate) use rings::without_rings;
pub(crate) use rounded::Rounded;

/// Why no creases are continued across a hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub(crate) enum Declined {
    /// The rim is not one loop of edges with one face each.
    #[error("the rim is not a simple loop")]
    Rim,
    /// There is no smooth side at the rim.
    #[error("no smooth side comes to the rim")]
    NoSide,
    /// The rim lies off the sheets of its edges.
    #[error("the rim does not lie on smooth sides")]
    RimOff,
    /// All of the rim is on one side that is not flat, and runs along no crease.
    #[error("one side")]
    OneSide,
    /// Two sides meet at too small an angle for a crease.
    #[error("sides join smoothly")]
    Smooth,
    /// Two sides face each other.
    #[error("sides fold back")]
    Folds,
    /// More than three sides meet, and no three of them in a row in a corner.
    #[error("{0} sides meet")]
    Arcs(usize),
    /// Three sheets meet nowhere near.
    #[error("no corner")]
    NoCorner,
    /// A crease ends beside its rim vertex.
    #[error("a crease ends beside the rim")]
    EndOffCrease,
    /// Two sheets meet nowhere between two ends.
    #[error("sides do not meet")]
    NoCrease,
    /// A crease makes a detour.
    #[error("a crease is too long")]
    LongCrease,
    /// A part turns too far to be unrolled.
    #[error("a part turns too far")]
    Turns,
    /// A part is turned round.
    #[error("a part is reversed")]
    Reversed,
    /// A part meets itself.
    #[error("a part crosses itself")]
    Crosses,
    /// A part is too large for the edges at the rim.
    #[error("a part is too large")]
    TooLarge,
    /// Two parts have the same edge, or one of the mesh.
    #[error("parts are not joined to a manifold")]
    NotManifold,
}

impl Declined {
    /// Whether other ends of the creases may be better.
    fn may_shift(self) -> bool {
        matches!(self, Self::Crosses | Self::NotManifold | Self::Reversed)
    }
}

/// A patch with creases.
#[derive(Clone, Debug)]
pub(crate) struct Continued {
    /// Positions of its own vertices, numbered behind those of the mesh.
    pub(crate) positions: Vec<DVec3>,
    pub(crate) faces: Vec<[u32; 3]>,
    pub(crate) creases: Vec<Crease>,
    /// Whether it is one flat side.
    pub(crate) is_flat: bool,
    /// The largest residual of the sheets of its parts, in edges.
    pub(crate) residual: f64,
}

/// A crease across a hole.
#[derive(Clone, Debug)]
pub(crate) struct Crease {
    /// Its length in the mesh's units.
    pub(crate) length: f64,
    /// Mean angle between the normals of both sides along it, in degrees.
    pub(crate) angle: f64,
}
