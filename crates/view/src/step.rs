//! Steps of the session: checks a request of the page, and runs it like a command from file to file, with the files in memory.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use serde::Deserialize;
use serde_json::Value;

use super::files::{Denied, relative, template_argument, to_read};
use super::runs::Runs;
use super::state::{State, StepDone, place_after};
use super::store::StoredStep;
use super::words::{CommandRenderer, NO_TEXTURE};
use isomend_core::fill::FillParams;
use isomend_core::mend::{Control, FairParams, RestoreParams};
use isomend_core::mesh::length_beside;
use isomend_core::repair::RepairParams;
use isomend_files::io::Format;
use isomend_files::job::{
    JobError, JobResult, JobSpec, MaskSpec, OperationReport, Output, Source, Work,
};
use isomend_files::report::{Standing, counted, joined_holes, tally_line};

/// A step that the page requests.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// The command.
    pub kind: StepKind,
    /// Its parameters; missing ones have their defaults.
    #[serde(default)]
    pub params: Value,
    /// The marked faces.
    #[serde(default)]
    pub mask: Option<Runs>,
    /// Whether the mesh keeps its own marked faces, because the request marks faces only for this step.
    #[serde(default)]
    pub keep_marks: bool,
    /// Whether patches across seams of a texture get no texels of their own.
    #[serde(default)]
    pub no_texture: bool,
    /// Whether the result is only a preview.
    #[serde(default)]
    pub preview: bool,
}

/// What a step is checked against.
pub struct Scope<'a> {
    /// Number of faces of the mesh.
    pub faces: usize,
    /// The folder below which a template is read.
    pub root: &'a Path,
    /// Writes the step as a command.
    pub words: &'a dyn CommandRenderer,
}

/// A kind of step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StepKind {
    /// Fill holes.
    Fill,
    /// Replace the marked faces.
    Restore,
    /// Fair the surface, or the marked faces.
    Fair,
    /// Repair defects.
    Repair,
}

/// Why a step is refused.
#[derive(Debug)]
pub enum StepRefusal {
    /// A field of the request is invalid.
    Wrong {
        /// The reason.
        error: String,
        /// The field.
        field: &'static str,
    },
    /// The template may not be read.
    Template(Denied),
}

impl StepRefusal {
    /// The reason in words.
    pub fn words(self) -> String {
        match self {
            Self::Wrong { error, .. } => error,
            Self::Template(denied) => denied.words(),
        }
    }
}

/// A checked step, ready to run.
#[derive(Clone)]
pub struct Order {
    /// The work, without the marked faces.
    pub work: Work,
    /// The marked faces.
    pub mask: Option<Runs>,
    /// Whether the mesh keeps its own marked faces.
    pub keep_marks: bool,
    /// Whether patches across seams of a texture get no texels of their own.
    pub no_texture: bool,
    /// The step as a command. A template is named relative to the folder of the page.
    pub command: super::words::Command,
}

impl Request {
    /// Checks the request. The command line must be able to express it.
    ///
    /// # Errors
    /// When a parameter or the mask is invalid, the template may not be read, or no command does the work.
    pub fn order(self, scope: &Scope) -> Result<Order, StepRefusal> {
        let params = match self.params {
            Value::Null => Value::Object(serde_json::Map::new()),
            params => params,
        };
        let no_mask = MaskSpec::default;
        let work = match self.kind {
            StepKind::Fill => Work::Fill(read::<FillParams>(params)?),
            StepKind::Restore => Work::Restore(no_mask(), read::<RestoreParams>(params)?),
            StepKind::Fair => {
                let mask = self.mask.as_ref().map(|_| no_mask());
                Work::Fair(mask, read::<FairParams>(params)?)
            }
            StepKind::Repair => Work::Repair(read::<RepairParams>(params)?),
        };
        let step = StoredStep {
            work,
            mask: self.mask,
            no_texture: self.no_texture,
        };
        let mut order = Order::new(step, scope)?;
        order.keep_marks = self.keep_marks;
        Ok(order)
    }
}

/// Parameters from JSON.
fn read<P: serde::de::DeserializeOwned>(params: Value) -> Result<P, StepRefusal> {
    serde_json::from_value(params).map_err(|error| StepRefusal::Wrong {
        error: error.to_string(),
        field: "params",
    })
}

impl Order {
    /// Checks a step, as [`Request::order`] does.
    ///
    /// # Errors
    /// As [`Request::order`].
    pub fn new(step: StoredStep, scope: &Scope) -> Result<Self, StepRefusal> {
        let StoredStep {
            work,
            mask,
            no_texture,
        } = step;
        let wrong = |error: &str, field| StepRefusal::Wrong {
            error: error.to_owned(),
            field,
        };
        if let Some(mask) = &mask {
            mask.check(scope.faces)
                .map_err(|error| wrong(&error, "mask"))?;
        }
        let refusal = match (&work, &mask) {
            (Work::Fill(_) | Work::Repair(_), Some(_)) => Some((
                "fill and repair take no marked faces: holes are chosen by their numbers",
                "mask",
            )),
            (Work::Restore(..), None) => Some((
                "no face is marked; mark the region to restore first",
                "mask",
            )),
            (work, _) if no_texture && !work.makes_patches() => {
                Some(("this command makes no patches", "no_texture"))
            }
            _ => None,
        };
        if let Some((error, field)) = refusal {
            return Err(wrong(error, field));
        }
        let work = template_below(work, scope.root).map_err(StepRefusal::Template)?;
        let faces = mask.as_ref().map(|_| "marks.faces");
        let command = scope.words.command(&work, faces);
        let mut command = command.map_err(|error| wrong(&error, "params"))?;
        if let Some(file) = work.template() {
            command.set("like", template_argument(&relative(scope.root, file)));
        }
        if no_texture {
            command.flag(NO_TEXTURE);
        }
        Ok(Self {
            work,
            mask,
            keep_marks: false,
            no_texture,
            command,
        })
    }

    /// The work with the marked faces.
    fn marked(&self) -> Work {
        let mut work = self.work.clone();
        let (Work::Restore(mask, _) | Work::Fair(Some(mask), _)) = &mut work else {
            return work;
        };
        if let Some(runs) = &self.mask {
            mask.faces = runs.numbers().collect();
        }
        work
    }

    /// Runs the step. The result is the mesh that the next command would read from this command's output.
    ///
    /// # Errors
    /// When the job fails or is cancelled.
    pub fn make(
        self,
        input: &Path,
        parent: &Arc<State>,
        control: &Control,
    ) -> Result<State, JobError> {
        let clock = Instant::now();
        // The job as a command would run it; the output goes to memory.
        let format = format_between(parent.loaded.format);
        let place = place_after(input, parent.depth + 1);
        let source = Source::mesh(parent.place(input), parent.loaded.clone());
        let mut spec = JobSpec::plan(source, self.marked());
        spec.output = Some(Output::new(place.clone(), Some(format))?);
        spec.deliverables.no_texture = self.no_texture;
        // Keep the removed faces for the report page of the step.
        spec.drawings.may_follow = true;
        spec.work.check()?;
        let mended = spec.read()?.mend(control)?.into_owned();
        let done = mended.clone().write()?;
        let step = StepDone {
            work: self.work,
            mask: self.mask,
            keep_marks: self.keep_marks,
            no_texture: self.no_texture,
            command: self.command,
            summary: summary(&done),
            document: serde_json::to_value(done.document()).unwrap_or_default(),
            standing: Standing::of_fill(&done.report),
            complete: done.complete(),
            seconds: clock.elapsed().as_secs_f64(),
            mended,
        };
        let report = done.report;
        let next = Source {
            bytes: done.bytes,
            format: Some(format),
            ..Source::from(place)
        };
        State::next(parent, step, &report, &next)
    }
}

/// The work with its template as a file below the folder of the page.
///
/// # Errors
/// When the template may not be read.
fn template_below(work: Work, root: &Path) -> Result<Work, Denied> {
    let Some(file) = work.template() else {
        return Ok(work);
    };
    let name = file
        .to_str()
        .ok_or_else(|| Denied::Wrong("the name of the template is not valid Unicode".to_owned()))?;
    let path = to_read(root, name)?;
    Ok(work.with_template(path))
}

/// The format of intermediate files: the input's format, which stores all its attributes; PLY for STL, which does not number vertices;
/// GLB for glTF, since it contains its images.
pub fn format_between(file: Format) -> Format {
    match file {
        Format::Stl => Format::Ply,
        Format::Gltf => Format::Glb,
        format => format,
    }
}

/// A summary of the result in one line.
fn summary(done: &JobResult) -> String {
    let fill = || tally_line(&done.report);
    match &done.extent {
        OperationReport::Region(cut) => {
            let cut_out = format!("{} cut out", counted(cut.removed_faces, "face"));
            let parts = [Some(cut_out), joined_holes(cut), Some(fill())];
            parts.into_iter().flatten().collect::<Vec<_>>().join("; ")
        }
        OperationReport::Faired(report) => format!(
            "moved by {} at most, {} root mean square",
            length_beside(report.moved_max, report.strength),
            length_beside(report.moved_rms, report.strength)
        ),
        OperationReport::Repaired(report) => {
            let mut lines = isomend_files::report::repair_lines(report);
            lines.extend(report.after.as_ref().map(|verdict| verdict.line()));
            lines.join("; ")
        }
        OperationReport::Holes => fill(),
        OperationReport::Copied => "nothing changed".to_owned(),
    }
}
