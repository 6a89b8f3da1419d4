//! Other files: those that there are, one that is opened, and one that is sent.

use std::fs::OpenOptions;
use std::io::Write;
use std::sync::Arc;

use axum::body::{Body, to_bytes};
use axum::extract::{Query, State};
use serde::Deserialize;
use serde_json::json;

use super::super::app::App;
use super::super::files::{to_read, to_write};
use super::asked::{Answer, Refused, SMALL, json_answer, long_work, read, work};
use crate::io::Format;

/// Most files that are listed.
const LISTED: usize = 500;
/// Largest file that is sent, in bytes.
const SENT: usize = 1 << 30;

/// `GET api/files`: the meshes in the folder of the program.
pub async fn files(State(app): State<Arc<App>>) -> Answer {
    let names = work(&app, |app| {
        let folder = std::fs::read_dir(&app.root);
        let folder = folder.map_err(|error| Refused::failed(error.to_string()))?;
        let meshes = folder.flatten().filter(|entry| {
            let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
            is_file && Format::from_extension(&entry.path()).is_some()
        });
        let names = meshes.filter_map(|entry| entry.file_name().into_string().ok());
        let mut names: Vec<String> = names.collect();
        names.sort_unstable();
        names.truncate(LISTED);
        Ok(names)
    });
    Ok(json_answer(&json!({ "files": names.await? })))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Wanted {
    path: String,
}

/// `POST api/open`: opens a file below the folder on a page of its own.
pub async fn open(State(app): State<Arc<App>>, body: Body) -> Answer {
    let Wanted { path } = read(body, SMALL).await?;
    let page = long_work(&app, move |app| {
        let path = to_read(&app.root, &path)?;
        (app.open)(path).map_err(|error| Refused::wrong(error, "path"))
    });
    Ok(json_answer(&json!({ "page": page.await? })))
}

#[derive(Deserialize)]
pub struct Named {
    name: String,
}

/// `POST api/send?name=…`: writes a file that was sent into the folder, where none has its name.
pub async fn send(
    State(app): State<Arc<App>>,
    Query(Named { name }): Query<Named>,
    body: Body,
) -> Answer {
    let bytes = to_bytes(body, SENT).await;
    let bytes = bytes.map_err(|_| Refused::wrong("the file is too large", "name"))?;
    let written = work(&app, move |app| {
        let path = to_write(&app.root, &name, false)?;
        if Format::from_extension(&path).is_none() {
            let what = format!("end the name of the file in {}", Format::LIST);
            return Err(Refused::wrong(what, "name"));
        }
        let failed = |error: std::io::Error| Refused::failed(error.to_string());
        // Only a file that is not there, nor a link, is written.
        let mut file = OpenOptions::new();
        let file = file.write(true).create_new(true).open(&path);
        file.and_then(|mut file| file.write_all(&bytes))
            .map_err(failed)?;
        Ok(name)
    });
    Ok(json_answer(&json!({ "path": written.await? })))
}
