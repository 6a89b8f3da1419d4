//! Requests read and answers written.

use std::sync::Arc;
use std::time::Duration;

use axum::body::{Body, Bytes, HttpBody, to_bytes};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::super::app::{App, unless_panicked};

/// Most bytes of a request with marks of faces.
pub const MARKS: usize = 64 << 20;
/// Most bytes of other requests.
pub const SMALL: usize = 64 << 10;
/// Longest time that a request may take to arrive.
const ARRIVAL: Duration = Duration::from_secs(60);

/// Why a request is not answered as asked.
pub struct Refused {
    status: StatusCode,
    error: String,
    place: Option<&'static str>,
}

/// An answer, or why there is none.
pub type Answer = Result<Response, Refused>;

impl Refused {
    /// What was asked for makes no sense.
    pub fn wrong(error: impl Into<String>, place: &'static str) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, error).at(place)
    }

    /// Something else is being done, or is there.
    pub fn conflict(error: impl Into<String>) -> Self {
        Self::new(StatusCode::CONFLICT, error)
    }

    /// There is no such thing.
    pub fn missing(error: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_FOUND, error)
    }

    /// It may not be.
    pub fn forbidden(error: impl Into<String>) -> Self {
        Self::new(StatusCode::FORBIDDEN, error)
    }

    /// It was tried, and failed.
    pub fn failed(error: impl Into<String>) -> Self {
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, error)
    }

    fn new(status: StatusCode, error: impl Into<String>) -> Self {
        let error = error.into();
        Self {
            status,
            error,
            place: None,
        }
    }

    fn at(self, place: &'static str) -> Self {
        let place = Some(place);
        Self { place, ..self }
    }
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        let mut answer = json_answer(&json!({ "error": self.error, "where": self.place }));
        *answer.status_mut() = self.status;
        answer
    }
}

/// JSON as an answer.
pub fn json_answer(value: &Value) -> Response {
    ([(CONTENT_TYPE, "application/json")], value.to_string()).into_response()
}

/// Bytes as an answer.
pub fn bytes_answer(bytes: Vec<u8>) -> Response {
    ([(CONTENT_TYPE, "application/octet-stream")], bytes).into_response()
}

/// The body of a request of bounded size, as JSON.
///
/// # Errors
/// When it is too large, too slow or something else.
pub async fn read<T: DeserializeOwned>(body: Body, most: usize) -> Result<T, Refused> {
    let bytes = receive(body, most, ARRIVAL).await?;
    serde_json::from_slice(&bytes)
        .map_err(|error| Refused::new(StatusCode::BAD_REQUEST, error.to_string()))
}

/// The body of a request, of at most `most` bytes, that arrives within a time.
///
/// # Errors
/// When it is too large, too slow or breaks off.
pub async fn receive(body: Body, most: usize, within: Duration) -> Result<Bytes, Refused> {
    let too_large = || {
        let error = format!("the request could not be read, or has more than {most} bytes");
        Refused::new(StatusCode::PAYLOAD_TOO_LARGE, error)
    };
    // As its header says, before any of it is read.
    if body.size_hint().lower() > most as u64 {
        return Err(too_large());
    }
    let bytes = tokio::time::timeout(within, to_bytes(body, most)).await;
    let bytes = bytes.map_err(|_| Refused::new(StatusCode::REQUEST_TIMEOUT, "too slow"))?;
    bytes.map_err(|_| too_large())
}

/// Does something that takes a moment, away from the threads that listen.
///
/// # Errors
/// Its own, and that it panicked.
pub async fn work<R: Send + 'static>(
    app: &Arc<App>,
    work: impl FnOnce(&App) -> Result<R, Refused> + Send + 'static,
) -> Result<R, Refused> {
    let app = app.clone();
    let done = tokio::task::spawn_blocking(move || unless_panicked(|| work(&app))).await;
    done.map_err(|error| Refused::failed(error.to_string()))?
        .map_err(Refused::failed)?
}

/// Does something that takes long, on several threads.
///
/// # Errors
/// As [`work`].
pub async fn long_work<R: Send + 'static>(
    app: &Arc<App>,
    long: impl FnOnce(&App) -> Result<R, Refused> + Send + 'static,
) -> Result<R, Refused> {
    work(app, |app| app.aside.install(|| long(app))).await
}
