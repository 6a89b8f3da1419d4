//! The planes of flat bases: each is below its whole sheet, although a region holds only a part of the sheet.

use super::Inspection;
use crate::fill::{BasePlane, Closure, FillParams};

/// The plane of the flat base of each group of holes, for groups that get one.
pub(super) fn base_planes(
    found: &Inspection,
    params: &FillParams,
    groups: &[Vec<usize>],
    decided: &[Option<Closure>],
) -> Vec<Option<BasePlane>> {
    if !decided.contains(&Some(Closure::Base)) {
        return vec![None; decided.len()];
    }
    let extents = found.topology.component_bounds(&found.mesh);
    let plane = |(group, closure): (&Vec<usize>, &Option<Closure>)| {
        let ([hole], Some(Closure::Base)) = (&group[..], closure) else {
            return None;
        };
        let hole = &found.holes[*hole];
        let extent = extents[hole.component as usize];
        Some(BasePlane::new(hole, extent, params.base_offset))
    };
    groups.iter().zip(decided).map(plane).collect()
}
