//! Text report of a repair: one line per step that changed something.

use super::counts::{counted, counted_as};
use isomend_core::check::Component;
use isomend_core::mesh::Unit;
use isomend_core::repair::{RepairReport, RepairSteps};

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
    let steps = &r.steps;
    let crossing: usize = steps
        .intersection_passes
        .first()
        .map_or(0, |p| p.intersecting_faces);
    let all = [
        (steps.merged_vertices, "coinciding vertices merged".to_owned()),
        (
            steps.welded_vertices,
            "boundary vertices merged into a nearby one".to_owned(),
        ),
        (
            steps.stitched_junctions,
            junctions(steps.crack_width, unit),
        ),
        (
            steps.closing_faces,
            "faces added where bodies that share edges lacked one".to_owned(),
        ),
        (steps.degenerate_faces, "degenerate faces removed".to_owned()),
        (
            steps.flipped_edges,
            "faces without area merged into a neighbour".to_owned(),
        ),
        (steps.duplicate_faces, "duplicate faces removed".to_owned()),
        (steps.reoriented_faces, "faces reversed".to_owned()),
        (
            steps.split_vertices,
            "vertices split where surfaces met in an edge or a point".to_owned(),
        ),
        (
            steps.non_manifold_faces,
            "faces cut out at edges with more than two faces".to_owned(),
        ),
        removed(steps.dropped_components, steps.dropped_faces, "components removed by their numbers"),
        removed(steps.debris_components, steps.debris_faces, "small components removed as debris"),
        removed(steps.inside_components, steps.inside_faces, "components inside others removed"),
        (steps.inner_skins, inner_skins(steps, unit)),
        (
            steps.united_bodies,
            format!(
                "touching or intersecting bodies united: {} split, {} removed",
                counted(steps.split_faces, "face"),
                counted(steps.inner_faces, "inner face")
            ),
        ),
        (steps.moved_vertices, moves(steps, unit)),
        (steps.relaxed_vertices, relaxed(steps, unit)),
        (crossing, cut_out(steps)),
        (
            steps.components_left_intersecting,
            "components left with self-intersections, because cutting them would remove the whole component".to_owned(),
        ),
    ];
    let some = all.into_iter().filter(|(count, _)| *count > 0);
    let mut lines: Vec<String> = some.map(|(count, what)| counted_as(count, &what)).collect();
    lines.extend(shell_lines(r, unit));
    lines
}

/// Components that were removed, with the number of their faces.
fn removed(components: usize, faces: usize, what: &str) -> (usize, String) {
    let faces = counted(faces, "face");
    (components, format!("{what}, {faces} in all"))
}

fn inner_skins(steps: &RepairSteps, unit: Option<Unit>) -> String {
    let thickness = Unit::text(unit, steps.skin_thickness);
    format!(
        "inner skins removed, {} in all, {thickness} behind the outer skin: {} closed",
        counted(steps.inner_skin_faces, "face"),
        counted(steps.pinholes, "pinhole")
    )
}

fn moves(steps: &RepairSteps, unit: Option<Unit>) -> String {
    let most = Unit::text(unit, steps.largest_move);
    format!("vertices of touching faces moved by up to {most}, so that the bodies could be united")
}

fn relaxed(steps: &RepairSteps, unit: Option<Unit>) -> String {
    let most = Unit::text(unit, steps.largest_relaxation);
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
fn cut_out(steps: &RepairSteps) -> String {
    let cut: usize = steps.intersection_passes.iter().map(|p| p.cut_faces).sum();
    let passes = match steps.intersection_passes.len() {
        1 => "1 pass".to_owned(),
        count => format!("{count} passes"),
    };
    format!(
        "faces intersected others: {cut} cut out in {passes}, {} more removed inside or under other surfaces",
        steps.covered_faces
    )
}
