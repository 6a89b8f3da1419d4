//! The verdict of a mesh check as text: one line per kind of defect, with counts and positions.

use super::{length, point};
use crate::check::{Defect, DefectKind, Verdict};

/// Most positions in a line.
const MOST_PLACES: usize = 3;

/// A verdict in lines: the verdict itself, then one line for each kind of defect that was looked for. `size` is the diagonal of the
/// mesh's bounding box, to which positions are rounded.
pub fn verdict_lines(verdict: &Verdict, size: f64) -> Vec<String> {
    let mut lines = vec![verdict.line(), String::new()];
    lines.extend(
        verdict_rows(verdict, size)
            .into_iter()
            .map(|(name, value)| {
                let name = format!("{name}:");
                format!("{name:<22} {value}")
            }),
    );
    lines
}

/// The rows of a verdict as names and values; `size` is as in [`verdict_lines`].
pub fn verdict_rows(verdict: &Verdict, size: f64) -> Vec<(&'static str, String)> {
    let mut rows = vec![(
        "mesh",
        format!(
            "{} vertices, {} faces, {} {}",
            verdict.vertices,
            verdict.faces,
            verdict.components.len(),
            match verdict.components.len() {
                1 => "component",
                _ => "components",
            }
        ),
    )];
    rows.extend(DefectKind::ALL.into_iter().filter_map(|kind| {
        let found = verdict.defects.iter().find(|d| d.kind == kind);
        let name = name(kind);
        match (found, kind) {
            (Some(defect), _) => Some((name, defect_text(defect, verdict, size))),
            (None, DefectKind::Thin) if verdict.params.thin.is_none() => None,
            (None, DefectKind::ThinWall) if verdict.params.min_wall.is_none() => None,
            (None, _) => Some((name, "none".to_owned())),
        }
    }));
    if let Some(walls) = walls(verdict, size) {
        rows.push(("walls", walls));
    }
    if verdict.t_junctions > 0 {
        let what = format!(
            "{} boundary vertices on boundary edges; `isomend repair` splits these edges",
            verdict.t_junctions
        );
        rows.push(("T-junctions", what));
    }
    if let Some((length, edges)) = verdict.weld {
        let by_itself = match verdict.weld_by_default {
            true => "; `isomend repair` merges them by default",
            false => "",
        };
        let what = format!(
            "{edges} of {} boundary edges close if vertices within {length:e} are merged{by_itself}",
            verdict.count(DefectKind::Border)
        );
        rows.push(("nearly closed", what));
    }
    let others = [
        ("debris", verdict.debris(), "components"),
        ("inside others", verdict.inside(), "components"),
        ("unused vertices", verdict.unused_vertices, ""),
        ("coinciding vertices", verdict.duplicate_vertices, ""),
    ];
    let some = others.into_iter().filter(|(_, count, _)| *count > 0);
    rows.extend(
        some.map(|(name, count, unit)| (name, format!("{count} {unit}").trim_end().to_owned())),
    );
    rows
}

/// The least wall thickness with its position, and the mean.
fn walls(verdict: &Verdict, size: f64) -> Option<String> {
    let (number, thinnest, mean) = verdict.walls()?;
    let own = match verdict.components.len() {
        1 => String::new(),
        _ => format!(" in component {number}"),
    };
    let at = thinnest.thinnest_at.unwrap_or(thinnest.centre);
    Some(format!(
        "least thickness {}{own} at {}; mean {}",
        length(thinnest.least_wall?),
        point(at, size),
        length(mean)
    ))
}

/// The name of a kind of defect in a list.
fn name(kind: DefectKind) -> &'static str {
    match kind {
        DefectKind::Border => "boundary edges",
        DefectKind::NonManifoldEdge => "non-manifold edges",
        DefectKind::NonManifoldVertex => "non-manifold vertices",
        DefectKind::Misoriented => "misoriented edges",
        DefectKind::InsideOut => "inside out",
        DefectKind::Degenerate => "degenerate faces",
        DefectKind::Duplicate => "duplicate faces",
        DefectKind::Crossing => "intersecting faces",
        DefectKind::Thin => "thin parts",
        DefectKind::ThinWall => "thin walls",
    }
}

/// The count of a defect with details and its first positions.
fn defect_text(defect: &Defect, verdict: &Verdict, size: f64) -> String {
    let mut text = defect.count.to_string();
    match (defect.kind, verdict.params.thin) {
        (DefectKind::Border, _) => {
            text += &format!(" round {} holes", verdict.holes);
            if verdict.open_chains > 0 {
                text += &format!(
                    " and in {} boundary chains that do not close",
                    verdict.open_chains
                );
            }
        }
        (DefectKind::InsideOut, _) => text += " closed components",
        (DefectKind::Thin, Some(thin)) => {
            text += &format!(" faces where the body is thinner than {}", length(thin));
        }
        (DefectKind::ThinWall, _) => {
            let limit = verdict.params.min_wall.unwrap_or_default();
            text += &format!(" faces at walls thinner than {}", length(limit));
        }
        _ => {}
    }
    if defect.places.is_empty() {
        return text;
    }
    let places = defect.places.iter().take(MOST_PLACES);
    let places: Vec<String> = places.map(|p| point(*p, size)).collect();
    let more = match defect.places.len() {
        n if n > MOST_PLACES => format!("; and at {} more places", n - MOST_PLACES),
        _ => String::new(),
    };
    format!("{text}, at {}{more}", places.join("; "))
}
