//! What a request hands over with a mesh, and the API request for figures of the patches and for the missing piece.

use std::path::Path;
use std::sync::Arc;

use axum::extract::{Path as InPath, Query, State};
use serde::Deserialize;
use serde_json::{Value, json};

use super::super::app::{App, error_text};
use super::super::deliver::{beside, mark_text, patches_extension, piece_extension};
use super::http::{Answer, Refused, json_answer, long_work};
use super::mesh::state_of;
use isomend_files::io::Format;
use isomend_files::job::{Deliverables, JobError, Output};

/// The paint of a slicer on patches, as on the command line.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum PatchPaint {
    #[default]
    None,
    Continue,
}

/// The deliverables that a page requests. The files of patches and piece get their names from the file of the mesh.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DeliveryRequest {
    /// The sign of the unit of the coordinates.
    unit: Option<String>,
    /// In the mesh's units.
    tolerance: Option<f64>,
    /// As on the command line.
    mark: Option<String>,
    /// The paint of patches.
    paint: PatchPaint,
    /// Whether to write the new faces to a file of their own.
    pub patches: bool,
    /// Whether to write the missing piece to a file.
    pub piece: bool,
}

impl DeliveryRequest {
    /// Parses the query parameter of a GET request; `None` if it is missing.
    ///
    /// # Errors
    /// When it is not the expected JSON.
    pub fn parse(text: Option<&str>) -> Result<Option<Self>, Refused> {
        let wrong = |error: serde_json::Error| Refused::wrong(error.to_string(), "deliver");
        text.map(|text| serde_json::from_str(text).map_err(wrong))
            .transpose()
    }

    /// The deliverables, with files beside the file of a mesh.
    ///
    /// # Errors
    /// When the unit, the tolerance or the mark is invalid.
    pub fn beside(&self, mesh: &Path) -> Result<Deliverables, Refused> {
        let tolerance = self.tolerance.map(|t| match t.is_finite() && t > 0.0 {
            true => Ok(t),
            false => {
                let what = "the tolerance must be a positive number";
                Err(Refused::wrong(what, "tolerance"))
            }
        });
        let unit = self.unit.as_deref().map(str::parse);
        let mark = self.mark.as_deref().map(str::parse);
        let format = Format::from_extension(mesh).unwrap_or(Format::Ply);
        let patches = self.patches.then(|| patches_extension(format));
        let piece = self.piece.then(|| piece_extension(format));
        let file = |name: &str, extension: Option<&str>| -> Result<Option<Output>, Refused> {
            let output = extension.map(|extension| beside(mesh, name, extension));
            output.transpose().map_err(refused)
        };
        Ok(Deliverables {
            unit: unit
                .transpose()
                .map_err(|error| Refused::wrong(error, "unit"))?,
            tolerance: tolerance.transpose()?,
            mark: mark
                .transpose()
                .map_err(|error| Refused::wrong(error, "mark"))?,
            patches: file("patches", patches)?,
            piece: file("piece", piece)?,
            continue_paint: self.paint == PatchPaint::Continue,
            ..Deliverables::default()
        })
    }
}

/// The answer to an error of a job: 422 if the request is wrong, else 500.
#[allow(clippy::needless_pass_by_value)] // For `map_err`.
pub fn refused(error: JobError) -> Refused {
    match error.is_usage() {
        true => Refused::wrong(error_text(&error), "deliver"),
        false => Refused::failed(error_text(&error)),
    }
}

/// The deliverables that were saved with a mesh, as the page requests them; null if there are none.
pub fn saved_row(app: &App, id: u32) -> Value {
    let session = app.session();
    let Some(saved) = session.output(id).map(|saved| &saved.deliverables) else {
        return Value::Null;
    };
    json!({
        "unit": saved.unit,
        "tolerance": saved.tolerance,
        "mark": saved.mark.map(mark_text),
        "paint": saved.continue_paint.then_some("continue"),
        "patches": saved.patches.is_some(),
        "piece": saved.piece.is_some(),
    })
}

impl App {
    /// Checks that the files of deliverables may be written: below the folder, over no input, and over no file that this session did not
    /// write unless `overwrite` is set.
    pub(super) fn check_files(
        &self,
        wanted: &Deliverables,
        overwrite: bool,
    ) -> Result<(), Refused> {
        for output in [&wanted.patches, &wanted.piece].into_iter().flatten() {
            let path = output.place.path().unwrap_or(Path::new(""));
            let name = path.to_str().ok_or_else(|| {
                Refused::wrong("the name of the file is not valid Unicode", "path")
            })?;
            self.refuse_input(&self.to_write(name, overwrite)?)?;
        }
        Ok(())
    }
}

#[derive(Deserialize)]
pub struct DeliverQuery {
    /// A [`DeliveryRequest`] as JSON.
    pub deliver: Option<String>,
}

/// `GET api/deliver/ID?deliver=…`: area and expected error of the patches of the last step, and whether it makes a missing piece, if one is
/// requested.
pub async fn figures(
    State(app): State<Arc<App>>,
    InPath((_, id)): InPath<(String, u32)>,
    Query(query): Query<DeliverQuery>,
) -> Answer {
    let request = DeliveryRequest::parse(query.deliver.as_deref())?.unwrap_or_default();
    let value = long_work(&app, move |app| {
        let state = state_of(app, id)?;
        let wanted = request.beside(&app.input)?;
        let piece = wanted.piece.as_ref().map(|_| {
            let refusal = state.piece_refusal();
            json!({ "made": refusal.is_none() && state.step.is_some(), "reason": refusal })
        });
        let invented = state.invented(&wanted).map_err(refused)?;
        Ok(json!({ "invented": invented, "piece": piece }))
    });
    Ok(json_answer(&value.await?))
}
