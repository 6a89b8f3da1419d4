//! Files of options.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Args, CommandFactory, Parser, Subcommand, ValueHint};

use crate::cli::{arguments, config, mask, parameters};

/// A program with options of every kind that isomend's commands have.
#[derive(Debug, Parser)]
struct Program {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Fill(Options),
    Restore(Marked),
}

#[derive(Debug, Args)]
struct Options {
    input: PathBuf,
    #[arg(short, long, value_hint = ValueHint::FilePath)]
    output: PathBuf,
    #[arg(long)]
    config: Option<PathBuf>,
    #[command(flatten)]
    parameters: parameters::ParameterArgs<parameters::Fill>,
    #[arg(long, value_parser = arguments::count)]
    threads: Option<usize>,
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,
    #[arg(short, long)]
    verbose: bool,
}

#[derive(Debug, Args)]
struct Marked {
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    mask: mask::MaskArgs,
}

/// Reads the bytes as a file of options of some command lines.
pub fn toml(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let program = Program::command();
    for given in [
        "fill in.ply -o out.ply",
        "restore in.ply --voxel 0.1",
        "fill in.ply -q",
    ] {
        let words = std::iter::once("isomend").chain(given.split(' '));
        let arguments: Vec<OsString> = words.map(OsString::from).collect();
        let file = Path::new("folder/options.toml");
        let all = config::with_file(arguments.clone(), &program, file, || Ok(text.to_owned()));
        match all {
            Ok(all) => {
                assert_eq!(all[..2], arguments[..2]);
                assert!(all.ends_with(&arguments[2..]), "{all:?}");
                let _ = Program::try_parse_from(all);
            }
            Err(error) => {
                let message = error.to_string();
                assert!(message.contains("options.toml, line "), "{message}");
            }
        }
    }
}
