//! The patches of a run as a table of at most 80 columns, with a remark on each problem.

use std::collections::{BTreeSet, HashMap};

use isomend_core::fill::{Closure, HoleOutcome, RegionReport};
use isomend_core::mend::{FillReport, HoleReport};
use isomend_core::mesh::{HoleId, Unit};

use super::{Remark, counted, lengths_in, number, significant};

/// Number of widest holes that the table always shows.
const LARGEST: usize = 10;
/// Most rows with a remark.
const MOST_PROBLEMS: usize = 30;
/// Width of the column of hole numbers, in characters; longer lists are cut off.
const NUMBERS: usize = 9;

/// How the table of patches is printed.
#[doc(hidden)]
pub struct ClosedTable<'a> {
    /// Unit of the lengths, where it is known.
    pub unit: Option<Unit>,
    /// Width of the terminal in characters, where it is known.
    pub width: Option<usize>,
    /// Only the widest holes and those with a remark get a row; the others are counted, in a line with this end. `None` for all rows.
    pub limited: Option<&'a str>,
}

impl ClosedTable<'_> {
    /// The lines of the table, with the numbers of the holes that have no row.
    pub fn lines(&self, report: &FillReport, rows: &[ClosedRow]) -> Vec<String> {
        let mut lines = Vec::new();
        let (shown, hidden) = split(rows, self.limited.is_none());
        if !shown.is_empty() {
            lines.push(lengths_in(self.unit));
            lines.push(HEADING.line(self.width));
            lines.extend(shown.iter().map(|row| row.line(self.width)));
        }
        let end = self.limited.unwrap_or_default();
        let of_hidden = |remarked: bool| {
            let own = hidden.iter().filter(|r| r.remark.is_some() == remarked);
            own.count()
        };
        for (more, how) in [
            (of_hidden(true), "with a remark"),
            (of_hidden(false), "closed without remark"),
        ] {
            if more > 0 {
                lines.push(format!("{more} more {how}{end}"));
            }
        }
        let of_rows: BTreeSet<usize> = rows.iter().map(|row| row.region.id).collect();
        let others = || regions(report).filter(|r| !of_rows.contains(&r.id));
        let small = others().count();
        if small > 0 {
            let by = match others().map(|r| r.new_faces).sum() {
                // Later steps of a repair may have removed them.
                0 => String::new(),
                left => format!(" by {} between rim vertices", counted(left, "triangle")),
            };
            lines.push(format!("{} closed{by}", small_regions(report, small)));
        }
        lines
    }
}

/// The regions of a report. Skips regions that closed nothing and whose holes another region closed later, for example walls after a flat
/// cap that intersected the sheet.
fn regions(report: &FillReport) -> impl Iterator<Item = &RegionReport> {
    let in_use: BTreeSet<usize> = report.holes.iter().map(|h| h.region).collect();
    let is_stale = move |r: &&RegionReport| r.closure.is_none() && !in_use.contains(&r.id);
    report.regions.iter().filter(move |r| !is_stale(r))
}

/// The rows of the table of patches, widest first. Small holes without a remark get no row.
#[doc(hidden)]
pub fn closed_rows(report: &FillReport) -> Vec<ClosedRow<'_>> {
    let holes: HashMap<HoleId, &HoleReport> = report.holes.iter().map(|h| (h.hole.id, h)).collect();
    let mut rows: Vec<ClosedRow> = Vec::new();
    for region in regions(report) {
        // A later step of a repair may have closed some of its holes, and left others open on purpose.
        let own = region.holes.iter().filter_map(|id| holes.get(id).copied());
        let is_own =
            |h: &&HoleReport| h.region == region.id && !matches!(h.outcome, HoleOutcome::Left(_));
        let own: Vec<&HoleReport> = own.filter(is_own).collect();
        if own.is_empty() && !region.holes.is_empty() {
            continue;
        }
        let is_part = own.len() < region.holes.len();
        // Some holes of a region may be open although others are closed.
        let is_open = |h: &&HoleReport| matches!(h.outcome, HoleOutcome::Open(_));
        let (open, others): (Vec<_>, Vec<_>) = own.into_iter().partition(is_open);
        match (&open[..], &others[..]) {
            (own, []) | ([], own) => rows.push(ClosedRow::new(region, own, is_part)),
            parts => rows.extend([parts.1, parts.0].map(|own| ClosedRow::new(region, own, true))),
        }
    }
    rows.retain(|row| row.region.has_surface() || row.remark.is_some());
    rows.sort_by(|a, b| {
        let wider = b.diameter.total_cmp(&a.diameter);
        wider.then(a.region.id.cmp(&b.region.id))
    });
    rows
}

/// Splits rows into those to print (the widest holes, and holes with a remark) and the others.
fn split<'a, 'r>(
    rows: &'a [ClosedRow<'r>],
    all: bool,
) -> (Vec<&'a ClosedRow<'r>>, Vec<&'a ClosedRow<'r>>) {
    let mut problems = 0;
    let mut is_shown = |(at, row): &(usize, &ClosedRow)| {
        problems += usize::from(row.remark.is_some());
        all || *at < LARGEST || row.remark.is_some() && problems <= MOST_PROBLEMS
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
        Remark::Unsure => "unsure",
        Remark::SeparateCaps => "separate caps",
        Remark::OtherEnergy => "Willmore energy",
    }
}

/// A row of the table.
#[doc(hidden)]
pub struct ClosedRow<'a> {
    /// What was done.
    pub region: &'a RegionReport,
    /// The holes of the region that the row is about.
    pub holes: Vec<HoleId>,
    /// How they were closed.
    closure: Option<&'a Closure>,
    /// The largest diameter.
    diameter: f64,
    /// Edges of their rims.
    edges: usize,
    /// The problem with the patch, if there is one.
    pub remark: Option<Remark>,
    /// The object of a 3MF file that the holes belong to, if there are several.
    object: Option<&'a str>,
}

impl<'a> ClosedRow<'a> {
    /// The row of holes of a region with the same outcome; `is_part` if other holes of the region have another.
    fn new(region: &'a RegionReport, own: &[&'a HoleReport], is_part: bool) -> Self {
        let first = own.first();
        let outcome = first.map(|h| &h.outcome);
        let diameters = own.iter().map(|h| h.hole.diameter);
        Self {
            region,
            holes: match is_part {
                true => own.iter().map(|h| h.hole.id).collect(),
                false => region.holes.clone(),
            },
            closure: match outcome {
                Some(outcome) if is_part => outcome.closure(),
                _ => region.closure.as_ref(),
            },
            diameter: match is_part {
                true => diameters.fold(0.0, f64::max),
                false => region.diameter,
            },
            edges: own.iter().map(|h| h.hole.edges).sum(),
            remark: Remark::of(region, outcome),
            object: first.and_then(|h| h.hole.object.as_deref()),
        }
    }

    fn line(&self, width: Option<usize>) -> String {
        let r = self.region;
        let cells = Cells {
            hole: &short_list(&self.holes, r.components),
            diameter: &number(self.diameter),
            edges: &self.edges.to_string(),
            closed_by: closed_by(self.closure, width.is_some_and(|width| width < WIDE)),
            error: &r
                .largest_expected_error
                .map_or("-".to_owned(), |e| significant(e, 2)),
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

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use isomend_core::fill::{AttemptFailure, NotSmooth, OpenReason};
    use isomend_core::mend::Inspection;
    use isomend_core::mesh::Mesh;

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

    /// A region of two holes: one closed by triangles between the vertices of its rim, one that could not be closed.
    #[test]
    fn holes_of_a_region_with_several_outcomes_get_rows_of_their_own() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3]];
        let mesh = Mesh::new(corners.to_vec(), faces);
        let open = Inspection::new(&mesh).unwrap();
        let mut report = FillReport::default();
        for id in [1, 2] {
            let mut hole = HoleReport::listed(&open.holes[0]);
            hole.hole.id = id.into();
            hole.region = 1;
            report.holes.push(hole);
        }
        report.holes[0].outcome = HoleOutcome::Closed(Closure::RimTriangles(NotSmooth::NoSurface(
            AttemptFailure::Diverged,
        )));
        report.holes[1].outcome = HoleOutcome::Open(OpenReason::NotReached);
        let mut region = RegionReport::default();
        (region.id, region.new_faces) = (1, 1);
        region.holes = vec![1.into(), 2.into()];
        report.regions.push(region);

        let rows = closed_rows(&report);
        let remarks: Vec<_> = rows
            .iter()
            .map(|row| (row.holes.len(), row.remark))
            .collect();
        assert_eq!(
            remarks,
            [(1, Some(Remark::RimTriangles)), (1, Some(Remark::Open))]
        );
        let table = ClosedTable {
            unit: None,
            width: None,
            limited: None,
        };
        let lines = table.lines(&report, &rows);
        assert!(lines[2].contains("rim triangles"), "{lines:?}");
        assert!(lines[3].ends_with("still open"), "{lines:?}");
        assert_eq!(lines.len(), 4, "{lines:?}");
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
