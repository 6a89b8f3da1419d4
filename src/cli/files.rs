//! The files of the commands that turn meshes into meshes: one into one, or several into a folder.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;
use isomend::io::{Format, Loaded};
use isomend::job::{
    Batch, BatchObserver, BatchResult, Deliverables, JobError, JobPlan, JobResult, JobSpec, Output,
    Place, Work,
};
use isomend::report::region_lines_in;
use isomend::{Control, RegionReport, Step, Unit};

use super::console::{self, Console};
use super::input::{self, is_stream};
use super::json::{self, Target};
use super::progress::{self, RegionProgress};
use super::report::ReportArgs;
use super::{CommonArgs, End, Usage, arguments, messages};

/// What is read and written.
#[derive(Debug, Args)]
pub struct FilesArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy, VTP, OFF or 3MF; `-` is standard input. Several go into a folder.
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,

    /// The file to write, in the format of its extension; `-` is standard output, whose format --to tells.
    ///
    /// A folder, or a name that ends with a slash and becomes one, takes the results of all inputs under their names.
    #[arg(short, long, value_name = "OUT", required_unless_present = "dry_run")]
    output: Option<PathBuf>,

    /// Format of the output, whatever its extension: obj, ply, stl, gltf, glb, vtk, vtp, off or 3mf.
    #[arg(long, value_name = "FORMAT", value_parser = arguments::format)]
    to: Option<Format>,

    /// Write text instead of binary: PLY, STL and VTK legacy.
    #[arg(long)]
    ascii: bool,

    /// The unit of the mesh's coordinates: mm, cm, m, in, um or ft.
    ///
    /// It stands with every length in messages, --json and --report, and in 3MF files. Reports then have no run times, so that the same
    /// run gives the same bytes.
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,

    #[command(flatten)]
    report: ReportArgs,

    /// Only say what would be done: which holes, on which grid. No mesh is written.
    #[arg(long)]
    dry_run: bool,
}

/// What a command does with each of its files.
pub struct Task<'a> {
    /// The work.
    pub work: Work,
    /// The options of all commands.
    pub common: &'a CommonArgs,
    /// Whether anything but steady surfaces that are joined and cross nothing counts as done in part.
    pub strict: bool,
    /// What is handed on beside the mesh; the unit is that of the options of files.
    pub deliverables: Deliverables,
}

impl FilesArgs {
    /// Does the work on each input, one after another, and writes the reports.
    ///
    /// # Errors
    /// When the files cannot be used so, before any is read; and what the work fails with, for a single input.
    pub fn each(&self, task: &Task, console: &Console) -> anyhow::Result<End> {
        let mut batch = self.batch(task)?;
        if batch.sources.iter().any(|s| s.place.path().is_none()) {
            // What is wrong is said before standard input is waited for.
            batch.check().map_err(super::told)?;
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
            prints_plans: !task.common.json.as_ref().is_some_and(Target::is_stdout),
        };
        let ended = batch.run(&mut printer, &Control::new().progress(&show));
        progress::clear();
        let ended = ended.map_err(super::told)?;
        if let Some(text) = &ended.document {
            json::print(text)?;
        }
        if printer.several && !self.dry_run {
            console.say(&summary(&ended));
        }
        Ok(match ended {
            BatchResult { failed: 1.., .. } => End::Failed,
            BatchResult { in_part: 1.., .. } => End::InPart,
            _ => End::Done,
        })
    }

    /// What is asked for.
    fn batch(&self, task: &Task) -> anyhow::Result<Batch> {
        let common = task.common;
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
        batch.strict = task.strict;
        batch.deliverables = task.deliverables.clone();
        batch.deliverables.unit = self.unit;
        Ok(batch)
    }
}

/// The output that a path stands for.
pub fn output(path: &Path, to: Option<Format>) -> anyhow::Result<Output> {
    Output::new(output_place(path, to)?, to).map_err(super::told)
}

/// The place that a path of an output stands for.
fn output_place(path: &Path, to: Option<Format>) -> anyhow::Result<Place> {
    match (is_stream(path), to) {
        (false, _) => Ok(path.into()),
        (true, Some(_)) => Ok(Place::memory("standard output")),
        (true, None) => Err(usage(
            "--output - needs --to, such as --to ply: standard output has no name that tells the format",
        )),
    }
}

/// Checks what can be known of an output before the mesh is.
pub fn check(output: &Output) -> anyhow::Result<()> {
    output.check().map_err(super::told)?;
    check_terminal(output)
}

/// Refuses bytes for a terminal.
fn check_terminal(output: &Output) -> anyhow::Result<()> {
    let to_stream = output.place.path().is_none();
    if to_stream && std::io::stdout().is_terminal() && !output.is_text() {
        return Err(usage(&format!(
            "standard output is a terminal, which {} would upset; send it to a file or a program",
            output.format
        )));
    }
    Ok(())
}

/// Says what the jobs of a command do.
struct Printer<'a> {
    console: &'a Console,
    shown: &'a RegionProgress<'a>,
    several: bool,
    /// Whether plans are printed: standard output is not the JSON report's.
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
        input::tell_notes(&job.source.place, loaded, self.console);
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
        Ok(())
    }

    fn failed(&mut self, job: &JobSpec, words: &str) {
        progress::clear();
        self.console.failed(&with_name(&job.source.place, words));
    }

    fn words(&self, error: JobError) -> String {
        format!("{:#}", super::told(error))
    }
}

fn usage(what: &str) -> anyhow::Error {
    Usage(what.to_owned()).into()
}

/// The message of an error with the name of the file before it, once.
fn with_name(input: &Place, error: &str) -> String {
    let name = input.name();
    if error.contains(&name) {
        error.to_owned()
    } else {
        format!("{name}: {error}")
    }
}

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
