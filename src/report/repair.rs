//! What a repair did, in lines.

use crate::check::Component;
use crate::mesh::Unit;
use crate::repair::RepairReport;

/// Most lined components that get a line of their own.
const MAX_SHELL_LINES: usize = 5;

/// What was done, one line for each step that found something.
pub fn repair_lines(r: &RepairReport) -> Vec<String> {
    repair_lines_in(r, None)
}

/// The same with the unit of lengths.
pub fn repair_lines_in(r: &RepairReport, unit: Option<Unit>) -> Vec<String> {
    let crossing: usize = r.passes.first().map_or(0, |p| p.crossing_faces);
    let all = [
        (r.merged_vertices, "coinciding vertices merged".to_owned()),
        (
            r.welded_vertices,
            "vertices of the border merged into one nearby".to_owned(),
        ),
        (
            r.stitched_junctions,
            "T-junctions stitched: the edges there were split".to_owned(),
        ),
        (r.degenerate_faces, "degenerate faces taken out".to_owned()),
        (
            r.flipped_edges,
            "faces without area taken into a neighbour".to_owned(),
        ),
        (r.duplicate_faces, "duplicate faces taken out".to_owned()),
        (r.turned_faces, "faces turned over".to_owned()),
        (
            r.split_vertices,
            "vertices split, where surfaces met in an edge or a point".to_owned(),
        ),
        (
            r.non_manifold_faces,
            "faces cut out at edges with more than two".to_owned(),
        ),
        (
            r.debris[0],
            format!("components of debris taken out, {} faces", r.debris[1]),
        ),
        (
            r.inside[0],
            format!("components inside others taken out, {} faces", r.inside[1]),
        ),
        (
            r.united_bodies,
            format!(
                "touching or crossing bodies united: {} faces split, {} inside removed",
                r.split_faces, r.inner_faces
            ),
        ),
        (
            r.moved_vertices,
            format!(
                "vertices of faces in which bodies touch moved by up to {} for that",
                Unit::text(unit, r.largest_move)
            ),
        ),
        (crossing, cut_out(r)),
        (
            r.left_crossing,
            "components left crossing, since nothing of them would have stayed".to_owned(),
        ),
    ];
    let some = all.into_iter().filter(|(count, _)| *count > 0);
    let mut lines: Vec<String> = some
        .map(|(count, what)| format!("{count} {what}"))
        .collect();
    lines.extend(shell_lines(r, unit));
    lines
}

/// The components that were lined, the largest first.
fn shell_lines(r: &RepairReport, unit: Option<Unit>) -> Vec<String> {
    let mut shells: Vec<&(usize, Component)> = r.offset_shells.iter().collect();
    shells.sort_by(|a, b| b.1.area.total_cmp(&a.1.area).then(a.0.cmp(&b.0)));
    let mut lines: Vec<String> = shells
        .iter()
        .take(MAX_SHELL_LINES)
        .map(|l| shell_line(l, unit))
        .collect();
    if let Some(more) = shells
        .get(MAX_SHELL_LINES..)
        .filter(|more| !more.is_empty())
    {
        let least = more.iter().filter_map(|(_, c)| c.least_wall);
        lines.push(format!(
            "{} more components were lined: walls {} thick at least",
            more.len(),
            Unit::text(unit, least.fold(f64::INFINITY, f64::min))
        ));
    }
    lines
}

/// A component that was lined, and how thick its walls are.
fn shell_line((number, component): &(usize, Component), unit: Option<Unit>) -> String {
    format!(
        "component {number} was lined: walls {} thick in the mean, {} at least",
        Unit::text(unit, component.mean_wall.unwrap_or_default()),
        Unit::text(unit, component.least_wall.unwrap_or_default())
    )
}

/// What was cut out where faces crossed others, behind their number.
fn cut_out(r: &RepairReport) -> String {
    let cut: usize = r.passes.iter().map(|p| p.cut_faces).sum();
    let passes = match r.passes.len() {
        1 => "1 pass".to_owned(),
        count => format!("{count} passes"),
    };
    format!(
        "faces crossed others: {cut} cut out in {passes}, {} under another layer",
        r.covered_faces
    )
}
