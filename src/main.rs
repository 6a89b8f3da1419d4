//! The command line of isomend: see `isomend --help`.

mod cli;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match cli::run(cli::Cli::parse()) {
        Ok(end) => end.into(),
        Err(error) => {
            eprintln!("isomend: {error:#}");
            ExitCode::FAILURE
        }
    }
}
