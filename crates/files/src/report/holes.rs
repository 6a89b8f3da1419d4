//! Text tables of holes and of the crease ends at their rims.

use super::counts::counted;
use isomend_core::mend::{CreaseEnd, Inspection};
use isomend_core::mesh::{Hole, length, length_beside, number, point};

/// Columns of a table of holes: name and least width in characters; longer cells widen a column. Negative widths: aligned to the left.
const HOLE_COLUMNS: [(&str, isize); 10] = [
    ("hole", 5),
    ("edges", 6),
    ("length", 9),
    ("diameter", 9),
    ("height", 9),
    ("planarity", 9),
    ("centre", -22),
    ("normal", -21),
    ("component", 9),
    ("kind", -4),
];
/// The columns of a table of holes that are left out where the table is too wide, in this order.
const LESS_NEEDED: [&str; 7] = [
    "normal",
    "planarity",
    "component",
    "height",
    "length",
    "centre",
    "creases",
];
/// The column with the number of crease ends, after the edges; only if a rim has any.
const CREASE_COLUMN: (&str, isize) = ("creases", 7);
/// The column with the object of a 3MF file, the last one; only if there are several.
const OBJECT_COLUMN: (&str, isize) = ("object", -6);
/// Columns of a table of crease ends, as [`HOLE_COLUMNS`].
const END_COLUMNS: [(&str, isize); 4] =
    [("crease end", 10), ("hole", 5), ("angle", 6), ("at", -22)];

/// A table of holes with a heading, one line each; with a column for the number of crease ends if there are any. Columns are left out if it
/// would be wider than `width` characters.
#[doc(hidden)]
pub fn hole_table(holes: &[Hole], ends: &[CreaseEnd], width: Option<usize>) -> Vec<String> {
    let mut columns = HOLE_COLUMNS.to_vec();
    // One size for all centres, so that they have the same number of decimals.
    let sizes = holes
        .iter()
        .map(|h| h.diameter.max(h.centre.abs().max_element()));
    let size = sizes.fold(0.0, f64::max);
    let cells = |h: &Hole| hole_cells(h, size).to_vec();
    let mut rows: Vec<Vec<String>> = holes.iter().map(cells).collect();
    if !ends.is_empty() {
        columns.insert(2, CREASE_COLUMN);
        for (row, hole) in rows.iter_mut().zip(holes) {
            let own = ends.iter().filter(|end| end.hole == hole.id).count();
            row.insert(2, own.to_string());
        }
    }
    if holes.iter().any(|hole| hole.object.is_some()) {
        columns.push(OBJECT_COLUMN);
        for (row, hole) in rows.iter_mut().zip(holes) {
            row.push(hole.object.clone().unwrap_or_default());
        }
    }
    let mut lines = table(&columns, rows.clone());
    let is_wide = |lines: &[String]| {
        lines
            .iter()
            .any(|line| width.is_some_and(|w| line.chars().count() > w))
    };
    for name in LESS_NEEDED {
        let at = columns.iter().position(|(column, _)| *column == name);
        if let Some(at) = at.filter(|_| is_wide(&lines)) {
            columns.remove(at);
            for row in &mut rows {
                row.remove(at);
            }
            lines = table(&columns, rows.clone());
        }
    }
    lines
}

/// A table of crease ends with a heading, one line each. `size` is the size of the mesh, to which positions are rounded.
#[doc(hidden)]
pub fn crease_end_table(ends: &[CreaseEnd], size: f64) -> Vec<String> {
    let cells = |end: &CreaseEnd| {
        vec![
            end.id.to_string(),
            end.hole.to_string(),
            format!("{:.1}°", end.angle),
            point(end.position, size),
        ]
    };
    table(&END_COLUMNS, ends.iter().map(cells).collect())
}

/// Most components that are listed.
const MOST_COMPONENTS: usize = 1000;

/// For each component its number, faces, area and size; of the first ones, if there are very many.
#[doc(hidden)]
pub fn component_rows(found: &Inspection) -> Vec<Vec<String>> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let areas = topology.component_areas(mesh);
    let bounds = topology.component_bounds(mesh);
    let row = |i: usize| {
        let (low, high) = bounds[i];
        let size = (high - low).to_array().map(length).join(" x ");
        let faces = topology.component_faces[i].to_string();
        vec![(i + 1).to_string(), faces, length(areas[i]), size]
    };
    (0..areas.len().min(MOST_COMPONENTS)).map(row).collect()
}

/// The number of sharp edges that end at rims, in one line; `None` if there are none.
#[doc(hidden)]
pub fn crease_end_line(ends: &[CreaseEnd]) -> Option<String> {
    let mut holes: Vec<_> = ends.iter().map(|end| end.hole).collect();
    holes.dedup();
    let at = match &holes[..] {
        [] => return None,
        [one] => format!("the rim of hole {one}"),
        many => format!("the rims of {}", counted(many.len(), "hole")),
    };
    let end = if ends.len() == 1 { "ends" } else { "end" };
    Some(format!(
        "{} {end} at {at}",
        counted(ends.len(), "sharp edge")
    ))
}

/// The names of the columns and the rows below them, each column as wide as its widest cell.
fn table(columns: &[(&str, isize)], rows: Vec<Vec<String>>) -> Vec<String> {
    let names = columns.iter().map(|(name, _)| (*name).to_owned());
    let mut all = vec![names.collect::<Vec<String>>()];
    all.extend(rows);
    let least = columns.iter().map(|(_, width)| width.unsigned_abs());
    let mut widths: Vec<usize> = least.collect();
    for row in &all {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let line = |row: &Vec<String>| {
        let mut line = String::new();
        for ((cell, width), (_, side)) in row.iter().zip(&widths).zip(columns) {
            line += &match side {
                ..0 => format!("  {cell:<width$}"),
                _ if line.is_empty() => format!("{cell:>width$}"),
                _ => format!(" {cell:>width$}"),
            };
        }
        line.trim_end().to_owned()
    };
    all.iter().map(line).collect()
}

/// The cells of a hole; `size` is the size to which centres are rounded.
fn hole_cells(h: &Hole, size: f64) -> [String; 10] {
    let kind = if h.outer_boundary {
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
        length_beside(h.height, h.diameter),
        // Three points are in one plane.
        match h.edges {
            3 => "0".to_owned(),
            _ => number(h.planarity),
        },
        point(h.centre, size),
        normal.join(", "),
        (h.component + 1).to_string(),
        kind.to_owned(),
    ]
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use isomend_core::mesh::HoleId;

    #[test]
    fn crease_ends_are_counted_in_words() {
        let end = |id, hole| CreaseEnd {
            id,
            hole: HoleId::from(hole),
            vertex: 0,
            position: DVec3::ZERO,
            angle: 90.0,
        };
        let line = |ends: &[CreaseEnd]| crease_end_line(ends).unwrap_or_default();
        assert_eq!(line(&[]), "");
        assert_eq!(line(&[end(1, 3)]), "1 sharp edge ends at the rim of hole 3");
        let ends = [end(1, 2), end(2, 2), end(3, 5)];
        assert_eq!(line(&ends[..2]), "2 sharp edges end at the rim of hole 2");
        assert_eq!(line(&ends), "3 sharp edges end at the rims of 2 holes");
        let rows = crease_end_table(&ends, 1.0);
        assert_eq!(rows.len(), 4);
        assert!(
            rows[3].starts_with("         3     5  90.0°  0"),
            "{rows:?}"
        );
    }
}
