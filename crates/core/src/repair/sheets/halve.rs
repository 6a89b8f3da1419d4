//! Splits non-manifold edges in the middle, where the surfaces that meet there can be separated.

use std::collections::HashSet;

use super::pairs::paired;
use crate::mend::FillError;
use crate::mesh::topology::{end, start};
use crate::repair::draft::Draft;

/// Splits non-manifold edges round which bodies and gaps alternate at their midpoints, with their faces; at most one edge per
/// face. Returns the number of edges split.
pub(super) fn halve(draft: &mut Draft) -> Result<usize, FillError> {
    let halves = {
        let found = draft.inspect()?;
        let (mesh, crowded) = (&found.mesh, found.topology.non_manifold_edges(&found.mesh));
        let (_, unclear) = paired(&found, &crowded);
        let unclear: HashSet<u32> = unclear.into_iter().flatten().collect();
        let mut touched: HashSet<u32> = HashSet::new();
        let mut halves = Vec::new();
        for edge in crowded.iter().filter(|e| !unclear.contains(&e[0])) {
            let ends = [start(mesh, edge[0]), end(mesh, edge[0])];
            let [p, q] = ends.map(|v| mesh.positions[v as usize]);
            let middle = draft.rounding.moved(p, 0.5 * (q - p));
            let faces = || edge.iter().map(|h| h / 3);
            if middle == p || middle == q || faces().any(|f| touched.contains(&f)) {
                continue;
            }
            touched.extend(faces());
            // Corners in the numbering of the draft: the inspection may have reoriented the face.
            let half_edge = |f: u32| {
                let own = draft.mesh.faces[f as usize].map(|v| found.weld[v as usize]);
                let k =
                    (0..3).find(|k| ends.contains(&own[*k]) && ends.contains(&own[(k + 1) % 3]));
                k.map(|k| 3 * f + k as u32)
            };
            let own: Vec<u32> = faces().filter_map(half_edge).collect();
            halves.push((ends[0], middle, own));
        }
        halves
    };
    for (end, middle, half_edges) in &halves {
        let new = draft.copy_vertex(*end, *middle);
        half_edges.iter().for_each(|h| divide(draft, *h, new));
    }
    Ok(halves.len())
}

/// Splits a face in two at a vertex on one of its edges.
fn divide(draft: &mut Draft, h: u32, middle: u32) {
    let (f, k) = (h as usize / 3, h as usize % 3);
    let (face, origin, region) = (draft.mesh.faces[f], draft.origins.faces[f], draft.region[f]);
    let mut first = (face, origin);
    first.0[(k + 1) % 3] = middle;
    first.1.corners[(k + 1) % 3] = 3;
    let mut second = (face, origin);
    second.0[k] = middle;
    second.1.corners[k] = 3;
    draft.mesh.faces[f] = first.0;
    draft.origins.faces[f] = first.1;
    draft.mesh.faces.push(second.0);
    draft.origins.faces.push(second.1);
    draft.region.push(region);
}
