//! The signed distances that a region is given as data.

use glam::DVec3;

use super::sphere::Sphere;
use crate::cancel::Cancel;

/// What is known at a point.
#[derive(Clone, Copy, Debug)]
pub struct NodeData {
    /// Signed distance in world units, negative inside.
    pub signed: f64,
    /// Unsigned distance to the known surface in world units.
    pub distance: f64,
    /// Whether the missing surface may be nearer: the point is nearest to a rim, or near a hole and far from what is known.
    pub free: bool,
}

/// What a sample is needed for, so that less accurate ones can be faster.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// The sign at a free point may be wrong: the start of the flow gives it another value.
    pub rough: bool,
    /// Beyond this, in world units, the distance need not be that to the smooth surface.
    pub reach: f64,
    /// Beyond this distance, in world units, points near a hole are free though an opposite wall is nearer than the rim: in thin
    /// parts, or where far faces are seen through the hole.
    pub deep: f64,
}

impl Wanted {
    /// Everything, as exactly as it can be told.
    pub fn exact() -> Self {
        Self {
            rough: false,
            reach: f64::INFINITY,
            deep: f64::INFINITY,
        }
    }
}

/// A signed distance with a hole in it.
pub trait DistanceData: Sync {
    /// The data at the world point `x`; `limit` is an upper bound of the distance in world units, infinite where none is known.
    fn sample(&self, x: DVec3, limit: f64) -> NodeData;
    /// The same as accurately as it is wanted, and the closest point of the known surface where there is one.
    fn sample_for(&self, x: DVec3, limit: f64, wanted: &Wanted) -> (NodeData, Option<DVec3>) {
        let _ = wanted;
        (self.sample(x, limit), None)
    }
    /// A first guess of the signed distance at a free point, in world units, from a triangulation of the holes; none where there is none.
    fn guess(&self, x: DVec3) -> Option<f64> {
        let _ = x;
        None
    }
    /// The sphere that continues the surface at the rims; none where they lie on none.
    fn sphere(&self) -> Option<Sphere> {
        None
    }
    /// The token that stops what is computed from the data; none where nothing does.
    fn cancel(&self) -> Option<&Cancel> {
        None
    }
    /// World positions of the rims' vertices, where only the zero set that meets a rim evolves.
    fn rims(&self) -> Vec<DVec3> {
        Vec::new()
    }
    /// The weight of the pull to a surface whose shape is kept, in 1 / length⁴; 0 where there is none.
    fn pull(&self) -> f64 {
        0.0
    }
    /// The signed distance to that surface at a free point, in world units; none where it says nothing about the missing one.
    fn kept_shape(&self, x: DVec3) -> Option<f64> {
        let _ = x;
        None
    }
}
