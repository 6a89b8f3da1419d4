//! Reads request bodies and writes responses: size and time limits, JSON and binary answers, refusals with a status code.

use std::sync::Arc;
use std::time::Duration;

use axum::body::{Body, Bytes, HttpBody, to_bytes};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::super::app::{App, unless_panicked};
use super::super::files::Denied;

/// Upper bound of the size of a request with marked faces, in bytes.
pub const MARKS: usize = 64 << 20;
/// Upper bound of the size of other requests, in bytes.
pub const SMALL: usize = 64 << 10;
/// Time limit for the arrival of a request's body.
const ARRIVAL: Duration = Duration::from_secs(60);

/// A refused request: status, reason, the field of the request that is wrong, and the name of a file that was not to be replaced.
pub struct Refused {
    status: StatusCode,
    error: String,
    field: Option<&'static str>,
    exists: Option<String>,
}

/// A response, or why the request was refused.
pub type Answer = Result<Response, Refused>;

impl Refused {
    /// 422: the request is invalid; `field` names its wrong part.
    pub fn wrong(error: impl Into<String>, field: &'static str) -> Self {
        Self {
            field: Some(field),
            ..Self::new(StatusCode::UNPROCESSABLE_ENTITY, error)
        }
    }

    /// 409: another job is running, or a file exists already.
    pub fn conflict(error: impl Into<String>) -> Self {
        Self::new(StatusCode::CONFLICT, error)
    }

    /// 409: a file of this name exists, and was not to be replaced.
    pub fn exists(name: String) -> Self {
        Self {
            exists: Some(name.clone()),
            ..Self::conflict(Denied::Exists(name).words())
        }
    }

    /// 404: the requested item does not exist.
    pub fn missing(error: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_FOUND, error)
    }

    /// 403: access is not allowed.
    pub fn forbidden(error: impl Into<String>) -> Self {
        Self::new(StatusCode::FORBIDDEN, error)
    }

    /// 500: the work failed.
    pub fn failed(error: impl Into<String>) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, error)
    }

    fn new(status: StatusCode, error: impl Into<String>) -> Self {
        let error = error.into();
        Self {
            status,
            error,
            field: None,
            exists: None,
        }
    }
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        let body = json!({ "error": self.error, "where": self.field, "exists": self.exists });
        let mut answer = json_answer(&body);
        *answer.status_mut() = self.status;
        answer
    }
}

/// A response with a JSON body.
pub fn json_answer(value: &Value) -> Response {
    ([(CONTENT_TYPE, "application/json")], value.to_string()).into_response()
}

/// A response with a binary body.
pub fn bytes_answer(bytes: Vec<u8>) -> Response {
    ([(CONTENT_TYPE, "application/octet-stream")], bytes).into_response()
}

/// Parses the body of a request as JSON.
///
/// # Errors
/// When the body is larger than `most` bytes, arrives too slowly or is not the expected JSON.
pub async fn read<T: DeserializeOwned>(body: Body, most: usize) -> Result<T, Refused> {
    let bytes = receive(body, most, ARRIVAL).await?;
    serde_json::from_slice(&bytes)
        .map_err(|error| Refused::new(StatusCode::BAD_REQUEST, error.to_string()))
}

/// Receives the body of a request.
///
/// # Errors
/// When the body is larger than `most` bytes, does not arrive in time or breaks off.
pub async fn receive(body: Body, most: usize, within: Duration) -> Result<Bytes, Refused> {
    let too_large = || {
        let error =
            format!("the request cannot be read: it broke off, or has more than {most} bytes");
        Refused::new(StatusCode::PAYLOAD_TOO_LARGE, error)
    };
    // Refuse by the declared length, before any of the body is read.
    if body.size_hint().lower() > most as u64 {
        return Err(too_large());
    }
    let bytes = tokio::time::timeout(within, to_bytes(body, most)).await;
    let too_slow = |_| {
        let error = format!("the request did not arrive within {} s", within.as_secs());
        Refused::new(StatusCode::REQUEST_TIMEOUT, error)
    };
    let bytes = bytes.map_err(too_slow)?;
    bytes.map_err(|_| too_large())
}

/// Runs short work on a blocking thread, so that the threads that serve connections stay free.
///
/// # Errors
/// The error of the work, or a failure if it panicked.
pub async fn work<T: Send + Sync + 'static, R: Send + 'static>(
    app: &Arc<T>,
    work: impl FnOnce(&T) -> Result<R, Refused> + Send + 'static,
) -> Result<R, Refused> {
    let app = app.clone();
    let done = blocking(move || unless_panicked(|| work(&app))).await?;
    done.map_err(Refused::failed)?
}

/// Runs work on a blocking thread. The work is boxed and sends its result through a channel, so that Tokio's task is compiled once for all
/// kinds of work.
#[cfg(not(target_family = "wasm"))]
async fn blocking<R: Send + 'static>(
    work: impl FnOnce() -> R + Send + 'static,
) -> Result<R, Refused> {
    let (sender, receiver) = tokio::sync::oneshot::channel();
    let run: Box<dyn FnOnce() + Send> = Box::new(move || {
        // The receiver is gone if the request was given up; then nobody needs the result.
        let _ = sender.send(work());
    });
    let task = tokio::task::spawn_blocking(run);
    match receiver.await {
        Ok(result) => Ok(result),
        // The work panicked, or the runtime shuts down: the task has the reason.
        Err(closed) => Err(Refused::failed(match task.await {
            Err(error) => error.to_string(),
            Ok(()) => closed.to_string(),
        })),
    }
}

/// Runs work at once: there are no other threads.
#[cfg(target_family = "wasm")]
async fn blocking<R>(work: impl FnOnce() -> R) -> Result<R, Refused> {
    Ok(work())
}

/// Runs long work on the thread pool for requests.
///
/// # Errors
/// As [`work`].
pub async fn long_work<R: Send + 'static>(
    app: &Arc<App>,
    long: impl FnOnce(&App) -> Result<R, Refused> + Send + 'static,
) -> Result<R, Refused> {
    work(app, |app: &App| app.host.aside.install(|| long(app))).await
}
