//! Lines on holes that were not filled with the counterpart that the caller named.

use isomend_core::fill::RegionReport;
use isomend_core::mend::FillReport;
use isomend_core::mesh::Unit;

use super::counterpart::refused;
use super::text::named_holes;

/// Most holes that were not filled with a counterpart and of which each gets a line.
const MOST_REFUSED: usize = 3;

/// Lines on holes that were not filled with the requested counterpart: with the reason, unless there are many.
#[doc(hidden)]
pub fn refused_lines(report: &FillReport, unit: Option<Unit>) -> Vec<String> {
    let is_refused =
        |r: &&RegionReport| r.counterpart.as_ref().is_some_and(|c| c.refused.is_some());
    let regions = report.regions.iter().filter(is_refused);
    let all: Vec<_> = regions
        .filter_map(|r| Some((r, refused(r, unit)?)))
        .collect();
    if all.len() > MOST_REFUSED {
        return vec![format!(
            "{} regions not filled with a counterpart (-v says why)",
            all.len()
        )];
    }
    let line = |(r, why): (&RegionReport, String)| format!("{} {why}", named_holes(&r.holes));
    all.into_iter().map(line).collect()
}
