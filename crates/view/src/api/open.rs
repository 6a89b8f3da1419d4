//! API requests that list the meshes in the folder and the recent files, open another file, upload a file, and make a folder.

use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::{Query, State};
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::sync::Semaphore;

use super::super::app::{App, Host, error_text};
use super::super::files::{to_make, to_read, to_write};
use super::super::recent::{recent, record};
use super::http::{Answer, Refused, SMALL, json_answer, read, receive, work};
use isomend_files::io::{Format, read_path, write_new};

/// Upper bound of the number of listed files.
const LISTED: usize = 10_000;
/// Upper bound of the size of an uploaded file, in bytes.
const MAX_UPLOAD: usize = 1 << 30;
/// Time limit of an upload: 1 GiB at 2 MB/s, as through a tunnel to another machine.
const UPLOAD_TIME: Duration = Duration::from_secs(600);
/// Only one file is uploaded at a time, since each is held in memory until it is complete.
static UPLOAD: Semaphore = Semaphore::const_new(1);

/// `GET api/files`: the meshes in the folder with their sizes in bytes, and the names of the files that were opened lately.
pub async fn files(State(app): State<Arc<App>>) -> Answer {
    let found = work(&app, |app| listed(&app.host, Some(&app.input)));
    Ok(json_answer(&found.await?))
}

/// The meshes in the folder of a page, and the recent files, as JSON; `input` is the file that is open on it.
///
/// # Errors
/// When the folder cannot be read.
pub fn listed(host: &Host, input: Option<&Path>) -> Result<Value, Refused> {
    let folder = std::fs::read_dir(&host.root);
    let folder = folder.map_err(|error| Refused::failed(error.to_string()))?;
    let meshes = folder.flatten().filter_map(|entry| {
        let about = entry.metadata().ok()?;
        Format::from_extension(&entry.path()).filter(|_| about.is_file())?;
        Some((entry.file_name().into_string().ok()?, about.len()))
    });
    let mut meshes: Vec<(String, u64)> = meshes.collect();
    meshes.sort_unstable();
    meshes.truncate(LISTED);
    let (names, sizes): (Vec<String>, Vec<u64>) = meshes.into_iter().unzip();
    let recent = recent(
        &host.kept.recent(),
        &host.root,
        input.unwrap_or(Path::new("")),
    );
    Ok(
        json!({ "files": names, "sizes": sizes, "recent": recent, "root": host.root.display().to_string() }),
    )
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OpenRequest {
    path: String,
}

/// `POST api/open`: opens a file below the folder on its own page, and returns the page's path.
pub async fn open(State(app): State<Arc<App>>, body: Body) -> Answer {
    let wanted = read(body, SMALL).await?;
    // Not on a thread of a rayon pool: see `Shared::opening`.
    let page = work(&app, move |app| {
        opened(&app.host, Some(&app.input), &wanted)
    });
    Ok(json_answer(&page.await?))
}

/// Opens a file below the folder of a page, as JSON with the path of its own page; `input` is the file that is open on it.
///
/// # Errors
/// When the file may not be read, or is no mesh.
pub fn opened(host: &Host, input: Option<&Path>, wanted: &OpenRequest) -> Result<Value, Refused> {
    let path = to_read(&host.root, &wanted.path)?;
    let page = (host.open)(path.clone());
    let page = page.map_err(|error| Refused::wrong(error, "path"))?;
    let files: Vec<&Path> = input.into_iter().chain([path.as_path()]).collect();
    record(&host.kept.recent(), &host.root, &files);
    Ok(json!({ "page": page }))
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

/// `POST api/send?name=…`: writes an uploaded mesh into the folder.
pub async fn send(State(app): State<Arc<App>>, Query(file): Query<FileName>, body: Body) -> Answer {
    sent(&app, |app| &app.host, file, body).await
}

/// Receives a mesh and writes it into the folder of a page. A file with the same name and content is there already, and one with the
/// same name and another content is an error. A file that cannot be read as a mesh is not left behind.
///
/// # Errors
/// When the name or the mesh is invalid, or the file cannot be written.
pub async fn sent<T: Send + Sync + 'static>(
    page: &Arc<T>,
    host: fn(&T) -> &Host,
    FileName { name }: FileName,
    body: Body,
) -> Answer {
    // Check the name before receiving the body, so that a refused file is not uploaded.
    let checked = name.clone();
    let path = work(page, move |page| {
        let path = to_write(&host(page).root, &checked, true)?;
        match Format::from_extension(&path) {
            Some(_) => Ok(path),
            None => {
                let what = format!(
                    "{checked} is no mesh: its name must end in {}",
                    Format::LIST
                );
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
    let written = work(page, move |_| {
        let written = write_mesh(&path, &name, &bytes);
        drop(upload);
        written.map(|()| name)
    });
    Ok(json_answer(&json!({ "path": written.await? })))
}

/// Writes the bytes of a mesh to a new file, and removes it if it cannot be read.
fn write_mesh(path: &Path, name: &str, bytes: &[u8]) -> Result<(), Refused> {
    if let Err(error) = write_new(path, bytes) {
        if error.kind() != ErrorKind::AlreadyExists {
            return Err(Refused::failed(error.to_string()));
        }
        let is_as_long = std::fs::metadata(path).is_ok_and(|m| m.len() == bytes.len() as u64);
        let is_same = is_as_long && std::fs::read(path).is_ok_and(|there| there == bytes);
        return match is_same {
            true => Ok(()),
            false => Err(Refused::conflict(format!(
                "the folder has another file {name}: rename one of them"
            ))),
        };
    }
    read_path(path, None).map(drop).map_err(|error| {
        let _ = std::fs::remove_file(path);
        Refused::wrong(error_text(&error), "name")
    })
}
