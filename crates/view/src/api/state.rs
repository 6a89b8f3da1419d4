//! API requests for the state of the session, as one JSON document, and for the stream of events.

use std::collections::HashMap;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::UNIX_EPOCH;

use axum::body::Body;
use axum::extract::{Query, State};
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tokio::sync::broadcast::error::RecvError;

use super::super::app::App;
use super::super::deliver::{patches_extension, piece_extension};
use super::super::events::event;
use super::super::named::NamedMask;
use super::super::revisions::{List, ListRow, hash};
use super::super::session::Busy;
use super::super::state::State as MeshState;
use super::deliver::saved_row;
use super::http::{Answer, json_answer, work};
use super::values::OUTLIERS;
use isomend_core::fill::{FillParams, LeftReason};
use isomend_core::mend::{FairParams, RestoreParams};
use isomend_core::mesh::Attributes;
use isomend_core::mesh::attributes::{Attribute, EXPECTED_ERROR_NAME, Role};
use isomend_core::parameters;
use isomend_core::repair::RepairParams;
use isomend_files::io::{FileDocument, Format};

/// Seconds without an event after which an empty line is sent, so that both sides notice a lost connection.
const QUIET: u64 = 20;

#[derive(Deserialize)]
pub struct KnownRevision {
    /// The revision of the document that the page has.
    known: Option<u64>,
}

/// `GET api/state?known=…`: the document from which the page builds everything but the meshes; only the changes if the page has a
/// revision that is remembered, see [`Revisions::answer`](super::super::revisions::Revisions::answer).
pub async fn state(
    State(app): State<Arc<App>>,
    Query(KnownRevision { known }): Query<KnownRevision>,
) -> Answer {
    let value = work(&app, move |app| Ok(document(app, known))).await?;
    Ok(json_answer(&value))
}

fn document(app: &App, known: Option<u64>) -> Value {
    // Locked first, so that a later revision has a later state of the session.
    let mut revisions = app.revisions();
    let session = app.session();
    let current = session.current().clone();
    let line = session.line().map(|state| (state.clone(), false));
    let beside = session.previews().map(|state| (state.clone(), true));
    let states: Vec<(Arc<MeshState>, bool)> = line.chain(beside).collect();
    let [undo, redo] = session.can_undo_redo();
    let busy = session.busy.as_ref().map(busy_row);
    let unsaved = session.is_unsaved();
    let choices = session.choices(current.id);
    let masked = session.was_masked();
    drop(session);
    let first = states
        .first()
        .map_or_else(|| current.clone(), |(s, _)| s.clone());
    let holes = hole_rows(&current);
    let lists = [state_list(&states), hole_list(&holes)];
    let images = current.textures().count();
    let texture = (images > 0).then(|| json!({ "url": "api/texture/0", "count": images }));
    let members = json!({
        "program": { "version": env!("CARGO_PKG_VERSION") },
        "file": {
            "name": app.input.file_name().unwrap_or_default().to_string_lossy(),
            "format": current.loaded.format.extension(),
            "bytes": app.bytes,
            "root": app.host.root.display().to_string(),
            "unit": current.loaded.attributes.unit,
            "painted": first.loaded.document.as_ref().is_some_and(FileDocument::is_painted),
        },
        "deliver": saved_row(app, current.id),
        "current": current.id,
        "undo": undo,
        "redo": redo,
        "unsaved": unsaved,
        "earlier": app.earlier.as_ref().filter(|_| !app.store.is_own()).map(|file| file.display().to_string()),
        "session": { "path": app.store.path().display().to_string(), "error": app.store.error() },
        "choices": choices.actions(&current),
        "number_shifts": number_shifts(&current, &first),
        "crease_ends": current.inspected["crease_ends"],
        "creases": choices.creases(&current),
        "marked": choices.mask().count(),
        "masked": masked,
        "masks": choices.named.iter().map(mask_row).collect::<Vec<_>>(),
        "defects": current.inspected["defects"],
        "open_chains": current.inspected["open_chains"],
        "bounds": current.inspected["bounds"],
        "notes": current.inspected["notes"],
        "busy": busy,
        "formats": Format::ALL.map(format_row),
        "attributes": attribute_rows(&current.loaded.attributes),
        "errors": current.errors.is_known(),
        "error_high": current.errors.high(OUTLIERS),
        "texture": texture,
        "parameters": parameters::document(),
        "defaults": defaults(),
        "scene": scene(app, &current, &first),
    });
    revisions.answer(known, &members, &lists)
}

/// The rows of the meshes. A mesh with its step never changes, so that its number and its place in the session stand for the content.
fn state_list(states: &[(Arc<MeshState>, bool)]) -> List<'_> {
    let row = |(state, preview): &(Arc<MeshState>, bool)| ListRow {
        id: state.id,
        hash: hash(&(state.id, preview)),
    };
    List {
        name: "states",
        rows: states.iter().map(row).collect(),
        object: Box::new(|index| state_row(&states[index].0, states[index].1)),
    }
}

/// The rows of the holes.
fn hole_list(holes: &[Value]) -> List<'_> {
    let row = |hole: &Value| {
        let mut content = hole.clone();
        let id = content["id"].take().as_u64().unwrap_or_default();
        ListRow {
            id: id as u32,
            hash: hash(&content.to_string()),
        }
    };
    List {
        name: "holes",
        rows: holes.iter().map(row).collect(),
        object: Box::new(|index| holes[index].clone()),
    }
}

/// The default parameters of each command.
fn defaults() -> Value {
    json!({
        "fill": default_params::<FillParams>(),
        "restore": default_params::<RestoreParams>(),
        "fair": default_params::<FairParams>(),
        "repair": default_params::<RepairParams>(),
    })
}

fn default_params<P: Default + Serialize>() -> Value {
    serde_json::to_value(P::default()).unwrap_or_default()
}

fn format_row(format: Format) -> Value {
    json!({
        "extension": format.extension(),
        "name": format.to_string(),
        "attributes": format != Format::Stl,
        "patches": patches_extension(format),
        "piece": piece_extension(format),
    })
}

fn busy_row(busy: &Busy) -> Value {
    let since = busy.since.duration_since(UNIX_EPOCH).unwrap_or_default();
    json!({ "job": busy.job, "kind": busy.kind, "since": since.as_secs_f64() })
}

fn state_row(state: &MeshState, preview: bool) -> Value {
    let mesh = &state.loaded.mesh;
    let step = state.step.as_ref();
    json!({
        "id": state.id,
        "parent": state.parent.as_ref().map(|p| p.id),
        "label": step.map_or_else(|| "as read".to_owned(), |s| s.label()),
        "command": step.map(|s| s.command.words()).unwrap_or_default(),
        "seconds": step.map(|s| s.seconds),
        "summary": step.map(|s| s.summary.as_str()),
        "standing": step.map(|s| s.standing.class()),
        "complete": step.map(|s| s.complete),
        "vertices": mesh.positions.len(),
        "faces": mesh.faces.len(),
        "report": step.map(|s| without_others(&s.document)),
        "preview": preview,
    })
}

fn mask_row(mask: &NamedMask) -> Value {
    json!({ "name": mask.name, "count": mask.faces.count(), "gone": mask.gone })
}

/// The report of a step without the holes that the step was not asked to fill.
fn without_others(report: &Value) -> Value {
    let mut report = report.clone();
    if let Some(holes) = report["holes"].as_array_mut() {
        holes.retain(|hole| !is_other(hole));
    }
    report
}

/// Whether a hole of a report was left open because other holes were chosen.
fn is_other(hole: &Value) -> bool {
    let reason = LeftReason::NotChosen.to_string();
    hole["outcome"] == "left" && hole["reason"] == reason.as_str()
}

/// The holes, with what a fill with default parameters would do: whether each stays open, and with which others it is filled
/// together. A hole that the last step was asked to fill and left open has the outcome and the reason. Holes are matched by centre and
/// number of edges.
fn hole_rows(state: &MeshState) -> Vec<Value> {
    let holes = state.inspected["holes"].as_array();
    let mut holes = holes.cloned().unwrap_or_default();
    let reported = state.step.as_ref().map(|step| &step.document["holes"]);
    let key = hole_key;
    let reported = reported.and_then(Value::as_array).into_iter().flatten();
    let reported = reported.filter(|hole| !is_other(hole));
    let reported: HashMap<_, _> = reported.map(|hole| (key(hole), hole)).collect();
    for (hole, id) in holes.iter_mut().zip(state.holes.iter().map(|hole| hole.id)) {
        hole["stays_open"] = state.stays_open(id).into();
        hole["joined"] = json!(state.joined(id));
        if let Some(before) = reported.get(&key(hole)) {
            for name in ["outcome", "closed_by", "reason", "cause"] {
                hole[name] = before[name].clone();
            }
        }
    }
    holes
}

/// What a hole is found by in other meshes: its centre and number of edges.
fn hole_key(hole: &Value) -> (String, Option<u64>) {
    (hole["centre"].to_string(), hole["edges"].as_u64())
}

/// By how much the numbers of holes differ from those in the input file: pairs of the first number from which on a difference holds, and the
/// difference; none for holes that the file does not have. A step shifts all later numbers, so that few pairs describe many holes.
fn number_shifts(state: &MeshState, first: &MeshState) -> Vec<(i64, Option<i64>)> {
    let rows = |state: &MeshState| state.inspected["holes"].as_array().cloned();
    let number = |hole: &Value| hole["id"].as_i64().unwrap_or_default();
    let old = rows(first).unwrap_or_default();
    let old: HashMap<_, _> = old.iter().map(|h| (hole_key(h), number(h))).collect();
    let mut shifts: Vec<(i64, Option<i64>)> = Vec::new();
    for hole in rows(state).unwrap_or_default() {
        let id = number(&hole);
        let shift = old.get(&hole_key(&hole)).map(|was| was - id);
        if shifts.last().map_or(Some(0), |(_, last)| *last) != shift {
            shifts.push((id, shift));
        }
    }
    shifts
}

fn attribute_rows(attributes: &Attributes) -> Vec<Value> {
    let row = |on: &'static str| {
        move |a: &Attribute| {
            let kind = match a.role {
                Role::Normal => "normal",
                Role::Colour => "colour",
                Role::Uv(_) => "uv",
                Role::Tangent => "tangent",
                Role::Other => "values",
            };
            json!({ "name": a.name, "on": on, "components": a.components, "kind": kind })
        }
    };
    let corner = attributes.corner.iter().map(|c| &c.pool);
    let vertex = attributes.vertex.iter().map(row("vertex"));
    let face = attributes.face.iter().map(row("face"));
    let rows = vertex.chain(face).chain(corner.map(row("corner")));
    // Expected errors have their own colouring, which also shows unknown values.
    rows.filter(|row| row["name"] != EXPECTED_ERROR_NAME)
        .collect()
}

/// Cosine of the angle against the up axis within which the first hole is one in the top or in the bottom (37°).
const UPRIGHT: f64 = 0.8;

/// Length of the mean normal of a mesh above which it counts as a sheet that faces one way.
const FACES_ONE_WAY: f64 = 0.3;

/// The initial view: facing the first hole of the input file that is no outer border, or from a corner if there is none.
fn scene(app: &App, state: &MeshState, first: &MeshState) -> Value {
    let [low, high] = state.bounds;
    let size = high - low;
    let up = first.up();
    let side = match up == glam::DVec3::Y {
        true => glam::DVec3::Z,
        false => -glam::DVec3::Y,
    };
    let inner = first.holes.iter().find(|h| !h.outer_boundary);
    let facing = inner.map(|h| h.normal).filter(|n| *n != glam::DVec3::ZERO);
    let corner = |height: f64| glam::DVec3::new(0.5, 0.0, 0.0) + side + height * up;
    // A hole in the top is seen from a corner above it; what stands on a hole in the bottom stands.
    let towards = match facing {
        Some(normal) if normal.dot(up) > UPRIGHT => corner(0.9),
        Some(normal) if normal.dot(up) > -UPRIGHT => normal,
        _ => corner(0.4),
    };
    // An open sheet is not shown from behind.
    let net = first.mean_normal();
    let is_behind = net.length() > FACES_ONE_WAY && towards.dot(net) < 0.0;
    let towards = if is_behind { net } else { towards };
    json!({
        "centre": app.centre.to_array(),
        "radius": 0.5 * size.length(),
        "up": up.to_array(),
        "towards": towards.normalize_or_zero().to_array(),
    })
}

/// `GET api/events`: the stream of events from now on.
pub async fn events(State(app): State<Arc<App>>) -> Response {
    let Ok(own) = app.host.streams.clone().try_acquire_owned() else {
        return axum::http::StatusCode::SERVICE_UNAVAILABLE.into_response();
    };
    let receiver = app.events.listen();
    let lines = stream::unfold(
        (receiver, own, true),
        |(mut receiver, own, is_first)| async move {
            // The first event makes the page fetch the state: something may have changed before it connected.
            if is_first {
                return Some((
                    Ok::<_, Infallible>(event("state", &json!({}))),
                    (receiver, own, false),
                ));
            }
            let quiet = std::time::Duration::from_secs(QUIET);
            let text = match tokio::time::timeout(quiet, receiver.recv()).await {
                Ok(Ok(text)) => text,
                Ok(Err(RecvError::Lagged(_))) => event("state", &json!({})),
                Ok(Err(RecvError::Closed)) => return None,
                Err(_) => ":\n\n".to_owned(),
            };
            Some((Ok(text), (receiver, own, false)))
        },
    );
    (
        [(CONTENT_TYPE, "text/event-stream")],
        Body::from_stream(lines),
    )
        .into_response()
}
