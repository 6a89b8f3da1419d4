//! The verdict of a mesh check as text: one line per kind of defect, with counts and positions.

use super::counts::counted;
use super::point;
use isomend_core::check::{Defect, DefectKind, Verdict};
use isomend_core::mesh::Unit;

/// Most positions in a line.
const MOST_PLACES: usize = 3;

/// A verdict in lines: the verdict itself first, then what was looked for, what was found and where.
pub fn verdict_lines(verdict: &Verdict, size: f64, unit: Option<Unit>) -> Vec<String> {
    let mut lines = vec![verdict.line(), String::new()];
    lines.extend(
        verdict_rows(verdict, size, unit)
            .into_iter()
            .map(|(name, value)| {
                let name = format!("{name}:");
                format!("{name:<22} {value}")
            }),
    );
    lines
}

/// The rows of a verdict: names and values; `size` is the extent of the mesh, `unit` the unit of its coordinates, where it is known.
#[doc(hidden)]
pub fn verdict_rows(
    verdict: &Verdict,
    size: f64,
    unit: Option<Unit>,
) -> Vec<(&'static str, String)> {
    let mut rows = counts(verdict);
    rows.extend(DefectKind::ALL.into_iter().filter_map(|kind| {
        let found = verdict.defects.iter().find(|d| d.kind == kind);
        let name = name(kind);
        match (found, kind) {
            (Some(defect), _) => Some((name, defect_text(defect, verdict, size, unit))),
            (None, DefectKind::Thin) if verdict.params.thin.is_none() => None,
            (None, DefectKind::ThinWall) if verdict.params.min_wall.is_none() => None,
            (None, _) => Some((name, "none".to_owned())),
        }
    }));
    if let Some(unit) = unit {
        rows.push(("unit of lengths", unit.to_string()));
    }
    if let Some(walls) = walls(verdict, size, unit) {
        rows.push(("walls", walls));
    }
    if verdict.t_junctions > 0 {
        let what = format!(
            "{} on boundary edges; `isomend repair` splits these edges",
            counted(verdict.t_junctions, "boundary vertex")
        );
        rows.push(("T-junctions", what));
    }
    if let Some((length, edges)) = verdict.weld {
        let by_itself = match verdict.weld_by_default {
            true => "; `isomend repair` merges them by default",
            false => "",
        };
        let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
        let what = format!(
            "{edges} of {} border edges close where vertices within {length:e}{unit} are merged{by_itself}",
            verdict.count(DefectKind::BoundaryEdge)
        );
        rows.push(("nearly closed", what));
    }
    let others = [
        ("debris", verdict.debris(), true),
        ("inside others", verdict.inside(), true),
        ("unused vertices", verdict.unused_vertices, false),
        ("coinciding vertices", verdict.duplicate_vertices, false),
    ];
    let some = others.into_iter().filter(|(_, count, _)| *count > 0);
    rows.extend(
        some.map(|(name, count, are_components)| match are_components {
            true => (name, counted(count, "component")),
            false => (name, count.to_string()),
        }),
    );
    rows
}

/// The rows of the numbers of elements and objects.
fn counts(verdict: &Verdict) -> Vec<(&'static str, String)> {
    let text = format!(
        "{}, {}, {}",
        counted(verdict.vertices, "vertex"),
        counted(verdict.faces, "face"),
        counted(verdict.components.len(), "component")
    );
    let mut rows = vec![("mesh", text)];
    if !verdict.objects.is_empty() {
        let count = verdict.objects.len();
        rows.push(("objects", format!("{count}, each checked by itself")));
    }
    rows
}

/// The least wall, with where it is, and the mean one.
fn walls(verdict: &Verdict, size: f64, unit: Option<Unit>) -> Option<String> {
    let (number, thinnest, mean) = verdict.walls()?;
    let own = match verdict.components.len() {
        1 => String::new(),
        _ => format!(" in component {number}"),
    };
    let at = thinnest.thinnest_at.unwrap_or(thinnest.centre);
    let of = match verdict.samples_walls() {
        true => " of samples",
        false => "",
    };
    Some(format!(
        "least thickness{of} {}{own} at {}; mean {}",
        Unit::text(unit, thinnest.least_wall?),
        point(at, size),
        Unit::text(unit, mean)
    ))
}

/// The name of a kind of defect in a list.
fn name(kind: DefectKind) -> &'static str {
    match kind {
        DefectKind::BoundaryEdge => "boundary edges",
        DefectKind::NonManifoldEdge => "non-manifold edges",
        DefectKind::NonManifoldVertex => "non-manifold vertices",
        DefectKind::Misoriented => "misoriented edges",
        DefectKind::InsideOut => "inside out",
        DefectKind::Degenerate => "degenerate faces",
        DefectKind::Duplicate => "duplicate faces",
        DefectKind::SelfIntersection => "intersecting faces",
        DefectKind::Thin => "thin parts",
        DefectKind::ThinWall => "thin walls",
    }
}

fn defect_text(defect: &Defect, verdict: &Verdict, size: f64, unit: Option<Unit>) -> String {
    let mut text = defect.count.to_string();
    match (defect.kind, verdict.params.thin) {
        (DefectKind::BoundaryEdge, _) => {
            text += &format!(" round {}", counted(verdict.holes, "hole"));
            if verdict.open_chains > 0 {
                text += &format!(
                    " and in {} that {} not close",
                    counted(verdict.open_chains, "boundary chain"),
                    if verdict.open_chains == 1 {
                        "does"
                    } else {
                        "do"
                    }
                );
            }
        }
        (DefectKind::InsideOut, _) => text = counted(defect.count, "closed component"),
        (DefectKind::Thin, Some(thin)) => {
            text = counted(defect.count, "face");
            text += &format!(" where it is thinner than {}", Unit::text(unit, thin));
        }
        (DefectKind::ThinWall, _) => {
            let limit = verdict.params.min_wall.unwrap_or_default();
            text = counted(defect.count, "face");
            text += &format!(" at walls thinner than {}", Unit::text(unit, limit));
        }
        _ => {}
    }
    if defect.places.is_empty() {
        return text;
    }
    let places = defect.places.iter().take(MOST_PLACES);
    let places: Vec<String> = places.map(|p| point(*p, size)).collect();
    let more = match defect.places.len() {
        n if n > MOST_PLACES => format!("; and at {}", counted(n - MOST_PLACES, "more place")),
        _ => String::new(),
    };
    format!("{text}, at {}{more}", places.join("; "))
}
