//! What a try at a region came to.

use super::report::RegionReport;
use super::tries::Verdict;
use crate::mesh::Mesh;
use crate::region::{MeshData, Region, Solved};
use crate::stitch::Patch;

/// What a try came to.
pub(super) struct Tried<'a> {
    pub(super) verdict: Verdict,
    pub(super) report: RegionReport,
    /// The surface, where it was joined or is all that was asked for.
    pub(super) patch: Option<Found>,
    /// What it was extracted from, where it was not joined for want of rest.
    pub(super) unsteady: Option<Unsteady<'a>>,
}

/// A surface that is nearly steady.
pub(super) struct Unsteady<'a> {
    pub(super) solved: Solved,
    pub(super) region: Region,
    pub(super) data: MeshData<'a>,
    pub(super) report: RegionReport,
}

/// The surface that a try found.
pub(super) enum Found {
    /// A patch.
    Patch(Patch),
    /// The zero set by itself.
    Whole(Mesh),
}
