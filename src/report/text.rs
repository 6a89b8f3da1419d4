//! Reports as plain text.

use super::{FillReport, HoleOutcome, RegionReport, length, point};
use crate::flow::Energy;
use crate::mesh::{Defects, Hole};

/// Least widths of the columns of a table of holes; longer cells widen them. Negative: from the left.
const HOLE_COLUMNS: [(&str, isize); 10] = [
    ("hole", 5),
    ("edges", 6),
    ("length", 12),
    ("diameter", 12),
    ("height", 12),
    ("planarity", 9),
    ("centre", -30),
    ("normal", -22),
    ("piece", 5),
    ("kind", -4),
];

/// A table of holes, one line each, with a heading.
pub fn hole_table(holes: &[Hole]) -> Vec<String> {
    let mut rows = vec![HOLE_COLUMNS.map(|(name, _)| name.to_owned())];
    rows.extend(holes.iter().map(hole_cells));
    let mut widths = HOLE_COLUMNS.map(|(_, width)| width.unsigned_abs());
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    rows.iter()
        .map(|row| {
            let mut line = String::new();
            for ((cell, width), (_, side)) in row.iter().zip(widths).zip(HOLE_COLUMNS) {
                line += &match side {
                    ..0 => format!("  {cell:<width$}"),
                    _ if line.is_empty() => format!("{cell:>width$}"),
                    _ => format!(" {cell:>width$}"),
                };
            }
            line.trim_end().to_owned()
        })
        .collect()
}

fn hole_cells(h: &Hole) -> [String; 10] {
    let kind = if h.outer_border {
        "outer border"
    } else {
        "hole"
    };
    let normal = h.normal.to_array().map(|x| format!("{x:.3}"));
    [
        h.id.to_string(),
        h.edges.to_string(),
        length(h.length),
        length(h.diameter),
        length(h.height),
        format!("{:.4}", h.planarity),
        point(h.centre, h.diameter),
        normal.join(", "),
        h.piece.to_string(),
        kind.to_owned(),
    ]
}

/// What is wrong with a mesh, one line each.
pub fn defect_lines(d: &Defects) -> Vec<String> {
    let all = [
        (d.degenerate_faces, "degenerate faces"),
        (d.non_manifold_edges, "edges with more than two faces"),
        (
            d.misoriented_edges,
            "edges whose two faces are oriented against each other",
        ),
        (
            d.faces_turned,
            "faces turned over for the computation (kept as they are in the output)",
        ),
        (
            d.non_manifold_boundary_vertices,
            "vertices where the boundary passes more than once",
        ),
        (
            d.duplicate_vertices,
            "vertices at the position of an earlier one",
        ),
        (d.crumbs, "crumbs (pieces of one or two triangles)"),
    ];
    all.iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, what)| format!("{n} {what}"))
        .collect()
}

/// A line for each region.
pub fn region_lines(r: &RegionReport) -> String {
    let steps: usize = r.levels.iter().map(|l| l.flow.steps.len()).sum();
    let energy = r
        .levels
        .last()
        .map_or((0.0, 0.0), |l| (l.flow.energy_before, l.flow.energy_after));
    let mut line = format!(
        "hole {}: diameter {:.5}, {:.0} voxels across, {} steps, energy {:.4} -> {:.4}, seam {:.1} degrees, {} faces, {:.2} s",
        join(&r.holes),
        r.diameter,
        r.diameter / r.voxel,
        steps,
        energy.0,
        energy.1,
        r.seam_angle_mean,
        r.new_faces,
        r.seconds
    );
    if !r.levels.is_empty() && !r.converged {
        let movement = r.levels.last().map_or(f64::NAN, |l| l.flow.movement);
        line += &format!("; not steady: the last step moved it by {movement:.1e} voxels");
    }
    if r.other_energy {
        line += "; by the Willmore energy, the variation of curvature found no surface";
    }
    if r.intersecting_faces > 0 {
        line += &format!("; {} faces intersect others", r.intersecting_faces);
    }
    if r.bridge && r.components > 1 {
        line += &format!("; the surface came out in {} separate caps", r.components);
    }
    line
}

/// The levels of a region's solve, the coarsest first, and the tries that came before.
pub fn level_lines(r: &RegionReport) -> Vec<String> {
    let mut lines = vec![format!("region {} (hole {}):", r.id, join(&r.holes))];
    for why in &r.earlier_tries {
        lines.push(format!("  tried again: {why}"));
    }
    for level in &r.levels {
        let flow = &level.flow;
        let iterations: usize = flow.steps.iter().map(|s| s.iterations).sum();
        let movement = flow.movement;
        lines.push(format!(
            "  voxel {:.6}{}: {} nodes, {} unknowns, {} steps, {} iterations, last movement {:.1e} voxels{}, \
             sampled in {:.2} s, solved in {:.2} s",
            level.voxel,
            match flow.energy {
                Energy::Willmore => "",
                _ => ", variation of curvature",
            },
            level.nodes,
            flow.unknowns,
            flow.steps.len(),
            iterations,
            movement,
            if flow.converged { "" } else { " (not steady)" },
            level.seconds[0],
            level.seconds[1],
        ));
    }
    lines.push(format!(
        "  patch: {} vertices, {} faces, quality {:.3}, seam angle mean {:.2} and largest {:.2} degrees, {} components",
        r.new_vertices, r.new_faces, r.quality_mean, r.seam_angle_mean, r.seam_angle_max, r.components
    ));
    lines
}

fn join(holes: &[usize]) -> String {
    let numbers: Vec<String> = holes.iter().map(ToString::to_string).collect();
    numbers.join("+")
}

/// The summary of a fill: defects, then a line for each region, then the holes that stayed open.
pub fn summary_lines(report: &FillReport) -> Vec<String> {
    let mut lines = defect_lines(&report.defects);
    if report.open_chains > 0 {
        lines.push(format!(
            "{} boundary chains do not close and were left",
            report.open_chains
        ));
    }
    let (small, solved): (Vec<_>, Vec<_>) =
        report.regions.iter().partition(|r| r.levels.is_empty());
    lines.extend(solved.into_iter().map(region_lines));
    if !small.is_empty() {
        let holes: usize = small.iter().map(|r| r.holes.len()).sum();
        let faces: usize = small.iter().map(|r| r.new_faces).sum();
        lines.push(format!(
            "{holes} small holes and sides of seams: closed with {faces} faces between their own vertices"
        ));
    }
    let mut left: Vec<(&str, Vec<usize>)> = Vec::new();
    for h in &report.holes {
        match &h.outcome {
            HoleOutcome::Filled => {}
            HoleOutcome::Triangulated(why) => {
                if h.hole.edges > 4 {
                    lines.push(format!("hole {} triangulated: {why}", h.hole.id));
                }
            }
            HoleOutcome::Left(why) => match left.iter_mut().find(|(w, _)| w == why) {
                Some((_, ids)) => ids.push(h.hole.id),
                None => left.push((why, vec![h.hole.id])),
            },
            HoleOutcome::Failed(why) => lines.push(format!("hole {} NOT filled: {why}", h.hole.id)),
        }
    }
    for (why, ids) in left {
        let noun = if ids.len() == 1 { "hole" } else { "holes" };
        let numbers: Vec<String> = ids.iter().map(ToString::to_string).collect();
        lines.push(format!("{noun} {} left open: {why}", numbers.join(", ")));
    }
    let count = |f: fn(&HoleOutcome) -> bool| report.holes.iter().filter(|h| f(&h.outcome)).count();
    let mended = count(|o| matches!(o, HoleOutcome::Filled | HoleOutcome::Triangulated(_)));
    lines.push(format!(
        "{mended} of {} holes filled in {:.2} s",
        report.holes.len(),
        report.seconds
    ));
    lines
}
