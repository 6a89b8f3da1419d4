//! API requests for the user's choices on a mesh: actions on holes, sharp edges, marked faces.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Path, State};
use serde_json::json;

use super::super::app::App;
use super::super::choices::Change;
use super::http::{Answer, MARKS, Refused, json_answer, read, work};

/// `POST api/choices`: changes the actions on holes, the pairs of crease ends and the marked faces.
pub async fn choose(State(app): State<Arc<App>>, body: Body) -> Answer {
    let change: Change = read(body, MARKS).await?;
    let done = work(&app, move |app| {
        let chosen = app.session().choose(&change);
        let chosen = chosen.ok_or_else(|| {
            Refused::missing("there is no mesh with this number; reload the page")
        })?;
        chosen.map_err(|(error, place)| Refused::wrong(error, place))?;
        app.store_session();
        Ok(())
    });
    done.await?;
    Ok(json_answer(&json!({})))
}

/// `GET api/marks/ID`: the marked faces.
pub async fn marks(State(app): State<Arc<App>>, Path((_, id)): Path<(String, u32)>) -> Answer {
    let session = app.session();
    if session.state(id).is_none() {
        return Err(Refused::missing(
            "there is no mesh with this number; reload the page",
        ));
    }
    Ok(json_answer(&json!({ "runs": session.choices(id).mask() })))
}
