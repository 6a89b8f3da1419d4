//! API requests for the geometry of a mesh and its rims, whole or relative to a mesh that the page already has.

use std::sync::Arc;

use axum::extract::{Path, Query, State};
use serde::Deserialize;
use serde_json::json;

use super::super::app::App;
use super::super::clusters::Clusters;
use super::super::container::Container;
use super::super::delta::Delta;
use super::super::revisions::{ListPart, ListRow, hash, parts};
use super::super::runs::Runs;
use super::super::state::State as MeshState;
use super::http::{Answer, Refused, bytes_answer, long_work, work};
use isomend_core::mesh::Hole;

/// The state with the given number.
///
/// # Errors
/// When it does not exist.
pub fn state_of(app: &App, id: u32) -> Result<Arc<MeshState>, Refused> {
    let session = app.session();
    let state = session.state(id).cloned();
    state.ok_or_else(|| Refused::missing("there is no mesh with this number; reload the page"))
}

#[derive(Deserialize)]
pub struct From {
    /// A mesh that the page already has.
    from: Option<u32>,
}

/// `GET api/mesh/ID?from=…`: vertices, faces, and the origin and region of each face; only the changes if `from` shares vertices and
/// faces with it.
pub async fn mesh(
    State(app): State<Arc<App>>,
    Path((_, id)): Path<(String, u32)>,
    Query(From { from }): Query<From>,
) -> Answer {
    compared(&app, id, from, packed).await
}

/// The bytes that `pack` makes of a mesh, compared with the mesh `from`, which the page has.
async fn compared(
    app: &Arc<App>,
    id: u32,
    from: Option<u32>,
    pack: fn(&App, &MeshState, Option<&MeshState>) -> Vec<u8>,
) -> Answer {
    let bytes = work(app, move |app| {
        let state = state_of(app, id)?;
        // If the other mesh does not exist any more, everything is sent.
        let old = from.and_then(|id| state_of(app, id).ok());
        Ok(pack(app, &state, old.as_deref()))
    });
    Ok(bytes_answer(bytes.await?))
}

/// The vertices and faces of the old mesh that the new one starts with, if one of the two was made from the other.
fn kept_of(old: &MeshState, new: &MeshState) -> Option<Delta> {
    let parent_of = |state: &MeshState| state.parent.as_ref().map(|p| p.id);
    if parent_of(new) == Some(old.id) {
        return new.delta.clone();
    }
    let undone = parent_of(old) == Some(new.id);
    let kept_all = |delta: &&Delta| undone && delta.keeps_all(&new.loaded.mesh);
    old.delta.as_ref().filter(kept_all).cloned()
}

fn packed(app: &App, state: &MeshState, old: Option<&MeshState>) -> Vec<u8> {
    let kept = old.and_then(|old| Some((kept_of(old, state)?, old.id)));
    let mesh = &state.loaded.mesh;
    let from = kept.as_ref().map(|(_, id)| *id);
    let header = json!({ "id": state.id, "from": from, "centre": app.centre.to_array() });
    let container = Container::new(header);
    let points = |first: usize| {
        let new = mesh.positions[first..].iter();
        new.flat_map(|p| (*p - app.centre).as_vec3().to_array())
    };
    let faces = |first: usize| mesh.faces[first..].iter().flatten().copied();
    let origins = || state.origin.iter().map(|o| *o as u8);
    let Some((delta, _)) = kept else {
        return container
            .with("positions", 3, points(0))
            .with("faces", 3, faces(0))
            .with("origin", 1, origins())
            .with("region", 1, state.region.iter().copied())
            .bytes();
    };
    // The mesh starts with the kept vertices and faces. After an undo, the old mesh has more than this one: then all of it is kept.
    let first = |runs: &Runs, count: usize| runs.count().min(count);
    let ranges = |runs: &Runs| runs.0.clone().into_iter().flatten();
    let is_child = state.parent.as_ref().map(|parent| parent.id) == from;
    let replaced = state.replaced.iter().filter(|_| is_child).flatten();
    container
        .with("kept_vertices", 2, ranges(&delta.vertices))
        .with(
            "positions",
            3,
            points(first(&delta.vertices, mesh.positions.len())),
        )
        .with("kept_faces", 2, ranges(&delta.faces))
        .with("faces", 3, faces(first(&delta.faces, mesh.faces.len())))
        .with("replaced", 2, replaced.copied())
        .with("origin_runs", 2, value_runs(origins().map(u32::from)))
        .with(
            "region_runs",
            2,
            value_runs(state.region.iter().map(|r| u32::from(*r))),
        )
        .bytes()
}

/// Run-length encoding: for each run of equal values its first index and its value.
fn value_runs(values: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut runs: Vec<u32> = Vec::new();
    for (place, value) in (0u32..).zip(values) {
        if runs.last() != Some(&value) || runs.is_empty() {
            runs.extend([place, value]);
        }
    }
    runs
}

/// `GET api/coarse/ID`: a coarse version of a large mesh: its vertices, also as vertices of the mesh, its faces, and for each of them the
/// face of the mesh that became it, with origin and region.
pub async fn coarse(State(app): State<Arc<App>>, Path((_, id)): Path<(String, u32)>) -> Answer {
    let bytes = long_work(&app, move |app| {
        let state = state_of(app, id)?;
        let clusters = Clusters::new(&state.loaded.mesh);
        let point = |v: &u32| state.loaded.mesh.positions[*v as usize] - app.centre;
        let points = clusters.vertices.iter().map(point);
        let of = |face: &u32| *face as usize;
        let numbers = || clusters.numbers.iter().map(of);
        let header = json!({ "id": id, "centre": app.centre.to_array() });
        Ok(Container::new(header)
            .with("positions", 3, points.flat_map(|p| p.as_vec3().to_array()))
            .with("origin", 1, numbers().map(|face| state.origin[face] as u8))
            .with("region", 1, numbers().map(|face| state.region[face]))
            .with("faces", 3, clusters.faces.iter().flatten().copied())
            .with("numbers", 1, clusters.numbers.iter().copied())
            .with("vertices", 1, clusters.vertices)
            .bytes())
    });
    Ok(bytes_answer(bytes.await?))
}

/// `GET api/rims/ID?from=…`: the rims of the holes as points; only the changes relative to the rims of the mesh `from`.
///
/// `parts` has the numbers first, end and id of each part of the list: if end is greater than first, the rims `first..end` of the other
/// mesh, now of the holes numbered from id; otherwise the next rim of `points` and `starts`, of the hole id.
pub async fn rims(
    State(app): State<Arc<App>>,
    Path((_, id)): Path<(String, u32)>,
    Query(From { from }): Query<From>,
) -> Answer {
    compared(&app, id, from, packed_rims).await
}

fn packed_rims(app: &App, state: &MeshState, old: Option<&MeshState>) -> Vec<u8> {
    let rim = |state: &MeshState, hole: &Hole| -> Vec<f32> {
        let point = |v: &u32| (state.loaded.mesh.positions[*v as usize] - app.centre).as_vec3();
        let points = hole.rim.iter().map(point);
        points.flat_map(|p| p.to_array()).collect()
    };
    let rows = |state: &MeshState| -> Vec<ListRow> {
        let bits = |rim: Vec<f32>| -> Vec<u32> { rim.into_iter().map(f32::to_bits).collect() };
        let row = |hole: &Hole| ListRow {
            id: hole.id.get() as u32,
            hash: hash(&bits(rim(state, hole))),
        };
        state.holes.iter().map(row).collect()
    };
    let (before, now) = (old.map(rows).unwrap_or_default(), rows(state));
    let (mut sent, mut points, mut starts) = (Vec::new(), Vec::new(), vec![0]);
    for part in parts(&before, &now) {
        match part {
            ListPart::Kept { first, end, id } => sent.extend([first as u32, end as u32, id]),
            ListPart::New(index) => {
                sent.extend([0, 0, now[index].id]);
                points.extend(rim(state, &state.holes[index]));
                starts.push(points.len() as u32 / 3);
            }
        }
    }
    let header =
        json!({ "id": state.id, "from": old.map(|old| old.id), "centre": app.centre.to_array() });
    Container::new(header)
        .with("parts", 3, sent)
        .with("points", 3, points)
        .with("starts", 1, starts)
        .bytes()
}

#[cfg(test)]
mod tests {
    use super::value_runs;

    #[test]
    fn equal_values_are_one_run() {
        assert!(value_runs([].into_iter()).is_empty());
        assert_eq!(value_runs([0, 0, 2, 2, 0].into_iter()), [0, 0, 2, 2, 4, 0]);
        assert_eq!(value_runs([1, 1].into_iter()), [0, 1]);
    }
}
