//! The holes of a run as a table of at most 80 columns, with remarks on problems and advice.

use std::collections::{BTreeSet, HashMap};

use isomend::job::{JobResult, OperationReport, Work};
use isomend::report::{
    Remark, chain_lines, counted, defect_lines, left_holes, lost_creases, named_holes, number,
    significant, weighed_lines,
};
use isomend::{Closure, FillReport, HoleId, HoleReport, LeftReason, RegionReport, Unit};

/// Number of widest holes that the table always shows.
const LARGEST: usize = 10;
/// Most rows with a remark.
const MOST_PROBLEMS: usize = 30;
/// Width of the column of hole numbers, in characters; longer lists are cut off.
const NUMBERS: usize = 9;

/// A remark as the table shows it, at most 18 characters.
fn short(remark: Remark) -> &'static str {
    match remark {
        Remark::Open => "still open",
        Remark::Intersects => "intersects others",
        Remark::NoSurface => "no level set",
        Remark::RimTriangles => "no new vertices",
        Remark::NoCap => "no flat cap",
        Remark::NotConverged => "not converged",
        Remark::LostCreases => "edge not continued",
        Remark::Bulges => "bulges",
        Remark::SeparateCaps => "separate caps",
        Remark::OtherEnergy => "Willmore energy",
    }
}

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
            Remark::SeparateCaps => "the rims were closed by separate caps instead of a bridge, because their surroundings do not lead from one \
                            rim to the other"
                .to_owned(),
            Remark::OtherEnergy => {
                "the variation of curvature found no surface, so the Willmore energy was used"
                    .to_owned()
            }
        }
}
/// A row of the table.
struct Row<'a> {
    region: &'a RegionReport,
    edges: usize,
    remark: Option<Remark>,
    /// The object of a 3MF file that the holes belong to, if there are several.
    object: Option<&'a str>,
}

impl Row<'_> {
    fn line(&self, width: Option<usize>) -> String {
        let r = self.region;
        let error = r.finish.as_ref().and_then(|f| f.largest_expected_error());
        let cells = Cells {
            hole: &short_list(&r.holes, r.components),
            diameter: &number(r.diameter),
            edges: &self.edges.to_string(),
            closed_by: closed_by(r.closure.as_ref(), width.is_some_and(|width| width < WIDE)),
            error: &error.map_or("-".to_owned(), |e| significant(e, 2)),
            remark: self.remark.map(short).unwrap_or_default(),
        };
        let line = cells.line(width);
        match self.object {
            None => line,
            Some(object) => with_object(line, object, width.unwrap_or(WIDE)),
        }
    }
}

/// A row with the name of its object in the column of remarks. Names that do not fit in the width are cut off.
fn with_object(line: String, object: &str, width: usize) -> String {
    let start = HEADING.line(Some(width)).len() - HEADING.remark.len();
    let (mut line, mark) = match line.chars().count() > start {
        true => (line, ", in "),
        false => (format!("{line:<start$}"), "in "),
    };
    let room = width.saturating_sub(line.chars().count() + mark.len());
    let name: String = match object.chars().count() > room {
        true if room < 4 => return line.trim_end().to_owned(),
        true => object.chars().take(room - 3).chain("...".chars()).collect(),
        false => object.to_owned(),
    };
    line += mark;
    line + &name
}

/// The cells of a row.
struct Cells<'a> {
    hole: &'a str,
    diameter: &'a str,
    edges: &'a str,
    closed_by: &'a str,
    error: &'a str,
    remark: &'a str,
}

const HEADING: Cells<'static> = Cells {
    hole: "hole",
    diameter: "diameter",
    edges: "edges",
    closed_by: "closed by",
    error: "expected error",
    remark: "remark",
};

impl Cells<'_> {
    /// The cells in a line of 80 characters; in a narrower terminal in one of 60, without the number of edges.
    fn line(&self, width: Option<usize>) -> String {
        let Self {
            hole,
            diameter,
            edges,
            closed_by,
            error,
            remark,
        } = self;
        let line = match width {
            Some(..WIDE) => {
                let error = error.strip_prefix("expected ").unwrap_or(error);
                format!("{hole:>NUMBERS$} {diameter:>9} {closed_by:<13} {error:>7} {remark}")
            }
            _ => format!(
                "{hole:>NUMBERS$} {diameter:>9} {edges:>5}  {closed_by:<18} {error:>14}  {remark}"
            ),
        };
        line.trim_end().to_owned()
    }
}

/// Width of the table in characters where there is room for it.
const WIDE: usize = 80;

/// The name of the surface that closed a region, in a narrow table at most 13 characters.
fn closed_by(how: Option<&Closure>, is_narrow: bool) -> &'static str {
    match how {
        Some(Closure::Sides) if is_narrow => "sides",
        Some(Closure::Faired(_)) if is_narrow => "smoothed",
        Some(Closure::Seam) if is_narrow => "seam",
        Some(how) => how.name(),
        None => "-",
    }
}

/// Numbers of holes as `3+7` if one patch joins their rims, as `3, 7` if each has its own; cut off at the width of their column.
fn short_list(holes: &[HoleId], patches: usize) -> String {
    let all: Vec<String> = holes.iter().map(HoleId::to_string).collect();
    let all = all.join(if patches < holes.len() { "+" } else { ", " });
    match all.len() > NUMBERS {
        true => format!("{}...", &all[..NUMBERS - 3]),
        false => all,
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
    let rows = rows(report);
    let (shown, hidden) = shown(&rows, verbose);
    if !shown.is_empty() {
        lines.extend(done.spec.deliverables.unit.map(lengths_in));
        lines.push(HEADING.line(width));
        lines.extend(shown.iter().map(|row| row.line(width)));
    }
    let small = regions(report).count() - rows.len();
    let of_hidden = |remarked: bool| {
        let own = hidden.iter().filter(|r| r.remark.is_some() == remarked);
        own.count()
    };
    for (more, how) in [
        (of_hidden(true), "with a remark"),
        (of_hidden(false), "closed without remark"),
    ] {
        if more > 0 {
            lines.push(format!("{more} more {how} (-v lists them)"));
        }
    }
    if small > 0 {
        let faces: usize = report.regions.iter().map(|r| r.new_faces).sum();
        let of_rows: usize = rows.iter().map(|row| row.region.new_faces).sum();
        lines.push(format!(
            "{} closed by {} between rim vertices",
            small_regions(report, small),
            counted(faces - of_rows, "triangle")
        ));
    }
    lines.extend(advice(&rows, work, last));
    lines.extend(report.joined_walls().into_iter().map(|[a, b]| {
        format!("holes {a} and {b} are the two sides of a wall: joined by the edge of an opening; --apart closes each side")
    }));
    lines.extend(weighed_lines(report, done.spec.deliverables.unit));
    lines.extend(left(report, work));
    if let (Work::Repair(params), OperationReport::Repaired(repair)) = (work, &done.extent)
        && params.solid
        && repair.steps.inner_skins == 0
    {
        lines.push(NO_INNER_SKIN.to_owned());
    }
    lines
}

/// The number of regions that get no row, in words: small holes, and sides of seams where there are any.
fn small_regions(report: &FillReport, count: usize) -> String {
    let own = |r: &&RegionReport| r.closure == Some(Closure::Seam) && !r.has_surface();
    let seams = report.regions.iter().filter(own).count().min(count);
    match (seams, count - seams) {
        (0, holes) => counted(holes, "small hole"),
        (seams, 0) => counted(seams, "seam"),
        (seams, holes) => format!(
            "{} and {}",
            counted(holes, "small hole"),
            counted(seams, "seam")
        ),
    }
}

/// The line of a repair with `--solid` that found no inner skin.
const NO_INNER_SKIN: &str = "no inner skin was found: --solid removes skins at a constant small distance behind the outer one, with openings of \
                             at most three times this distance";

/// The line that names the unit of the lengths in the table.
fn lengths_in(unit: Unit) -> String {
    format!("lengths in {unit}:")
}

/// The regions of a report. Skips regions that closed nothing and whose holes another region closed later, for example walls after a flat
/// cap that intersected the sheet.
fn regions(report: &FillReport) -> impl Iterator<Item = &RegionReport> {
    let in_use: BTreeSet<usize> = report.holes.iter().map(|h| h.region).collect();
    let is_stale = move |r: &&RegionReport| r.closure.is_none() && !in_use.contains(&r.id);
    report.regions.iter().filter(move |r| !is_stale(r))
}

/// The rows of the table, widest first. Small holes without a remark get no row.
fn rows(report: &FillReport) -> Vec<Row<'_>> {
    let holes: HashMap<HoleId, &HoleReport> = report.holes.iter().map(|h| (h.hole.id, h)).collect();
    let mut rows: Vec<Row> = Vec::new();
    for region in regions(report) {
        let own = || region.holes.iter().filter_map(|id| holes.get(id));
        let edges = own().map(|h| h.hole.edges).sum();
        let remark = Remark::of(region, own().next().map(|h| &h.outcome));
        let object = own().next().and_then(|h| h.hole.object.as_deref());
        if region.has_surface() || remark.is_some() {
            rows.push(Row {
                region,
                edges,
                remark,
                object,
            });
        }
    }
    rows.sort_by(|a, b| {
        let wider = b.region.diameter.total_cmp(&a.region.diameter);
        wider.then(a.region.id.cmp(&b.region.id))
    });
    rows
}

/// Splits rows into those to print (the widest holes, and holes with a remark) and the others.
fn shown<'a, 'r>(rows: &'a [Row<'r>], verbose: bool) -> (Vec<&'a Row<'r>>, Vec<&'a Row<'r>>) {
    let mut problems = 0;
    let mut is_shown = |(at, row): &(usize, &Row)| {
        problems += usize::from(row.remark.is_some());
        verbose || *at < LARGEST || row.remark.is_some() && problems <= MOST_PROBLEMS
    };
    let (mut shown, mut hidden) = (Vec::new(), Vec::new());
    for row in rows.iter().enumerate() {
        match is_shown(&row) {
            true => shown.push(row.1),
            false => hidden.push(row.1),
        }
    }
    (shown, hidden)
}

/// Advice, one line for each remark with all its holes.
fn advice(rows: &[Row], work: &Work, last: usize) -> Vec<String> {
    let line = |remark: &Remark| {
        let own: Vec<&Row> = rows.iter().filter(|r| r.remark == Some(*remark)).collect();
        let ids: BTreeSet<HoleId> = own.iter().flat_map(|r| r.region.holes.clone()).collect();
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

#[cfg(test)]
mod tests {
    use isomend::NotSmooth;

    use super::*;

    #[test]
    fn rows_name_objects_where_they_fit() {
        let row = |remark: &str, object: &str, width: usize| {
            let cells = Cells {
                hole: "3",
                diameter: "1.2",
                edges: "14",
                closed_by: "level set",
                error: "0.1",
                remark,
            };
            with_object(cells.line(Some(width)), object, width)
        };
        for width in [60, 80] {
            assert!(row("", "lid", width).ends_with("in lid"));
            assert!(row("bulges", "lid", width).ends_with("bulges, in lid"));
            let long = row("bulges", "the lid of the box, left half", width);
            assert!(long.ends_with("...") && long.len() == width, "{long}");
            assert!(row("edge not continued", "lid", width).len() <= width);
        }
    }

    #[test]
    fn rows_fit_sixty_and_eighty_columns() {
        let ways = [
            Some(Closure::LevelSet),
            Some(Closure::Sides),
            Some(Closure::Counterpart),
            Some(Closure::Faired(None)),
            Some(Closure::Flat),
            Some(Closure::Base),
            Some(Closure::Walls),
            Some(Closure::Seam),
            Some(Closure::RimTriangles(NotSmooth::FewEdges)),
            Some(Closure::OffsetShell(NotSmooth::LastSteps)),
            None,
        ];
        for (remark, way) in Remark::ALL
            .iter()
            .flat_map(|r| ways.iter().map(move |way| (r, way)))
        {
            for width in [60, 80] {
                let widest = Cells {
                    hole: &short_list(&[1234, 2345, 3456].map(HoleId::from), 1),
                    diameter: "1.234e-9",
                    edges: "12345",
                    closed_by: closed_by(way.as_ref(), width < WIDE),
                    error: "1.2e-9",
                    remark: short(*remark),
                };
                let line = widest.line(Some(width));
                assert!(line.len() <= width, "{line}");
            }
        }
        assert!(HEADING.line(None).len() <= 80 && HEADING.line(Some(60)).len() <= 60);
    }
}
