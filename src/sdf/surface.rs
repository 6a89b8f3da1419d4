//! A smooth surface that patches lie on.

use glam::DVec3;

/// The smooth surface a patch lies on, such as the zero set of a level set function.
pub trait Surface: Sync {
    /// Projects `p` on the surface: the point and the unit outward normal there.
    ///
    /// None where the surface is not defined or the projection did not converge.
    fn project(&self, p: DVec3) -> Option<(DVec3, DVec3)>;

    /// The distance from `p` to the rim, in world units, if `p` belongs to the hole, which is where its closest point on the input mesh lies
    /// on a rim edge of the region; otherwise the negative distance to the mesh.
    fn depth(&self, p: DVec3) -> f64;

    /// Whether work on the surface is to stop: its result will not be used.
    fn is_cancelled(&self) -> bool {
        false
    }
}
