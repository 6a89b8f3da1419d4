//! A mesh for the browser to keep on the computer that it runs on.

use std::sync::Arc;

use axum::extract::{Path, Query, State};
use serde::Deserialize;

use super::super::app::{App, told};
use super::asked::{Answer, Refused, bytes_answer, long_work};
use super::mesh::state_of;
use crate::io::Format;

#[derive(Deserialize)]
pub struct Wanted {
    /// The extension of its format.
    format: String,
}

/// `GET api/download/ID?format=…`: the bytes that saving it would write.
pub async fn download(
    State(app): State<Arc<App>>,
    Path((_, id)): Path<(String, u32)>,
    Query(Wanted { format }): Query<Wanted>,
) -> Answer {
    let bytes = long_work(&app, move |app| app.downloaded(id, &format)).await?;
    Ok(bytes_answer(bytes))
}

impl App {
    /// A mesh as the bytes of a file in a format that has one file only.
    fn downloaded(&self, id: u32, extension: &str) -> Result<Vec<u8>, Refused> {
        let known = Format::ALL.iter().any(|f| f.extension() == extension);
        if !known {
            return Err(Refused::wrong("there is no such format", "format"));
        }
        let state = state_of(self, id)?;
        let failed = |error: std::io::Error| Refused::failed(error.to_string());
        let folder = tempfile::tempdir().map_err(failed)?;
        let stem = self.input.file_stem().unwrap_or_default();
        let path = folder.path().join(stem).with_extension(extension);
        let saved = self.save_mesh(&state, &path, false);
        saved.map_err(|error| Refused::failed(told(&error)))?;
        if std::fs::read_dir(folder.path()).map_err(failed)?.count() > 1 {
            let what = "this mesh has several files in that format: save it in the folder";
            return Err(Refused::wrong(what, "format"));
        }
        std::fs::read(&path).map_err(failed)
    }
}
