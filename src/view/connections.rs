//! Connections: how many there are at a time, and how long they may take to say what they want.

use std::sync::Arc;
use std::time::Duration;

use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;

use super::pages::Pages;

/// Most connections at a time: a browser has up to six for a page, one of which hears what happens. More wait until one ends.
const CONNECTIONS: usize = 64;
/// Longest time until the head of a request is there, also of the next one on the same connection.
const HEAD: Duration = Duration::from_secs(5);
/// Pause after a connection that could not be taken, such as when there are too many files open.
const PAUSE: Duration = Duration::from_millis(50);

/// Answers requests until the process ends.
///
/// # Errors
/// None: a connection that fails is one that ends.
pub async fn serve(listener: TcpListener, pages: Arc<Pages>) -> std::io::Result<()> {
    let free = Arc::new(Semaphore::new(CONNECTIONS));
    loop {
        let own = free.clone().acquire_owned().await;
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        let pages = pages.clone();
        let service = service_fn(move |request: Request<Incoming>| {
            let router = pages.of(request.uri().path());
            async move { TowerToHyperService::new(router).call(request).await }
        });
        tokio::spawn(async move {
            let mut http = http1::Builder::new();
            http.timer(TokioTimer::new()).header_read_timeout(HEAD);
            // One that breaks off concerns nobody else.
            let _ = http.serve_connection(TokioIo::new(stream), service).await;
            drop(own);
        });
    }
}
