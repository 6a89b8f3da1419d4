//! Pages and pictures: files, text and bytes.

use std::path::PathBuf;

use isomend::job::{Drawings, Output, Place};

use crate::errors::Failure;

/// The command line that a page shows: the call of a command's function.
pub fn call(command: &str) -> String {
    format!("isomend.{command}(…)")
}

/// The page and the picture of a mesh that is written, where they are wanted.
pub fn drawings(
    command: &str,
    page: Option<PathBuf>,
    picture: Option<PathBuf>,
    source: &Place,
    output: &Output,
) -> Result<Drawings, Failure> {
    let drawings = Drawings {
        page,
        picture,
        command_line: call(command),
        ..Drawings::default()
    };
    drawings.check(source, Some(&output.place))?;
    Ok(drawings)
}
