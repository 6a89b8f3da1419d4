//! The HTTP connections: their number at a time, and the time limit for request headers.
//!
//! A connection is a stranger's until a request on it has the token of a page. Strangers cannot keep others out: a request without a token
//! ends its connection, and where there are too many strangers the oldest one goes, once it has had time for a request.

use std::collections::VecDeque;
use std::future::Future;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use axum::http::HeaderValue;
use axum::http::header::CONNECTION;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::AbortHandle;

use super::pages::Pages;

/// Upper bound of the number of strangers' connections at a time.
const STRANGERS: usize = 64;
/// Time that every stranger has for a request, also where there are too many.
const GRACE: Duration = Duration::from_millis(250);
/// Upper bound of the number of other connections at a time; requests on further ones wait. A browser uses up to six for a page, one of them
/// for events.
const CONNECTIONS: usize = 256;
/// Time limit for the header of a request, also of each further request on the same connection.
const HEAD: Duration = Duration::from_secs(5);
/// Upper bound of the header of a request, in bytes.
const LONGEST_HEAD: usize = 64 << 10;
/// Pause after a failed `accept`, for example when too many files are open.
const PAUSE: Duration = Duration::from_millis(50);

/// Answers requests until the process ends.
///
/// # Errors
/// None at present: the failure of one connection only ends that connection.
pub async fn serve(listener: TcpListener, pages: Arc<Pages>) -> std::io::Result<()> {
    let free = Arc::new(Semaphore::new(CONNECTIONS));
    let strangers = Arc::new(Strangers::default());
    for number in 0u64.. {
        strangers.make_room().await;
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        let own = Own {
            number,
            strangers: strangers.clone(),
            free: free.clone(),
            permit: Mutex::default(),
        };
        strangers.admit(number, answer(stream, pages.clone(), own));
    }
    Ok(())
}

/// Answers the requests of a connection.
async fn answer(stream: TcpStream, pages: Arc<Pages>, own: Own) {
    let own = Arc::new(own);
    let service = service_fn(move |request: Request<Incoming>| {
        let (router, is_known) = pages.of(request.uri().path());
        let own = own.clone();
        async move {
            if is_known {
                own.becomes_known().await;
            }
            let mut answer = TowerToHyperService::new(router).call(request).await?;
            if !is_known {
                let close = HeaderValue::from_static("close");
                answer.headers_mut().insert(CONNECTION, close);
            }
            Ok::<_, std::convert::Infallible>(answer)
        }
    });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD);
    http.max_buf_size(LONGEST_HEAD);
    // An error of this connection does not concern the others.
    let _ = http.serve_connection(TokioIo::new(stream), service).await;
}

/// What a connection holds while it is open.
struct Own {
    number: u64,
    strangers: Arc<Strangers>,
    free: Arc<Semaphore>,
    permit: Mutex<Option<OwnedSemaphorePermit>>,
}

impl Own {
    /// Takes the connection from the strangers, and a permit for it.
    async fn becomes_known(&self) {
        if self.permit().is_some() {
            return;
        }
        self.strangers.remove(self.number);
        // The semaphore is never closed.
        if let Ok(permit) = self.free.clone().acquire_owned().await {
            *self.permit() = Some(permit);
        }
    }

    fn permit(&self) -> MutexGuard<'_, Option<OwnedSemaphorePermit>> {
        self.permit.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Own {
    fn drop(&mut self) {
        self.strangers.remove(self.number);
    }
}

/// A stranger's connection.
struct Stranger {
    number: u64,
    since: Instant,
    task: AbortHandle,
}

/// The strangers' connections, the oldest first.
#[derive(Default)]
struct Strangers(Mutex<VecDeque<Stranger>>);

impl Strangers {
    fn list(&self) -> MutexGuard<'_, VecDeque<Stranger>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until another connection can be added; ends the oldest one if there are too many.
    async fn make_room(&self) {
        while let Some(wait) = self.end_oldest() {
            tokio::time::sleep(wait).await;
        }
    }

    /// Ends the oldest connection if there are too many; returns how long to wait where it has not had its time.
    fn end_oldest(&self) -> Option<Duration> {
        let mut list = self.list();
        if list.len() < STRANGERS {
            return None;
        }
        let left = GRACE.checked_sub(list.front()?.since.elapsed());
        if left.is_some_and(|left| !left.is_zero()) {
            return left;
        }
        let oldest = list.pop_front();
        drop(list);
        oldest?.task.abort();
        None
    }

    /// Adds a connection and starts its task.
    fn admit(&self, number: u64, task: impl Future<Output = ()> + Send + 'static) {
        // Locked until the task is in the list, so that it cannot remove itself before.
        let mut list = self.list();
        list.push_back(Stranger {
            number,
            since: Instant::now(),
            task: tokio::spawn(task).abort_handle(),
        });
    }

    fn remove(&self, number: u64) {
        self.list().retain(|other| other.number != number);
    }
}
