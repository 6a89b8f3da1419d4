//! Steps of the session: checks a request of the page, and runs it like a command from file to file, with the files in memory.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use serde::Deserialize;
use serde_json::Value;

use super::runs::Runs;
use super::state::{State, StepDone, place_after};
use super::words::CommandRenderer;
use crate::fill::FillParams;
use crate::io::Format;
use crate::job::{JobError, JobResult, JobSpec, MaskSpec, OperationReport, Output, Source, Work};
use crate::mend::{Control, FairParams, RestoreParams};
use crate::mesh::length_beside;
use crate::repair::RepairParams;
use crate::report::{counted, tally_line};

/// A step that the page requests.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// The command.
    pub kind: Kind,
    /// Its parameters; missing ones have their defaults.
    #[serde(default)]
    pub params: Value,
    /// The marked faces.
    #[serde(default)]
    pub mask: Option<Runs>,
    /// Whether the result is only a preview.
    #[serde(default)]
    pub preview: bool,
}

/// A kind of step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Fill holes.
    Fill,
    /// Replace the marked faces.
    Restore,
    /// Fair the surface, or the marked faces.
    Fair,
    /// Repair defects.
    Repair,
}

/// The error of an invalid request.
#[derive(Debug)]
pub struct Wrong {
    /// The reason.
    pub error: String,
    /// The invalid field of the request.
    pub field: &'static str,
}

/// A checked step, ready to run.
#[derive(Clone)]
pub struct Order {
    /// The work, without the marked faces.
    pub work: Work,
    /// The marked faces.
    pub mask: Option<Runs>,
    /// The step as a command.
    pub command: super::words::Command,
}

impl Request {
    /// Checks the request for a mesh with `faces` faces. The command line must be able to express it.
    ///
    /// # Errors
    /// When a parameter or the mask is invalid, or no command does the work.
    pub fn order(self, faces: usize, words: &dyn CommandRenderer) -> Result<Order, Wrong> {
        let params = match self.params {
            Value::Null => Value::Object(serde_json::Map::new()),
            params => params,
        };
        let no_mask = MaskSpec::default;
        let work = match self.kind {
            Kind::Fill => Work::Fill(read::<FillParams>(params)?),
            Kind::Restore => Work::Restore(no_mask(), read::<RestoreParams>(params)?),
            Kind::Fair => {
                let mask = self.mask.as_ref().map(|_| no_mask());
                Work::Fair(mask, read::<FairParams>(params)?)
            }
            Kind::Repair => Work::Repair(read::<RepairParams>(params)?),
        };
        Order::new(work, self.mask, faces, words)
    }
}

/// Parameters from JSON.
fn read<P: serde::de::DeserializeOwned>(params: Value) -> Result<P, Wrong> {
    serde_json::from_value(params).map_err(|error| Wrong {
        error: error.to_string(),
        field: "params",
    })
}

impl Order {
    /// Checks a step, as [`Request::order`] does.
    ///
    /// # Errors
    /// As [`Request::order`].
    pub fn new(
        work: Work,
        mask: Option<Runs>,
        faces: usize,
        words: &dyn CommandRenderer,
    ) -> Result<Self, Wrong> {
        let in_mask = |error| Wrong {
            error,
            field: "mask",
        };
        if let Some(mask) = &mask {
            mask.check(faces).map_err(in_mask)?;
        }
        match (&work, &mask) {
            (Work::Fill(_) | Work::Repair(_), Some(_)) => {
                return Err(in_mask(
                    "fill and repair take no marked faces: holes are chosen by their numbers"
                        .to_owned(),
                ));
            }
            (Work::Restore(..), None) => {
                return Err(in_mask(
                    "no face is marked; mark the region to restore first".to_owned(),
                ));
            }
            _ => {}
        }
        if let Some(file) = work.template() {
            let file = file.display();
            let error = format!(
                "{file}: templates are read by the command line and by Python, not by the page"
            );
            return Err(Wrong {
                error,
                field: "params",
            });
        }
        let faces = mask.as_ref().map(|_| "marks.faces");
        let command = words.command(&work, faces).map_err(|error| Wrong {
            error,
            field: "params",
        })?;
        Ok(Self {
            work,
            mask,
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
        // Keep the removed faces for the report page of the step.
        spec.drawings.may_follow = true;
        spec.work.check()?;
        let mended = spec.read()?.mend(control)?.into_owned();
        let done = mended.clone().write()?;
        let step = StepDone {
            work: self.work,
            mask: self.mask,
            command: self.command,
            summary: summary(&done),
            document: serde_json::to_value(done.document()).unwrap_or_default(),
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

/// The format of intermediate files: the input's format, which stores all its attributes; PLY for STL, which does not number vertices.
pub fn format_between(file: Format) -> Format {
    match file {
        Format::Stl => Format::Ply,
        format => format,
    }
}

/// A summary of the result in one line.
fn summary(done: &JobResult) -> String {
    let fill = || tally_line(&done.report);
    match &done.extent {
        OperationReport::Region(cut) => {
            format!("{} cut out; {}", counted(cut.removed_faces, "face"), fill())
        }
        OperationReport::Faired(report) => format!(
            "moved by {} at most, {} root mean square",
            length_beside(report.moved_max, report.strength),
            length_beside(report.moved_rms, report.strength)
        ),
        OperationReport::Repaired(report) => {
            let mut lines = crate::report::repair_lines(report);
            lines.extend(report.after.as_ref().map(|verdict| verdict.line()));
            lines.join("; ")
        }
        OperationReport::Holes => fill(),
        OperationReport::Copied => "nothing changed".to_owned(),
    }
}
