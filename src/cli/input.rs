//! Reading the input.

use std::path::Path;

use anyhow::Context;
use isomend::io::{Format, Loaded, read_path};

use super::console::Console;

/// Reads a mesh and passes on what its reader has to say.
pub fn read(path: &Path, from: Option<Format>, console: &Console) -> anyhow::Result<Loaded> {
    if path.is_dir() {
        anyhow::bail!("{} is a folder: name a mesh file in it", path.display());
    }
    let loaded = read_path(path, from)?;
    let vertices = u32::try_from(loaded.mesh.positions.len());
    vertices
        .ok()
        .filter(|n| *n < u32::MAX / 4)
        .with_context(|| format!("{} has too many vertices", path.display()))?;
    for note in &loaded.notes {
        console.note(&format!("{}: {note}", path.display()));
    }
    Ok(loaded)
}
