//! Where JSON documents go.

use std::cell::RefCell;
use std::convert::Infallible;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Context, bail};
use isomend::job::{Place, write_text};
use serde::Serialize;

use super::{Usage, console};

/// Where a report goes.
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

    /// Refuses a file that cannot be written or is one of the meshes, and standard output where a mesh goes there.
    pub fn check(&self, inputs: &[Place], outputs: &[Place]) -> anyhow::Result<()> {
        let Target::File(path) = self else {
            if outputs.iter().any(|output| output.path().is_none()) {
                let what = "--json - and --output - cannot both have standard output; name a file for one of them";
                return Err(Usage(what.to_owned()).into());
            }
            return Ok(());
        };
        let place = Place::from(path.clone());
        place.check_writable()?;
        if inputs
            .iter()
            .chain(outputs)
            .any(|mesh| place.is_same_file(mesh))
        {
            bail!(
                "--json {} would overwrite a mesh; name another file",
                path.display()
            );
        }
        Ok(())
    }

    /// Writes a document.
    pub fn write(&self, document: &impl Serialize) -> anyhow::Result<()> {
        self.write_text(&(pretty(document)? + "\n"))
    }

    fn write_text(&self, text: &str) -> anyhow::Result<()> {
        match self {
            Target::Stdout => {
                console::write(text.as_bytes()).context("cannot write to standard output")
            }
            Target::File(path) => Ok(write_text(path, text)?),
        }
    }
}

fn pretty(document: &impl Serialize) -> anyhow::Result<String> {
    serde_json::to_string_pretty(document).context("cannot make the JSON report")
}

/// The reports of several inputs.
#[derive(Debug, Default)]
pub struct Documents(RefCell<Vec<String>>);

impl Documents {
    /// Adds the report of one.
    pub fn add(&self, document: &impl Serialize) -> anyhow::Result<()> {
        self.0.borrow_mut().push(pretty(document)?);
        Ok(())
    }

    /// Writes the only one, or a list of all.
    pub fn write(&self, target: &Target, list: bool) -> anyhow::Result<()> {
        let mut text = self.0.borrow().join(",\n");
        if list {
            // No line of a JSON document ends inside a string.
            text = format!("[\n  {}\n]", text.replace('\n', "\n  "));
        }
        target.write_text(&(text + "\n"))
    }
}
