//! API request that downloads a mesh to the computer of the browser.

use std::sync::Arc;

use axum::extract::{Path, Query, State};
use serde::Deserialize;

use super::super::app::{App, error_text};
use super::http::{Answer, Refused, bytes_answer, long_work};
use super::mesh::state_of;
use crate::io::Format;

#[derive(Deserialize)]
pub struct DownloadQuery {
    /// The file extension of the format.
    format: String,
}

/// `GET api/download/ID?format=…`: the bytes of the file that saving the mesh would write.
pub async fn download(
    State(app): State<Arc<App>>,
    Path((_, id)): Path<(String, u32)>,
    Query(DownloadQuery { format }): Query<DownloadQuery>,
) -> Answer {
    let bytes = long_work(&app, move |app| app.downloaded(id, &format)).await?;
    Ok(bytes_answer(bytes))
}

impl App {
    /// A mesh as the bytes of a file; refused if the format needs several files.
    fn downloaded(&self, id: u32, extension: &str) -> Result<Vec<u8>, Refused> {
        let known = Format::ALL.iter().any(|f| f.extension() == extension);
        if !known {
            let what = format!(
                "there is no format {extension}; the formats are {}",
                Format::LIST
            );
            return Err(Refused::wrong(what, "format"));
        }
        let state = state_of(self, id)?;
        let failed = |error: std::io::Error| Refused::failed(error.to_string());
        let folder = tempfile::tempdir().map_err(failed)?;
        let stem = self.input.file_stem().unwrap_or_default();
        let path = folder.path().join(stem).with_extension(extension);
        let saved = self.save_mesh(&state, &path, false);
        saved.map_err(|error| Refused::failed(error_text(&error)))?;
        if std::fs::read_dir(folder.path()).map_err(failed)?.count() > 1 {
            let what =
                "this mesh needs several files in this format: save it in the folder instead";
            return Err(Refused::wrong(what, "format"));
        }
        std::fs::read(&path).map_err(failed)
    }
}
