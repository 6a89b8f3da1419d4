//! Reading the input.

use std::io::Read;
use std::path::Path;

use anyhow::{Context, bail};
use isomend::io::{Format, Loaded, no_side_files, read_bytes, read_path};

use super::console::Console;

/// Whether a path stands for standard input or output.
pub fn is_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The name of an input in messages.
pub fn shown(path: &Path) -> String {
    if is_stream(path) {
        "standard input".to_owned()
    } else {
        path.display().to_string()
    }
}

/// Reads a mesh and passes on what its reader has to say.
pub fn read(path: &Path, from: Option<Format>, console: &Console) -> anyhow::Result<Loaded> {
    if path.is_dir() {
        bail!("{} is a folder: name a mesh file in it", path.display());
    }
    let loaded = if is_stream(path) {
        let bytes = standard_input()?;
        let format = match from {
            Some(format) => format,
            None => Format::detect(&bytes, Path::new(""))
                .context("standard input, whose format --from can tell")?,
        };
        read_bytes(&bytes, format, &no_side_files).context("standard input")?
    } else {
        read_path(path, from)?
    };
    let name = shown(path);
    let vertices = u32::try_from(loaded.mesh.positions.len());
    vertices
        .ok()
        .filter(|n| *n < u32::MAX / 4)
        .with_context(|| format!("{name} has too many vertices"))?;
    for note in &loaded.notes {
        console.note(&format!("{name}: {note}"));
    }
    Ok(loaded)
}

/// All bytes of standard input.
pub fn standard_input() -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::io::stdin()
        .lock()
        .read_to_end(&mut bytes)
        .context("cannot read standard input")?;
    if bytes.is_empty() {
        bail!("standard input is empty");
    }
    Ok(bytes)
}
