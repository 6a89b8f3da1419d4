//! The HTTP API of the local page: its routes.

mod choices;
mod deliver;
mod download;
mod http;
mod masks;
mod mesh;
mod open;
mod print;
mod save;
#[cfg(not(target_family = "wasm"))]
mod start;
mod state;
mod steps;
mod values;

use std::sync::Arc;

use axum::Router;

use axum::extract::Path;
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::{get, post};

use super::app::App;
use super::assets;
#[cfg(not(target_family = "wasm"))]
pub use start::start_router;

/// All routes of one page. The first part of each path is a name of the page that its gate checks.
pub fn router(app: Arc<App>) -> Router {
    Router::new()
        .route("/{token}", get(with_slash))
        .route("/{token}/", get(|| file(String::new())))
        .route(
            "/{token}/{file}",
            get(|Path((_, name)): Path<(String, String)>| file(name)),
        )
        .route("/{token}/api/state", get(state::state))
        .route("/{token}/api/events", get(state::events))
        .route("/{token}/api/mesh/{id}", get(mesh::mesh))
        .route("/{token}/api/coarse/{id}", get(mesh::coarse))
        .route("/{token}/api/rims/{id}", get(mesh::rims))
        .route("/{token}/api/choices", post(choices::choose))
        .route("/{token}/api/marks/{id}", get(choices::marks))
        .route("/{token}/api/masks/{id}", get(masks::faces))
        .route("/{token}/api/mask/keep", post(masks::keep))
        .route("/{token}/api/mask/drop", post(masks::remove))
        .route("/{token}/api/step", post(steps::step))
        .route("/{token}/api/cancel", post(steps::cancel))
        .route("/{token}/api/undo", post(steps::undo))
        .route("/{token}/api/redo", post(steps::redo))
        .route("/{token}/api/goto", post(steps::go_to))
        .route("/{token}/api/adopt", post(steps::adopt))
        .route("/{token}/api/discard", post(steps::discard))
        .route("/{token}/api/save", post(save::save))
        .route("/{token}/api/recipe", get(save::recipe))
        .route("/{token}/api/report/{id}", get(save::report))
        .route("/{token}/api/mask/load", post(save::load_mask))
        .route("/{token}/api/download/{id}", get(download::download))
        .route("/{token}/api/deliver/{id}", get(deliver::figures))
        .route("/{token}/api/files", get(open::files))
        .route("/{token}/api/folder", post(open::folder))
        .route("/{token}/api/open", post(open::open))
        .route("/{token}/api/send", post(open::send))
        .route("/{token}/api/values/{id}", get(values::values))
        .route("/{token}/api/check/{id}", get(values::check))
        .route("/{token}/api/walls/{id}", get(print::walls))
        .route("/{token}/api/components/{id}", get(print::components))
        .route("/{token}/api/uv/{id}", get(values::uvs))
        .route("/{token}/api/texture/{number}", get(values::texture))
        .fallback(|| async { StatusCode::NOT_FOUND })
        .with_state(app)
}

/// Redirects the address of the page without its trailing slash.
async fn with_slash(Path(token): Path<String>) -> Redirect {
    Redirect::permanent(&format!("/{token}/"))
}

/// Serves a file of the page.
async fn file(name: String) -> Response {
    served(assets::asset(&name))
}

/// A file of a page, or that there is none of its name.
fn served(asset: Option<(&'static str, String)>) -> Response {
    match asset {
        Some((kind, text)) => ([(CONTENT_TYPE, kind)], text).into_response(),
        None => StatusCode::NOT_FOUND.into_response(),
    }
}
