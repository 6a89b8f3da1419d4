//! The command line, with one file per command. Arguments are converted to validated parameters once; all printing is done here.

mod arguments;
mod check;
mod compare;
mod config;
mod console;
mod convert;
mod deliver;
mod fair;
mod files;
mod fill;
mod help;
mod input;
mod inspect;
#[cfg(not(target_family = "wasm"))]
mod interrupt;
/// No signals reach the program in WebAssembly.
#[cfg(target_family = "wasm")]
mod interrupt {
    pub fn listen() -> anyhow::Result<()> {
        Ok(())
    }
}
mod json;
mod look;
mod manual;
mod mask;
#[cfg(not(target_family = "wasm"))]
mod mcp;
mod messages;
mod outcome;
mod parameters;
mod progress;
mod repair;
mod report;
mod restore;
mod sdf;
mod study;
mod surface;
mod table;
#[cfg(not(target_family = "wasm"))]
mod view;
mod words;

#[cfg(target_family = "wasm")]
pub use {progress::report_progress, words::CommandLine};

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, anyhow};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueHint};
use isomend::io::{Format, IoError};
use isomend::job::JobError;
use isomend::parameters::Table;
use isomend::{FairError, FillError, RestoreError};

pub use config::Usage;
use console::Console;

use isomend_core::threads::Threads;

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Everything requested was done.
    Done,
    /// Something requested was not done, such as a hole that is still open, or the answer of `check` is no.
    InPart,
    /// The command, or one of several inputs, failed; a message was printed.
    Failed,
    /// Wrong usage; a message was printed.
    Misused,
    /// The reader of standard output has closed it, as `head` does, before all was written.
    Unread,
}

impl End {
    /// The exit code.
    pub fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Failed => 1,
            Self::Misused => 2,
            Self::InPart => 3,
            Self::Unread => 141,
        }
    }
}

impl From<End> for ExitCode {
    fn from(end: End) -> Self {
        end.code().into()
    }
}

/// Most files that a message names one by one.
const MOST_NAMED: usize = 3;

const EXIT_CODES: &str = "\
Exit codes:
  0    done
  1    failed; the output file is unchanged. With several inputs: at least one failed
  2    wrong usage, or an error in an options file
  3    done in part: the output is written, but a hole that was to be filled is open
  3    the verdict of `check` or `repair` is no or doubtful; `study` found another value
  130  stopped by Ctrl-C (143: SIGTERM, 129: SIGHUP); written files are named
  141  the reader of standard output, such as `head`, closed it too early";

/// Fills holes in triangle meshes by 3D level-set Willmore flow.
///
/// Patches continue the curvature of their surroundings. The vertices and faces of the input stay bit for bit and in order; the patches
/// are appended.
#[derive(Debug, Parser)]
#[command(name = "isomend", version, after_help = EXIT_CODES, max_term_width = 110)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Fill(fill::FillArgs),
    Repair(repair::RepairArgs),
    Restore(restore::RestoreArgs),
    Fair(fair::FairArgs),
    Inspect(inspect::InspectArgs),
    Check(check::CheckArgs),
    Compare(compare::CompareArgs),
    Convert(convert::ConvertArgs),
    #[cfg(not(target_family = "wasm"))]
    View(view::ViewArgs),
    #[cfg(not(target_family = "wasm"))]
    Mcp(mcp::McpArgs),
    Study(study::StudyArgs),
    Sdf(sdf::SdfArgs),
    Surface(surface::SurfaceArgs),
    Completions(manual::CompletionsArgs),
    Man(manual::ManArgs),
}

/// Options that most commands have.
#[derive(Debug, Args)]
struct CommonArgs {
    /// Format of the input: obj, ply, stl, gltf, glb, vtk, vtp, off, 3mf, usda or usdz.
    ///
    /// By default the format is detected from the content, else from the extension.
    #[arg(long, value_name = "FORMAT", value_parser = arguments::format)]
    from: Option<Format>,

    /// Write a report as JSON to a file, or to standard output with `-`.
    #[arg(long, value_name = "FILE|-", value_hint = ValueHint::FilePath)]
    json: Option<json::Target>,

    #[command(flatten)]
    run: RunArgs,
}

/// Options for the run of a command.
#[derive(Debug, Args)]
struct RunArgs {
    /// Take options from a TOML file, by their long names; options on the command line override them.
    ///
    /// Top-level keys apply to all commands that have the option, keys of a table such as [fill] to one command. Paths in the file are
    /// relative to its folder.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,

    /// Number of threads [default: one per core]. The result does not depend on it.
    #[arg(long, value_name = "N", value_parser = arguments::threads)]
    threads: Option<usize>,

    /// Print only errors, and what could not be done.
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,

    /// Print more: the details of each step, and the attempts that failed.
    #[arg(short, long)]
    verbose: bool,
}

/// Runs the program with the arguments of the command line and of the file that `--config` names. Prints errors.
pub fn main(arguments: impl Iterator<Item = OsString>) -> End {
    let end = interrupt::listen()
        .and_then(|()| Ok(config::expand(arguments.collect(), &Cli::command())?))
        .and_then(parse)
        .and_then(run);
    match end {
        Ok(end) => end,
        Err(error) if is_unread(&error) => End::Unread,
        Err(error) => {
            console::fail(&format!(
                "{error:#}{}",
                written_before(&isomend::io::written_files())
            ));
            match error.is::<Usage>() {
                true => End::Misused,
                false => End::Failed,
            }
        }
    }
}

/// Parses the arguments. Where clap refuses them, the process ends with clap's message.
///
/// # Errors
/// If an option is a former one: what takes its place.
fn parse(arguments: Vec<OsString>) -> anyhow::Result<Cli> {
    let command = arguments.get(1).cloned().unwrap_or_default();
    let program = help::grouped(Cli::command());
    let parsed = program.try_get_matches_from(arguments);
    let parsed = parsed.and_then(|matches| Cli::from_arg_matches(&matches));
    parsed.or_else(|error| {
        let unknown = match (error.kind(), error.get(ContextKind::InvalidArg)) {
            (ErrorKind::UnknownArgument, Some(ContextValue::String(name))) => name.as_str(),
            _ => "",
        };
        let option = unknown.split('=').next().unwrap_or_default();
        match config::former(&command.to_string_lossy(), option.trim_start_matches('-')) {
            Some(advice) => Err(Usage(advice).into()),
            None => error.exit(),
        }
    })
}

/// Whether an error says that the reader of standard output has closed it.
fn is_unread(error: &anyhow::Error) -> bool {
    let is_closed = |cause: &(dyn std::error::Error + 'static)| {
        let cause = cause.downcast_ref::<std::io::Error>();
        cause.is_some_and(|cause| cause.kind() == std::io::ErrorKind::BrokenPipe)
    };
    error.to_string() == console::NO_OUTPUT && error.chain().any(is_closed)
}

/// What an error does not undo, as the end of a message: the files that were written before it.
fn written_before(written: &[PathBuf]) -> String {
    let names: Vec<String> = written
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    match names.len() {
        0 => String::new(),
        1..=MOST_NAMED => format!("; written before: {}", names.join(", ")),
        count => format!(
            "; {count} files were written before, the last is {}",
            names[count - 1]
        ),
    }
}

/// The error of a job as the command line reports it: with the options that help, and as wrong usage if the request is wrong.
fn cli_error(error: JobError) -> anyhow::Error {
    let usage = |what: String| Usage(what).into();
    match error {
        JobError::NoTextForm { .. } => usage(format!("--ascii: {error}")),
        JobError::No64Bit { .. } => usage(format!("--f64: {error}")),
        JobError::PlanDrawn => usage(
            "--dry-run makes no mesh that --report and --picture could show; leave them out, or use `isomend inspect` to draw the holes"
                .to_owned(),
        ),
        JobError::SeveralDrawn => usage(
            "--report and --picture show one mesh, but there are several inputs; run them one by one"
                .to_owned(),
        ),
        JobError::SeveralDelivered => usage(
            "--patches and --piece write the result of one mesh, but there are several inputs; run them one by one"
                .to_owned(),
        ),
        JobError::Deliverable { what } => usage(what),
        JobError::DocumentOverMesh { .. } => usage(format!("--json: {error}")),
        JobError::Drawing { what } => usage(what),
        JobError::Observer(error) => anyhow::Error::from(error).context(console::NO_OUTPUT),
        // This error occurs only without --from, when the format is detected from the content.
        JobError::Bytes {
            name,
            error: error @ IoError::UnknownFormat { .. },
        } => anyhow::Error::from(error).context(format!("{name} (use --from to name its format)")),
        JobError::Places { what } => usage(what),
        JobError::Fill(FillError::Parameter { what })
        | JobError::Restore(RestoreError::Fill(FillError::Parameter { what })) => {
            usage(as_options(what))
        }
        JobError::BinaryUsd { .. } => usage(error.to_string()),
        JobError::NoFormat { .. } => usage(format!("{error}; change the extension, or use --to")),
        JobError::OpenMask { .. } => anyhow!("{error} with `isomend fill`"),
        JobError::Fill(FillError::NoSuchComponent { .. }) => {
            anyhow!("{error} (`isomend inspect -v` lists them)")
        }
        JobError::Fill(FillError::NoSuchHole { .. }) => {
            anyhow!("{error} (`isomend inspect` lists them)")
        }
        JobError::Fair(FairError::OnlyBorder { .. })
        | JobError::FairObject {
            error: FairError::OnlyBorder { .. },
            ..
        } => {
            let error = anyhow::Error::from(error);
            anyhow!("{error:#}; use a smaller --strength")
        }
        error => error.into(),
    }
}

/// Replaces the names of parameters in a message of the library by options.
fn as_options(text: &str) -> String {
    let tables = Table::ALL.iter();
    tables.fold(text.to_owned(), |text, table| table.as_options(&text))
}

/// Runs a command.
fn run(cli: Cli) -> anyhow::Result<End> {
    match cli.command {
        Command::Fill(args) => start(&args.common, |console| fill::run(&args, console)),
        Command::Repair(args) => start(&args.common, |console| repair::run(&args, console)),
        Command::Restore(args) => start(&args.common, |console| restore::run(&args, console)),
        Command::Fair(args) => start(&args.common, |console| fair::run(&args, console)),
        Command::Inspect(args) => start(&args.common, |console| inspect::run(&args, console)),
        Command::Check(args) => start(&args.common, |console| check::run(&args, console)),
        Command::Compare(args) => start(&args.common, |console| compare::run(&args, console)),
        Command::Convert(args) => start(&args.common, |console| convert::run(&args, console)),
        #[cfg(not(target_family = "wasm"))]
        Command::View(args) => view::run(&args),
        #[cfg(not(target_family = "wasm"))]
        Command::Mcp(args) => start_run(&args.run, |console| mcp::run(&args, console)),
        Command::Study(args) => start_run(&args.run, |console| study::run(&args, console)),
        Command::Sdf(args) => start(&args.common, |console| sdf::run(&args, console)),
        Command::Surface(args) => start_run(&args.run, |console| surface::run(&args, console)),
        Command::Completions(args) => manual::completions(&args),
        Command::Man(args) => manual::man(&args),
    }
}

/// Runs a command that has the common options.
fn start(
    common: &CommonArgs,
    command: impl FnOnce(&Console) -> anyhow::Result<End> + Send,
) -> anyhow::Result<End> {
    start_run(&common.run, command)
}

/// Runs a command in a pool with the number of threads that `--threads` sets.
fn start_run(
    run: &RunArgs,
    command: impl FnOnce(&Console) -> anyhow::Result<End> + Send,
) -> anyhow::Result<End> {
    let console = Console::new(run.quiet, run.verbose);
    if let Some(file) = &run.config {
        console.detail(&format!("options from {}", file.display()));
    }
    let pool = Threads::new(run.threads.unwrap_or(0))
        .context("cannot start the threads; try fewer with --threads")?;
    pool.install(|| command(&console))
}
