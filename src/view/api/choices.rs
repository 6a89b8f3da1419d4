//! What is chosen on a mesh: told by the page, and asked for.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Path, State};
use serde_json::json;

use super::super::app::App;
use super::super::choices::Change;
use super::asked::{Answer, MARKS, Refused, json_answer, read, work};

/// `POST api/choices`: what is to be done with holes, and which faces are marked.
pub async fn choose(State(app): State<Arc<App>>, body: Body) -> Answer {
    let change: Change = read(body, MARKS).await?;
    let done = work(&app, move |app| {
        let chosen = app.session().choose(&change);
        let chosen = chosen.ok_or_else(|| Refused::missing("there is no such mesh"))?;
        chosen.map_err(|(error, place)| Refused::wrong(error, place))?;
        app.keep();
        Ok(())
    });
    done.await?;
    Ok(json_answer(&json!({})))
}

/// `GET api/marks/ID`: the faces that are marked.
pub async fn marks(State(app): State<Arc<App>>, Path((_, id)): Path<(String, u32)>) -> Answer {
    let session = app.session();
    if session.state(id).is_none() {
        return Err(Refused::missing("there is no such mesh"));
    }
    Ok(json_answer(&json!({ "runs": session.choices(id).mask() })))
}
