//! The `--json` option: writes JSON documents to a file or to standard output.

use std::convert::Infallible;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::Context;
use isomend::job::{Place, write_text};
use serde::Serialize;

use super::{Usage, console};

/// The target of a JSON document.
#[derive(Clone, Debug)]
pub enum Target {
    /// Standard output.
    Stdout,
    /// A file.
    File(PathBuf),
}

impl FromStr for Target {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text {
            "-" => Target::Stdout,
            path => Target::File(path.into()),
        })
    }
}

impl Target {
    /// Whether it is standard output.
    pub fn is_stdout(&self) -> bool {
        matches!(self, Target::Stdout)
    }

    /// Refuses a file that cannot be written or is one of the meshes, and standard output if a mesh goes there.
    pub fn check(&self, inputs: &[Place], outputs: &[Place]) -> anyhow::Result<()> {
        let Target::File(path) = self else {
            if outputs.iter().any(|output| output.path().is_none()) {
                let what = "--json - and --output - cannot both use standard output; name a file for one of them";
                return Err(Usage(what.to_owned()).into());
            }
            return Ok(());
        };
        let place = Place::from(path.clone());
        let checked = place.check_document(inputs.iter().chain(outputs));
        checked.map_err(super::cli_error)?;
        Ok(())
    }

    /// The target as a place.
    pub fn place(&self) -> Place {
        match self {
            Target::Stdout => Place::memory("standard output"),
            Target::File(path) => Place::from(path.clone()),
        }
    }

    /// Writes a document.
    pub fn write(&self, document: &impl Serialize) -> anyhow::Result<()> {
        let text = serde_json::to_string_pretty(document).context("cannot make the JSON report")?;
        self.write_text(&(text + "\n"))
    }

    /// Writes the text of a document.
    pub fn write_text(&self, text: &str) -> anyhow::Result<()> {
        match self {
            Target::Stdout => print(text),
            Target::File(path) => Ok(write_text(path, text)?),
        }
    }
}

/// Prints the text of a document.
pub fn print(text: &str) -> anyhow::Result<()> {
    console::write(text.as_bytes()).context("cannot write to standard output")
}
