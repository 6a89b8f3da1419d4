//! Reads input meshes from files or standard input, and prints the remarks of the reader.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, bail};
use isomend::io::{Format, Loaded, read_stream};
use isomend::job::{Place, Source};

use super::console::Console;

/// The name of standard input in messages.
const STANDARD_INPUT: &str = "standard input";

/// Whether a path stands for standard input or output.
pub fn is_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The place for the path of an input.
pub fn place(path: &Path) -> Place {
    match is_stream(path) {
        true => Place::memory(STANDARD_INPUT),
        false => Place::from(path),
    }
}

/// The source for a path; standard input is read to its end.
pub fn source(path: &Path, from: Option<Format>) -> anyhow::Result<Source> {
    let mut source = named(path, from);
    fetch(&mut source)?;
    Ok(source)
}

/// The source for a path, without reading standard input yet.
pub fn named(path: &Path, from: Option<Format>) -> Source {
    let mut source = Source::from(place(path));
    source.format = from;
    source
}

/// Reads standard input to its end, if it is the source.
pub fn fetch(source: &mut Source) -> anyhow::Result<()> {
    if source.place.path().is_none() {
        source.bytes = standard_input()?;
    }
    Ok(())
}

/// Reads a mesh and prints the remarks of its reader.
pub fn read(source: &Source, console: &Console) -> anyhow::Result<Arc<Loaded>> {
    let loaded = source.read().map_err(super::cli_error)?;
    print_notes(&source.place, &loaded, console);
    Ok(loaded)
}

/// Prints the remarks of the reader of a mesh.
pub fn print_notes(place: &Place, loaded: &Loaded, console: &Console) {
    for note in &loaded.notes {
        console.note(&format!("{}: {note}", place.name()));
    }
}

/// The message of an error, with the name of the file in front if the message does not contain it.
pub fn with_name(input: &Place, error: &str) -> String {
    let name = input.name();
    if error.contains(&name) {
        error.to_owned()
    } else {
        format!("{name}: {error}")
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
