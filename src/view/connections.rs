//! The HTTP connections: their number at a time, and the time limit for request headers.

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

/// Upper bound of the number of connections at a time; further ones wait. A browser uses up to six for a page, one of them for events.
const CONNECTIONS: usize = 64;
/// Time limit for the header of a request, also of each further request on the same connection.
const HEAD: Duration = Duration::from_secs(5);
/// Pause after a failed `accept`, for example when too many files are open.
const PAUSE: Duration = Duration::from_millis(50);

/// Answers requests until the process ends.
///
/// # Errors
/// None at present: the failure of one connection only ends that connection.
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
            // An error of this connection does not concern the others.
            let _ = http.serve_connection(TokioIo::new(stream), service).await;
            drop(own);
        });
    }
}
