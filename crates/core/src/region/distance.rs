//! The interface through which a region reads signed distances.

use glam::DVec3;

use super::sphere::Sphere;
use crate::cancel::Cancel;

/// Data of a region at one point.
#[derive(Clone, Copy, Debug)]
pub struct NodeData {
    /// Signed distance in world units, negative inside.
    pub signed: f64,
    /// Unsigned distance to the known surface in world units.
    pub distance: f64,
    /// Whether the missing surface may be nearer: the point is nearest to a rim, or near a hole and far from the known surface.
    pub free: bool,
}

/// The accuracy that a sample needs; less accurate ones can be faster.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// The sign at a free point may be wrong: the initialisation of the flow replaces the value.
    pub any_sign: bool,
    /// World units. Beyond this distance the distance to the triangles suffices; that to the smooth surface is not needed.
    pub reach: f64,
    /// World units. Beyond this distance points near a hole are free although an opposite wall is nearer than the rim: in thin
    /// parts, or where far faces are seen through the hole.
    pub deep: f64,
}

impl Wanted {
    /// Full accuracy.
    pub fn exact() -> Self {
        Self {
            any_sign: false,
            reach: f64::INFINITY,
            deep: f64::INFINITY,
        }
    }
}

/// A signed distance that is unknown near holes.
pub trait DistanceData: Sync {
    /// The data at the world point `x`. `limit` is an upper bound of the distance in world units, infinite where none is known.
    fn sample(&self, x: DVec3, limit: f64) -> NodeData;
    /// The same with the wanted accuracy, and the closest point of the known surface where there is one.
    fn sample_for(&self, x: DVec3, limit: f64, wanted: &Wanted) -> (NodeData, Option<DVec3>) {
        let _ = wanted;
        (self.sample(x, limit), None)
    }
    /// An initial guess of the signed distance at a free point, in world units, from a triangulation of the holes; none where
    /// there is none.
    fn guess(&self, x: DVec3) -> Option<f64> {
        let _ = x;
        None
    }
    /// The sphere that continues the surface at the rims; none where they do not fit one.
    fn sphere(&self) -> Option<Sphere> {
        None
    }
    /// The token that stops the sampling; none where it cannot be stopped.
    fn cancel(&self) -> Option<&Cancel> {
        None
    }
    /// World positions of the rims' vertices, if only components of the zero set that touch a rim evolve; else empty.
    fn rims(&self) -> Vec<DVec3> {
        Vec::new()
    }
    /// The weight of the pull towards a reference surface, in 1 / length⁴; 0 where there is none.
    fn pull(&self) -> f64 {
        0.0
    }
    /// The signed distance to the reference surface at a free point, in world units; none where it has no shape there.
    fn kept_shape(&self, x: DVec3) -> Option<f64> {
        let _ = x;
        None
    }
}
