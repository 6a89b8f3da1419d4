//! Chained setters of [`FillParams`].

use super::like::Like;
use super::params::{FillParams, Finish, Sharp};
use crate::flow::Energy;
use crate::mesh::HoleId;
use crate::region::VoxelSize;
use crate::setters::setters;

/// Converts to a list of hole numbers.
fn ids<T: Into<HoleId>>(holes: impl IntoIterator<Item = T>) -> Vec<HoleId> {
    holes.into_iter().map(Into::into).collect()
}

setters! { FillParams:
    /// Sets [`FillParams::voxel`].
    with_voxel(voxel: impl Into<VoxelSize>) => voxel = voxel.into();
    /// Fills these holes only; see [`FillParams::holes`].
    ///
    /// ```
    /// use isomend::{Energy, FillParams};
    ///
    /// let params = FillParams::new()
    ///     .with_holes([2, 5])
    ///     .with_max_diameter(0.3)
    ///     .with_energy(Energy::CurvatureVariation);
    /// assert_eq!(params.holes, Some(vec![2.into(), 5.into()]));
    /// assert_eq!(params.max_diameter, Some(0.3));
    /// params.check()?;
    /// # Ok::<(), isomend::FillError>(())
    /// ```
    with_holes(holes: impl IntoIterator<Item = impl Into<HoleId>>) => holes = Some(ids(holes));
    /// Leaves wider holes open; see [`FillParams::max_diameter`].
    with_max_diameter(length: f64) => max_diameter = Some(length);
    /// Keeps these holes open; see [`FillParams::keep_open`].
    with_keep_open(holes: impl IntoIterator<Item = impl Into<HoleId>>) => keep_open = ids(holes);
    /// Fills the holes of each group in one region; see [`FillParams::bridge`].
    ///
    /// ```
    /// let params = isomend::FillParams::new().with_bridges([[1, 4], [2, 3]]);
    /// assert_eq!(params.bridge[1], [2.into(), 3.into()]);
    /// ```
    with_bridges(groups: impl IntoIterator<Item = impl IntoIterator<Item = impl Into<HoleId>>>) => bridge = groups.into_iter().map(ids).collect();
    /// Closes these holes by nearly flat caps; see [`FillParams::flat`].
    with_flat(holes: impl IntoIterator<Item = impl Into<HoleId>>) => flat = ids(holes);
    /// Sets [`FillParams::apart`].
    with_apart(apart: bool) => apart = apart;
    /// Continues sharp edges between these pairs of crease ends; see [`FillParams::crease`].
    ///
    /// ```
    /// let params = isomend::FillParams::new().with_creases([[1, 2]]);
    /// assert_eq!(params.crease, [[1, 2]]);
    /// ```
    with_creases(pairs: impl IntoIterator<Item = [usize; 2]>) => crease = pairs.into_iter().collect();
    /// Sets [`FillParams::flat_base`].
    with_flat_base(base: bool) => flat_base = base;
    /// Sets [`FillParams::base_offset`], in the mesh's units.
    with_base_offset(length: f64) => base_offset = Some(length);
    /// Fills holes with the shape of a counterpart; see [`FillParams::like`].
    ///
    /// ```
    /// let params = isomend::FillParams::new().with_like(isomend::Like::Mirror(None));
    /// assert_eq!(params.like, Some("mirror".parse()?));
    /// # Ok::<(), String>(())
    /// ```
    with_like(like: Like) => like = Some(like);
    /// Sets [`FillParams::grain`].
    with_grain(grain: bool) => grain = grain;
    /// Sets [`FillParams::finish`].
    with_finish(finish: Finish) => finish = finish;
    /// Sets [`FillParams::sharp`].
    with_sharp(sharp: Sharp) => sharp = sharp;
    /// Sets [`FillParams::energy`].
    with_energy(energy: Energy) => energy = energy;
    /// Sets [`FillParams::edge_ratio`].
    with_edge_ratio(ratio: f64) => edge_ratio = Some(ratio);
}
