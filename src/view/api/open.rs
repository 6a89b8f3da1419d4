//! Other files: those that there are, one that is opened, and one that is sent.

use std::io::ErrorKind;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::{Query, State};
use serde::Deserialize;
use serde_json::json;
use tokio::sync::Semaphore;

use super::super::app::App;
use super::super::files::{to_read, to_write};
use super::asked::{Answer, Refused, SMALL, json_answer, read, receive, work};
use crate::io::{Format, write_new};

/// Most files that are listed.
const LISTED: usize = 500;
/// Largest file that is sent, in bytes.
const SENT: usize = 1 << 30;
/// Longest time that a file may take to arrive: 1 GiB at 2 MB/s, as through a tunnel to another machine.
const SENDING: Duration = Duration::from_secs(600);
/// One file is received at a time: each is held in memory until it is whole.
static UPLOAD: Semaphore = Semaphore::const_new(1);

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
    // Not on a thread of a pool: see `Shared::opening`.
    let page = work(&app, move |app| {
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
    // The name is checked before the body is received: a file that is refused need not be sent.
    let checked = name.clone();
    let path = work(&app, move |app| {
        let path = to_write(&app.root, &checked, false)?;
        match Format::from_extension(&path) {
            Some(_) => Ok(path),
            None => {
                let what = format!("end the name of the file in {}", Format::LIST);
                Err(Refused::wrong(what, "name"))
            }
        }
    });
    let path = path.await?;
    let upload = UPLOAD.try_acquire();
    let upload = upload.map_err(|_| Refused::conflict("another file is being sent; try again"))?;
    let bytes = receive(body, SENT, SENDING).await?;
    let written = work(&app, move |_| {
        let written = write_new(&path, &bytes);
        drop(upload);
        written.map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => Refused::conflict(format!("{name} is there already")),
            _ => Refused::failed(error.to_string()),
        })?;
        Ok(name)
    });
    Ok(json_answer(&json!({ "path": written.await? })))
}
