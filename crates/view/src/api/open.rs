//! API requests that list the meshes in the folder and the recent files, open another file, upload a file, and make a folder.

use std::io::ErrorKind;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::{Query, State};
use serde::Deserialize;
use serde_json::json;
use tokio::sync::Semaphore;

use super::super::app::App;
use super::super::files::{to_make, to_read, to_write};
use super::super::recent::{recent, record};
use super::http::{Answer, Refused, SMALL, json_answer, read, receive, work};
use isomend_files::io::{Format, write_new};

/// Upper bound of the number of listed files.
const LISTED: usize = 500;
/// Upper bound of the size of an uploaded file, in bytes.
const MAX_UPLOAD: usize = 1 << 30;
/// Time limit of an upload: 1 GiB at 2 MB/s, as through a tunnel to another machine.
const UPLOAD_TIME: Duration = Duration::from_secs(600);
/// Only one file is uploaded at a time, since each is held in memory until it is complete.
static UPLOAD: Semaphore = Semaphore::const_new(1);

/// `GET api/files`: the names of the meshes in the folder, and of the files that were opened lately.
pub async fn files(State(app): State<Arc<App>>) -> Answer {
    let names = work(&app, |app| {
        let folder = std::fs::read_dir(&app.host.root);
        let folder = folder.map_err(|error| Refused::failed(error.to_string()))?;
        let meshes = folder.flatten().filter(|entry| {
            let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
            is_file && Format::from_extension(&entry.path()).is_some()
        });
        let names = meshes.filter_map(|entry| entry.file_name().into_string().ok());
        let mut names: Vec<String> = names.collect();
        names.sort_unstable();
        names.truncate(LISTED);
        Ok((
            names,
            recent(&app.host.kept.recent(), &app.host.root, &app.input),
        ))
    });
    let (names, recent) = names.await?;
    Ok(json_answer(&json!({ "files": names, "recent": recent })))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OpenRequest {
    path: String,
}

/// `POST api/open`: opens a file below the folder on its own page, and returns the page's path.
pub async fn open(State(app): State<Arc<App>>, body: Body) -> Answer {
    let OpenRequest { path } = read(body, SMALL).await?;
    // Not on a thread of a rayon pool: see `Shared::opening`.
    let page = work(&app, move |app| {
        let path = to_read(&app.host.root, &path)?;
        let page = (app.host.open)(path.clone());
        let page = page.map_err(|error| Refused::wrong(error, "path"))?;
        record(
            &app.host.kept.recent(),
            &app.host.root,
            &[&app.input, &path],
        );
        Ok(page)
    });
    Ok(json_answer(&json!({ "page": page.await? })))
}

/// `POST api/folder`: makes a folder below the folder; refused if something of this name exists.
pub async fn folder(State(app): State<Arc<App>>, body: Body) -> Answer {
    let OpenRequest { path } = read(body, SMALL).await?;
    let made = work(&app, move |app| {
        let folder = to_make(&app.host.root, &path)?;
        std::fs::create_dir(&folder).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => Refused::conflict(format!("{path} exists already")),
            _ => Refused::failed(format!("{path} cannot be made: {error}")),
        })?;
        Ok(app.shown(&folder))
    });
    Ok(json_answer(&json!({ "path": made.await? })))
}

#[derive(Deserialize)]
pub struct FileName {
    name: String,
}

/// `POST api/send?name=…`: writes an uploaded file into the folder; refused if a file of this name exists.
pub async fn send(
    State(app): State<Arc<App>>,
    Query(FileName { name }): Query<FileName>,
    body: Body,
) -> Answer {
    // Check the name before receiving the body, so that a refused file is not uploaded.
    let checked = name.clone();
    let path = work(&app, move |app| {
        let path = to_write(&app.host.root, &checked, false)?;
        match Format::from_extension(&path) {
            Some(_) => Ok(path),
            None => {
                let what = format!("the name of the file must end in {}", Format::LIST);
                Err(Refused::wrong(what, "name"))
            }
        }
    });
    let path = path.await?;
    let upload = UPLOAD.try_acquire();
    let upload = upload.map_err(|_| {
        Refused::conflict("another file is being uploaded; try again when it has arrived")
    })?;
    let bytes = receive(body, MAX_UPLOAD, UPLOAD_TIME).await?;
    let written = work(&app, move |_| {
        let written = write_new(&path, &bytes);
        drop(upload);
        written.map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => Refused::conflict(format!("{name} exists already")),
            _ => Refused::failed(error.to_string()),
        })?;
        Ok(name)
    });
    Ok(json_answer(&json!({ "path": written.await? })))
}
