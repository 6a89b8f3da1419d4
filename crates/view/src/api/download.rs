//! API request that downloads a mesh to the computer of the browser.

use std::sync::Arc;

use axum::extract::{Path, Query, State};
use serde::Deserialize;

use super::super::app::App;
use super::deliver::{DeliveryRequest, refused};
use super::http::{Answer, Refused, bytes_answer, long_work};
use super::mesh::state_of;
use isomend_files::io::Format;
use isomend_files::job::Output;

#[derive(Deserialize)]
pub struct DownloadQuery {
    /// The file extension of the format of the mesh.
    format: String,
    /// A [`DeliveryRequest`] as JSON.
    deliver: Option<String>,
    #[serde(default)]
    file: Part,
}

/// The file of a save that is downloaded.
#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Part {
    #[default]
    Mesh,
    Patches,
    Piece,
}

/// `GET api/download/ID?format=…&deliver=…&file=…`: the bytes of a file that saving the mesh would write: of the mesh, the patches or the
/// missing piece.
pub async fn download(
    State(app): State<Arc<App>>,
    Path((_, id)): Path<(String, u32)>,
    Query(query): Query<DownloadQuery>,
) -> Answer {
    let bytes = long_work(&app, move |app| app.downloaded(id, &query)).await?;
    Ok(bytes_answer(bytes))
}

impl App {
    /// A file as bytes; refused if the format of the mesh needs several files.
    fn downloaded(&self, id: u32, query: &DownloadQuery) -> Result<Vec<u8>, Refused> {
        let extension = &query.format;
        let known = Format::ALL.iter().any(|f| f.extension() == &extension[..]);
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
        // As the page suggests for saving: the name of texels in a GLB file depends on it.
        let stem = self.input.file_stem().unwrap_or_default();
        let name = format!("{}_mended.{extension}", stem.to_string_lossy());
        let path = folder.path().join(name);
        let mut request = DeliveryRequest::parse(query.deliver.as_deref())?.unwrap_or_default();
        request.patches = query.file == Part::Patches;
        request.piece = query.file == Part::Piece;
        let wanted = request.beside(&path)?;
        let output = Output::new(path.as_path(), None).map_err(refused)?;
        let saved = self.save_mesh(&state, &output, &wanted).map_err(refused)?;
        if let Some(output) = wanted.patches.or(wanted.piece) {
            let lines = [saved.warnings, saved.notes].concat();
            let own = output.place.path().filter(|path| path.exists());
            let own = own.ok_or_else(|| Refused::wrong(lines.join("; "), "deliver"))?;
            return std::fs::read(own).map_err(failed);
        }
        if std::fs::read_dir(folder.path()).map_err(failed)?.count() > 1 {
            let what =
                "this mesh needs several files in this format: save it in the folder instead";
            return Err(Refused::wrong(what, "format"));
        }
        std::fs::read(&path).map_err(failed)
    }
}
