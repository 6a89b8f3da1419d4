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
use crate::job::contradiction;

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
            console::print_out(&table(&headings, &rows))?;
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

/// A table with headings; each column is as wide as its widest cell. All columns except the first and the last are aligned to the right.
fn table(headings: &[String], rows: &[Vec<String>]) -> String {
    let last = headings.len() - 1;
    let cells = |column: usize| {
        // The row of a file that failed has no cells in the other columns.
        let whole = move |row: &&Vec<String>| column == 0 || row.len() == headings.len();
        let own = rows
            .iter()
            .filter(whole)
            .filter_map(move |row| row.get(column));
        own.chain(headings.get(column))
    };
    let width = |column: usize| cells(column).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..last).map(width).collect();
    let line = |row: &[String]| {
        let mut line = String::new();
        for (column, cell) in row.iter().enumerate() {
            match column {
                0 => line += &format!("{cell:<width$}", width = widths[0]),
                c if c == last || row.len() < headings.len() => line += &format!("  {cell}"),
                c => line += &format!("  {cell:>width$}", width = widths[c]),
            }
        }
        line.trim_end().to_owned()
    };
    let mut text = console::heading(&line(headings)) + "\n";
    for row in rows {
        text += &(line(row) + "\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_cells() {
        let row = |cells: &[&str]| cells.iter().map(ToString::to_string).collect::<Vec<_>>();
        let rows = [row(&["a.ply", "12", "yes"]), row(&["longer.stl", "failed"])];
        let text = table(&row(&["file", "faces", "verdict"]), &rows);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].contains("file        faces  verdict"));
        assert_eq!(lines[1], "a.ply          12  yes");
        assert_eq!(lines[2], "longer.stl  failed");
    }
}
