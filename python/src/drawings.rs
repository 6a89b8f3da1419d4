//! Settings of the HTML page and the PNG picture that are written with a mesh.

use std::path::PathBuf;

use isomend::job::{Drawings, Output, Place};

use crate::errors::Failure;

/// What a page shows in place of a command line: the call of the command's Python function.
pub fn call(command: &str) -> String {
    format!("isomend.{command}(…)")
}

/// Where the page and the picture of a written mesh go; an error if a path cannot be used, such as the input's or the output's.
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
