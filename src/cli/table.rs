//! Tables of several files, which fit into the width of the terminal.

use super::console;

/// Columns of a table for several files that are left out where it is too wide, in this order.
const LESS_NEEDED: [&str; 5] = ["format", "components", "vertices", "widest hole", "faces"];
/// Least width of the last column of a table in characters: narrower ones are not wrapped, but other columns are left out.
const LEAST_LAST: usize = 16;

/// A table with headings; each column is as wide as its widest cell. All columns except the first and the last are aligned to the right.
/// Where it is wider than `width` characters, columns are left out and the last one is wrapped; if that is not enough, names get lines of
/// their own.
pub fn table(headings: &[String], rows: &[Vec<String>], width: Option<usize>) -> String {
    let mut all = vec![headings.to_vec()];
    all.extend_from_slice(rows);
    let is_wide = |all: &[Vec<String>]| width.is_some_and(|most| least_width(all) > most);
    for name in LESS_NEEDED {
        let at = all[0].iter().position(|heading| heading == name);
        if let Some(at) = at.filter(|_| is_wide(&all)) {
            // The row of a file that failed has no cells in these columns.
            let columns = all[0].len();
            let whole = all.iter_mut().filter(|row| row.len() == columns);
            whole.for_each(|row| drop(row.remove(at)));
        }
    }
    let names_apart = is_wide(&all);
    let mut widths = widths(&all);
    if names_apart {
        widths[0] = 0;
    }
    let line = |row: &Vec<String>| {
        let (mut line, mut indent) = (String::new(), 0);
        for (column, cell) in row.iter().enumerate() {
            indent = line.chars().count() + 2;
            match column {
                0 if names_apart => {}
                0 => line += &format!("{cell:<most$}", most = widths[0]),
                c if c + 1 == row.len() => line += &format!("  {cell}"),
                c => line += &format!("  {cell:>most$}", most = widths[c]),
            }
        }
        let line = console::wrapped(line.trim_end(), width, indent);
        match names_apart {
            true => format!("{}\n{line}", row[0]),
            false => line,
        }
    };
    let mut lines = all.iter().map(line);
    let mut text = String::new();
    for heading in lines.next().iter().flat_map(|heading| heading.lines()) {
        text += &(console::heading(heading) + "\n");
    }
    lines.for_each(|line| text += &(line + "\n"));
    text
}

/// The width of each column; 0 for the last one.
fn widths(rows: &[Vec<String>]) -> Vec<usize> {
    let columns = rows[0].len();
    let mut widths = vec![0; columns];
    for row in rows {
        let own = if row.len() == columns { columns - 1 } else { 1 };
        for (width, cell) in widths.iter_mut().zip(row).take(own) {
            *width = (*width).max(cell.chars().count());
        }
    }
    widths
}

/// The least width of a table, with its last column wrapped at [`LEAST_LAST`] characters.
fn least_width(rows: &[Vec<String>]) -> usize {
    let last = rows.iter().filter_map(|row| row.last());
    let last = last
        .map(|cell| console::characters(cell))
        .max()
        .unwrap_or(0);
    let widths = widths(rows);
    widths.iter().sum::<usize>() + 2 * (widths.len() - 1) + last.min(LEAST_LAST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_cells() {
        let row = |cells: &[&str]| cells.iter().map(ToString::to_string).collect::<Vec<_>>();
        let rows = [row(&["a.ply", "12", "yes"]), row(&["longer.stl", "failed"])];
        let text = table(&row(&["file", "faces", "verdict"]), &rows, None);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].contains("file        faces  verdict"));
        assert_eq!(lines[1], "a.ply          12  yes");
        assert_eq!(lines[2], "longer.stl  failed");
    }

    #[test]
    fn wide_tables_lose_columns_and_are_wrapped() {
        let row = |cells: &[&str]| cells.iter().map(ToString::to_string).collect::<Vec<_>>();
        let headings = row(&["file", "format", "faces", "holes", "defects"]);
        let defects = "note of five words, and of five words more than these";
        for name in [
            "scan.ply",
            "a name of a file that is as long as the table of it.ply",
        ] {
            let rows = [
                row(&[name, "PLY", "1234567", "12", defects]),
                row(&[name, "failed"]),
            ];
            for width in [60, 80, 120] {
                let text = table(&headings, &rows, Some(width));
                let lines: Vec<&str> = text.lines().collect();
                let fits = |line: &&&str| console::characters(line) <= width;
                assert!(lines.iter().all(|line| fits(&line)), "{text}");
                let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
                assert!(words.contains(" 12 note of"), "{text}");
                assert_eq!(text.matches(name).count(), 2, "{text}");
            }
        }
    }
}
