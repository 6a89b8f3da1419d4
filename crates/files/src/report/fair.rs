//! The report of a fairing, or of what a restoration cuts out, as text.

use super::counted;
use super::text::named_holes;
use isomend_core::mend::{FairReport, KeptObject, RestoreReport};
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

/// How many faces were marked, and how many were cut out for them.
#[doc(hidden)]
pub fn cut_out(marked: usize, removed: usize) -> String {
    format!("{} marked, {removed} cut out", counted(marked, "face"))
}

/// The part of the surface that was faired: marked by the caller, or all but the surroundings of the boundary. None if whole surfaces were
/// replaced.
#[doc(hidden)]
pub fn faired_part(report: &FairReport, is_marked: bool) -> Option<String> {
    let is_whole = match &report.objects[..] {
        [] => report.whole,
        objects => objects.iter().all(|object| object.report.whole),
    };
    let removed = report.removed_faces;
    let text = match is_marked {
        true => cut_out(report.marked_faces, removed),
        false => format!(
            "{} replaced; a strip along the boundary of the mesh stays, since it is open",
            counted(removed, "face")
        ),
    };
    (!is_whole).then_some(text)
}

/// An object that could not be faired, with the reason.
#[doc(hidden)]
pub fn kept_object(object: &KeptObject) -> String {
    format!("{} stays unchanged: {}", object.name, object.reason)
}

/// The holes of the input that the region of a restoration reaches, which are closed with it. None if it reaches no hole.
#[doc(hidden)]
pub fn joined_holes(report: &RestoreReport) -> Option<String> {
    let holes = &report.joined_holes[..];
    let verb = if holes.len() == 1 { "is" } else { "are" };
    (!holes.is_empty()).then(|| {
        format!(
            "the region reaches {} of the input, which {verb} closed with it",
            named_holes(holes)
        )
    })
}
