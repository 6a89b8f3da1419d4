//! The report of a fairing as text.

use super::counted;
use isomend_core::mend::FairReport;
use isomend_core::mesh::{Unit, number};

/// What was smoothed away, and the flow that did it.
#[doc(hidden)]
pub fn faired_measures(report: &FairReport, unit: Option<Unit>) -> String {
    format!(
        "features narrower than {} were removed, time {}, voxel {}",
        Unit::text(unit, report.strength),
        number(report.time),
        Unit::text(unit, report.voxel)
    )
}

/// The part of the surface that was faired: marked by the caller, or all but the surroundings of the boundary.
#[doc(hidden)]
pub fn faired_part(report: &FairReport, is_marked: bool) -> String {
    let removed = report.removed_faces;
    match is_marked {
        true => {
            let marked = counted(report.marked_faces, "face");
            format!("{marked} marked, {removed} cut out")
        }
        false => format!(
            "{} replaced; a strip along the boundary of the mesh stays, since it is open",
            counted(removed, "face")
        ),
    }
}
