//! Makes a step: as the command line would, from a file to a file, but for the files.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use serde::Deserialize;
use serde_json::Value;

use super::runs::Runs;
use super::state::{State, StepDone, place_after};
use super::words::Words;
use crate::fill::FillParams;
use crate::io::Format;
use crate::job::{Extent, JobError, JobResult, JobSpec, MaskSpec, Output, Source, Work};
use crate::mend::{Control, FairParams, RestoreParams};
use crate::mesh::length_beside;
use crate::repair::RepairParams;
use crate::report::{counted, tally_line};

/// What a step is to do, as the page asks for it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// The command.
    pub kind: Kind,
    /// Its parameters; those that are not given are the usual ones.
    #[serde(default)]
    pub params: Value,
    /// The faces that are marked.
    #[serde(default)]
    pub mask: Option<Runs>,
    /// Whether the result is only to be looked at.
    #[serde(default)]
    pub preview: bool,
}

/// A kind of step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Holes are filled.
    Fill,
    /// What is marked is replaced.
    Restore,
    /// The surface, or what is marked, is faired.
    Fair,
    /// What is wrong is mended.
    Repair,
}

/// What is wrong with a request, and where.
#[derive(Debug)]
pub struct Wrong {
    /// What is wrong.
    pub error: String,
    /// The part of the request.
    pub place: &'static str,
}

/// A step that can be made.
#[derive(Clone)]
pub struct Order {
    /// What is to be done, without the marks of the mask.
    pub work: Work,
    /// The faces that are marked.
    pub mask: Option<Runs>,
    /// The same as a command.
    pub command: super::words::Command,
}

impl Request {
    /// Checks it for a mesh of so many faces: what it asks for must be something that the command line can be asked for.
    ///
    /// # Errors
    /// What is wrong.
    pub fn order(self, faces: usize, words: &dyn Words) -> Result<Order, Wrong> {
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
        place: "params",
    })
}

impl Order {
    /// As [`Request::order`].
    ///
    /// # Errors
    /// What is wrong.
    pub fn new(
        work: Work,
        mask: Option<Runs>,
        faces: usize,
        words: &dyn Words,
    ) -> Result<Self, Wrong> {
        let in_mask = |error| Wrong {
            error,
            place: "mask",
        };
        if let Some(mask) = &mask {
            mask.check(faces).map_err(in_mask)?;
        }
        match (&work, &mask) {
            (Work::Fill(_) | Work::Repair(_), Some(_)) => {
                return Err(in_mask(
                    "holes are filled by their numbers, not by a mask".to_owned(),
                ));
            }
            (Work::Restore(..), None) => return Err(in_mask("no face is marked".to_owned())),
            _ => {}
        }
        if let Some(file) = work.template() {
            let file = file.display();
            let error = format!(
                "{file}: templates are read by the command line and by Python, not by the page"
            );
            return Err(Wrong {
                error,
                place: "params",
            });
        }
        let faces = mask.as_ref().map(|_| "marks.faces");
        let command = words.command(&work, faces).map_err(|error| Wrong {
            error,
            place: "params",
        })?;
        Ok(Self {
            work,
            mask,
            command,
        })
    }

    /// The work with the marks of its mask.
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

    /// Makes the step. The result is what the next command would read from the file that this one writes.
    ///
    /// # Errors
    /// What the job fails with; also when it is cancelled.
    pub fn make(
        self,
        input: &Path,
        parent: &Arc<State>,
        control: &Control,
    ) -> Result<State, JobError> {
        let clock = Instant::now();
        // As it was read, or as the step before wrote it.
        let format = format_between(parent.loaded.format);
        let place = place_after(input, parent.depth + 1);
        let source = Source::mesh(parent.place(input), parent.loaded.clone());
        let mut spec = JobSpec::plan(source, self.marked());
        spec.output = Some(Output::new(place.clone(), Some(format))?);
        // What was cut out is kept for the page of the step.
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

/// The format between two steps: that of the file, which carries all that came with it; of STL files, whose vertices have no
/// numbers, PLY.
pub fn format_between(file: Format) -> Format {
    match file {
        Format::Stl => Format::Ply,
        format => format,
    }
}

/// What was done, in a line.
fn summary(done: &JobResult) -> String {
    let fill = || tally_line(&done.report);
    match &done.extent {
        Extent::Region(cut) => {
            format!("{} cut out; {}", counted(cut.removed_faces, "face"), fill())
        }
        Extent::Faired(report) => format!(
            "moved by {} at most, {} root mean square",
            length_beside(report.moved_max, report.strength),
            length_beside(report.moved_rms, report.strength)
        ),
        Extent::Repaired(report) => {
            let mut lines = crate::report::repair_lines(report);
            lines.extend(report.after.as_ref().map(|verdict| verdict.line()));
            lines.join("; ")
        }
        Extent::Holes => fill(),
        Extent::Copied => "nothing changed".to_owned(),
    }
}
