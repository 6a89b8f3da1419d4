//! A remark where a flat base was asked for, and no sheet has an outer border that gets one.

use isomend_core::fill::{Closure, HoleOutcome};
use isomend_core::mend::HoleReport;
use isomend_core::tuning::{Tunable, tunable};

/// Distance of a rim from its plane in diameters, for which a flat cap is named.
const FLAT_RIM: Tunable<f64> = tunable("job.flat_rim", 0.02);

/// The remark, from what became of the holes. It names the widest rim if that is flat and has no flat cap.
pub(super) fn note(holes: &[HoleReport]) -> Option<String> {
    let is_base = |h: &HoleReport| h.outcome == HoleOutcome::Closed(Closure::Base);
    if holes.iter().any(is_base) {
        return None;
    }
    let diameter = |h: &HoleReport| h.hole.diameter;
    let widest = holes
        .iter()
        .max_by(|a, b| diameter(a).total_cmp(&diameter(b)));
    let flat = widest.filter(|h| {
        h.hole.planarity < FLAT_RIM.get() && h.outcome != HoleOutcome::Closed(Closure::Flat)
    });
    let advice = flat.map_or(String::new(), |h| {
        format!(
            "; --flat {} gives hole {0}, whose rim is flat, a flat cap",
            h.hole.id.get()
        )
    });
    Some(format!(
        "no sheet has an outer border, so nothing was put on a flat base{advice}"
    ))
}
