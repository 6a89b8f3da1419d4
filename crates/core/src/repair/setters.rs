//! Chainable setters of [`RepairParams`].

use super::params::{RepairParams, RepairStep};
use crate::fill::FillParams;
use crate::setters::setters;

setters! { RepairParams:
    /// Sets [`RepairParams::skip`].
    ///
    /// ```
    /// use isomend::{RepairParams, RepairStep};
    /// let params = RepairParams::new().with_skip([RepairStep::Holes]);
    /// assert!(!params.does(RepairStep::Holes) && params.check().is_ok());
    /// ```
    with_skip(steps: impl IntoIterator<Item = RepairStep>) => skip = steps.into_iter().collect();
    /// Sets [`RepairParams::weld`], in the mesh's units.
    with_weld(length: f64) => weld = Some(length);
    /// Sets [`RepairParams::drop_unused`].
    with_drop_unused(drop: bool) => drop_unused = drop;
    /// Sets [`RepairParams::drop`].
    with_drop(numbers: impl IntoIterator<Item = usize>) => drop = numbers.into_iter().collect();
    /// Sets [`RepairParams::debris`], a fraction of an area.
    ///
    /// ```
    /// let params = isomend::RepairParams::new().with_debris(0.01);
    /// assert_eq!(params.debris, Some(0.01));
    /// ```
    with_debris(part: f64) => debris = Some(part);
    /// Sets [`RepairParams::drop_inside`].
    with_drop_inside(drop: bool) => drop_inside = drop;
    /// Sets [`RepairParams::solid`].
    with_solid(solid: bool) => solid = solid;
    /// Sets [`RepairParams::borders`].
    with_borders(fill: bool) => borders = fill;
    /// Sets [`RepairParams::wall`], in the mesh's units.
    with_wall(length: f64) => wall = Some(length);
    /// Sets [`RepairParams::min_wall`], in the mesh's units.
    with_min_wall(length: f64) => min_wall = Some(length);
    /// Sets [`RepairParams::fill`].
    with_fill(fill: FillParams) => fill = fill;
}
