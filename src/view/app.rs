//! What all requests share.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use serde_json::json;

use super::choices::Choices;
use super::events::{Events, Teller};
use super::session::{Busy, Session};
use super::state::State;
use super::step::Order;
use super::store::{KeptStep, Store};
use super::words::Words;
use crate::mend::Control;

/// What is being done when the steps of an earlier session are made again.
const AGAIN: &str = "resume";

/// The server's state.
pub struct App {
    /// The file that was opened.
    pub input: PathBuf,
    /// Bytes of it.
    pub bytes: u64,
    /// The format that it was said to have.
    pub from: Option<crate::io::Format>,
    /// The format of the files between two steps.
    pub format_between: crate::io::Format,
    /// The folder that files are written below.
    pub root: PathBuf,
    /// The point that positions are relative to.
    pub centre: DVec3,
    /// The session.
    pub session: Mutex<Session>,
    /// Where steps that are not saved are kept.
    pub store: Store,
    /// The file of an earlier session whose steps were not saved, where it is not gone on with.
    pub earlier: Option<PathBuf>,
    /// What pages are told.
    pub events: Events,
    /// The threads that steps are made on, which all pages of the server share.
    pub pool: Arc<rayon::ThreadPool>,
    /// The threads that requests are answered on which take long: those of a step would keep them waiting.
    pub aside: Arc<rayon::ThreadPool>,
    /// The words of the command line.
    pub words: Arc<dyn Words>,
    /// Opens another file on a page of its own; returns where that page is on this server.
    pub open: Box<dyn Fn(PathBuf) -> Result<String, String> + Send + Sync>,
    /// Whether a path is the input of any page of this server.
    pub is_input: Box<dyn Fn(&Path) -> bool + Send + Sync>,
}

impl App {
    /// The session, for a short time.
    pub fn session(&self) -> MutexGuard<'_, Session> {
        self.session.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps what is not saved, and tells pages that something has changed.
    pub fn changed(&self) {
        self.keep();
        self.events.tell("state", &json!({}));
    }

    /// Keeps the steps and the choices that are not saved.
    pub fn keep(&self) {
        // Steps that are made again are in the file until all of them are.
        let is_again = |b: &Busy| b.kind == AGAIN;
        if !self.session().busy.as_ref().is_some_and(is_again) {
            self.store.keep(|| {
                let session = self.session();
                session.is_kept().then(|| session.kept())
            });
        }
    }

    /// Begins a step on a thread of its own and returns the number of its job; none where another is being made.
    ///
    /// # Errors
    /// When there is no thread for it.
    pub fn begin(self: &Arc<Self>, order: Order, preview: bool) -> std::io::Result<Option<u64>> {
        let kind = order.work.name();
        self.start(kind, move |app, control| {
            let parent = app.session().current().clone();
            let state = app.make(order, &parent, control)?;
            Ok(Some((state, preview)))
        })
    }

    /// Makes the steps of an earlier session again, and takes what was chosen on the file and after each; `own` says whether they were kept where this session keeps its own.
    ///
    /// # Errors
    /// When there is no thread for it.
    pub fn resume(
        self: &Arc<Self>,
        (steps, choices): (Vec<KeptStep>, Vec<Choices>),
        own: bool,
    ) -> std::io::Result<()> {
        let mut choices = choices.into_iter();
        if let Some(choices) = choices.next() {
            self.session().restore_choices(choices);
        }
        self.start(AGAIN, move |app, control| {
            for step in steps {
                let parent = app.session().current().clone();
                let faces = parent.loaded.mesh.faces.len();
                let order = Order::new(step.work, step.mask, faces, app.words.as_ref());
                let order = order.map_err(|wrong| wrong.error)?;
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

    /// Makes a step.
    fn make(&self, order: Order, parent: &Arc<State>, control: &Control) -> Result<State, String> {
        let make = || order.make(&self.input, parent, control);
        let made = unless_panicked(|| self.pool.install(make))?;
        made.map_err(|error| told(&error))
    }

    /// Does a job on a thread of its own, and takes the mesh that it makes, where it is none that is only looked at.
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
            let teller = Teller::new(&app.events, number);
            let tell = |step: &crate::mend::Step| teller.step(step);
            let control = Control::new().cancel(&cancel).progress(&tell);
            let made = job(&app, &control);
            app.finish(number, made, cancel.is_cancelled());
        };
        let thread = std::thread::Builder::new().name(kind.to_owned());
        if let Err(error) = thread.spawn(work) {
            self.session().busy = None;
            return Err(error);
        }
        Ok(Some(number))
    }

    /// Takes what a job made, unless it was cancelled.
    fn finish(&self, job: u64, made: Result<Option<(State, bool)>, String>, cancelled: bool) {
        let mut session = self.session();
        session.busy = None;
        let told = match made {
            _ if cancelled => ("cancelled", json!({ "job": job })),
            Ok(state) => {
                let added = state.map(|(state, preview)| session.add(state, preview));
                let id = added.unwrap_or_else(|| session.current().id);
                ("done", json!({ "job": job, "state": id }))
            }
            Err(error) => ("failed", json!({ "job": job, "error": error })),
        };
        drop(session);
        self.events.tell(told.0, &told.1);
        self.changed();
    }
}

/// Runs something; what panics in it is an error.
///
/// # Errors
/// That it panicked.
pub fn unless_panicked<R>(work: impl FnOnce() -> R) -> Result<R, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|_| {
        "an internal error; please report it with the file that it was made with".to_owned()
    })
}

/// An error with what caused it.
pub fn told(error: &dyn std::error::Error) -> String {
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
