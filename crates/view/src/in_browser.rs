//! The local page without a server: the program runs in the browser, and answers the page's requests by calls.
//!
//! Requests and answers are the server's ([`super::api`]). There is one thread: a step runs when the caller allows it
//! ([`InBrowser::work`]), after the request that starts it was answered.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::header::CONTENT_TYPE;
use axum::http::{Request, StatusCode};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::Semaphore;
use tower_service::Service;

use super::api::router;
use super::app::{Host, Job, error_text};
use super::events::Events;
use super::kept::Kept;
use super::opened::Opened;
use super::words::CommandRenderer;
use isomend_core::threads::Threads;

/// The folder for temporary files.
#[cfg(target_family = "wasm")]
const TEMPORARY: &str = ".temporary";

/// Calls a function with the number of a page and each of its events, in the text format of server-sent events.
pub type Listener = fn(usize, &str);

/// An answer to a request.
#[derive(Debug)]
pub struct PageAnswer {
    /// The HTTP status.
    pub status: u16,
    /// The media type of the body; empty if it has none.
    pub media_type: String,
    /// The body.
    pub body: Vec<u8>,
}

/// The pages of the files that were opened.
pub struct InBrowser {
    root: PathBuf,
    renderer: Arc<dyn CommandRenderer>,
    threads: Arc<Threads>,
    listener: Listener,
    runtime: Runtime,
    /// The input of each page, and its routes.
    pages: Mutex<Vec<(PathBuf, Router)>>,
    /// Jobs that have not begun.
    jobs: Mutex<VecDeque<Job>>,
}

impl InBrowser {
    /// No pages yet. Files are read and written below `root`.
    ///
    /// # Errors
    /// When the work cannot be set up.
    pub fn new(
        root: PathBuf,
        renderer: Arc<dyn CommandRenderer>,
        listener: Listener,
    ) -> std::io::Result<Arc<Self>> {
        let threads = Threads::new(1).map_err(std::io::Error::other)?;
        // WASI names no folder for temporary files.
        #[cfg(target_family = "wasm")]
        {
            let folder = root.join(TEMPORARY);
            std::fs::create_dir_all(&folder)?;
            let _ = tempfile::env::override_temp_dir(&folder);
        }
        Ok(Arc::new(Self {
            root,
            renderer,
            threads: Arc::new(threads),
            listener,
            runtime: Builder::new_current_thread().enable_time().build()?,
            pages: Mutex::default(),
            jobs: Mutex::default(),
        }))
    }

    /// Opens a file and returns the number of its page. A file that is already open keeps its page. The steps of an earlier session
    /// are repeated if `resume` is true and they can be read.
    ///
    /// # Errors
    /// The reason in words.
    pub fn open(self: &Arc<Self>, path: &Path, resume: bool) -> Result<usize, String> {
        if let Some(page) = self.pages().iter().position(|(input, _)| input == path) {
            return Ok(page);
        }
        let kept = Kept::within(&self.root);
        let read = |resume| Opened::read(&self.threads, &kept, path.into(), None, resume);
        let opened = match resume {
            true => read(Some(None)).or_else(|_| read(None)),
            false => read(None),
        };
        let opened = opened.map_err(|error| error_text(&error))?;
        let (page, listener) = (self.pages().len(), self.listener);
        let events = Events::to(Box::new(move |text| listener(page, text)));
        let app = opened.app(self.host(), events, true);
        let app = app.map_err(|error| error.to_string())?;
        self.pages().push((path.into(), router(app)));
        Ok(page)
    }

    /// What the pages share.
    fn host(self: &Arc<Self>) -> Host {
        let [opens, knows, starts] = [self, self, self].map(Arc::clone);
        Host {
            root: self.root.clone(),
            kept: Kept::within(&self.root),
            // Events are delivered by calls.
            streams: Arc::new(Semaphore::new(0)),
            pool: self.threads.clone(),
            aside: self.threads.clone(),
            renderer: self.renderer.clone(),
            open: Box::new(move |path| Ok(address(opens.open(&path, false)?))),
            is_input: Box::new(move |path| knows.pages().iter().any(|(input, _)| input == path)),
            start: Box::new(move |_, job| {
                locked(&starts.jobs).push_back(job);
                Ok(())
            }),
            stores_saved: true,
        }
    }

    /// Answers a request to a page. `path` is relative to the page, as `api/state`; a request with a body is a POST request.
    pub fn answer(&self, page: usize, path: &str, body: Option<(&str, Vec<u8>)>) -> PageAnswer {
        let router = self.pages().get(page).map(|(_, router)| router.clone());
        let Some(mut router) = router else {
            return PageAnswer::empty(StatusCode::NOT_FOUND);
        };
        let request = Request::builder().uri(format!("/page/{path}"));
        let request = match body {
            Some((media_type, body)) => request
                .method("POST")
                .header(CONTENT_TYPE, media_type)
                .body(Body::from(body)),
            None => request.body(Body::empty()),
        };
        let Ok(request) = request else {
            return PageAnswer::empty(StatusCode::BAD_REQUEST);
        };
        self.runtime.block_on(async move {
            let Ok(response) = router.call(request).await;
            let (head, body) = response.into_parts();
            let media_type = head.headers.get(CONTENT_TYPE);
            let media_type = media_type.and_then(|value| value.to_str().ok());
            match to_bytes(body, usize::MAX).await {
                Ok(body) => PageAnswer {
                    status: head.status.as_u16(),
                    media_type: media_type.unwrap_or_default().to_owned(),
                    body: body.into(),
                },
                Err(_) => PageAnswer::empty(StatusCode::INTERNAL_SERVER_ERROR),
            }
        })
    }

    /// Runs one job that has not begun; false if there is none.
    pub fn work(&self) -> bool {
        let job = locked(&self.jobs).pop_front();
        job.map(|job| job()).is_some()
    }

    fn pages(&self) -> MutexGuard<'_, Vec<(PathBuf, Router)>> {
        locked(&self.pages)
    }
}

impl PageAnswer {
    fn empty(status: StatusCode) -> Self {
        Self {
            status: status.as_u16(),
            media_type: String::new(),
            body: Vec::new(),
        }
    }
}

/// The address of a page, relative to the folder of the site.
fn address(page: usize) -> String {
    format!("page.html?page={page}")
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use serde_json::{Value, json};

    use super::super::words::Command;
    use super::*;
    use isomend_core::mesh::Mesh;
    use isomend_files::io::{WriteOptions, write_path};
    use isomend_files::job::Work;

    struct Names;

    impl CommandRenderer for Names {
        fn command(&self, work: &Work, _: Option<&str>) -> Result<Command, String> {
            Ok(Command::new(work.name()))
        }
    }

    static EVENTS: AtomicUsize = AtomicUsize::new(0);

    fn count(_: usize, text: &str) {
        assert!(text.starts_with("event: ") && text.ends_with("\n\n"));
        EVENTS.fetch_add(1, Ordering::Relaxed);
    }

    fn sent(pages: &InBrowser, page: usize, path: &str, body: &Value) -> PageAnswer {
        let body = body.to_string().into_bytes();
        pages.answer(page, path, Some(("application/json", body)))
    }

    fn state(pages: &InBrowser, page: usize) -> Value {
        let answer = pages.answer(page, "api/state", None);
        assert_eq!(answer.status, 200);
        assert_eq!(answer.media_type, "application/json");
        serde_json::from_slice(&answer.body).unwrap()
    }

    /// A pyramid without its base.
    fn pyramid() -> Mesh {
        let mut mesh = Mesh::new(Vec::new(), Vec::new());
        for [x, y, z] in [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.5, 0.5, 1.0],
        ] {
            mesh.positions.push(glam::DVec3::new(x, y, z));
        }
        mesh.faces = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        mesh
    }

    #[test]
    fn a_step_runs_after_its_request_and_is_kept_for_the_next_program() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.ply");
        write_path(&path, &pyramid(), None, &WriteOptions::default()).unwrap();
        let new = || InBrowser::new(folder.path().into(), Arc::new(Names), count).unwrap();
        let pages = new();
        let page = pages.open(&path, false).unwrap();
        assert_eq!(pages.open(&path, false), Ok(page));
        assert!(!pages.work());
        let step = json!({ "kind": "fill", "params": { "close_outer": true } });
        let refused = sent(&pages, page, "api/step", &step);
        assert_eq!(refused.status, 422, "an unknown parameter");
        let answer = sent(&pages, page, "api/step", &json!({ "kind": "fill" }));
        assert_eq!(answer.status, 202);
        assert!(state(&pages, page)["busy"]["job"].is_u64());
        assert!(pages.work() && !pages.work());
        assert!(EVENTS.load(Ordering::Relaxed) > 1);
        let after = state(&pages, page);
        assert_eq!(after["current"], 1);
        let known = format!("api/state?known={}", after["revision"]);
        let same = pages.answer(page, &known, None).body;
        let same: Value = serde_json::from_slice(&same).unwrap();
        assert_eq!(same["known"], after["revision"]);
        assert_eq!(same["holes"], Value::Null, "what the page has");
        let save = json!({ "kind": "mesh", "path": "whole.ply", "overwrite": false });
        assert_eq!(sent(&pages, page, "api/save", &save).status, 200);
        // Another program repeats the step, although it was saved.
        let again = new();
        let page = again.open(&path, true).unwrap();
        assert!(again.work());
        assert_eq!(state(&again, page)["current"], 1);
    }

    #[test]
    fn what_does_not_exist_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let pages = InBrowser::new(folder.path().into(), Arc::new(Names), count).unwrap();
        assert_eq!(pages.answer(0, "api/state", None).status, 404);
        assert!(pages.open(&folder.path().join("none.ply"), false).is_err());
    }
}
