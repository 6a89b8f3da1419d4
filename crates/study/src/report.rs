//! The report of an experiment: tables, stated values beside measured ones, and charts; as text and CSV.

use std::fmt;

use serde::Serialize;

use super::contour::Segment;

/// The result of an experiment.
#[derive(Clone, Debug, Serialize)]
pub struct StudyReport {
    /// Name of the experiment on the command line.
    pub name: &'static str,
    /// Title, with the main parameters.
    pub title: String,
    /// The measurements.
    pub tables: Vec<ResultTable>,
    /// Stated values beside measured ones.
    pub claims: Vec<Claim>,
    /// Remarks on the run.
    pub remarks: Vec<String>,
    /// Run time in seconds.
    pub seconds: f64,
    /// Charts and level lines to draw.
    #[serde(skip)]
    pub panels: Vec<Panel>,
}

impl StudyReport {
    /// An empty report.
    pub fn new(name: &'static str, title: &str) -> Self {
        Self {
            name,
            title: title.to_owned(),
            tables: Vec::new(),
            claims: Vec::new(),
            remarks: Vec::new(),
            seconds: 0.0,
            panels: Vec::new(),
        }
    }

    /// Whether every claim holds.
    pub fn holds(&self) -> bool {
        self.claims.iter().all(|c| c.holds)
    }

    /// Adds a claim.
    pub(crate) fn claim(
        &mut self,
        by: StatedBy,
        what: &str,
        stated: String,
        got: String,
        holds: bool,
    ) {
        self.claims.push(Claim {
            what: what.to_owned(),
            by: by.to_string(),
            stated,
            got,
            holds,
        });
    }

    /// The report as lines of text.
    pub fn text_lines(&self) -> Vec<String> {
        let mut lines = vec![self.title.clone(), String::new()];
        for table in &self.tables {
            lines.extend(table.text_lines());
            lines.push(String::new());
        }
        lines.extend(self.remarks.iter().map(|r| format!("note: {r}")));
        if !self.remarks.is_empty() {
            lines.push(String::new());
        }
        for c in &self.claims {
            let word = if c.holds { "pass" } else { "FAIL" };
            lines.push(format!(
                "{word}  {}: stated by {}: {}; got {}",
                c.what, c.by, c.stated, c.got
            ));
        }
        lines.push(format!("{:.1} s", self.seconds));
        lines
    }

    /// The tables as comma-separated values, each after a line `# title`.
    pub fn csv(&self) -> String {
        let mut out = String::new();
        for table in &self.tables {
            out += &format!("# {}\n", table.title);
            out += &csv_line(table.columns.iter().map(|c| (*c).to_owned()));
            for row in &table.rows {
                out += &csv_line(row.iter().map(TableCell::exact));
            }
        }
        out
    }
}

fn csv_line(cells: impl Iterator<Item = String>) -> String {
    let quoted = cells.map(|c| {
        if c.contains([',', '"', '\n']) {
            format!("\"{}\"", c.replace('"', "\"\""))
        } else {
            c
        }
    });
    let mut line = quoted.collect::<Vec<_>>().join(",");
    line.push('\n');
    line
}

/// Who states a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StatedBy {
    /// The paper, in words or pictures; a bound that is a number is the reference's.
    Paper,
    /// Theory: an exact solution, a limit or an order of convergence.
    Theory,
    /// The prototype: an implementation of the paper in Python and C that shares no code with this one.
    Reference,
    /// This project: what its own method is held to.
    Project,
}

impl fmt::Display for StatedBy {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Paper => "the paper",
            Self::Theory => "theory",
            Self::Reference => "the prototype",
            Self::Project => "isomend",
        })
    }
}

/// A stated value beside the measured one.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    /// The measured quantity.
    pub what: String,
    /// Who states the value.
    pub by: String,
    /// The stated value.
    pub stated: String,
    /// The measured value.
    pub got: String,
    /// Whether they agree.
    pub holds: bool,
}

/// A table of measurements.
#[derive(Clone, Debug, Serialize)]
pub struct ResultTable {
    /// Heading.
    pub title: String,
    /// Names of the columns, with units.
    pub columns: Vec<&'static str>,
    /// The rows.
    pub rows: Vec<Vec<TableCell>>,
}

impl ResultTable {
    /// A table without rows.
    pub fn new(title: &str, columns: &[&'static str]) -> Self {
        Self {
            title: title.to_owned(),
            columns: columns.to_vec(),
            rows: Vec::new(),
        }
    }

    /// The table as text, its columns aligned.
    pub fn text_lines(&self) -> Vec<String> {
        let cells: Vec<Vec<String>> =
            std::iter::once(self.columns.iter().map(|c| (*c).to_owned()).collect())
                .chain(
                    self.rows
                        .iter()
                        .map(|r| r.iter().map(TableCell::short).collect()),
                )
                .collect();
        let widths: Vec<usize> = (0..self.columns.len())
            .map(|k| {
                cells
                    .iter()
                    .map(|r| r[k].chars().count())
                    .max()
                    .unwrap_or(0)
            })
            .collect();
        let line = |row: &Vec<String>| {
            let padded = row.iter().zip(&widths).map(|(c, w)| format!("{c:>w$}"));
            padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
        };
        std::iter::once(self.title.clone())
            .chain(cells.iter().map(line))
            .collect()
    }
}

/// An entry of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum TableCell {
    /// Text.
    Text(String),
    /// A count.
    Count(usize),
    /// A number.
    Number(f64),
    /// No value.
    Missing,
}

impl TableCell {
    fn short(&self) -> String {
        match self {
            TableCell::Text(t) => t.clone(),
            TableCell::Count(n) => n.to_string(),
            TableCell::Number(x) => short_number(*x),
            TableCell::Missing => "-".to_owned(),
        }
    }

    fn exact(&self) -> String {
        match self {
            TableCell::Number(x) => format!("{x:e}"),
            TableCell::Missing => String::new(),
            other => other.short(),
        }
    }
}

impl From<&str> for TableCell {
    fn from(text: &str) -> Self {
        TableCell::Text(text.to_owned())
    }
}

impl From<usize> for TableCell {
    fn from(n: usize) -> Self {
        TableCell::Count(n)
    }
}

impl From<f64> for TableCell {
    fn from(x: f64) -> Self {
        TableCell::Number(x)
    }
}

impl From<Option<f64>> for TableCell {
    fn from(x: Option<f64>) -> Self {
        x.map_or(TableCell::Missing, TableCell::Number)
    }
}

/// Formats a number with about four digits, with an exponent below 0.01 and from 100,000 on.
pub fn short_number(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        a if !(1e-2..1e5).contains(&a) => format!("{x:.3e}"),
        a if a < 1.0 => format!("{x:.4}"),
        a if a < 100.0 => format!("{x:.3}"),
        _ => format!("{x:.1}"),
    }
}

/// One panel of the drawing.
#[derive(Clone, Debug)]
pub enum Panel {
    /// Curves over axes.
    Chart(Chart),
    /// Level lines of a function on a square.
    Levels(Levels),
}

/// Curves over axes.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Heading.
    pub title: String,
    /// Quantities along the axes, with units.
    pub axes: [&'static str; 2],
    /// Which axes are logarithmic.
    pub logarithmic: [bool; 2],
    /// The order of convergence whose slope is drawn as a triangle; only with two logarithmic axes.
    pub order: Option<f64>,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// A curve of a chart.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name in the legend.
    pub name: String,
    /// Its points.
    pub points: Vec<(f64, f64)>,
    /// Whether it is drawn as dots, for few measurements.
    pub dots: bool,
}

/// Level lines of a function on a square.
#[derive(Clone, Debug)]
pub struct Levels {
    /// Heading.
    pub title: String,
    /// Lower left corner and side of the square.
    pub square: ([f64; 2], f64),
    /// Segments drawn thin: several levels.
    pub thin: Vec<Segment>,
    /// Segments drawn bold: the level of interest.
    pub bold: Vec<Segment>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_aligned_and_csv_is_quoted() {
        let mut report = StudyReport::new("x", "An experiment");
        let mut table = ResultTable::new("one", &["name", "value"]);
        table.rows.push(vec!["a, b".into(), 0.000_012_345.into()]);
        table.rows.push(vec!["c".into(), TableCell::Missing]);
        assert_eq!(
            table.text_lines(),
            ["one", "name     value", "a, b  1.234e-5", "   c         -"]
        );
        report.tables.push(table);
        assert_eq!(report.csv(), "# one\nname,value\n\"a, b\",1.2345e-5\nc,\n");
        report.claim(StatedBy::Theory, "b", "1".into(), "2".into(), false);
        assert!(!report.holds());
        assert!(report.text_lines().iter().any(|l| l.starts_with("FAIL")));
    }
}
