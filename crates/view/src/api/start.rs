//! The start page of a folder: lists its meshes, opens them, and takes dropped files.

use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::routing::{get, post};

use super::super::app::Host;
use super::super::assets;
use super::http::{Answer, SMALL, json_answer, read, work};
use super::open::{FileName, listed, opened, sent};
use super::{served, with_slash};

/// All routes of the start page. The first part of each path is a name of the page that its gate checks.
pub fn start_router(host: Arc<Host>) -> Router {
    Router::new()
        .route("/{token}", get(with_slash))
        .route(
            "/{token}/",
            get(|| async { served(assets::start_asset("")) }),
        )
        .route(
            "/{token}/{file}",
            get(|Path((_, name)): Path<(String, String)>| async move {
                served(assets::start_asset(&name))
            }),
        )
        .route("/{token}/api/files", get(files))
        .route("/{token}/api/open", post(open))
        .route("/{token}/api/send", post(send))
        .fallback(|| async { StatusCode::NOT_FOUND })
        .with_state(host)
}

/// `GET api/files`: as on the page of a mesh.
async fn files(State(host): State<Arc<Host>>) -> Answer {
    let found = work(&host, |host| listed(host, None));
    Ok(json_answer(&found.await?))
}

/// `POST api/open`: as on the page of a mesh.
async fn open(State(host): State<Arc<Host>>, body: Body) -> Answer {
    let wanted = read(body, SMALL).await?;
    let page = work(&host, move |host| opened(host, None, &wanted));
    Ok(json_answer(&page.await?))
}

/// `POST api/send?name=…`: as on the page of a mesh.
async fn send(State(host): State<Arc<Host>>, Query(file): Query<FileName>, body: Body) -> Answer {
    sent(&host, |host| host, file, body).await
}
