//! What all requests share.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use serde_json::json;

use super::events::{Events, Teller};
use super::gate::Gate;
use super::make::Order;
use super::session::Session;
use super::state::State;
use super::words::Words;
use crate::mend::Control;

/// The server's state.
pub struct App {
    /// Who is let in.
    pub gate: Gate,
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
    /// What pages are told.
    pub events: Events,
    /// The threads that work is done on.
    pub pool: rayon::ThreadPool,
    /// The words of the command line.
    pub words: Box<dyn Words>,
}

impl App {
    /// The session, for a short time.
    pub fn session(&self) -> MutexGuard<'_, Session> {
        self.session.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells pages that something has changed.
    pub fn changed(&self) {
        self.events.tell("state", &json!({}));
    }

    /// Runs something long on the threads for work; what panics in it is an error.
    ///
    /// # Errors
    /// That it panicked.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> Result<R, String> {
        let run = || catch_unwind(AssertUnwindSafe(work));
        let done = self.pool.install(run);
        done.map_err(|_| {
            "an internal error; please report it with the file that it was made with".to_owned()
        })
    }

    /// Begins a step on a thread of its own and returns the number of its job; none where another is being made.
    ///
    /// # Errors
    /// When there is no thread for it.
    pub fn begin(self: &Arc<Self>, order: Order, preview: bool) -> std::io::Result<Option<u64>> {
        let (job, cancel, parent) = {
            let mut session = self.session();
            let parent = session.current().clone();
            match session.begin(order.work.name()) {
                Some((job, cancel)) => (job, cancel, parent),
                None => return Ok(None),
            }
        };
        let app = self.clone();
        let work = move || {
            let teller = Teller::new(&app.events, job);
            let tell = |step: &crate::mend::Step| teller.step(step);
            let control = Control::new().cancel(&cancel).progress(&tell);
            let made = app.run(|| order.make(&app.input, &parent, &control));
            let made = made.and_then(|made| made.map_err(|error| told(&error)));
            app.finish(job, made, preview, cancel.is_cancelled());
        };
        let started = std::thread::Builder::new()
            .name("step".to_owned())
            .spawn(work);
        if let Err(error) = started {
            self.session().busy = None;
            return Err(error);
        }
        self.changed();
        Ok(Some(job))
    }

    /// Takes what a step made, unless it was cancelled.
    fn finish(&self, job: u64, made: Result<State, String>, preview: bool, cancelled: bool) {
        let mut session = self.session();
        session.busy = None;
        let told = match made {
            _ if cancelled => ("cancelled", json!({ "job": job })),
            Ok(state) => {
                let id = session.add(state, preview);
                ("done", json!({ "job": job, "state": id }))
            }
            Err(error) => ("failed", json!({ "job": job, "error": error })),
        };
        drop(session);
        self.events.tell(told.0, &told.1);
        self.changed();
    }
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
