//! Reading the input.

use std::path::Path;

use anyhow::{Context, bail};
use isomend::io::{Format, IoError, Loaded, read_stream};
use isomend::job::{JobError, Place, Source};

use super::console::Console;

/// The name of standard input in messages.
const STANDARD_INPUT: &str = "standard input";

/// Whether a path stands for standard input or output.
pub fn is_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The place that a path of an input stands for.
pub fn place(path: &Path) -> Place {
    match is_stream(path) {
        true => Place::Bytes(STANDARD_INPUT.to_owned()),
        false => Place::from(path),
    }
}

/// What a path stands for; standard input is read to its end.
pub fn source(path: &Path, from: Option<Format>) -> anyhow::Result<Source> {
    let mut source = match is_stream(path) {
        true => Source::bytes(STANDARD_INPUT, standard_input()?),
        false => Source::from(path),
    };
    source.format = from;
    Ok(source)
}

/// Reads a mesh and passes on what its reader has to say.
pub fn read(source: &Source, console: &Console) -> anyhow::Result<Loaded> {
    let loaded = source.read().map_err(|error| told(error, source))?;
    tell_notes(&source.place, &loaded, console);
    Ok(loaded)
}

/// Passes on what the reader of a mesh has to say.
pub fn tell_notes(place: &Place, loaded: &Loaded, console: &Console) {
    for note in &loaded.notes {
        console.note(&format!("{}: {note}", place.name()));
    }
}

/// An error with the option that helps where the format of standard input cannot be told.
pub fn told(error: JobError, source: &Source) -> anyhow::Error {
    let unknown = |e: &IoError| matches!(e, IoError::UnknownFormat { .. });
    match error {
        JobError::Bytes { error, .. } if source.format.is_none() && unknown(&error) => {
            anyhow::Error::from(error)
                .context(format!("{STANDARD_INPUT}, whose format --from can tell"))
        }
        error => super::told(error),
    }
}

/// All bytes of standard input.
pub fn standard_input() -> anyhow::Result<Vec<u8>> {
    let bytes = read_stream(std::io::stdin().lock()).context("cannot read standard input")?;
    if bytes.is_empty() {
        bail!("standard input is empty");
    }
    Ok(bytes)
}
