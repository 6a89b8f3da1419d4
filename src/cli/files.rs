//! Input and output files of the commands that write meshes (`fill`, `repair`, `restore`, `fair`, `convert`), and their batch run.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;
use isomend::io::{Format, Loaded};
use isomend::job::{
    Batch, BatchObserver, BatchResult, Deliverables, JobError, JobPlan, JobResult, JobSpec, Output,
    Place, Work,
};
use isomend::report::{named_holes, region_lines_in};
use isomend::{Control, RegionReport, Step, Unit};

use super::console::{self, Console};
use super::input::{self, is_stream};
use super::json::{self, Target};
use super::progress::{self, RegionProgress};
use super::report::ReportArgs;
use super::{CommonArgs, End, Usage, arguments, messages};

/// Options for the files to read and write.
#[derive(Debug, Args)]
pub struct FilesArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy, VTP, OFF, 3MF or USD; `-` is standard input. Several meshes need a folder as output.
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,

    /// The file to write, in the format of its extension; `-` is standard output, with the format of --to.
    ///
    /// It may be a folder: the results of all inputs are written to it under their names. A folder whose name ends with a slash is created.
    #[arg(short, long, value_name = "OUT", required_unless_present = "dry_run")]
    output: Option<PathBuf>,

    /// Format of the output, whatever its extension: obj, ply, stl, gltf, glb, vtk, vtp, off, 3mf, usda or usdz.
    #[arg(long, value_name = "FORMAT", value_parser = arguments::format)]
    to: Option<Format>,

    /// Write text instead of binary: PLY, STL and VTK legacy.
    #[arg(long)]
    ascii: bool,

    /// The unit of the mesh's coordinates: mm, cm, m, in, um or ft.
    ///
    /// Messages and --report print it with every length; --json and 3MF files contain it. Reports then have no run times, so that equal
    /// runs give equal bytes.
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,

    #[command(flatten)]
    report: ReportArgs,

    /// Only print what would be done; no mesh is written.
    #[arg(long)]
    dry_run: bool,
}

/// The work of a command on each of its files.
pub struct Task<'a> {
    /// The work.
    pub work: Work,
    /// The options that all commands have.
    pub common: &'a CommonArgs,
    /// Count a fill that is not flawless as done in part; see [`isomend::FillReport::flawless`].
    pub strict: bool,
    /// The deliverables; their unit comes from [`FilesArgs`].
    pub deliverables: Deliverables,
}

impl FilesArgs {
    /// Does the work on each input, one after another, and writes the reports.
    ///
    /// # Errors
    /// If the files cannot be used, before any is read; for a single input, also the error of the work.
    pub fn each(&self, task: &Task, console: &Console) -> anyhow::Result<End> {
        let mut batch = self.batch(task)?;
        if batch.sources.iter().any(|s| s.place.path().is_none()) {
            // Report errors before waiting for standard input.
            batch.check().map_err(super::cli_error)?;
            for source in &mut batch.sources {
                input::fetch(source)?;
            }
        }
        let is_fair = matches!(task.work, Work::Fair(..));
        let line = |region: &RegionReport| match is_fair {
            true => messages::faired_region_line(region),
            false => region_lines_in(region, self.unit),
        };
        let shown = RegionProgress::new(*console, &line);
        let show = |step: &Step| shown.step(step);
        let mut printer = Printer {
            console,
            shown: &shown,
            several: batch.sources.len() > 1,
            strict: batch.strict,
            prints_plans: !task.common.json.as_ref().is_some_and(Target::is_stdout),
        };
        let ended = batch.run(&mut printer, &Control::new().progress(&show));
        progress::clear();
        let ended = ended.map_err(super::cli_error)?;
        if let Some(text) = &ended.document {
            json::print(text)?;
        }
        if printer.several && !self.dry_run {
            console.say(&summary(&ended));
        }
        Ok(End::of(&ended))
    }

    /// The batch that the options ask for.
    fn batch(&self, task: &Task) -> anyhow::Result<Batch> {
        let common = task.common;
        for input in &self.inputs {
            check_input(input)?;
        }
        let sources = self.inputs.iter().map(|i| input::named(i, common.from));
        let mut batch = Batch::new(sources, task.work.clone());
        if let Some(path) = &self.output {
            let place = output_place(path, self.to)?;
            if place.path().is_none() {
                let mut output = output(path, self.to)?;
                output.ascii = self.ascii;
                check_terminal(&output)?;
            }
            batch.output = Some(place);
        }
        if let (Some(Target::Stdout), Some(output), false) =
            (&common.json, &batch.output, self.dry_run)
        {
            Target::Stdout.check(&[], std::slice::from_ref(output))?;
        }
        batch.format = self.to;
        batch.ascii = self.ascii;
        batch.plan = self.dry_run;
        batch.document = common.json.as_ref().map(Target::place);
        batch.drawings = self.report.drawings(common.json.as_ref())?;
        batch.each_step = common.run.verbose;
        batch.strict = task.strict;
        batch.deliverables = task.deliverables.clone();
        batch.deliverables.unit = self.unit;
        Ok(batch)
    }
}

/// The output for a path.
pub fn output(path: &Path, to: Option<Format>) -> anyhow::Result<Output> {
    Output::new(output_place(path, to)?, to).map_err(super::cli_error)
}

/// The place for the path of an output.
fn output_place(path: &Path, to: Option<Format>) -> anyhow::Result<Place> {
    match (is_stream(path), to) {
        (false, _) => Ok(path.into()),
        (true, Some(_)) => Ok(Place::memory("standard output")),
        (true, None) => Err(usage(
            "--output - needs --to, such as --to ply: standard output has no extension that names the format",
        )),
    }
}

/// Checks an output before the mesh is known.
pub fn check(output: &Output) -> anyhow::Result<()> {
    output.check().map_err(super::cli_error)?;
    check_terminal(output)
}

/// Refuses to write binary data to a terminal.
fn check_terminal(output: &Output) -> anyhow::Result<()> {
    let to_stream = output.place.path().is_none();
    if to_stream && std::io::stdout().is_terminal() && !output.is_text() {
        return Err(usage(&format!(
            "standard output is a terminal, but {} is binary; redirect the output to a file or a program",
            output.format
        )));
    }
    Ok(())
}

/// Prints the events of a batch.
struct Printer<'a> {
    console: &'a Console,
    shown: &'a RegionProgress<'a>,
    several: bool,
    /// Whether holes that are not closed well are named.
    strict: bool,
    /// Whether plans are printed, that is, the JSON report does not go to standard output.
    prints_plans: bool,
}

impl BatchObserver for Printer<'_> {
    fn begins(&mut self, job: &JobSpec) {
        if let Some(output) = job.output.as_ref().filter(|_| self.several) {
            let (from, to) = (job.source.place.name(), output.place.name());
            self.console.say(&format!("{from} -> {to}"));
        }
    }

    fn has_read(&mut self, job: &JobSpec, loaded: &Loaded) {
        input::print_notes(&job.source.place, loaded, self.console);
        if job.output.is_some() {
            self.shown.begin();
        }
    }

    fn planned(&mut self, plan: &JobPlan) -> std::io::Result<()> {
        if !self.prints_plans {
            return Ok(());
        }
        let mut text = String::new();
        if self.several {
            text += &format!("{}\n", console::heading(&plan.spec.source.place.name()));
        }
        console::print(&(text + &messages::plan(plan)))
    }

    fn done(&mut self, done: &JobResult) -> std::io::Result<()> {
        progress::clear();
        let place = done.spec.output.as_ref().map(|o| &o.place);
        for note in done.notes_written() {
            let name = place.map(Place::name).unwrap_or_default();
            self.console.note(&format!("{name}: {note}"));
        }
        if place.is_some_and(|p| p.path().is_none()) {
            console::write_file(&done.bytes)?;
        }
        let name = match self.several {
            true => format!("{}: ", done.spec.source.place.name()),
            false => String::new(),
        };
        messages::done(done, &name, self.console);
        let flawed = done.report.flawed();
        if self.strict && !flawed.is_empty() {
            let holes = named_holes(&flawed);
            self.console.note(&format!(
                "{name}{holes}: not closed well, which --strict asks for (-v says why)"
            ));
        }
        Ok(())
    }

    fn failed(&mut self, job: &JobSpec, words: &str) {
        progress::clear();
        self.console
            .failed(&input::with_name(&job.source.place, words));
    }

    fn words(&self, error: JobError) -> String {
        format!("{:#}", super::cli_error(error))
    }
}

/// Refuses a folder, and a pattern that no shell has replaced by names of files.
fn check_input(input: &Path) -> anyhow::Result<()> {
    let text = input.to_string_lossy();
    if input.is_dir() {
        let what = format!("{text} is a folder; name its files, such as {text}/*.ply");
        return Err(Usage(what).into());
    }
    match text.contains(['*', '?', '[']) && !input.exists() {
        true => Err(Usage(format!("no file matches {text}")).into()),
        false => Ok(()),
    }
}

fn usage(what: &str) -> anyhow::Error {
    Usage(what.to_owned()).into()
}

/// The last line for several files: how many were done, done in part and failed.
fn summary(ended: &BatchResult) -> String {
    let all = ended.done + ended.in_part + ended.failed;
    let mut text = format!("{all} files: {} done", ended.done);
    for (count, what) in [(ended.in_part, "in part"), (ended.failed, "failed")] {
        if count > 0 {
            text += &format!(", {count} {what}");
        }
    }
    text
}
