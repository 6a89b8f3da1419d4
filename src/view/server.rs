//! The server.

use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use thiserror::Error;

use super::api::router;
use super::app::App;
use super::connections;
use super::events::Events;
use super::gate::Gate;
use super::session::Session;
use super::state::State;
use super::step::format_between;
use super::store::{Mark, ResumeError, Store};
use super::token::Token;
use super::words::Words;
use crate::io::Format;
use crate::job::{JobError, Source};

/// Threads that wait for requests; work is done on others.
const LISTENERS: usize = 2;

/// What is served, and where.
pub struct Settings {
    /// The mesh file.
    pub input: PathBuf,
    /// Its format, where it is not told from it.
    pub from: Option<Format>,
    /// The address to listen on.
    pub listen: IpAddr,
    /// The port; 0 for any that is free.
    pub port: u16,
    /// The folder below which the page may write; none for that of the file.
    pub root: Option<PathBuf>,
    /// Threads for the work; 0 for one per core.
    pub threads: usize,
    /// The words of the command line.
    pub words: Box<dyn Words>,
    /// Whether to go on with the steps of an earlier session, and where they are if not in the usual file.
    pub resume: Option<Option<PathBuf>>,
}

/// Why there is no page.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ViewError {
    /// The mesh cannot be had.
    #[error(transparent)]
    Job(#[from] JobError),
    /// An earlier session cannot be gone on with.
    #[error(transparent)]
    Resume(#[from] ResumeError),
    /// The folder to write to cannot be used.
    #[error("the folder {} cannot be used: {cause}", path.display())]
    Root {
        /// The folder.
        path: PathBuf,
        /// What is wrong.
        cause: std::io::Error,
    },
    /// Nothing can be served there.
    #[error("cannot listen on {at}: {cause}")]
    Listen {
        /// The address.
        at: SocketAddr,
        /// What is wrong.
        cause: std::io::Error,
    },
    /// The system does not give what a server needs.
    #[error("cannot start the server: {0}")]
    Start(#[from] std::io::Error),
    /// There are no threads.
    #[error("cannot start the threads; try fewer: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// Where the page is.
pub struct Address {
    /// Where the server listens.
    pub at: SocketAddr,
    /// The address of the page, which holds the secret.
    pub page: String,
    /// An address that leads to the page once.
    pub once: String,
    /// The file of an earlier session whose steps were not saved, where it is not gone on with.
    pub earlier: Option<PathBuf>,
    /// The file that keeps steps that are not saved now, if there are any.
    pub unsaved: Box<dyn Fn() -> Option<PathBuf> + Send + Sync>,
}

/// Serves the page until the process ends. `ready` is called once the server listens.
///
/// # Errors
/// [`ViewError`].
pub fn serve(settings: Settings, ready: impl FnOnce(Address)) -> Result<(), ViewError> {
    let mut source = Source::from(settings.input.clone());
    source.format = settings.from;
    let threads = || rayon::ThreadPoolBuilder::new().num_threads(settings.threads);
    let (pool, aside) = (threads().build()?, threads().build()?);
    let first = pool.install(|| State::first(&source, source.read()?))?;
    let root = root(&settings)?;
    let content = std::fs::read(&settings.input)?;
    let store = Store::new(&root, &settings.input, Mark::of(&content));
    let steps = settings
        .resume
        .as_ref()
        .map(|file| store.read(file.as_deref()));
    let steps = steps.transpose()?;
    let earlier = store.path().to_path_buf();
    let earlier = (steps.is_none() && earlier.exists()).then_some(earlier);
    let [low, high] = first.loaded.mesh.bounds();
    let wanted = SocketAddr::new(settings.listen, settings.port);
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(LISTENERS)
        .enable_io()
        .enable_time()
        .build()?;
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::bind(wanted).await;
        let listener = listener.map_err(|cause| ViewError::Listen { at: wanted, cause })?;
        let at = listener.local_addr()?;
        let [token, ticket] = [Token::new()?, Token::new()?];
        let [page, once] = [format!("{}/", address(at, &token)), address(at, &ticket)];
        let gate = Arc::new(Gate::new(token, ticket, at));
        let app = Arc::new(App {
            bytes: content.len() as u64,
            input: settings.input,
            format_between: format_between(first.loaded.format),
            from: settings.from,
            root,
            centre: 0.5 * (low + high),
            session: Mutex::new(Session::new(first)),
            store,
            earlier: earlier.clone(),
            events: Events::default(),
            pool,
            aside,
            words: settings.words,
        });
        if let Some(steps) = steps {
            app.resume(steps, matches!(settings.resume, Some(None)))?;
        }
        let unsaved = unsaved(app.clone());
        ready(Address {
            at,
            page,
            once,
            earlier,
            unsaved: Box::new(unsaved),
        });
        connections::serve(listener, router(app, gate)).await?;
        Ok(())
    })
}

/// Tells the file that keeps steps that are not saved, if there are any.
fn unsaved(app: Arc<App>) -> impl Fn() -> Option<PathBuf> + Send + Sync {
    move || {
        let is_unsaved = app.session().is_kept();
        let is_kept = app.store.error().is_none();
        (is_unsaved && is_kept).then(|| app.store.path().to_path_buf())
    }
}

/// The folder below which files are written.
fn root(settings: &Settings) -> Result<PathBuf, ViewError> {
    let beside = settings.input.parent().unwrap_or(Path::new(""));
    let beside = match beside.as_os_str().is_empty() {
        true => Path::new("."),
        false => beside,
    };
    let root = settings.root.as_deref().unwrap_or(beside);
    let in_root = |cause| ViewError::Root {
        path: root.to_path_buf(),
        cause,
    };
    let whole = root.canonicalize().map_err(in_root)?;
    match whole.is_dir() {
        true => Ok(whole),
        false => Err(in_root(std::io::Error::other("it is no folder"))),
    }
}

/// The address that a secret stands in, for a browser on this machine.
fn address(at: SocketAddr, token: &Token) -> String {
    let host = match at.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => "127.0.0.1".to_owned(),
        IpAddr::V6(ip) if ip.is_unspecified() => "[::1]".to_owned(),
        IpAddr::V4(ip) => ip.to_string(),
        IpAddr::V6(ip) => format!("[{ip}]"),
    };
    format!("http://{host}:{}/{}", at.port(), token.text())
}
