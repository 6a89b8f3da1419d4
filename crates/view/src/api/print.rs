//! API requests of the print check: wall thickness at all faces, and the connected components of a mesh.

use std::sync::{Arc, PoisonError};

use axum::extract::{Path, Query, State};
use glam::DVec3;
use serde::Deserialize;
use serde_json::json;

use super::super::app::App;
use super::super::container::Container;
use super::super::state::State as MeshState;
use super::http::{Answer, bytes_answer, long_work, work};
use super::mesh::state_of;
use isomend_core::mesh::{Topology, welded};

#[derive(Deserialize)]
pub struct WallsQuery {
    /// Number of faces whose thickness the page has.
    known: usize,
}

/// `GET api/walls/ID?known=N`: the wall thickness at faces from face N on, in mesh units, as far as it is measured after a fraction of a
/// second: possibly none. Negative at wedges, which are no walls, and NaN where a face has no other side.
pub async fn walls(
    State(app): State<Arc<App>>,
    Path((_, id)): Path<(String, u32)>,
    Query(WallsQuery { known }): Query<WallsQuery>,
) -> Answer {
    let bytes = work(&app, move |app| {
        let state = state_of(app, id)?;
        // Lock outside of the rayon pool, as for a check.
        let mut own = state
            .thickness
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let (mesh, own) = (&state.loaded.mesh, &mut *own);
        if own.is_wanting(known, mesh) {
            let mut slot = app.wall_map.lock().unwrap_or_else(PoisonError::into_inner);
            let slot = &mut *slot;
            app.host.aside.install(|| own.measure(id, mesh, slot));
        }
        let values = own.after(known);
        let header = json!({ "id": id, "known": known, "faces": mesh.faces.len() });
        Ok(Container::new(header)
            .with("values", 1, values.iter().copied())
            .bytes())
    });
    Ok(bytes_answer(bytes.await?))
}

/// `GET api/components/ID`: the connected components of a mesh in the order of their numbers from 0: number of faces, area, centre
/// relative to the scene's, and half the diagonal of the bounding box; and the component of each face (`u32::MAX` for a degenerate one) and
/// of each hole.
pub async fn components(State(app): State<Arc<App>>, Path((_, id)): Path<(String, u32)>) -> Answer {
    let bytes = long_work(&app, move |app| {
        let state = state_of(app, id)?;
        Ok(packed(&state, app.centre))
    });
    Ok(bytes_answer(bytes.await?))
}

fn packed(state: &MeshState, centre: DVec3) -> Vec<u8> {
    let (mut mesh, _) = welded(&state.loaded.mesh);
    let topology = Topology::new(&mut mesh);
    let areas = topology.component_areas(&mesh);
    let boxes = topology.component_bounds(&mesh);
    let middle = |(low, high): &(DVec3, DVec3)| (0.5 * (*low + *high) - centre).as_vec3();
    let faces = topology.component_faces.iter().map(|count| *count as u32);
    Container::new(json!({ "id": state.id }))
        .with("faces", 1, faces)
        .with("areas", 1, areas.iter().map(|area| *area as f32))
        .with(
            "centres",
            3,
            boxes.iter().flat_map(|b| middle(b).to_array()),
        )
        .with(
            "reaches",
            1,
            boxes
                .iter()
                .map(|(low, high)| 0.5 * low.distance(*high) as f32),
        )
        .with("of_faces", 1, topology.component.iter().copied())
        .with("of_holes", 1, state.holes.iter().map(|hole| hole.component))
        .bytes()
}
