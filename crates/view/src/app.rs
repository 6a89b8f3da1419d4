//! The server-side state of one page, shared by all its requests; jobs and their threads.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use serde_json::json;
use tokio::sync::Semaphore;

use super::choices::Choices;
use super::events::{Events, ProgressSender};
use super::kept::Kept;
use super::revisions::Revisions;
use super::session::{Busy, Session};
use super::state::State;
use super::step::{Order, Scope, StepRefusal};
use super::store::{Store, StoredStep};
use super::walls::WallSlot;
use super::words::CommandRenderer;
use isomend_core::mend::Control;
use isomend_core::threads::Threads;
use isomend_files::io::Format;

/// Kind of the job that repeats the steps of an earlier session.
const RESUME: &str = "resume";

/// The server-side state of one page.
pub struct App {
    /// The input file.
    pub input: PathBuf,
    /// Size of the input file in bytes.
    pub bytes: u64,
    /// The format of the input file, if the caller set it.
    pub from: Option<Format>,
    /// The format of the intermediate files between two steps.
    pub format_between: Format,
    /// The point that positions sent to the page are relative to.
    pub centre: DVec3,
    /// The session.
    pub session: Mutex<Session>,
    /// What pages have of the document of the state.
    pub revisions: Mutex<Revisions>,
    /// The recovery file of unsaved steps.
    pub store: Store,
    /// The recovery file of an earlier session that this one does not resume.
    pub earlier: Option<PathBuf>,
    /// What the wall thickness is measured with, of the state that was asked for last.
    pub wall_map: Mutex<WallSlot>,
    /// The events for the page.
    pub events: Events,
    /// What all pages share.
    pub host: Host,
}

/// A job of a page.
pub type Job = Box<dyn FnOnce() + Send>;
/// Runs a job of the given kind after the request that starts it was answered.
pub type StartThread = dyn Fn(&str, Job) -> std::io::Result<()> + Send + Sync;

/// What the pages of a server, or of a browser that runs the program itself, share.
pub struct Host {
    /// The folder below which files are read and written.
    pub root: PathBuf,
    /// The places of the page's own files.
    pub kept: Kept,
    /// Permits for streams of events.
    pub streams: Arc<Semaphore>,
    /// The thread pool for steps.
    pub pool: Arc<Threads>,
    /// The thread pool for long requests, so that they need not wait for a step.
    pub aside: Arc<Threads>,
    /// Writes steps as commands of the command line.
    pub renderer: Arc<dyn CommandRenderer>,
    /// Opens another file on its own page; returns the address of that page.
    pub open: Box<dyn Fn(PathBuf) -> Result<String, String> + Send + Sync>,
    /// Whether a path is the input of any page.
    pub is_input: Box<dyn Fn(&Path) -> bool + Send + Sync>,
    /// Starts jobs.
    pub start: Box<StartThread>,
    /// Whether the recovery file keeps saved steps too, since cancelling a step ends the program.
    pub stores_saved: bool,
}

impl App {
    /// Locks the session. Hold the lock for a short time only.
    pub fn session(&self) -> MutexGuard<'_, Session> {
        self.session.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Locks the revisions of the state's document. Lock them before the session.
    pub fn revisions(&self) -> MutexGuard<'_, Revisions> {
        self.revisions
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes the recovery file and notifies the page that the state has changed.
    pub fn changed(&self) {
        self.store_session();
        self.events.send("state", &json!({}));
    }

    /// Writes unsaved steps and choices to the recovery file.
    pub fn store_session(&self) {
        // While an earlier session is repeated, the file keeps its steps until all of them are done.
        let is_resume = |b: &Busy| b.kind == RESUME;
        if !self.session().busy.as_ref().is_some_and(is_resume) {
            self.store.update(|| {
                let session = self.session();
                let needs_storing = self.host.stores_saved || session.needs_storing();
                needs_storing.then(|| session.snapshot())
            });
        }
    }

    /// Starts a step and returns the number of its job; none if another job is running.
    ///
    /// # Errors
    /// When the thread cannot be started.
    pub fn begin(self: &Arc<Self>, order: Order, preview: bool) -> std::io::Result<Option<u64>> {
        let kind = order.work.name();
        self.start(kind, move |app, control| {
            let parent = app.session().current().clone();
            let state = app.make(order, &parent, control)?;
            Ok(Some((state, preview)))
        })
    }

    /// Repeats the steps of an earlier session, and restores the choices on the file and after each step. `own` says whether the steps
    /// were read from the recovery file of this session.
    ///
    /// # Errors
    /// When the thread cannot be started.
    pub fn resume(
        self: &Arc<Self>,
        (steps, choices): (Vec<StoredStep>, Vec<Choices>),
        own: bool,
    ) -> std::io::Result<()> {
        let mut choices = choices.into_iter();
        if let Some(choices) = choices.next() {
            self.session().restore_choices(choices);
        }
        self.start(RESUME, move |app, control| {
            for step in steps {
                let parent = app.session().current().clone();
                let faces = parent.loaded.mesh.faces.len();
                let order = Order::new(step, &app.scope(faces));
                let order = order.map_err(StepRefusal::words)?;
                let state = app.make(order, &parent, control)?;
                app.session().add(state, false);
                if let Some(choices) = choices.next() {
                    app.session().restore_choices(choices);
                }
                app.changed();
            }
            if own {
                app.store.own();
            }
            Ok(None)
        })?;
        Ok(())
    }

    /// What a step on a mesh with `faces` faces is checked against.
    pub fn scope(&self, faces: usize) -> Scope<'_> {
        Scope {
            faces,
            root: &self.host.root,
            words: self.host.renderer.as_ref(),
        }
    }

    /// Whether patches get no texels of their own in intermediate files: OBJ keeps the images in files of their own, and the session keeps
    /// intermediate files in memory.
    pub fn plain_between(&self) -> bool {
        self.format_between == Format::Obj
    }

    /// Runs a step on the thread pool.
    fn make(&self, order: Order, parent: &Arc<State>, control: &Control) -> Result<State, String> {
        let make = || order.make(&self.input, parent, control);
        let made = unless_panicked(|| self.host.pool.install(make))?;
        made.map_err(|error| error_text(&error))
    }

    /// Runs a job aside. The job may return a mesh, and whether it is a preview; it is added to the session.
    fn start(
        self: &Arc<Self>,
        kind: &'static str,
        job: impl FnOnce(&Self, &Control) -> Result<Option<(State, bool)>, String> + Send + 'static,
    ) -> std::io::Result<Option<u64>> {
        let Some((number, cancel)) = self.session().begin(kind) else {
            return Ok(None);
        };
        self.changed();
        let app = self.clone();
        let work = move || {
            let sender = ProgressSender::new(&app.events, number);
            let send = |step: &isomend_core::mend::Step| sender.step(step);
            let control = Control::new().cancel(&cancel).progress(&send);
            let made = job(&app, &control);
            app.finish(number, made, cancel.is_cancelled());
        };
        if let Err(error) = (self.host.start)(kind, Box::new(work)) {
            self.session().busy = None;
            return Err(error);
        }
        Ok(Some(number))
    }

    /// Adds the result of a job to the session, unless it was cancelled, and sends the event of its end.
    fn finish(&self, job: u64, made: Result<Option<(State, bool)>, String>, cancelled: bool) {
        let mut session = self.session();
        session.busy = None;
        let (event, data) = match made {
            _ if cancelled => ("cancelled", json!({ "job": job })),
            Ok(state) => {
                let added = state.map(|(state, preview)| session.add(state, preview));
                let id = added.unwrap_or_else(|| session.current().id);
                ("done", json!({ "job": job, "state": id }))
            }
            Err(error) => ("failed", json!({ "job": job, "error": error })),
        };
        drop(session);
        self.events.send(event, &data);
        self.changed();
    }
}

/// Runs `work` and turns a panic into an error.
///
/// # Errors
/// When `work` panicked.
pub fn unless_panicked<R>(work: impl FnOnce() -> R) -> Result<R, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| {
        "an internal error; please report it, with the input file and the steps that led to it"
            .to_owned()
    })
}

/// The message of an error, followed by the messages of its causes that it does not contain.
pub fn error_text(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let more = error.to_string();
        if !text.contains(&more) {
            text += &format!(": {more}");
        }
        cause = error.source();
    }
    text
}
