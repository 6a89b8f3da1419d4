//! Options of what is drawn.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use isomend::job::{Drawings, Place};

use super::json::Target;

/// Options of what is drawn.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Write a page to look at: a 3D view with the holes and their numbers, plots and tables, in one HTML file that needs
    /// nothing else.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,

    /// Draw the mesh with its holes, before and after where it changes, into a PNG file.
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
}

impl ReportArgs {
    /// What is drawn; refuses the file of `--json`.
    pub fn drawings(&self, json: Option<&Target>) -> anyhow::Result<Drawings> {
        if let Some(Target::File(json)) = json {
            let json = Place::from(json.clone());
            for path in [&self.report, &self.picture].into_iter().flatten() {
                if Place::from(path.clone()).is_same_file(&json) {
                    bail!(
                        "{} is the file of --json too; name another file",
                        path.display()
                    );
                }
            }
        }
        let mut drawings = Drawings::default();
        drawings.page.clone_from(&self.report);
        drawings.picture.clone_from(&self.picture);
        drawings.command_line = command_line();
        Ok(drawings)
    }
}

/// The command line, quoted for a shell where it has to be.
fn command_line() -> String {
    let quoted = |argument: std::ffi::OsString| {
        let text = argument.to_string_lossy().into_owned();
        let plain = |c: char| c.is_alphanumeric() || "-_./:,=+@%".contains(c);
        if !text.is_empty() && text.chars().all(plain) {
            text
        } else {
            format!("'{}'", text.replace('\'', "'\\''"))
        }
    };
    let arguments: Vec<String> = std::env::args_os().skip(1).map(quoted).collect();
    format!("isomend {}", arguments.join(" "))
}
