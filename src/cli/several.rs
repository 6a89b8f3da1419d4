//! Runs the commands that do not change meshes (`inspect`, `check`) on one file or several. For several files: a table, a list of JSON
//! documents, and one exit code.

use std::path::PathBuf;

use anyhow::Context;
use isomend::Unit;
use isomend::io::Loaded;
use isomend::job::{Document, Drawings, JobError, Source};
use serde::Serialize;

use super::console::{self, Console};
use super::json::Target;
use super::report::ReportArgs;
use super::{CommonArgs, End, Usage, input};
use isomend_files::job::contradiction;

/// The result for one file.
pub struct FileResult {
    /// The text to print for a single file.
    pub text: String,
    /// The cells of its row in a table for several files, without its name.
    pub cells: Vec<String>,
    /// Its JSON document.
    pub document: String,
    /// Whether the result is good; if not, the exit code is 3.
    pub is_good: bool,
}

impl FileResult {
    /// A JSON document as text.
    pub fn document(document: &impl Serialize) -> anyhow::Result<String> {
        serde_json::to_string_pretty(document).context("cannot make the JSON report")
    }
}

/// A command that inspects meshes without changing them.
pub struct MeshInspector<'a> {
    /// The name of the command.
    pub command: &'static str,
    pub inputs: &'a [PathBuf],
    pub report: &'a ReportArgs,
    pub common: &'a CommonArgs,
    /// The unit of the coordinates, where it was given.
    pub unit: Option<Unit>,
    /// The headings of the table, without the first column, the names.
    pub headings: &'a [&'a str],
    /// Whether anything is printed.
    pub prints: bool,
}

impl MeshInspector<'_> {
    /// Inspects each file, one after another, and prints the results. If one of several files fails, the others are still inspected.
    ///
    /// # Errors
    /// If the files cannot be used; for a single file, also its error.
    pub fn each(
        &self,
        console: &Console,
        inspect: &mut dyn FnMut(&Source, &Loaded, &Drawings) -> anyhow::Result<FileResult>,
    ) -> anyhow::Result<End> {
        let drawings = self.checked()?;
        let mut one = |path: &PathBuf| {
            let source = input::source(path, self.common.from)?;
            let loaded = input::read(&source, console)?;
            if let Some(note) = contradiction(loaded.attributes.unit, self.unit) {
                console.note(&format!("{}: {note}", source.place.name()));
            }
            inspect(&source, &loaded, &drawings)
        };
        if let [path] = self.inputs {
            let found = one(path)?;
            self.write(&found.document)?;
            if self.prints() {
                console::print_out(&found.text)?;
            }
            return Ok(if found.is_good {
                End::Done
            } else {
                End::InPart
            });
        }
        let (mut rows, mut documents, mut end) = (Vec::new(), Vec::new(), End::Done);
        for path in self.inputs {
            let name = path.display().to_string();
            match one(path) {
                Ok(found) => {
                    if !found.is_good && end == End::Done {
                        end = End::InPart;
                    }
                    rows.push([vec![name], found.cells].concat());
                    documents.push(found.document);
                }
                Err(error) => {
                    let words = format!("{error:#}");
                    documents.push(failed(self.command, &name, &words)?);
                    console.failed(&match words.contains(&name) {
                        true => words,
                        false => format!("{name}: {words}"),
                    });
                    rows.push(vec![name, "failed".to_owned()]);
                    end = End::Failed;
                }
            }
        }
        // Indenting is safe: strings in JSON contain no line breaks.
        let all = documents.join(",\n").replace('\n', "\n  ");
        self.write(&format!("[\n  {all}\n]"))?;
        if self.prints() {
            let headings: Vec<String> = [&["file"], self.headings]
                .concat()
                .iter()
                .map(ToString::to_string)
                .collect();
            console::print_out(&table(&headings, &rows, console::width()))?;
        }
        Ok(end)
    }

    /// Checks the files and returns the drawings to make.
    fn checked(&self) -> anyhow::Result<Drawings> {
        let places: Vec<_> = self.inputs.iter().map(|path| input::place(path)).collect();
        let several = places.len() > 1;
        if let Some(stream) = places.iter().find(|p| several && p.path().is_none()) {
            let what = format!(
                "{} cannot be one of several inputs; read it alone",
                stream.name()
            );
            return Err(Usage(what).into());
        }
        let json = self.common.json.as_ref();
        if let Some(json) = json {
            json.check(&places, &[])?;
        }
        let drawings = self.report.drawings(json)?;
        if several && drawings.is_wanted() {
            return Err(super::cli_error(JobError::SeveralDrawn));
        }
        if let [place] = &places[..] {
            drawings.check(place, None).map_err(super::cli_error)?;
        }
        Ok(drawings)
    }

    /// Whether text is printed, that is, the JSON document does not go to standard output.
    fn prints(&self) -> bool {
        self.prints && !matches!(self.common.json, Some(Target::Stdout))
    }

    /// Writes the JSON document, if one is requested.
    fn write(&self, document: &str) -> anyhow::Result<()> {
        match &self.common.json {
            Some(json) => json.write_text(&format!("{document}\n")),
            None => Ok(()),
        }
    }
}

/// The JSON document of a file that failed.
fn failed(command: &'static str, name: &str, error: &str) -> anyhow::Result<String> {
    #[derive(Serialize)]
    struct Body<'a> {
        input: File<'a>,
        error: &'a str,
    }
    #[derive(Serialize)]
    struct File<'a> {
        path: &'a str,
    }
    let input = File { path: name };
    FileResult::document(&Document::new(command, Body { input, error }))
}

/// Columns of a table for several files that are left out where it is too wide, in this order.
const LESS_NEEDED: [&str; 5] = ["format", "components", "vertices", "widest hole", "faces"];
/// Least width of the last column of a table in characters: narrower ones are not wrapped, but other columns are left out.
const LEAST_LAST: usize = 16;

/// A table with headings; each column is as wide as its widest cell. All columns except the first and the last are aligned to the right.
/// Where it is wider than `width` characters, columns are left out and the last one is wrapped; if that is not enough, names get lines of
/// their own.
fn table(headings: &[String], rows: &[Vec<String>], width: Option<usize>) -> String {
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
    let last = last.map(|cell| cell.chars().count()).max().unwrap_or(0);
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
