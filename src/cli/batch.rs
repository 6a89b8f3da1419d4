//! The files of the commands that turn meshes into meshes: one into one, or several into a folder.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use isomend::io::{Format, Loaded};
use isomend::mesh::cut::Remainder;

use super::console::Console;
use super::input::is_stream;
use super::json::{Documents, FailedDocument};
use super::output::{Output, check_writable};
use super::report::{Before, Drawn, ReportArgs};
use super::{CommonArgs, End, Usage, arguments, input};

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

/// One input of a run, and what becomes of it.
pub struct Files<'a> {
    /// The name of the command.
    pub command: &'static str,
    /// The mesh read.
    pub input: &'a Path,
    /// The mesh written; none where it is only said what would be done.
    pub output: Option<Output>,
    /// What is drawn.
    report: &'a ReportArgs,
    /// Collects the reports, where one is asked for.
    pub documents: Option<&'a Documents>,
    /// Whether there are several inputs.
    pub several: bool,
    /// Whether the report is all that goes to standard output.
    pub report_only: bool,
}

impl Files<'_> {
    /// Reads the mesh.
    pub fn read(&self, from: Option<Format>, console: &Console) -> anyhow::Result<Loaded> {
        input::read(self.input, from, console)
    }

    /// The mesh as it was read, where it is to be drawn beside what is left of it after a cut.
    pub fn before(&self, loaded: &Loaded, kept: &Remainder) -> Option<Before> {
        self.report.is_wanted().then(|| Before {
            mesh: loaded.mesh.clone(),
            gone: kept.faces.iter().map(|kept| !kept).collect(),
        })
    }

    /// Draws what is asked for.
    pub fn draw(&self, drawn: &Drawn) -> anyhow::Result<()> {
        if self.report.is_wanted() {
            self.report.write(drawn)?;
        }
        Ok(())
    }

    /// Whether the output is glTF.
    pub fn to_gltf(&self) -> bool {
        let format = self.output.as_ref().map(|output| output.format);
        matches!(format, Some(Format::Gltf | Format::Glb))
    }
}

impl FilesArgs {
    /// Runs a command for each input, one after another, and writes the reports.
    ///
    /// Of several inputs one that fails does not stop the others.
    ///
    /// # Errors
    /// When the files cannot be used so, before any is read; and what the command fails with, for a single input.
    pub fn each(
        &self,
        command: &'static str,
        common: &CommonArgs,
        console: &Console,
        work: impl Fn(&Files<'_>) -> anyhow::Result<End>,
    ) -> anyhow::Result<End> {
        self.check_trial()?;
        let outputs = self.outputs()?;
        let inputs: Vec<&Path> = self.inputs.iter().map(PathBuf::as_path).collect();
        if let Some(json) = &common.json {
            let meshes = outputs.iter().flatten().map(|o| o.path.as_path());
            json.check(&inputs, &meshes.collect::<Vec<_>>())?;
        }
        self.check_drawings(&outputs, common)?;
        let documents = common.json.as_ref().map(|_| Documents::default());
        let several = inputs.len() > 1;
        let mut ends = Vec::new();
        for (input, output) in inputs.iter().zip(outputs) {
            let files = Files {
                command,
                input,
                output,
                report: &self.report,
                documents: documents.as_ref(),
                several,
                report_only: common.json.as_ref().is_some_and(|json| json.is_stdout()),
            };
            if let Some(output) = files.output.as_ref().filter(|_| several) {
                let (input, output) = (input.display(), output.path.display());
                console.say(&format!("{input} -> {output}"));
            }
            let end = match work(&files) {
                Err(error) if several => {
                    let error = format!("{error:#}");
                    console.failed(&with_name(input, &error));
                    if let Some(documents) = &documents {
                        documents.add(&FailedDocument::new(command, input, &error))?;
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

    /// Refuses to draw what a trial run does not make.
    fn check_trial(&self) -> anyhow::Result<()> {
        if self.dry_run && self.report.is_wanted() {
            return Err(usage(
                "--dry-run makes no mesh that --report and --picture could show; leave them out, or let `isomend inspect` draw \
                 the holes",
            ));
        }
        Ok(())
    }

    /// Whether what is to be drawn can be.
    fn check_drawings(
        &self,
        outputs: &[Option<Output>],
        common: &CommonArgs,
    ) -> anyhow::Result<()> {
        if !self.report.is_wanted() {
            return Ok(());
        }
        match (&self.inputs[..], outputs) {
            ([input], [Some(output)]) => {
                let mesh = Some(output.path.as_path());
                self.report.check(input, mesh, common.json.as_ref())
            }
            ([_], _) => Ok(()),
            _ => Err(usage(
                "--report and --picture show one mesh, but there are several inputs; run them one by one",
            )),
        }
    }

    /// Where each input goes.
    fn outputs(&self) -> anyhow::Result<Vec<Option<Output>>> {
        let several = self.inputs.len() > 1;
        let streams = self.inputs.iter().filter(|i| is_stream(i)).count();
        if streams > 0 && several {
            return Err(usage("standard input cannot be one of several inputs"));
        }
        let Some(path) = &self.output else {
            return Ok(self.inputs.iter().map(|_| None).collect());
        };
        let folder = path.is_dir()
            || path
                .as_os_str()
                .to_string_lossy()
                .ends_with(['/', std::path::MAIN_SEPARATOR]);
        let outputs = if !folder {
            if several {
                return Err(usage(&format!(
                    "several inputs need a folder to go to, but {} is none; make it first, or end its name with a slash",
                    path.display()
                )));
            }
            vec![Output::new(path, self.to, self.ascii)?]
        } else {
            self.outputs_in(path)?
        };
        let wanted = |output| (!self.dry_run).then_some(output);
        Ok(outputs.into_iter().map(wanted).collect())
    }

    /// The outputs in a folder: each under the name of its input.
    fn outputs_in(&self, folder: &Path) -> anyhow::Result<Vec<Output>> {
        if !folder.is_dir() {
            let name: PathBuf = folder.components().collect();
            check_writable(&name)?;
            if name.exists() {
                return Err(usage(&format!(
                    "{} is a file, not a folder",
                    name.display()
                )));
            }
        }
        let mut taken: BTreeMap<PathBuf, &Path> = BTreeMap::new();
        let mut outputs = Vec::new();
        for input in &self.inputs {
            let name = input.file_name().filter(|_| !is_stream(input));
            let Some(name) = name else {
                return Err(usage(&format!(
                    "{} has no name that its result could have in {}; name a file",
                    input::shown(input),
                    folder.display()
                )));
            };
            let mut path = folder.join(name);
            if let Some(format) = self.to {
                path.set_extension(format.extension());
            }
            if let Some(other) = taken.insert(path.clone(), input) {
                return Err(usage(&format!(
                    "{} and {} would both go to {}",
                    other.display(),
                    input.display(),
                    path.display()
                )));
            }
            outputs.push(Output::in_folder(&path, self.to, self.ascii)?);
        }
        self.refuse_crossing(&outputs)?;
        Ok(outputs)
    }

    /// Refuses outputs that are other inputs, such as by a link.
    fn refuse_crossing(&self, outputs: &[Output]) -> anyhow::Result<()> {
        let place = |path: &Path| std::fs::canonicalize(path).ok();
        let inputs = self.inputs.iter().enumerate();
        let places: BTreeMap<PathBuf, usize> = inputs
            .filter_map(|(i, path)| Some((place(path)?, i)))
            .collect();
        for (i, output) in outputs.iter().enumerate() {
            let found = place(&output.path).and_then(|p| places.get(&p));
            if let Some(&other) = found.filter(|other| **other != i) {
                return Err(usage(&format!(
                    "{} would go to {}, which is another input",
                    self.inputs[i].display(),
                    self.inputs[other].display()
                )));
            }
        }
        Ok(())
    }
}

fn usage(what: &str) -> anyhow::Error {
    Usage(what.to_owned()).into()
}

/// The message of an error with the name of the file before it, once.
fn with_name(input: &Path, error: &str) -> String {
    let name = input.display().to_string();
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
