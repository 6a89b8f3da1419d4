//! The holes of a region, and what is decided for it before it is solved.

use super::Inspection;
use crate::fill::{BasePlane, Closure, FillParams};
use crate::mesh::Hole;

/// The holes of one region, and what is decided for it before it is solved.
pub(super) struct HoleGroup {
    /// The holes, as indices.
    pub(super) holes: Vec<usize>,
    /// The closure, where it is known beforehand; none where the region gets a continued surface.
    pub(super) decided: Option<Closure>,
    /// Pairs of rim vertices between which the caller wants sharp edges.
    pub(super) joined: Vec<[u32; 2]>,
    /// The plane of its flat base, which is below the whole sheet, although a region holds only a part of that.
    pub(super) base: Option<BasePlane>,
}

/// Decides for each group of holes what is known before it is solved.
pub(super) fn hole_groups(
    found: &Inspection,
    params: &FillParams,
    groups: Vec<Vec<usize>>,
) -> Vec<HoleGroup> {
    let new = |holes: Vec<usize>| {
        let own: Vec<&Hole> = holes.iter().map(|&h| &found.holes[h]).collect();
        HoleGroup {
            decided: Closure::decided(&found.mesh, &own, params),
            holes,
            joined: Vec::new(),
            base: None,
        }
    };
    let mut groups: Vec<HoleGroup> = groups.into_iter().map(new).collect();
    let on_base = |group: &HoleGroup| group.decided == Some(Closure::Base);
    if groups.iter().any(on_base) {
        let extents = found.topology.component_bounds(&found.mesh);
        for group in groups.iter_mut().filter(|group| on_base(group)) {
            let hole = &found.holes[group.holes[0]];
            let extent = extents[hole.component as usize];
            group.base = Some(BasePlane::new(hole, extent, params.base_offset));
        }
    }
    groups
}
