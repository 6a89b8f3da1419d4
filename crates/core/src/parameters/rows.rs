//! The tables of parameters as a serialisable document, which the local page, Python and the test of the documentation read.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{DefaultValue, Kind, Parameter, Table};

/// A parameter of a command.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name in Python.
    pub name: &'static str,
    /// Option of the command line, without the leading dashes.
    pub option: String,
    /// Path of the value in the serialised parameters; empty if the parameter selects the command's work instead.
    pub path: Vec<&'static str>,
    /// Type of its values: `number`, `whole`, `voxel`, `band`, `choice`, `words`, `flag`, `holes`, `groups`, `pairs` or `like`.
    pub kind: &'static str,
    /// Placeholder of the value in the help.
    pub placeholder: String,
    /// Unit of a number.
    pub unit: &'static str,
    /// Lower bound of a number.
    pub low: Option<f64>,
    /// Upper bound of a number, if there is one.
    pub high: Option<f64>,
    /// Whether the bounds are excluded.
    pub open: bool,
    /// The allowed numbers, in words.
    pub allowed: Option<String>,
    /// The words to choose from.
    pub choices: Vec<ChoiceRow>,
    /// The value of the field if a flag is given.
    pub sets: Option<bool>,
    /// The default as it is written, if it is one value.
    pub default: Option<&'static str>,
    /// The default in words; may be empty.
    pub usual: String,
    /// What the parameter does, in one sentence.
    pub sentence: &'static str,
    /// Further text; may be empty.
    pub details: &'static str,
    /// A parameter that cannot be combined with this one; may be empty.
    pub excludes: &'static str,
    /// Whether only the library and Python have it, not the command line and the page.
    pub library_only: bool,
}

/// A word that can be chosen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ChoiceRow {
    /// The word.
    pub name: &'static str,
    /// Its meaning; may be empty.
    pub sentence: &'static str,
}

impl Table {
    /// The parameters as rows of the document.
    pub fn rows(&self) -> Vec<Row> {
        let entries = self.entries();
        entries.map(|(path, p)| p.row(path)).collect()
    }
}

/// The tables of all commands, by their names.
pub fn document() -> BTreeMap<&'static str, Vec<Row>> {
    let tables = Table::ALL.iter();
    tables.map(|table| (table.command, table.rows())).collect()
}

impl Parameter {
    fn row(&self, path: Vec<&'static str>) -> Row {
        let bounds = self.kind.bounds();
        let is_whole = matches!(self.kind, Kind::Whole(_));
        let choices = match self.kind {
            Kind::Choice(choices) | Kind::Words(choices, _) => choices,
            _ => &[],
        };
        let choice = |choice: &super::Choice| ChoiceRow {
            name: choice.name,
            sentence: choice.sentence,
        };
        Row {
            name: self.name,
            option: self.option(),
            path,
            kind: self.kind.name(),
            placeholder: self.kind.placeholder(),
            unit: self.unit,
            low: bounds.map(|b| b.low),
            high: bounds.map(|b| b.high).filter(|high| high.is_finite()),
            open: bounds.is_some_and(|b| b.open),
            allowed: bounds.map(|b| b.text(is_whole)),
            choices: choices.iter().map(choice).collect(),
            sets: match self.kind {
                Kind::Flag(value) => Some(value),
                _ => None,
            },
            default: match self.default {
                DefaultValue::Value(text) => Some(text),
                _ => None,
            },
            usual: self.default.text(),
            sentence: self.sentence,
            details: self.details,
            excludes: self.excludes,
            library_only: self.library_only,
        }
    }
}

impl Kind {
    /// The name of the type in the document.
    fn name(&self) -> &'static str {
        match self {
            Self::Number(..) => "number",
            Self::Whole(_) => "whole",
            Self::Voxel => "voxel",
            Self::Band => "band",
            Self::Choice(_) => "choice",
            Self::Words(..) => "words",
            Self::Flag(_) => "flag",
            Self::Holes(_) => "holes",
            Self::Groups => "groups",
            Self::Pairs => "pairs",
            Self::Like => "like",
        }
    }

    /// The placeholder of a value in the help of the command line.
    pub fn placeholder(&self) -> String {
        let text = match self {
            Self::Number(_, text) => text,
            Self::Whole(_) => "N",
            Self::Voxel => "LENGTH|auto",
            Self::Band => "LENGTH|full",
            Self::Choice(choices) => {
                let names: Vec<&str> = choices.iter().map(|c| c.name).collect();
                return names.join("|");
            }
            Self::Words(_, one) => return format!("{one},…"),
            Self::Flag(_) => "",
            Self::Holes(true) => "all|ID,…",
            Self::Holes(false) => "ID,…",
            Self::Groups => "ID+ID",
            Self::Pairs => "A+B",
            Self::Like => "mirror[:X,Y,Z,NX,NY,NZ]|FILE",
        };
        text.to_owned()
    }
}
