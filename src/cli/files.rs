//! The files of the commands that turn meshes into meshes: one into one, or several into a folder.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use clap::Args;
use isomend::Control;
use isomend::io::Format;
use isomend::job::{
    Drawings, JobResult, JobSpec, Output, Place, Work, failed_document, in_folder, is_folder_name,
};
use isomend::report::region_lines;

use super::console::{self, Console};
use super::input::{self, is_stream};
use super::json::Documents;
use super::report::ReportArgs;
use super::{CommonArgs, End, Usage, arguments, messages, progress};

/// What is read and written.
#[derive(Debug, Args)]
pub struct FilesArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy or VTP; `-` is standard input. Several go into a folder.
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,

    /// The file to write, in the format of its extension; `-` is standard output, whose format --to tells.
    ///
    /// A folder, or a name that ends with a slash and becomes one, takes the results of all inputs under their names.
    #[arg(short, long, value_name = "OUT", required_unless_present = "dry_run")]
    output: Option<PathBuf>,

    /// Format of the output, whatever its extension: obj, ply, stl, gltf, glb, vtk or vtp.
    #[arg(long, value_name = "FORMAT", value_parser = arguments::format)]
    to: Option<Format>,

    /// Write text instead of binary: PLY, STL and VTK legacy.
    #[arg(long)]
    ascii: bool,

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
}

impl FilesArgs {
    /// Does the work on each input, one after another, and writes the reports.
    ///
    /// Of several inputs one that fails does not stop the others.
    ///
    /// # Errors
    /// When the files cannot be used so, before any is read; and what the work fails with, for a single input.
    pub fn each(&self, task: &Task, console: &Console) -> anyhow::Result<End> {
        let (command, common) = (task.work.name(), task.common);
        let outputs = self.outputs()?;
        let inputs: Vec<Place> = self.inputs.iter().map(|i| input::place(i)).collect();
        if let Some(json) = &common.json {
            let meshes: Vec<Place> = outputs.iter().flatten().map(|o| o.place.clone()).collect();
            json.check(&inputs, &meshes)?;
        }
        let several = inputs.len() > 1;
        let drawings = self.drawings(common)?;
        if let ([input], [Some(output)]) = (&inputs[..], &outputs[..]) {
            drawings
                .check(input, Some(&output.place))
                .map_err(super::told)?;
        }
        task.work.check().map_err(super::told)?;
        let documents = common.json.as_ref().map(|_| Documents::default());
        let mut ends = Vec::new();
        for (path, output) in self.inputs.iter().zip(outputs) {
            let place = input::place(path);
            if let Some(output) = output.as_ref().filter(|_| several) {
                console.say(&format!("{} -> {}", place.name(), output.place.name()));
            }
            let run = Run {
                task,
                drawings: &drawings,
                documents: documents.as_ref(),
                several,
            };
            let end = match run.one(path, output, console) {
                Err(error) if several => {
                    let error = format!("{error:#}");
                    console.failed(&with_name(&place, &error));
                    if let Some(documents) = &documents {
                        documents.add(&failed_document(command, &place, &error))?;
                    }
                    End::Failed
                }
                end => end?,
            };
            ends.push(end);
        }
        if let (Some(json), Some(documents)) = (&common.json, &documents) {
            documents.write(json, several)?;
        }
        if several && !self.dry_run {
            console.say(&summary(&ends));
        }
        Ok(worst(&ends))
    }

    /// What is drawn: of a single mesh that is made.
    fn drawings(&self, common: &CommonArgs) -> anyhow::Result<Drawings> {
        if self.dry_run && self.report.is_wanted() {
            return Err(usage(
                "--dry-run makes no mesh that --report and --picture could show; leave them out, or let `isomend inspect` draw \
                 the holes",
            ));
        }
        if self.inputs.len() > 1 && self.report.is_wanted() {
            return Err(usage(
                "--report and --picture show one mesh, but there are several inputs; run them one by one",
            ));
        }
        self.report.drawings(common.json.as_ref())
    }

    /// Where each input goes; none where it is only said what would be done.
    fn outputs(&self) -> anyhow::Result<Vec<Option<Output>>> {
        let several = self.inputs.len() > 1;
        if several && self.inputs.iter().any(|i| is_stream(i)) {
            return Err(usage("standard input cannot be one of several inputs"));
        }
        let Some(path) = &self.output else {
            return Ok(self.inputs.iter().map(|_| None).collect());
        };
        let outputs = if is_folder_name(path) {
            let inputs: Vec<Place> = self.inputs.iter().map(|i| input::place(i)).collect();
            let paths = in_folder(path, &inputs, self.to).map_err(super::told)?;
            let make = |path: PathBuf| {
                let mut output = Output::new(path, self.to).map_err(super::told)?;
                output.make_folder = true;
                Ok(output)
            };
            paths.into_iter().map(make).collect::<anyhow::Result<_>>()?
        } else if several {
            return Err(usage(&format!(
                "several inputs need a folder to go to, but {} is none; make it first, or end its name with a slash",
                path.display()
            )));
        } else {
            vec![output(path, self.to)?]
        };
        let checked = |mut output: Output| {
            output.ascii = self.ascii;
            check(&output)?;
            Ok((!self.dry_run).then_some(output))
        };
        outputs.into_iter().map(checked).collect()
    }
}

/// The output that a path stands for.
pub fn output(path: &Path, to: Option<Format>) -> anyhow::Result<Output> {
    if !is_stream(path) {
        return Output::new(path, to).map_err(super::told);
    }
    let Some(format) = to else {
        return Err(usage(
            "--output - needs --to, such as --to ply: standard output has no name that tells the format",
        ));
    };
    let place = Place::Bytes("standard output".to_owned());
    Output::new(place, Some(format)).map_err(super::told)
}

/// Checks what can be known of an output before the mesh is.
pub fn check(output: &Output) -> anyhow::Result<()> {
    output.check().map_err(super::told)?;
    let to_stream = output.place.path().is_none();
    if to_stream && std::io::stdout().is_terminal() && !output.is_text() {
        return Err(usage(&format!(
            "standard output is a terminal, which {} would upset; send it to a file or a program",
            output.format
        )));
    }
    Ok(())
}

/// One input of a command.
struct Run<'a> {
    task: &'a Task<'a>,
    drawings: &'a Drawings,
    documents: Option<&'a Documents>,
    several: bool,
}

impl Run<'_> {
    fn one(&self, path: &Path, output: Option<Output>, console: &Console) -> anyhow::Result<End> {
        let mut spec = JobSpec::plan(
            input::source(path, self.task.common.from)?,
            self.task.work.clone(),
        );
        spec.output = output;
        spec.drawings = self.drawings.clone();
        let read = spec
            .read()
            .map_err(|error| input::told(error, &spec.source))?;
        input::tell_notes(&spec.source.place, &read.loaded, console);
        if spec.output.is_none() {
            let plan = read.plan().map_err(super::told)?;
            return self.preview(&plan);
        }
        let line = match self.task.work {
            Work::Fair(..) => messages::faired_region_line,
            _ => region_lines,
        };
        let mended = progress::watched(console, line, |progress| {
            read.mend(&Control::new().progress(progress))
        });
        let done = mended.map_err(super::told)?.write().map_err(super::told)?;
        self.finish(&done, console)
    }

    /// Says what would be done, on standard output unless the JSON report goes there.
    fn preview(&self, plan: &JobResult) -> anyhow::Result<End> {
        if let Some(documents) = self.documents {
            documents.add(&plan.document())?;
        }
        let report_only = self
            .task
            .common
            .json
            .as_ref()
            .is_some_and(|json| json.is_stdout());
        if !report_only {
            let mut text = String::new();
            if self.several {
                text += &format!("{}\n", console::heading(&plan.spec.source.place.name()));
            }
            console::print_out(&(text + &messages::plan(plan)))?;
        }
        Ok(End::Done)
    }

    /// Tells what was done.
    fn finish(&self, done: &JobResult, console: &Console) -> anyhow::Result<End> {
        let place = done.spec.output.as_ref().map(|o| &o.place);
        for note in done.notes_written() {
            let name = place.map(Place::name).unwrap_or_default();
            console.note(&format!("{name}: {note}"));
        }
        if place.is_some_and(|p| p.path().is_none()) {
            console::write_file_out(&done.bytes)?;
        }
        let name = match self.several {
            true => format!("{}: ", done.spec.source.place.name()),
            false => String::new(),
        };
        messages::done(done, &name, console);
        if let Some(documents) = self.documents {
            documents.add(&done.document())?;
        }
        let whole = done.complete() && (!self.task.strict || done.report.flawless());
        Ok(if whole { End::Done } else { End::InPart })
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

fn summary(ends: &[End]) -> String {
    let count = |end: End| ends.iter().filter(|e| **e == end).count();
    let mut text = format!("{} files: {} done", ends.len(), count(End::Done));
    for (end, what) in [(End::InPart, "in part"), (End::Failed, "failed")] {
        if count(end) > 0 {
            text += &format!(", {} {what}", count(end));
        }
    }
    text
}

fn worst(ends: &[End]) -> End {
    let order = [End::Failed, End::InPart];
    let found = order.into_iter().find(|end| ends.contains(end));
    found.unwrap_or(End::Done)
}
