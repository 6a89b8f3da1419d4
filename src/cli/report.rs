//! Options for drawings: the HTML report and the picture.

use std::path::PathBuf;

use clap::Args;
use isomend::job::{Drawings, Place};

use super::Usage;
use super::json::Target;

/// Options for drawings.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Write a report as a single HTML file: a 3D view of the mesh with its holes, and tables.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,

    /// Draw the mesh with its holes as a PNG file; before and after, if the mesh changes.
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
}

impl ReportArgs {
    /// The drawings to make. Refuses a file that is also the file of `--json`.
    pub fn drawings(&self, json: Option<&Target>) -> anyhow::Result<Drawings> {
        if let Some(Target::File(json)) = json {
            let json = Place::from(json.clone());
            for path in [&self.report, &self.picture].into_iter().flatten() {
                if Place::from(path.clone()).is_same_file(&json) {
                    let path = path.display();
                    let what = format!("{path} is the file of --json too; name another file");
                    return Err(Usage(what).into());
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

/// The command line, quoted for a shell where necessary.
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
