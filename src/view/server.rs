//! The web server of the local page: start, pages of several files, recovery of earlier sessions.

use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use thiserror::Error;

use super::api::router;
use super::app::{App, error_text};
use super::choices::Choices;
use super::connections;
use super::events::Events;
use super::gate::Gate;
use super::pages::Pages;
use super::session::Session;
use super::state::State;
use super::step::format_between;
use super::store::{Fingerprint, ResumeError, Store, StoredStep};
use super::token::Token;
use super::words::Words;
use crate::io::{Format, IoError};
use crate::job::{JobError, Source};

/// Number of threads that serve connections; the work of requests runs on other threads.
const LISTENERS: usize = 2;
/// The error when no further page can be added.
const TOO_MANY: &str = "too many files are open; end the program and start it again";

/// The settings of the server.
pub struct Settings {
    /// The mesh file.
    pub input: PathBuf,
    /// Its format; none to detect it from the file.
    pub from: Option<Format>,
    /// The address to listen on.
    pub listen: IpAddr,
    /// The port; 0 for any free one.
    pub port: u16,
    /// The folder below which the page may read and write; none for the folder of the input file.
    pub root: Option<PathBuf>,
    /// Number of threads for the work; 0 for one per core.
    pub threads: usize,
    /// Writes steps as commands of the command line.
    pub words: Box<dyn Words>,
    /// Whether to resume an earlier session, and its recovery file if it is not the default one.
    pub resume: Option<Option<PathBuf>>,
}

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

/// The address of a started server.
pub struct Address {
    /// The address that the server listens on.
    pub at: SocketAddr,
    /// The address of the page; it contains the secret token.
    pub page: String,
    /// An address that leads to the page once.
    pub once: String,
    /// The recovery file of an earlier session that this one does not resume.
    pub earlier: Option<PathBuf>,
    /// Lists the recovery files of all pages that have unsaved steps at the time of the call.
    pub unsaved: Box<dyn Fn() -> Vec<PathBuf> + Send + Sync>,
}

/// Serves the page until the process ends. `ready` is called once the server listens.
///
/// # Errors
/// [`ViewError`].
pub fn serve(settings: Settings, ready: impl FnOnce(Address)) -> Result<(), ViewError> {
    let threads = || rayon::ThreadPoolBuilder::new().num_threads(settings.threads);
    let (pool, aside) = (Arc::new(threads().build()?), Arc::new(threads().build()?));
    let root = root(&settings)?;
    let wanted = SocketAddr::new(settings.listen, settings.port);
    let resume = settings.resume.as_ref().map(Option::as_deref);
    let read = Read::new(&pool, &root, settings.input, settings.from, resume)?;
    let words: Arc<dyn Words> = Arc::from(settings.words);
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(LISTENERS)
        .enable_io()
        .enable_time()
        .build()?;
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::bind(wanted).await;
        let listener = listener.map_err(|cause| ViewError::Listen { at: wanted, cause })?;
        let at = listener.local_addr()?;
        let shared = Arc::new(Shared {
            at,
            root,
            pool,
            aside,
            words,
            pages: Arc::default(),
            apps: Mutex::default(),
            opening: Mutex::default(),
        });
        let earlier = read.earlier.clone();
        let is_own_file = matches!(settings.resume, Some(None));
        let [token, ticket] = shared.add_page(read, is_own_file)?;
        let all = shared.clone();
        ready(Address {
            at,
            page: format!("{}/", address(at, &token)),
            once: address(at, &ticket),
            earlier,
            unsaved: Box::new(move || all.unsaved()),
        });
        connections::serve(listener, shared.pages.clone()).await?;
        Ok(())
    })
}

/// A file that was read for a page.
struct Read {
    input: PathBuf,
    from: Option<Format>,
    bytes: u64,
    first: State,
    store: Store,
    steps: Option<(Vec<StoredStep>, Vec<Choices>)>,
    earlier: Option<PathBuf>,
}

impl Read {
    /// Reads a file and, if `resume` is given, the steps of an earlier session.
    fn new(
        pool: &rayon::ThreadPool,
        root: &Path,
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
        let store = Store::new(root, &input, Fingerprint::of(&content));
        let steps = resume.map(|file| store.read(file)).transpose()?;
        let earlier = store.path().to_path_buf();
        let earlier = (steps.is_none() && earlier.exists()).then_some(earlier);
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
}

/// The state that all pages of a server share.
struct Shared {
    at: SocketAddr,
    root: PathBuf,
    pool: Arc<rayon::ThreadPool>,
    aside: Arc<rayon::ThreadPool>,
    words: Arc<dyn Words>,
    pages: Arc<Pages>,
    /// The state of each page, with its token.
    apps: Mutex<Vec<(Token, Arc<App>)>>,
    /// Locked while a file is opened. Never lock it on a thread of a rayon pool: a waiting thread may take up another request.
    opening: Mutex<()>,
}

impl Shared {
    /// Adds the page of a file that was read. Returns the page's token and a ticket that leads to the page once. `is_own_file` says
    /// whether the steps of an earlier session were read from the recovery file of this session.
    fn add_page(self: &Arc<Self>, read: Read, is_own_file: bool) -> std::io::Result<[Token; 2]> {
        let [token, ticket] = [Token::new()?, Token::new()?];
        let gate = Arc::new(Gate::new(token.clone(), ticket.clone(), self.at));
        let [low, high] = read.first.loaded.mesh.bounds();
        let (opens, knows) = (self.clone(), self.clone());
        let app = Arc::new(App {
            bytes: read.bytes,
            input: read.input,
            format_between: format_between(read.first.loaded.format),
            from: read.from,
            root: self.root.clone(),
            centre: 0.5 * (low + high),
            session: Mutex::new(Session::new(read.first)),
            store: read.store,
            earlier: read.earlier,
            events: Events::default(),
            pool: self.pool.clone(),
            aside: self.aside.clone(),
            renderer: self.words.clone(),
            open: Box::new(move |path| opens.open(path)),
            is_input: Box::new(move |path| knows.page_of(path).is_some()),
        });
        if let Some(steps) = read.steps {
            app.resume(steps, is_own_file)?;
        }
        let mut apps = self.apps.lock().unwrap_or_else(PoisonError::into_inner);
        let router = router(app.clone(), gate);
        if !self.pages.add_page(token.clone(), router) {
            return Err(std::io::Error::other(TOO_MANY));
        }
        apps.push((token.clone(), app));
        Ok([token, ticket])
    }

    /// Opens another file and returns the path of its page on this server. A file that is already open keeps its page, since a second
    /// session would overwrite the first one's recovery file.
    fn open(self: &Arc<Self>, path: PathBuf) -> Result<String, String> {
        let _one_at_a_time = self.opening.lock().unwrap_or_else(PoisonError::into_inner);
        let page = |token: Token| format!("/{}/", token.text());
        if let Some(token) = self.page_of(&path) {
            return Ok(page(token));
        }
        if !self.pages.has_room() {
            return Err(TOO_MANY.to_owned());
        }
        let read = Read::new(&self.aside, &self.root, path, None, None);
        let read = read.map_err(|error| error_text(&error))?;
        let [token, _] = self
            .add_page(read, false)
            .map_err(|error| error.to_string())?;
        Ok(page(token))
    }

    /// The token of the page whose input is this file.
    fn page_of(&self, path: &Path) -> Option<Token> {
        let path = path.canonicalize().ok()?;
        let apps = self.apps.lock().unwrap_or_else(PoisonError::into_inner);
        let is_of = |app: &App| app.input.canonicalize().is_ok_and(|input| input == path);
        let page = apps.iter().find(|(_, app)| is_of(app));
        page.map(|(token, _)| token.clone())
    }

    /// The recovery files of all pages that have unsaved steps.
    fn unsaved(&self) -> Vec<PathBuf> {
        let apps = self.apps.lock().unwrap_or_else(PoisonError::into_inner);
        let is_unsaved = |app: &App| app.session().needs_storing() && app.store.error().is_none();
        let unsaved = apps.iter().filter(|(_, app)| is_unsaved(app));
        unsaved
            .map(|(_, app)| app.store.path().to_path_buf())
            .collect()
    }
}

/// The folder below which the page may read and write files.
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
        false => Err(in_root(std::io::Error::other("it is not a folder"))),
    }
}

/// The address of a secret path, for a browser on this machine.
fn address(at: SocketAddr, token: &Token) -> String {
    let host = match at.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => "127.0.0.1".to_owned(),
        IpAddr::V6(ip) if ip.is_unspecified() => "[::1]".to_owned(),
        IpAddr::V4(ip) => ip.to_string(),
        IpAddr::V6(ip) => format!("[{ip}]"),
    };
    format!("http://{host}:{}/{}", at.port(), token.text())
}
