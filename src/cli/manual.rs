//! `isomend completions` and `isomend man`: shell completions and manual pages, for packages of the program.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{Cli, End, console, help};

/// Print a script that completes isomend's commands and options in a shell.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  mkdir -p ~/.local/share/bash-completion/completions\n  isomend completions bash > ~/.local/share/bash-completion/completions/isomend"
)]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Print the manual page (roff) of isomend or of one of its commands.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  isomend man fill | man -l -")]
pub struct ManArgs {
    /// The command [default: the page of isomend itself].
    #[arg(value_name = "COMMAND")]
    command: Option<String>,
}

/// Prints a completion script.
pub fn completions(args: &CompletionsArgs) -> anyhow::Result<End> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "isomend", &mut script);
    console::write(&script)?;
    Ok(End::Done)
}

/// Prints a manual page.
pub fn man(args: &ManArgs) -> anyhow::Result<End> {
    let mut program = help::grouped(Cli::command());
    program.build();
    let command = match &args.command {
        None => program,
        Some(name) => match program.find_subcommand(name) {
            Some(command) => command.clone(),
            None => anyhow::bail!("there is no command '{name}'; `isomend help` lists them"),
        },
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page)?;
    console::write(&page)?;
    Ok(End::Done)
}
