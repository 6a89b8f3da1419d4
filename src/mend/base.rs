//! The plane of the base of a region: it lies below all of the sheet, of which a region knows a part.

use super::Inspection;
use crate::fill::{BasePlane, FillParams, RegionPlan};
use crate::mesh::Hole;

/// The plane of the base of a region with some holes, if it gets one.
pub(super) fn base_plane(
    found: &Inspection,
    holes: &[&Hole],
    plan: RegionPlan,
    params: &FillParams,
) -> Option<BasePlane> {
    let ([hole], RegionPlan::Base) = (holes, plan) else {
        return None;
    };
    let (mesh, topology) = (&found.mesh, &found.topology);
    let own = mesh.faces.iter().zip(&topology.piece);
    let own = own.filter(|(_, piece)| **piece == hole.piece);
    let vertices = own.flat_map(|(f, _)| f.map(|v| mesh.positions[v as usize]));
    Some(BasePlane::new(hole, vertices, params.base_offset))
}
