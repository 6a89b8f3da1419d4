//! The planes of the bases of regions: each lies below all of its sheet, of which a region knows a part.

use super::Inspection;
use crate::fill::{BasePlane, FillParams, RegionPlan};

/// For each group of holes the plane of its base, if it gets one.
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
