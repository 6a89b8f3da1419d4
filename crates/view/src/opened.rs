//! A file that was read for a page, and the state of its page.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::SystemTime;

use thiserror::Error;

use super::app::{App, Host};
use super::choices::Choices;
use super::events::Events;
use super::kept::Kept;
use super::revisions::Revisions;
use super::session::Session;
use super::state::State;
use super::step::format_between;
use super::store::{Fingerprint, ResumeError, Store, StoredStep};
use isomend_core::threads::Threads;
use isomend_files::io::{Format, IoError};
use isomend_files::job::{JobError, Source};

/// Why the server cannot start.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ViewError {
    /// The mesh cannot be read or inspected.
    #[error(transparent)]
    Job(#[from] JobError),
    /// The earlier session cannot be resumed.
    #[error(transparent)]
    Resume(#[from] ResumeError),
    /// The folder for files cannot be used.
    #[error("the folder {} cannot be used: {cause}", path.display())]
    Root {
        /// The folder.
        path: PathBuf,
        /// The cause.
        cause: std::io::Error,
    },
    /// The address or port cannot be used.
    #[error("cannot listen on {at}: {cause}")]
    Listen {
        /// The address.
        at: SocketAddr,
        /// The cause.
        cause: std::io::Error,
    },
    /// The system refuses a resource that the server needs.
    #[error("cannot start the server: {0}")]
    Start(#[from] std::io::Error),
    /// The threads cannot be started.
    #[error("cannot start the threads; try fewer: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// A file that was read for a page.
pub struct Opened {
    /// The file.
    pub input: PathBuf,
    /// The recovery file of an earlier session that this one does not resume.
    pub earlier: Option<PathBuf>,
    from: Option<Format>,
    bytes: u64,
    first: State,
    store: Store,
    steps: Option<(Vec<StoredStep>, Vec<Choices>)>,
}

impl Opened {
    /// Reads a file and, if `resume` is given, the steps of an earlier session.
    ///
    /// # Errors
    /// When the file cannot be read or inspected, or the earlier session cannot be resumed.
    pub fn read(
        pool: &Threads,
        kept: &Kept,
        input: PathBuf,
        from: Option<Format>,
        resume: Option<Option<&Path>>,
    ) -> Result<Self, ViewError> {
        let mut source = Source::from(input.clone());
        source.format = from;
        let first = pool.install(|| State::first(&source, source.read()?))?;
        let content = std::fs::read(&input).map_err(|cause| {
            let path = input.clone();
            JobError::Io(IoError::Read { path, cause })
        })?;
        let store = Store::new(kept.session(&input), &input, Fingerprint::of(&content));
        let steps = resume.map(|file| store.read(file)).transpose()?;
        let earlier = store.path().to_path_buf();
        let earlier = (steps.is_none() && earlier.is_file()).then_some(earlier);
        Ok(Self {
            input,
            from,
            bytes: content.len() as u64,
            first,
            store,
            steps,
            earlier,
        })
    }

    /// The state of the file's page. If an earlier session is resumed, its steps begin to be repeated; `is_own_file` says whether they
    /// were read from the recovery file of this session.
    ///
    /// # Errors
    /// When the thread for the steps cannot be started.
    pub fn app(self, host: Host, events: Events, is_own_file: bool) -> std::io::Result<Arc<App>> {
        let [low, high] = self.first.bounds;
        let app = Arc::new(App {
            bytes: self.bytes,
            input: self.input,
            format_between: format_between(self.first.loaded.format),
            from: self.from,
            centre: 0.5 * (low + high),
            session: Mutex::new(Session::new(self.first)),
            revisions: Mutex::new(Revisions::new(SystemTime::now())),
            store: self.store,
            earlier: self.earlier,
            wall_map: Mutex::default(),
            events,
            host,
        });
        if let Some(steps) = self.steps {
            app.resume(steps, is_own_file)?;
        }
        Ok(app)
    }
}
