//! The same work on one mesh or on several: where each result goes, what is checked before the first is read, which documents are
//! written, and how the whole ends. The commands `fill`, `repair`, `restore`, `fair` and `convert` are this.

use std::error::Error;
use std::io;
use std::path::PathBuf;

use super::deliver::Deliverables;
use super::documents::{DocumentList, failed_document};
use super::places::{in_folder, is_folder_name};
use super::{
    Drawings, JobError, JobPlan, JobResult, JobSpec, Output, Place, Source, Work, write_text,
};
use crate::io::{Format, Loaded};
use crate::mend::Control;

/// The same work on one mesh or on several. Several go into a folder, each under the name of its input; of several one that fails
/// does not stop the others.
///
/// ```no_run
/// use isomend::job::{Batch, Work};
/// use isomend::{Control, FillParams};
///
/// let mut batch = Batch::new(["a.ply", "b.obj"], Work::Fill(FillParams::default()));
/// batch.output = Some("mended/".into());
/// batch.document = Some("mended.json".into());
/// let ended = batch.run(&mut (), &Control::new())?;
/// println!("{} done, {} with an open hole, {} failed", ended.done, ended.in_part, ended.failed);
/// # Ok::<(), isomend::job::JobError>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Batch {
    /// The meshes to read.
    pub sources: Vec<Source>,
    /// The file to write; or the folder, which is made where its name ends with a slash. May be missing in a plan.
    pub output: Option<Place>,
    /// The format of what is written; that of the output's extension where none is given, in a folder that of the input.
    pub format: Option<Format>,
    /// Text instead of binary.
    pub ascii: bool,
    /// What is done with each mesh.
    pub work: Work,
    /// Whether no mesh is made: it is only said what would be done.
    pub plan: bool,
    /// What is drawn of it: of a single mesh that is made.
    pub drawings: Drawings,
    /// What is handed on beside the mesh, and how it is reported; patches and a piece of a single mesh.
    pub deliverables: Deliverables,
    /// Where the JSON document goes: that of the only mesh, or a list of those of all.
    pub document: Option<Place>,
    /// Whether only flawless fills count as done, as [`FillReport::flawless`](crate::FillReport::flawless) says.
    pub strict: bool,
}

/// How the jobs of a batch ended, and its document.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BatchResult {
    /// Jobs that did all that was asked for.
    pub done: usize,
    /// Jobs after which something is still open that was to be filled, or with [`Batch::strict`] is not flawless.
    pub in_part: usize,
    /// Jobs that failed, of several.
    pub failed: usize,
    /// The text of the document, where its place is the caller's memory.
    pub document: Option<String>,
}

/// Gets the events of a batch. An error that it returns ends the batch with [`JobError::Observer`].
pub trait BatchObserver {
    /// A job begins: nothing is read yet.
    fn begins(&mut self, _job: &JobSpec) {}

    /// Its mesh was read.
    fn has_read(&mut self, _job: &JobSpec, _loaded: &Loaded) {}

    /// The plan of a job is known.
    ///
    /// # Errors
    /// When it cannot be passed on.
    fn planned(&mut self, _plan: &JobPlan) -> io::Result<()> {
        Ok(())
    }

    /// A job ended. The bytes of its file are here where they are the caller's.
    ///
    /// # Errors
    /// When it cannot be passed on.
    fn done(&mut self, _result: &JobResult) -> io::Result<()> {
        Ok(())
    }

    /// One of several jobs failed.
    fn failed(&mut self, _job: &JobSpec, _words: &str) {}

    /// An error in words, for [`BatchObserver::failed`] and the document.
    fn words(&self, error: JobError) -> String {
        let mut text = error.to_string();
        let mut cause = error.source();
        while let Some(error) = cause {
            text += &format!(": {error}");
            cause = error.source();
        }
        text
    }
}

/// An observer that does nothing.
impl BatchObserver for () {}

impl Batch {
    /// A work on meshes, without an output.
    pub fn new<S: Into<Source>>(sources: impl IntoIterator<Item = S>, work: Work) -> Self {
        Self {
            sources: sources.into_iter().map(Into::into).collect(),
            output: None,
            format: None,
            ascii: false,
            work,
            plan: false,
            drawings: Drawings::default(),
            deliverables: Deliverables::default(),
            document: None,
            strict: false,
        }
    }

    /// Checks what can be known before anything is read.
    ///
    /// # Errors
    /// As [`Batch::run`], as far as no mesh is asked.
    pub fn check(&self) -> Result<(), JobError> {
        self.jobs().map(|_| ())
    }

    /// Does all jobs, one after another, and writes the document.
    ///
    /// # Errors
    /// When the files or the parameters cannot be used so, before any mesh is read; what a single job fails with; what the observer
    /// fails with.
    pub fn run(
        &self,
        observer: &mut dyn BatchObserver,
        control: &Control,
    ) -> Result<BatchResult, JobError> {
        let jobs = self.jobs()?;
        let mut documents = self.document.as_ref().map(|_| DocumentList::default());
        let mut result = BatchResult::default();
        for job in &jobs {
            observer.begins(job);
            let count = match self.one(job, observer, control, documents.as_mut()) {
                Err(error) if jobs.len() > 1 && !matches!(error, JobError::Observer(_)) => {
                    let words = observer.words(error);
                    observer.failed(job, &words);
                    if let Some(documents) = &mut documents {
                        let name = job.work.name();
                        documents.add(&failed_document(name, &job.source.place, &words));
                    }
                    &mut result.failed
                }
                Err(error) => return Err(error),
                Ok(true) => &mut result.done,
                Ok(false) => &mut result.in_part,
            };
            *count += 1;
        }
        if let (Some(place), Some(documents)) = (&self.document, documents) {
            let text = documents.text(jobs.len() > 1);
            match place.path() {
                Some(path) => write_text(path, &text)?,
                None => result.document = Some(text),
            }
        }
        Ok(result)
    }

    /// Does a job; whether all of it was done.
    fn one(
        &self,
        job: &JobSpec,
        observer: &mut dyn BatchObserver,
        control: &Control,
        documents: Option<&mut DocumentList>,
    ) -> Result<bool, JobError> {
        let read = job.read()?;
        observer.has_read(job, &read.loaded);
        if self.plan {
            let plan = read.plan()?;
            observer.planned(&plan).map_err(JobError::Observer)?;
            documents
                .into_iter()
                .for_each(|all| all.add(&plan.document()));
            return Ok(true);
        }
        let done = read.mend(control)?.write()?;
        observer.done(&done).map_err(JobError::Observer)?;
        documents
            .into_iter()
            .for_each(|all| all.add(&done.document()));
        let is_whole = done.complete() && done.delivered();
        Ok(is_whole && (!self.strict || done.report.flawless()))
    }

    /// The jobs, checked.
    fn jobs(&self) -> Result<Vec<JobSpec>, JobError> {
        let outputs = self.outputs()?;
        self.check_document(&outputs)?;
        self.check_drawings()?;
        let jobs = self.sources.iter().zip(outputs);
        let job = |(source, output): (&Source, Option<Output>)| JobSpec {
            output: output.filter(|_| !self.plan),
            drawings: self.drawings.clone(),
            deliverables: self.deliverables.clone(),
            ..JobSpec::plan(source.clone(), self.work.clone())
        };
        let jobs: Vec<JobSpec> = jobs.map(job).collect();
        if let [job] = &jobs[..] {
            let mesh = job.output.as_ref().map(|o| &o.place);
            self.drawings.check(&job.source.place, mesh)?;
        }
        let extra = [&self.deliverables.patches, &self.deliverables.piece];
        if jobs.len() > 1 && extra.into_iter().any(Option::is_some) {
            return Err(JobError::SeveralDelivered);
        }
        for job in &jobs {
            self.deliverables.check(job)?;
        }
        self.work.check()?;
        Ok(jobs)
    }

    /// Where each mesh goes; none where a plan names no output.
    fn outputs(&self) -> Result<Vec<Option<Output>>, JobError> {
        let places: Vec<Place> = self.sources.iter().map(|s| s.place.clone()).collect();
        let several = places.len() > 1;
        let wrong = |what: String| Err(JobError::Places { what });
        if let Some(stream) = places.iter().find(|p| several && p.path().is_none()) {
            return wrong(format!("{} cannot be one of several inputs", stream.name()));
        }
        let Some(place) = &self.output else {
            return match self.plan {
                true => Ok(places.iter().map(|_| None).collect()),
                false => wrong("there is no output; name one, or ask for a plan".to_owned()),
            };
        };
        let outputs = match place.path() {
            Some(path) if is_folder_name(path) => {
                let paths = in_folder(path, &places, self.format)?;
                let make = |path: PathBuf| {
                    let mut output = Output::new(path, self.format)?;
                    output.make_folder = true;
                    Ok(output)
                };
                paths
                    .into_iter()
                    .map(make)
                    .collect::<Result<_, JobError>>()?
            }
            _ if several => {
                return wrong(format!(
                    "several inputs need a folder to go to, but {} is none; make it first, or end its name with a slash",
                    place.name()
                ));
            }
            _ => vec![Output::new(place.clone(), self.format)?],
        };
        let checked = |mut output: Output| {
            output.ascii = self.ascii;
            output.check().map(|()| Some(output))
        };
        outputs.into_iter().map(checked).collect()
    }

    fn check_document(&self, outputs: &[Option<Output>]) -> Result<(), JobError> {
        let Some(document) = &self.document else {
            return Ok(());
        };
        let inputs = self.sources.iter().map(|s| &s.place);
        let delivered = [&self.deliverables.patches, &self.deliverables.piece];
        let meshes = outputs
            .iter()
            .flatten()
            .chain(delivered.into_iter().flatten());
        // A plan writes no mesh.
        let meshes = meshes.map(|o| &o.place).filter(|_| !self.plan);
        document.check_document(inputs.chain(meshes))
    }

    fn check_drawings(&self) -> Result<(), JobError> {
        if !self.drawings.is_wanted() {
            return Ok(());
        }
        if self.plan {
            return Err(JobError::PlanDrawn);
        }
        if self.sources.len() > 1 {
            return Err(JobError::SeveralDrawn);
        }
        Ok(())
    }
}
