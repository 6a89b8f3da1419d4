//! The command line of isomend: see `isomend --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    isomend::command_line(std::env::args_os()).into()
}
