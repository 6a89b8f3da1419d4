//! Absolute paths.

use std::io::Result;
use std::path::{Path, PathBuf};

/// The absolute path of a file or folder, with links resolved.
///
/// # Errors
/// When it does not exist.
#[cfg(not(target_family = "wasm"))]
#[doc(hidden)]
pub fn canonical(path: &Path) -> Result<PathBuf> {
    std::fs::canonicalize(path)
}

/// The absolute path of a file or folder. Files in memory have no links, and every path begins in their only folder, `/`.
///
/// # Errors
/// When it does not exist.
#[cfg(target_family = "wasm")]
#[doc(hidden)]
pub fn canonical(path: &Path) -> Result<PathBuf> {
    use std::path::Component;
    std::fs::metadata(path)?;
    let mut whole = PathBuf::from("/");
    for part in path.components() {
        match part {
            Component::Normal(name) => whole.push(name),
            Component::ParentDir => {
                whole.pop();
            }
            _ => {}
        }
    }
    Ok(whole)
}
