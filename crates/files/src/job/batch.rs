//! Batch runs: the same work on one or several meshes. Chooses the output files, checks everything that can be checked before the
//! first mesh is read, writes the JSON documents and counts how the jobs ended. The commands that read a mesh are batches, except `compare`
//! and `view`.

use std::io;
use std::path::PathBuf;

use super::deliver::Deliverables;
use super::documents::{DocumentList, failed_document};
use super::error::with_causes;
use super::places::{in_folder, is_folder_name, refuse_over};
use super::{
    Drawings, JobError, JobPlan, JobResult, JobSpec, Looked, Output, Place, Source, Work,
    write_text,
};
use crate::io::{Format, Loaded};
use isomend_core::mend::Control;

/// The same work on one or several meshes. The results of several meshes go into a folder, each under the name of its input. If one of
/// several jobs fails, the others still run.
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
    /// The file to write, or the folder; a folder whose name ends with a slash is created. Plans, and work that only looks, need none.
    pub output: Option<Place>,
    /// The format to write. Default: the format of the output's extension; in a folder, the format of each input.
    pub format: Option<Format>,
    /// Write text instead of binary.
    pub ascii: bool,
    /// What is done with each mesh.
    pub work: Work,
    /// Only plan: report what would be done and write no mesh.
    pub plan: bool,
    /// The page and the picture to draw; only for a single mesh, and not for a plan.
    pub drawings: Drawings,
    /// Further files besides the mesh (patches and the missing piece; only for a single mesh), and how the patches are reported.
    pub deliverables: Deliverables,
    /// Where the JSON document goes: one object for one mesh, a list for several.
    pub document: Option<Place>,
    /// Whether JSON documents list each step of the flows.
    pub each_step: bool,
    /// Count only flawless fills as done; see [`FillReport::flawless`](isomend_core::mend::FillReport::flawless).
    pub strict: bool,
}

/// Numbers of jobs of a batch by their ends, and its document.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BatchResult {
    /// Jobs that did everything that was requested.
    pub done: usize,
    /// Jobs that left something undone: a hole that was to be filled is still open, a deliverable is missing or an expected error is
    /// beyond the tolerance; with [`Batch::strict`] also jobs whose fill is not flawless.
    pub in_part: usize,
    /// Jobs that failed. If the only job of a batch fails, [`Batch::run`] returns its error instead.
    pub failed: usize,
    /// The text of the document, if its place is the caller's memory.
    pub document: Option<String>,
}

/// Receives the events of a batch. If it returns an error, the batch stops with [`JobError::Observer`].
pub trait BatchObserver {
    /// A job starts; its mesh has not been read yet.
    fn begins(&mut self, _job: &JobSpec) {}

    /// The mesh of a job has been read.
    fn has_read(&mut self, _job: &JobSpec, _loaded: &Loaded) {}

    /// The plan of a job is ready.
    ///
    /// # Errors
    /// If the plan cannot be shown, for example because standard output is closed.
    fn planned(&mut self, _plan: &JobPlan) -> io::Result<()> {
        Ok(())
    }

    /// Work that only looks at a mesh has ended.
    ///
    /// # Errors
    /// If the result cannot be shown, for example because standard output is closed.
    fn looked(&mut self, _job: &JobSpec, _looked: &Looked) -> io::Result<()> {
        Ok(())
    }

    /// A job has ended. If its output is the caller's memory, the result holds the bytes of the file.
    ///
    /// # Errors
    /// If the result cannot be shown, for example because standard output is closed.
    fn done(&mut self, _result: &JobResult) -> io::Result<()> {
        Ok(())
    }

    /// One of several jobs has failed; `_words` is the message.
    fn failed(&mut self, _job: &JobSpec, _words: &str) {}

    /// The message of an error with its causes, for [`BatchObserver::failed`] and the document.
    fn words(&self, error: JobError) -> String {
        with_causes(&error)
    }
}

/// An observer that does nothing.
impl BatchObserver for () {}

impl Batch {
    /// A batch without an output.
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
            each_step: false,
            strict: false,
        }
    }

    /// Checks files and parameters without reading a mesh.
    ///
    /// # Errors
    /// The errors of [`Batch::run`] that do not depend on a mesh.
    pub fn check(&self) -> Result<(), JobError> {
        self.jobs().map(|_| ())
    }

    /// Runs all jobs, one after another, and writes the document.
    ///
    /// # Errors
    /// Before any mesh is read: files or parameters that cannot be used. Later: the error of the only job, and the error of the
    /// observer.
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

    /// Runs one job and adds its document. Returns whether everything that was requested was done.
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
        if job.work.only_looks() {
            let looked = read.look(control)?;
            observer.looked(job, &looked).map_err(JobError::Observer)?;
            documents
                .into_iter()
                .for_each(|all| all.add(&looked.document()));
            return Ok(looked.is_good());
        }
        let done = read.mend(control)?.write()?;
        observer.done(&done).map_err(JobError::Observer)?;
        documents
            .into_iter()
            .for_each(|all| all.add(&done.document()));
        let is_whole = done.complete() && done.delivered();
        Ok(is_whole && (!self.strict || done.report.flawless()))
    }

    /// Makes one job per source and checks files and parameters of all of them.
    fn jobs(&self) -> Result<Vec<JobSpec>, JobError> {
        let outputs = self.outputs()?;
        self.check_document(&outputs)?;
        self.check_drawings()?;
        let jobs = self.sources.iter().zip(outputs);
        let job = |(source, output): (&Source, Option<Output>)| JobSpec {
            output: output.filter(|_| !self.plan),
            drawings: self.drawings.clone(),
            deliverables: self.deliverables.clone(),
            each_step: self.each_step,
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
            job.refuse_over_read()?;
            if let Some(document) = &self.document {
                refuse_over(document, &job.source.place, &self.work.files_read())?;
            }
            self.deliverables.check(job)?;
        }
        self.work.check()?;
        Ok(jobs)
    }

    /// The output of each source, in order; `None` for a plan without an output.
    fn outputs(&self) -> Result<Vec<Option<Output>>, JobError> {
        let places: Vec<Place> = self.sources.iter().map(|s| s.place.clone()).collect();
        let several = places.len() > 1;
        let wrong = |what: String| Err(JobError::Places { what });
        if let Some(stream) = places.iter().find(|p| several && p.path().is_none()) {
            return wrong(format!(
                "{} cannot be one of several inputs; read it alone",
                stream.name()
            ));
        }
        let Some(place) = &self.output else {
            return match self.plan || self.work.only_looks() {
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
                    "several inputs need a folder for their results, but {} is not one; create it first, or end its name with a slash",
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

    /// Refuses a document that would overwrite an input, a mesh or a deliverable.
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
