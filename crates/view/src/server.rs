//! The web server of the local page: start, pages of several files, recovery of earlier sessions.

use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use axum::Router;
use axum::middleware::from_fn_with_state;
use tokio::sync::Semaphore;

use super::api::{router, start_router};
use super::app::{App, Host, error_text};
use super::connections;
use super::events::Events;
use super::gate::{Gate, authorise};
use super::kept::Kept;
use super::opened::{Opened, ViewError};
use super::pages::Pages;
use super::recent::record;
use super::token::Token;
use super::words::CommandRenderer;
use isomend_core::threads::Threads;
use isomend_files::io::{Format, canonical};

/// Number of threads that serve connections; the work of requests runs on other threads.
const LISTENERS: usize = 2;
/// Upper bound of the number of streams of events of all pages; each tab of a browser has one.
const STREAMS: usize = 128;
/// The error when no further page can be added.
const TOO_MANY: &str = "too many files are open; end the program and start it again";

/// The settings of the server.
pub struct Settings {
    /// The mesh file, or a folder: then the first page lists its meshes.
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
    pub words: Box<dyn CommandRenderer>,
    /// Whether to resume an earlier session, and its recovery file if it is not the default one.
    pub resume: Option<Option<PathBuf>>,
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
    let threads = || Threads::new(settings.threads).map(Arc::new);
    let (pool, aside) = (threads()?, threads()?);
    let root = root(&settings)?;
    let wanted = SocketAddr::new(settings.listen, settings.port);
    let kept = Kept::of_user(&root);
    let read = input(&settings, &pool, &kept)?;
    let words: Arc<dyn CommandRenderer> = Arc::from(settings.words);
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
            kept,
            streams: Arc::new(Semaphore::new(STREAMS)),
            pool,
            aside,
            words,
            pages: Arc::default(),
            apps: Mutex::default(),
            opening: Mutex::default(),
        });
        let earlier = read.as_ref().and_then(|read| read.earlier.clone());
        let is_own_file = matches!(settings.resume, Some(None));
        let [token, ticket] = match read {
            None => shared.add_start()?,
            Some(read) => {
                if shared.kept.recent().exists() {
                    record(&shared.kept.recent(), &shared.root, &[&read.input]);
                }
                shared.add_page(read, is_own_file)?
            }
        };
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

/// The mesh of the first page; none if the settings name a folder.
fn input(settings: &Settings, pool: &Threads, kept: &Kept) -> Result<Option<Opened>, ViewError> {
    let resume = settings.resume.as_ref().map(Option::as_deref);
    let path = settings.input.clone();
    if !path.is_dir() {
        return Opened::read(pool, kept, path, settings.from, resume).map(Some);
    }
    let refused = match (resume, settings.from, &settings.root) {
        (None, None, None) => return Ok(None),
        (Some(_), ..) => "name the mesh whose steps are to be repeated",
        (_, Some(_), _) => "it is a folder, whose meshes have their own formats: leave out --from",
        _ => "its own meshes are listed: leave out --root",
    };
    let cause = std::io::Error::other(refused);
    Err(ViewError::Root { path, cause })
}

/// The state that all pages of a server share.
struct Shared {
    at: SocketAddr,
    root: PathBuf,
    kept: Kept,
    streams: Arc<Semaphore>,
    pool: Arc<Threads>,
    aside: Arc<Threads>,
    words: Arc<dyn CommandRenderer>,
    pages: Arc<Pages>,
    /// The state of each page, with its token.
    apps: Mutex<Vec<(Token, Arc<App>)>>,
    /// Locked while a file is opened. Never lock it on a thread of a rayon pool: a waiting thread may take up another request.
    opening: Mutex<()>,
}

impl Shared {
    /// Adds the page of a file that was read. Returns the page's token and a ticket that leads to the page once. `is_own_file` says
    /// whether the steps of an earlier session were read from the recovery file of this session.
    fn add_page(self: &Arc<Self>, read: Opened, is_own_file: bool) -> std::io::Result<[Token; 2]> {
        let app = read.app(self.host(), Events::default(), is_own_file)?;
        let mut apps = self.apps.lock().unwrap_or_else(PoisonError::into_inner);
        let tokens = self.add(router(app.clone()))?;
        apps.push((tokens[0].clone(), app));
        Ok(tokens)
    }

    /// Adds the start page of the folder. Returns its token and a ticket that leads to it once.
    fn add_start(self: &Arc<Self>) -> std::io::Result<[Token; 2]> {
        self.add(start_router(Arc::new(self.host())))
    }

    /// Adds a page with these routes. Returns its token and a ticket that leads to it once.
    fn add(&self, router: Router) -> std::io::Result<[Token; 2]> {
        let [token, ticket] = [Token::new()?, Token::new()?];
        let gate = Arc::new(Gate::new(token.clone(), ticket.clone(), self.at));
        let router = router.layer(from_fn_with_state(gate, authorise));
        match self.pages.add_page(token.clone(), router) {
            true => Ok([token, ticket]),
            false => Err(std::io::Error::other(TOO_MANY)),
        }
    }

    /// What a page shares with the others.
    fn host(self: &Arc<Self>) -> Host {
        let (opens, knows) = (self.clone(), self.clone());
        Host {
            root: self.root.clone(),
            kept: self.kept.clone(),
            streams: self.streams.clone(),
            pool: self.pool.clone(),
            aside: self.aside.clone(),
            renderer: self.words.clone(),
            open: Box::new(move |path| opens.open(path)),
            is_input: Box::new(move |path| knows.page_of(path).is_some()),
            start: Box::new(|kind, job| {
                let thread = std::thread::Builder::new().name(kind.to_owned());
                thread.spawn(job).map(drop)
            }),
            stores_saved: false,
        }
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
        let read = Opened::read(&self.aside, &self.kept, path, None, None);
        let read = read.map_err(|error| error_text(&error))?;
        let [token, _] = self
            .add_page(read, false)
            .map_err(|error| error.to_string())?;
        Ok(page(token))
    }

    /// The token of the page whose input is this file.
    fn page_of(&self, path: &Path) -> Option<Token> {
        let path = canonical(path).ok()?;
        let apps = self.apps.lock().unwrap_or_else(PoisonError::into_inner);
        let is_of = |app: &App| canonical(&app.input).is_ok_and(|input| input == path);
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
    let beside = match settings.input.is_dir() {
        true => settings.input.as_path(),
        false => settings.input.parent().unwrap_or(Path::new("")),
    };
    let beside = match beside.as_os_str().is_empty() {
        true => Path::new("."),
        false => beside,
    };
    let root = settings.root.as_deref().unwrap_or(beside);
    let in_root = |cause| ViewError::Root {
        path: root.to_path_buf(),
        cause,
    };
    let whole = canonical(root).map_err(in_root)?;
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
