//! API requests for masks under a name.

use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Path, Query, State};
use serde::Deserialize;
use serde_json::json;

use super::super::app::App;
use super::super::named::NamedMask;
use super::super::runs::Runs;
use super::http::{Answer, MARKS, Refused, SMALL, json_answer, read, work};

const NO_MESH: &str = "there is no mesh with this number; reload the page";
const NO_MASK: &str = "there is no mask of this name; reload the page";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeepRequest {
    id: u32,
    name: String,
    mask: Runs,
}

/// `POST api/mask/keep`: stores a mask of a mesh under a name; it replaces the mask of the same name.
pub async fn keep(State(app): State<Arc<App>>, body: Body) -> Answer {
    let KeepRequest { id, name, mask } = read(body, MARKS).await?;
    let mask = NamedMask {
        name,
        faces: mask,
        gone: 0,
    };
    let done = work(&app, move |app| {
        let kept = app.session().keep_mask(id, mask);
        let kept = kept.ok_or_else(|| Refused::missing(NO_MESH))?;
        kept.map_err(|(error, place)| Refused::wrong(error, place))?;
        app.changed();
        Ok(())
    });
    done.await?;
    Ok(json_answer(&json!({})))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaskName {
    name: String,
}

/// `POST api/mask/drop`: removes the mask of a name.
pub async fn remove(State(app): State<Arc<App>>, body: Body) -> Answer {
    let MaskName { name } = read(body, SMALL).await?;
    let done = work(&app, move |app| {
        if !app.session().drop_mask(&name) {
            return Err(Refused::missing(NO_MASK));
        }
        app.changed();
        Ok(())
    });
    done.await?;
    Ok(json_answer(&json!({})))
}

/// `GET api/masks/ID?name=…`: the faces of a named mask on a mesh.
pub async fn faces(
    State(app): State<Arc<App>>,
    Path((_, id)): Path<(String, u32)>,
    Query(MaskName { name }): Query<MaskName>,
) -> Answer {
    let choices = {
        let session = app.session();
        if session.state(id).is_none() {
            return Err(Refused::missing(NO_MESH));
        }
        session.choices(id)
    };
    let mask = choices.named.find(&name);
    let mask = mask.ok_or_else(|| Refused::missing(NO_MASK))?;
    Ok(json_answer(&json!({ "runs": mask.faces })))
}
