//! Text report of a repair: one line per step that changed something.

use super::counts::{counted, counted_as};
use isomend_core::check::Component;
use isomend_core::mesh::Unit;
use isomend_core::repair::RepairReport;

/// Maximum number of offset shells with a line of their own.
const MAX_SHELL_LINES: usize = 5;

/// What was done at T-junctions and cracks.
fn junctions(crack_width: f64, unit: Option<Unit>) -> String {
    let cracks = match crack_width > 0.0 {
        true => format!(
            "; cracks up to {} wide closed",
            Unit::text(unit, crack_width)
        ),
        false => String::new(),
    };
    format!("T-junctions closed by splitting the edges there{cracks}")
}

/// One line for each step that changed something.
#[doc(hidden)]
pub fn repair_lines(r: &RepairReport) -> Vec<String> {
    repair_lines_in(r, None)
}

/// The same, with a unit for lengths.
#[doc(hidden)]
pub fn repair_lines_in(r: &RepairReport, unit: Option<Unit>) -> Vec<String> {
    let crossing: usize = r.passes.first().map_or(0, |p| p.intersecting_faces);
    let all = [
        (r.merged_vertices, "coinciding vertices merged".to_owned()),
        (
            r.welded_vertices,
            "boundary vertices merged into a nearby one".to_owned(),
        ),
        (
            r.stitched_junctions,
            junctions(r.crack_width, unit),
        ),
        (
            r.closing_faces,
            "faces added where bodies that share edges lacked one".to_owned(),
        ),
        (r.degenerate_faces, "degenerate faces removed".to_owned()),
        (
            r.flipped_edges,
            "faces without area merged into a neighbour".to_owned(),
        ),
        (r.duplicate_faces, "duplicate faces removed".to_owned()),
        (r.reoriented_faces, "faces reversed".to_owned()),
        (
            r.split_vertices,
            "vertices split where surfaces met in an edge or a point".to_owned(),
        ),
        (
            r.non_manifold_faces,
            "faces cut out at edges with more than two faces".to_owned(),
        ),
        removed(r.dropped, "components removed by their numbers"),
        removed(r.debris, "small components removed as debris"),
        removed(r.inside, "components inside others removed"),
        (r.inner_skins[0], inner_skins(r, unit)),
        (
            r.united_bodies,
            format!(
                "touching or intersecting bodies united: {} split, {} removed",
                counted(r.split_faces, "face"),
                counted(r.inner_faces, "inner face")
            ),
        ),
        (r.moved_vertices, moves(r, unit)),
        (r.relaxed_vertices, relaxed(r, unit)),
        (crossing, cut_out(r)),
        (
            r.left_self_intersecting,
            "components left with self-intersections, because cutting them would remove the whole component".to_owned(),
        ),
    ];
    let some = all.into_iter().filter(|(count, _)| *count > 0);
    let mut lines: Vec<String> = some.map(|(count, what)| counted_as(count, &what)).collect();
    lines.extend(shell_lines(r, unit));
    lines
}

/// Components that were removed, with the number of their faces.
fn removed([components, faces]: [usize; 2], what: &str) -> (usize, String) {
    let faces = counted(faces, "face");
    (components, format!("{what}, {faces} in all"))
}

fn inner_skins(r: &RepairReport, unit: Option<Unit>) -> String {
    let thickness = Unit::text(unit, r.skin_thickness);
    format!(
        "inner skins removed, {} in all, {thickness} behind the outer skin: {} closed",
        counted(r.inner_skins[1], "face"),
        counted(r.pinholes, "pinhole")
    )
}

fn moves(r: &RepairReport, unit: Option<Unit>) -> String {
    let most = Unit::text(unit, r.largest_move);
    format!("vertices of touching faces moved by up to {most}, so that the bodies could be united")
}

fn relaxed(r: &RepairReport, unit: Option<Unit>) -> String {
    let most = Unit::text(unit, r.largest_relaxation);
    format!(
        "vertices of folded or noisy faces moved by up to {most}, so that these faces no longer intersect"
    )
}

/// The components with offset shells, largest area first.
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
            "{} with offset shells: walls at least {} thick",
            counted(more.len(), "more component"),
            Unit::text(unit, least.fold(f64::INFINITY, f64::min))
        ));
    }
    lines
}

/// The line of a component with an offset shell, with its wall thickness.
fn shell_line((number, component): &(usize, Component), unit: Option<Unit>) -> String {
    format!(
        "component {number} got an offset shell: walls {} thick on average, {} at the thinnest place",
        Unit::text(unit, component.mean_wall.unwrap_or_default()),
        Unit::text(unit, component.least_wall.unwrap_or_default())
    )
}

/// The text on cut self-intersections, after the number of faces.
fn cut_out(r: &RepairReport) -> String {
    let cut: usize = r.passes.iter().map(|p| p.cut_faces).sum();
    let passes = match r.passes.len() {
        1 => "1 pass".to_owned(),
        count => format!("{count} passes"),
    };
    format!(
        "faces intersected others: {cut} cut out in {passes}, {} more removed inside or under other surfaces",
        r.covered_faces
    )
}
