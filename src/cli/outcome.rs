//! What a run did to holes: the table of the patches, with advice on problems, and the holes that were left open.

use std::collections::BTreeSet;

use isomend::job::{JobResult, OperationReport, Work};
use isomend::report::{
    ClosedRow, ClosedTable, Remark, chain_lines, closed_rows, defect_lines, left_holes,
    lost_creases, named_holes, refused_lines, weighed_lines,
};
use isomend::{FillReport, HoleId, LeftReason};

/// What a remark means and what to do, to follow `hole 3:` or `holes 3, 5:`. Options can name holes with numbers up to `last`.
fn meaning(remark: Remark, ids: &[HoleId], work: &Work, last: usize) -> String {
    let can_name =
        matches!(work, Work::Fill(_) | Work::Repair(_)) && ids.iter().all(|id| id.get() <= last);
    let flat = match (can_name, ids) {
        (true, [one]) => format!("; --flat {one} makes a flat cap instead"),
        (true, _) => "; --flat with their numbers makes flat caps instead".to_owned(),
        _ => String::new(),
    };
    match remark {
            Remark::Open => "could not be closed; the reasons are below".to_owned(),
            Remark::Intersects => {
                let cuts = match work {
                    Work::Repair(_) => "",
                    _ => "`isomend repair` cuts these faces out, ",
                };
                format!("faces of the patch intersect other faces; {cuts}a finer --voxel may avoid them")
            }
            Remark::NoCap => "the requested flat cap could not be made, so the hole was closed by triangles between the vertices of the rim"
                .to_owned(),
            Remark::NoSurface => format!(
                "the level set found no surface, so the rim was triangulated and smoothed (-v says why){flat}"
            ),
            Remark::RimTriangles => format!(
                "closed by triangles between the vertices of the rim, since no smooth surface was found (-v says why){flat}"
            ),
            Remark::NotConverged => {
                "the surface was still moving after the last step; try a finer --voxel".to_owned()
            }
            Remark::LostCreases => {
                "sharp edges end at their rims and were not continued (-v says why)".to_owned()
            }
            Remark::Bulges => format!("the patch rises far above the rim; check its shape{flat}"),
            Remark::Unsure => "the patch may be far off, by a sixth of its diameter or more; check its shape".to_owned(),
            Remark::SeparateCaps => "the rims were closed by separate caps instead of a bridge, because their surroundings do not lead from one \
                            rim to the other"
                .to_owned(),
            Remark::OtherEnergy => {
                "the variation of curvature found no surface, so the Willmore energy was used"
                    .to_owned()
            }
        }
}
/// Remarks on the mesh that was read: its defects, and boundary chains that do not close.
pub fn remarks(report: &FillReport) -> Vec<String> {
    let mut lines = defect_lines(&report.input.defects);
    lines.extend(chain_lines(&report.input.open_chains));
    lines
}

/// All lines on a fill except its remarks and the summary line: the table, advice, and holes left open. `width` is the width of the terminal,
/// if it is known. Options can name holes with numbers up to
/// `last`.
pub fn lines(done: &JobResult, last: usize, verbose: bool, width: Option<usize>) -> Vec<String> {
    let (report, work) = (&done.report, &done.spec.work);
    let mut lines = Vec::new();
    let rows = closed_rows(report);
    let table = ClosedTable {
        unit: done.spec.deliverables.unit,
        width,
        limited: (!verbose).then_some(" (-v lists them)"),
    };
    lines.extend(table.lines(report, &rows));
    lines.extend(advice(&rows, work, last));
    lines.extend(report.joined_walls().into_iter().map(|[a, b]| {
        format!("holes {a} and {b} are the two sides of a wall: joined by the edge of an opening; --apart closes each side")
    }));
    lines.extend(weighed_lines(report, done.spec.deliverables.unit));
    if !verbose && matches!(work, Work::Fill(params) if params.like.is_some()) {
        lines.extend(refused_lines(report, done.spec.deliverables.unit));
    }
    lines.extend(left(report, work));
    if let (Work::Repair(params), OperationReport::Repaired(repair)) = (work, &done.extent)
        && params.solid
        && repair.steps.inner_skins == 0
    {
        lines.push(NO_INNER_SKIN.to_owned());
    }
    lines
}

/// The line of a repair with `--solid` that found no inner skin.
const NO_INNER_SKIN: &str = "no inner skin was found: --solid removes skins at a constant small distance behind the outer one, with openings of \
                             at most three times this distance";

/// Advice, one line for each remark with all its holes.
fn advice(rows: &[ClosedRow], work: &Work, last: usize) -> Vec<String> {
    let line = |remark: &Remark| {
        let own: Vec<&ClosedRow> = rows.iter().filter(|r| r.remark == Some(*remark)).collect();
        let ids: BTreeSet<HoleId> = own.iter().flat_map(|r| r.holes.clone()).collect();
        let ids: Vec<HoleId> = ids.into_iter().collect();
        let text = match (remark, &own[..]) {
            (_, []) => return None,
            (Remark::LostCreases, [one]) => lost_creases(one.region)?,
            _ => meaning(*remark, &ids, work, last),
        };
        let has_pair = own.iter().any(|row| row.region.crease_ends > 1);
        let more = match (remark, work) {
            (Remark::LostCreases, Work::Fill(params)) if has_pair && params.crease.is_empty() => {
                BY_HAND
            }
            _ => "",
        };
        Some(format!("{}: {text}{more}", named_holes(&ids)))
    };
    Remark::ALL.iter().filter_map(line).collect()
}

/// Advice for continuing sharp edges by hand.
const BY_HAND: &str = "; --crease A+B continues one between the crease ends A and B (`isomend inspect -v` lists them)";

/// The holes that were left open, with the reason and the option that changes it.
fn left(report: &FillReport, work: &Work) -> Vec<String> {
    let repairs = matches!(work, Work::Repair(_));
    let line = |(why, ids): &(LeftReason, Vec<HoleId>)| {
        let text = match why {
            LeftReason::OuterBoundary if repairs => {
                "the outer border of an open sheet; --close-borders closes it".to_owned()
            }
            LeftReason::KeptOpen if repairs => {
                "as --skip holes, --keep-open or --max-diameter requests".to_owned()
            }
            LeftReason::TooWide => {
                let them = if ids.len() == 1 { "it" } else { "them" };
                format!("{why}; a larger --max-diameter fills {them}")
            }
            LeftReason::OuterBoundary => format!("{why} (--holes with its number)"),
            LeftReason::NotChosen => {
                let them = if ids.len() == 1 { "it" } else { "them" };
                format!("{why}; add {them} to --holes to fill {them}")
            }
            LeftReason::KeptOpen => format!("{why} (--keep-open)"),
            _ => why.to_string(),
        };
        format!("{} left open: {text}", named_holes(ids))
    };
    left_holes(report).iter().map(line).collect()
}
