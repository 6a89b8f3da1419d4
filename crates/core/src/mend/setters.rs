//! Chained setters of [`RestoreParams`] and [`FairParams`].

use super::params::{FairExtent, FairParams, RestoreParams};
use crate::fill::FillParams;
use crate::region::VoxelSize;
use crate::setters::setters;

setters! { RestoreParams:
    /// Sets [`RestoreParams::fill`].
    with_fill(fill: FillParams) => fill = fill;
    /// Sets [`RestoreParams::keep_shape`], from 0 to 1.
    ///
    /// ```
    /// let params = isomend::RestoreParams::new().with_keep_shape(0.5);
    /// assert_eq!(params.keep_shape, 0.5);
    /// ```
    with_keep_shape(part: f64) => keep_shape = part;
    /// Sets [`RestoreParams::keep_vertices`].
    with_keep_vertices(keep: bool) => keep_vertices = keep;
}

setters! { FairParams:
    /// Sets [`FairParams::extent`].
    ///
    /// ```
    /// use isomend::{FairExtent, FairParams};
    ///
    /// let params = FairParams::new().with_extent(FairExtent::Strength(2.5));
    /// assert_eq!(params.extent, FairExtent::Strength(2.5));
    /// ```
    with_extent(extent: FairExtent) => extent = extent;
    /// Sets [`FairParams::voxel`].
    with_voxel(voxel: impl Into<VoxelSize>) => voxel = voxel.into();
    /// Sets [`FairParams::edge_ratio`].
    with_edge_ratio(ratio: f64) => edge_ratio = ratio;
    /// Sets [`FairParams::keep_vertices`].
    with_keep_vertices(keep: bool) => keep_vertices = keep;
}
