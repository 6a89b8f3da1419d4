//! API requests that run steps, cancel, undo and redo them, and adopt or discard previews.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::IntoResponse;
use serde::Deserialize;
use serde_json::json;

use super::super::app::App;
use super::super::session::Session;
use super::super::step::{Request, StepRefusal};
use super::http::{Answer, MARKS, Refused, SMALL, json_answer, read, work};

const BUSY: &str = "another step is running; wait for it, or cancel it";

impl From<StepRefusal> for Refused {
    fn from(refusal: StepRefusal) -> Self {
        match refusal {
            StepRefusal::Wrong { error, field } => Self::wrong(error, field),
            StepRefusal::Template(denied) => denied.into(),
        }
    }
}

/// `POST api/step`: starts a step or a preview, and returns the number of its job.
pub async fn step(State(app): State<Arc<App>>, body: Body) -> Answer {
    let request: Request = read(body, MARKS).await?;
    let preview = request.preview;
    let faces = {
        let session = app.session();
        if session.busy.is_some() {
            return Err(Refused::conflict(BUSY));
        }
        session.current().loaded.mesh.faces.len()
    };
    // Checking a template looks for its file.
    let checked = work(&app, move |app| Ok(request.order(&app.scope(faces))?));
    let order = checked.await?;
    match app.begin(order, preview) {
        Ok(Some(job)) => {
            let mut answer = json_answer(&json!({ "job": job }));
            *answer.status_mut() = StatusCode::ACCEPTED;
            Ok(answer)
        }
        Ok(None) => Err(Refused::conflict(BUSY)),
        Err(error) => Err(Refused::failed(error.to_string())),
    }
}

#[derive(Deserialize)]
struct OfJob {
    job: u64,
}

/// `POST api/cancel`: stops a job as soon as possible.
pub async fn cancel(State(app): State<Arc<App>>, body: Body) -> Answer {
    let OfJob { job } = read(body, SMALL).await?;
    let session = app.session();
    match session.busy.as_ref().filter(|busy| busy.job == job) {
        Some(busy) => {
            busy.cancel.cancel();
            Ok(StatusCode::ACCEPTED.into_response())
        }
        None => Err(Refused::missing(
            "there is no job with this number, or it has ended",
        )),
    }
}

#[derive(Deserialize)]
struct OfState {
    id: u32,
}

/// `POST api/undo`.
pub async fn undo(State(app): State<Arc<App>>) -> Answer {
    change_session(&app, |s| match s.go(false) {
        true => Ok(()),
        false => Err(Refused::conflict("there is nothing to undo")),
    })
}

/// `POST api/redo`.
pub async fn redo(State(app): State<Arc<App>>) -> Answer {
    change_session(&app, |s| match s.go(true) {
        true => Ok(()),
        false => Err(Refused::conflict("there is nothing to redo")),
    })
}

/// `POST api/goto`: makes a mesh of the history the current one.
pub async fn go_to(State(app): State<Arc<App>>, body: Body) -> Answer {
    let OfState { id } = read(body, SMALL).await?;
    change_session(&app, |s| match s.go_to(id) {
        true => Ok(()),
        false => Err(Refused::missing("the history has no mesh with this number")),
    })
}

/// `POST api/adopt`: makes a preview the next step.
pub async fn adopt(State(app): State<Arc<App>>, body: Body) -> Answer {
    let OfState { id } = read(body, SMALL).await?;
    change_session(&app, |s| s.adopt(id).map_err(Refused::conflict))
}

/// `POST api/discard`: deletes a preview.
pub async fn discard(State(app): State<Arc<App>>, body: Body) -> Answer {
    let OfState { id } = read(body, SMALL).await?;
    change_session(&app, |s| match s.discard(id) {
        true => Ok(()),
        false => Err(Refused::missing("there is no such preview")),
    })
}

/// Changes the session unless a step is running, and returns the number of the current mesh.
fn change_session(
    app: &Arc<App>,
    change: impl FnOnce(&mut Session) -> Result<(), Refused>,
) -> Answer {
    let current = {
        let mut session = app.session();
        if session.busy.is_some() {
            return Err(Refused::conflict(BUSY));
        }
        change(&mut session)?;
        session.current().id
    };
    app.changed();
    Ok(json_answer(&json!({ "current": current })))
}
