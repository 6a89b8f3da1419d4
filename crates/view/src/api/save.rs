//! API requests that save meshes, reports, recipes and masks, and that load masks.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Path as InPath, Query, State};
use axum::http::header::{CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::response::IntoResponse;
use serde::Deserialize;
use serde_json::{Value, json};

use super::super::app::{App, error_text};
use super::super::files::{Denied, to_read, to_write};
use super::super::recipe::Recipe;
use super::super::runs::Runs;
use super::super::session::SavedAs;
use super::super::state::State as MeshState;
use super::deliver::{DeliverQuery, DeliveryRequest, refused};
use super::http::{Answer, MARKS, Refused, SMALL, json_answer, long_work, read, work};
use super::mesh::state_of;
use isomend_files::io::Format;
use isomend_files::job::{Deliverables, Output, parse_face_numbers, write_text};

/// Upper bound of the size of a file of face numbers, in bytes.
const FACE_LIST: u64 = 256 << 20;
/// Why an input is not overwritten.
const INPUT: &str = "this file is open here, and the recipe starts from it; choose another name";
/// Why a template is not overwritten.
const TEMPLATE: &str =
    "this file is the template of a step, and the recipe reads it; choose another name";
/// Content security policy of a report: it runs its own script in a sandbox and loads nothing.
const REPORT_POLICY: &str = "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                             img-src data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

impl From<Denied> for Refused {
    fn from(denied: Denied) -> Self {
        match denied {
            Denied::Exists(name) => Self::exists(name),
            Denied::Outside(what) => Self::forbidden(what),
            Denied::Wrong(what) => Self::wrong(what, "path"),
            Denied::Taken(what) => Self::conflict(what),
            Denied::Missing(what) => Self::missing(what),
        }
    }
}

/// A request to save a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SaveRequest {
    path: String,
    #[serde(default)]
    overwrite: bool,
    kind: Content,
    #[serde(default)]
    mask: Option<Runs>,
    /// Whether to write a mesh as text instead of binary.
    #[serde(default)]
    ascii: bool,
    /// The mesh; none for the current one.
    #[serde(default)]
    id: Option<u32>,
    /// What is handed over with the mesh; none for what was saved with it last.
    #[serde(default)]
    deliver: Option<DeliveryRequest>,
}

#[derive(Clone, Copy, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
enum Content {
    Mesh,
    Report,
    Recipe,
    Mask,
}

impl Content {
    /// Refuses names whose extension does not fit the content.
    fn check(self, path: &Path) -> Result<(), Refused> {
        let extension = path
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or_default();
        let extension = extension.to_ascii_lowercase();
        let (fits, needed) = match self {
            Self::Mesh => (
                Format::from_extension(path).is_some_and(|f| Format::ALL.contains(&f)),
                Format::LIST,
            ),
            Self::Report => (matches!(&extension[..], "html" | "htm"), ".html"),
            Self::Recipe => (matches!(&extension[..], "sh" | "toml"), ".sh or .toml"),
            Self::Mask => (
                matches!(&extension[..], "faces" | "txt" | "json"),
                ".faces, .txt or .json",
            ),
        };
        match fits {
            true => Ok(()),
            false => Err(Refused::wrong(
                format!("the name of the file must end in {needed}"),
                "path",
            )),
        }
    }
}

/// `POST api/save`: writes a mesh, a report, a recipe or a mask below the folder.
pub async fn save(State(app): State<Arc<App>>, body: Body) -> Answer {
    let request: SaveRequest = read(body, MARKS).await?;
    let value = long_work(&app, move |app| app.save_content(&request)).await?;
    Ok(json_answer(&value))
}

impl App {
    fn save_content(&self, request: &SaveRequest) -> Result<Value, Refused> {
        let path = self.to_write(&request.path, request.overwrite)?;
        request.kind.check(&path)?;
        self.refuse_input(&path)?;
        let id = request.id.unwrap_or_else(|| self.session().current().id);
        let state = state_of(self, id)?;
        let failed = |error| Refused::failed(error_text(&error));
        match request.kind {
            Content::Mesh => return self.save_with_files(request, &state, &path),
            Content::Report => {
                let wanted = self.deliverables(request.deliver.as_ref(), id, &path)?;
                let saved = self.save_report(&state, &path, &wanted);
                saved.map(drop).map_err(refused)?;
            }
            Content::Recipe => return self.save_recipe(id, &path, request),
            Content::Mask => {
                let mask = request.mask.as_ref();
                let mask = mask.ok_or_else(|| Refused::wrong("no face is marked", "mask"))?;
                let faces = state.loaded.mesh.faces.len();
                mask.check(faces)
                    .map_err(|error| Refused::wrong(error, "mask"))?;
                let text = match path
                    .extension()
                    .is_some_and(|e| e.eq_ignore_ascii_case("json"))
                {
                    true => json!(mask.numbers().collect::<Vec<_>>()).to_string(),
                    false => mask.text(),
                };
                write_text(&path, &text).map_err(failed)?;
            }
        }
        let bytes = std::fs::metadata(&path).map_or(0, |about| about.len());
        Ok(json!({ "path": self.shown(&path), "bytes": bytes, "notes": [] }))
    }

    /// The path of a file to write. A file that this session wrote is replaced without `overwrite`.
    pub(super) fn to_write(&self, name: &str, overwrite: bool) -> Result<PathBuf, Denied> {
        let path = to_write(&self.host.root, name, true)?;
        match overwrite || self.session().wrote(&path) {
            true => Ok(path),
            false => to_write(&self.host.root, name, false),
        }
    }

    /// Saves a mesh, and the files that are handed over with it.
    fn save_with_files(
        &self,
        request: &SaveRequest,
        state: &MeshState,
        path: &Path,
    ) -> Result<Value, Refused> {
        let wanted = request.deliver.clone().unwrap_or_default().beside(path)?;
        self.check_files(&wanted, request.overwrite)?;
        let mut output = Output::new(path, None).map_err(refused)?;
        output.ascii = request.ascii;
        let saved = self.save_mesh(state, &output, &wanted).map_err(refused)?;
        let file = |name: &str| {
            let row = saved.document.get(name)?;
            let path = Path::new(row.get("path")?.as_str()?);
            Some(self.shown(path))
        };
        let [patches, piece] = ["patches", "piece"].map(file);
        let bytes = std::fs::metadata(path).map_or(0, |about| about.len());
        let answer = json!({
            "path": self.shown(path), "bytes": bytes, "notes": saved.notes, "patches": patches, "piece": piece, "warnings": saved.warnings,
        });
        let saved = SavedAs {
            path: saved.path,
            ascii: request.ascii,
            deliverables: wanted,
            delivered: saved.warnings.is_empty(),
        };
        self.session().was_saved(state.id, saved);
        self.changed();
        Ok(answer)
    }

    /// The deliverables of a request, with files beside `mesh`; without a request those that were saved with the mesh.
    fn deliverables(
        &self,
        request: Option<&DeliveryRequest>,
        id: u32,
        mesh: &Path,
    ) -> Result<Deliverables, Refused> {
        let saved = || self.session().output(id).map(|s| s.deliverables.clone());
        match request {
            Some(request) => request.beside(mesh),
            None => Ok(saved().unwrap_or_default()),
        }
    }

    /// Refuses to overwrite the input of any page of this server, and the template of a step.
    pub(super) fn refuse_input(&self, path: &Path) -> Result<(), Refused> {
        if (self.host.is_input)(path) {
            return Err(Refused::conflict(INPUT));
        }
        let is_template = |state: &Arc<MeshState>| {
            let step = state.step.as_ref();
            step.is_some_and(|step| step.work.template() == Some(path))
        };
        match self.session().line().any(is_template) {
            true => Err(Refused::conflict(TEMPLATE)),
            false => Ok(()),
        }
    }

    /// A path as the page shows it: relative to the folder if it is below it.
    pub(super) fn shown(&self, path: &Path) -> String {
        let path = path.strip_prefix(&self.host.root).unwrap_or(path);
        path.display().to_string()
    }

    /// The recipe of a mesh, with paths relative to the recipe file `path`.
    fn recipe_at(
        &self,
        id: u32,
        path: &Path,
        request: Option<&DeliveryRequest>,
    ) -> Result<Recipe, Refused> {
        let state = state_of(self, id)?;
        let mut saved = self.output_of(id);
        let wanted = self.deliverables(request, id, &saved.path)?;
        if wanted != saved.deliverables {
            state.check_deliverables(&wanted).map_err(refused)?;
            saved.delivered = state.delivers(&wanted).map_err(refused)?;
            saved.deliverables = wanted;
        }
        let folder = path.parent().unwrap_or(&self.host.root);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        self.recipe(&state, (folder, &stem), &saved)
            .map_err(|error| Refused::wrong(error, "path"))
    }

    /// The file that a mesh was last saved to, or one with a default name.
    fn output_of(&self, id: u32) -> SavedAs {
        let session = self.session();
        if let Some(saved) = session.output(id) {
            return saved.clone();
        }
        let stem = self.input.file_stem().unwrap_or_default().to_string_lossy();
        let format = session.current().loaded.format;
        let name = format!("{stem}_mended.{}", format.extension());
        SavedAs {
            path: self.host.root.join(name),
            ascii: false,
            deliverables: Deliverables::default(),
            delivered: true,
        }
    }

    /// Writes a recipe as shell script and as TOML, with its mask files beside it.
    fn save_recipe(&self, id: u32, path: &Path, request: &SaveRequest) -> Result<Value, Refused> {
        let recipe = self.recipe_at(id, path, request.deliver.as_ref())?;
        let mut files = vec![
            (path.with_extension("sh"), recipe.shell()),
            (path.with_extension("toml"), recipe.toml()),
        ];
        for (name, text) in recipe.masks() {
            files.push((path.with_file_name(name), text));
        }
        for (file, _) in &files {
            let name = file.to_str().ok_or_else(|| {
                Refused::wrong("the name of the file is not valid Unicode", "path")
            })?;
            self.refuse_input(&to_write(&self.host.root, name, request.overwrite)?)?;
        }
        let mut bytes = 0;
        for (file, text) in &files {
            write_text(file, text).map_err(|error| Refused::failed(error_text(&error)))?;
            bytes += text.len();
        }
        let names: Vec<String> = files.iter().map(|(file, _)| self.shown(file)).collect();
        Ok(json!({ "path": self.shown(path), "bytes": bytes, "files": names, "notes": [] }))
    }
}

/// `GET api/recipe?deliver=…`: the recipe of the current mesh, and the names of its mask files.
pub async fn recipe(State(app): State<Arc<App>>, Query(query): Query<DeliverQuery>) -> Answer {
    let request = DeliveryRequest::parse(query.deliver.as_deref())?;
    let value = long_work(&app, move |app| {
        let id = app.session().current().id;
        let recipe = app.recipe_at(id, &app.host.root.join("recipe.sh"), request.as_ref())?;
        let masks: Vec<&str> = recipe.masks().map(|(name, _)| name).collect();
        Ok(json!({ "shell": recipe.shell(), "toml": recipe.toml(), "masks": masks }))
    });
    Ok(json_answer(&value.await?))
}

#[derive(Deserialize)]
struct FaceFile {
    path: String,
}

/// `POST api/mask/load`: reads a file of face numbers below the folder.
pub async fn load_mask(State(app): State<Arc<App>>, body: Body) -> Answer {
    let FaceFile { path: name } = read(body, SMALL).await?;
    let value = work(&app, move |app| {
        let path = to_read(&app.host.root, &name)?;
        let wrong = |error: String| Refused::wrong(error, "path");
        let size = std::fs::metadata(&path).map_or(0, |about| about.len());
        if size > FACE_LIST {
            let most = FACE_LIST >> 20;
            return Err(wrong(format!(
                "{name} is too large for a list of faces: at most {most} MiB are read"
            )));
        }
        let text = std::fs::read_to_string(&path);
        let text = text.map_err(|error| wrong(format!("{name} cannot be read: {error}")))?;
        let numbers = parse_face_numbers(&text, &name);
        let mut numbers = numbers.map_err(|error| wrong(error_text(&error)))?;
        numbers.sort_unstable();
        numbers.dedup();
        let faces = app.session().current().loaded.mesh.faces.len();
        if let Some(last) = numbers.last().filter(|last| **last >= faces) {
            return Err(wrong(format!(
                "there is no face {last}: the mesh has {faces} faces, numbered from 0"
            )));
        }
        let runs = Runs::of_sorted(numbers.into_iter().map(|n| n as u32));
        Ok(json!({ "runs": runs }))
    });
    Ok(json_answer(&value.await?))
}

/// `GET api/report/ID?deliver=…`: the report page of a step.
pub async fn report(
    State(app): State<Arc<App>>,
    InPath((_, id)): InPath<(String, u32)>,
    Query(query): Query<DeliverQuery>,
) -> Answer {
    let request = DeliveryRequest::parse(query.deliver.as_deref())?;
    let page = long_work(&app, move |app| {
        let state = state_of(app, id)?;
        let failed = |error: std::io::Error| Refused::failed(error.to_string());
        let folder = tempfile::tempdir().map_err(failed)?;
        let path = folder.path().join("report.html");
        let wanted = app.deliverables(request.as_ref(), id, &path)?;
        let drawn = app.save_report(&state, &path, &wanted);
        drawn.map_err(refused)?;
        std::fs::read_to_string(&path).map_err(failed)
    });
    let headers = [
        (CONTENT_TYPE, "text/html; charset=utf-8"),
        (CONTENT_SECURITY_POLICY, REPORT_POLICY),
    ];
    Ok((headers, page.await?).into_response())
}
