//! Interface of a smooth surface that supports a patch.

use glam::DVec3;

/// The smooth surface of a patch, for example the zero set of a level set function.
pub trait Surface: Sync {
    /// Projects `p` on the surface; returns the point and the unit outward normal there.
    ///
    /// `None` if the surface is not defined there or the projection did not converge.
    fn project(&self, p: DVec3) -> Option<(DVec3, DVec3)>;

    /// The distance from `p` to the rim, in world units, if `p` belongs to the hole, which means that its closest point on the
    /// input mesh is on a rim edge of the region; otherwise the negative distance to the mesh.
    fn depth(&self, p: DVec3) -> f64;

    /// Whether work on the surface should stop; its result will not be used.
    fn is_cancelled(&self) -> bool {
        false
    }
}
