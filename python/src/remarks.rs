//! A result in words: its outcome, remarks on patches that need attention, and holes that stay open. Advice names Python's keywords.

use std::collections::BTreeMap;

use isomend::job::{Mended, OperationReport, Work};
use isomend::report::{
    ClosedRow, ClosedTable, Remark, chain_lines, closed_rows, counted, cut_out, defect_lines,
    faired_measures, faired_part, joined_holes, kept_object, left_holes, lost_creases, named_holes,
    repair_lines, significant, tally_line, weighed_lines,
};
use isomend::{FairReport, FillReport, HoleId, HoleOutcome, LeftReason};

/// Width of the table of patches, in characters.
const WIDTH: usize = 80;

/// What a remark means and what to do. `flat` is advice for a flat cap; it is empty where no keyword names the holes.
fn text(remark: Remark, flat: &str) -> String {
    match remark {
        Remark::Open => "still open".to_owned(),
        Remark::Intersects => {
            "faces of the patch intersect other faces; isomend.repair cuts these faces out, a smaller voxel may avoid them".to_owned()
        }
        Remark::NoSurface => {
            format!("the level set found no surface, so the rim was triangulated and smoothed{flat}")
        }
        Remark::RimTriangles => format!(
            "closed by triangles between the vertices of the rim, since no smooth surface was found{flat}"
        ),
        Remark::NoCap => {
            "the requested flat cap could not be made, so the hole was closed by triangles between the vertices of the rim".to_owned()
        }
        Remark::NotConverged => {
            "the surface was still moving after the last step; try a smaller voxel".to_owned()
        }
        Remark::LostCreases => "sharp edges end at their rims and were not continued".to_owned(),
        Remark::Bulges => format!("the patch rises far above the rim; check its shape{flat}"),
        Remark::Unsure => "the patch may be far off, by a sixth of its diameter or more; check its shape".to_owned(),
        Remark::SeparateCaps => "the rims were closed by separate caps instead of a bridge".to_owned(),
        Remark::OtherEnergy => {
            "the variation of curvature found no surface, so the Willmore energy was used".to_owned()
        }
    }
}

/// The numbers of holes that keywords can name: those up to the last hole of the input. Holes of a marked region have numbers that no
/// keyword takes; a repair opens holes with higher numbers.
fn last_named(mended: &Mended) -> usize {
    match &mended.extent {
        OperationReport::Holes => usize::MAX,
        OperationReport::Repaired(report) => report.before.as_ref().map_or(0, |v| v.holes),
        _ => 0,
    }
}

/// Remarks on patches that need attention, one line for each remark with the numbers of its holes, and a line for each reason why
/// holes could not be closed.
pub fn remarks(mended: &Mended) -> Vec<String> {
    if let OperationReport::Faired(report) = &mended.extent {
        return of_fairing(report, &mended.report);
    }
    let (rows, last) = (closed_rows(&mended.report), last_named(mended));
    // Why holes are open is said below.
    let wanted = Remark::ALL.into_iter().filter(|r| *r != Remark::Open);
    let lines = wanted.filter_map(|remark| {
        let own = rows.iter().filter(|row| row.remark == Some(remark));
        of_remark(remark, &own.collect::<Vec<_>>(), last)
    });
    let mut lines: Vec<String> = lines.collect();
    let mut open: BTreeMap<String, Vec<HoleId>> = BTreeMap::new();
    for hole in &mended.report.holes {
        if let HoleOutcome::Open(why) = &hole.outcome {
            open.entry(why.to_string()).or_default().push(hole.hole.id);
        }
    }
    let still =
        |(why, ids): (&String, &Vec<HoleId>)| format!("{} still open: {why}", named_holes(ids));
    lines.extend(open.iter().map(still));
    lines
}

/// The line of a remark with the numbers of the holes of its rows; `None` if there are none.
fn of_remark(remark: Remark, own: &[&ClosedRow<'_>], last: usize) -> Option<String> {
    let mut ids: Vec<HoleId> = own.iter().flat_map(|r| r.holes.clone()).collect();
    ids.sort_unstable();
    ids.dedup();
    let flat = match &ids[..] {
        [] => return None,
        ids if ids.iter().any(|id| id.get() > last) => String::new(),
        [one] => format!("; flat=[{one}] makes a flat cap instead"),
        _ => "; flat with their numbers makes flat caps instead".to_owned(),
    };
    let text = match (remark, own) {
        (Remark::LostCreases, [one]) => lost_creases(one.region)?,
        _ => text(remark, &flat),
    };
    Some(format!("{}: {text}", named_holes(&ids)))
}

/// Remarks on a fairing: faces that intersect others, and components and objects that stayed as they were.
fn of_fairing(report: &FairReport, fill: &FillReport) -> Vec<String> {
    let regions = fill.regions.iter();
    let intersecting: usize = regions.map(|r| r.intersecting_faces).sum();
    let crossing = format!(
        "{} intersecting other faces; isomend.repair cuts these faces out",
        counted(intersecting, "new face")
    );
    let left = format!(
        "{} left unchanged, because the mesh also has open ones; mark to fair too",
        counted(report.components_left, "closed component")
    );
    let lines = [(intersecting, crossing), (report.components_left, left)];
    let wanted = lines.into_iter().filter(|(count, _)| *count > 0);
    let wanted = wanted.map(|(_, line)| line);
    wanted
        .chain(report.kept_objects.iter().map(kept_object))
        .collect()
}

/// The holes that were left open, one line for each reason, with the keyword that changes it; and whether the caller may not expect
/// it: outer borders are left open although no keyword says so.
pub fn left_open(mended: &Mended) -> Vec<(bool, String)> {
    let repairs = matches!(mended.extent, OperationReport::Repaired(_));
    let line = |(why, ids): &(LeftReason, Vec<HoleId>)| {
        let shown: Vec<String> = ids.iter().take(3).map(HoleId::to_string).collect();
        let more = if ids.len() > 3 { ", ..." } else { "" };
        let named = format!("[{}{more}]", shown.join(", "));
        let advice = match why {
            LeftReason::OuterBoundary if repairs => "; close_borders=True closes it".to_owned(),
            LeftReason::OuterBoundary => format!(": holes={named}"),
            LeftReason::TooWide => "; a larger max_diameter fills it".to_owned(),
            _ => String::new(),
        };
        let is_unasked = *why == LeftReason::OuterBoundary;
        let text = format!("{} left open: {why}{advice}", named_holes(ids));
        (is_unasked, text)
    };
    left_holes(&mended.report).iter().map(line).collect()
}

/// The outcome in a few words: counts of holes, and after a repair whether the mesh is sound.
pub fn state(mended: &Mended) -> String {
    let tally = mended.report.tally();
    let counts = [
        (tally.closed, "closed"),
        (tally.left, "left open"),
        (tally.open, "could not be closed"),
    ];
    let mut parts: Vec<String> = Vec::new();
    for (count, what) in counts.into_iter().filter(|(count, _)| *count > 0) {
        parts.push(match parts.is_empty() {
            true => format!("{} {what}", counted(count, "hole")),
            false => format!("{count} {what}"),
        });
    }
    if parts.is_empty() {
        parts.push("no holes".to_owned());
    }
    if tally.open_chains > 0 {
        parts.push(counted(tally.open_chains, "open boundary chain"));
    }
    let holes = parts.join(", ");
    match &mended.extent {
        OperationReport::Faired(_) => "faired".to_owned(),
        OperationReport::Repaired(_) if mended.complete() => format!("{holes}; sound"),
        OperationReport::Repaired(_) => format!("{holes}; not sound"),
        _ => holes,
    }
}

/// The lines that the text of a result has: steps, the table of patches, remarks, holes left open, and the outcome last.
pub fn lines(mended: &Mended) -> Vec<String> {
    let report = &mended.report;
    let mut lines = Vec::new();
    match &mended.extent {
        OperationReport::Faired(report) => return fairing_lines(mended, report),
        OperationReport::Region(cut) => {
            lines.push(cut_out(cut.marked_faces, cut.removed_faces));
            lines.extend(joined_holes(cut));
        }
        _ => {}
    }
    lines.extend(defect_lines(&report.input.defects));
    lines.extend(chain_lines(&report.input.open_chains));
    let table = ClosedTable {
        unit: None,
        width: Some(WIDTH),
        limited: Some(""),
    };
    lines.extend(table.lines(report, &closed_rows(report)));
    lines.extend(weighed_lines(report, None));
    lines.extend(remarks(mended));
    lines.extend(left_open(mended).into_iter().map(|(_, line)| line));
    lines.push(tally_line(report));
    if let OperationReport::Repaired(report) = &mended.extent {
        lines.extend(repair_lines(report));
        lines.push(match report.lost_faces {
            0 => "no face of the input was removed".to_owned(),
            1 => "1 face of the input was removed".to_owned(),
            n => format!("{n} faces of the input were removed"),
        });
        lines.extend(report.after.as_ref().map(|verdict| verdict.line()));
    }
    lines
}

/// The lines of a fairing: its measures, remarks, and how far the surface moved.
fn fairing_lines(mended: &Mended, report: &FairReport) -> Vec<String> {
    let mut lines = vec![faired_measures(report, None)];
    let is_marked = matches!(mended.work(), Work::Fair(Some(_), _));
    lines.extend(faired_part(report, is_marked));
    lines.extend(remarks(mended));
    lines.push(format!(
        "moved by at most {}, root mean square {}",
        significant(report.moved_max, 3),
        significant(report.moved_rms, 3)
    ));
    lines
}
