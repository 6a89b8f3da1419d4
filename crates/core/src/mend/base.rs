//! The planes of flat bases: each is below its whole sheet, although a region holds only a part of the sheet.

use super::Inspection;
use crate::fill::{BasePlane, FillParams, RegionPlan};

/// The plane of the flat base of each group of holes, for groups that get one.
pub(super) fn base_planes(
    found: &Inspection,
    params: &FillParams,
    groups: &[Vec<usize>],
    plans: &[RegionPlan],
) -> Vec<Option<BasePlane>> {
    if !plans.contains(&RegionPlan::Base) {
        return vec![None; plans.len()];
    }
    let extents = found.topology.component_bounds(&found.mesh);
    let plane = |(group, plan): (&Vec<usize>, &RegionPlan)| {
        let ([hole], RegionPlan::Base) = (&group[..], plan) else {
            return None;
        };
        let hole = &found.holes[*hole];
        let extent = extents[hole.component as usize];
        Some(BasePlane::new(hole, extent, params.base_offset))
    };
    groups.iter().zip(plans).map(plane).collect()
}
