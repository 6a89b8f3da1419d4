//! Pairs the half-edges of a non-manifold edge so that a body lies between each two.

use crate::elementary::atan2;
use crate::mend::Inspection;
use crate::mesh::Mesh;
use crate::mesh::topology::{apex, end, start};

/// The half-edges of non-manifold edges in pairs with a body between them, and the edges round which bodies and gaps do not
/// alternate.
pub(in crate::repair) fn paired(
    found: &Inspection,
    crowded: &[Vec<u32>],
) -> (Vec<[u32; 2]>, Vec<Vec<u32>>) {
    let (mut pairs, mut unclear) = (Vec::new(), Vec::new());
    for half_edges in crowded {
        match around_edge(&found.mesh, half_edges) {
            Some(own) => pairs.extend(own),
            None => unclear.push(half_edges.clone()),
        }
    }
    (pairs, unclear)
}

/// Pairs the faces round an edge by angle: in each pair the face with the smaller angle runs against the edge and the next one
/// along it, so that the body lies between them. None if the directions do not alternate.
fn around_edge(mesh: &Mesh, half_edges: &[u32]) -> Option<Vec<[u32; 2]>> {
    let first = half_edges[0];
    let (a, b) = (start(mesh, first), end(mesh, first));
    let at = |v: u32| mesh.positions[v as usize];
    let along = (at(b) - at(a)).normalize_or_zero();
    let across = |h: u32| {
        let d = at(apex(mesh, h)) - at(a);
        d - along * along.dot(d)
    };
    let x = across(first).normalize_or_zero();
    let y = along.cross(x);
    let angle = |h: u32| {
        let d = across(h);
        atan2(y.dot(d), x.dot(d)).rem_euclid(std::f64::consts::TAU)
    };
    let mut order: Vec<(f64, u32, bool)> = half_edges
        .iter()
        .map(|&h| {
            (
                if h == first { 0.0 } else { angle(h) },
                h,
                start(mesh, h) == a,
            )
        })
        .collect();
    order.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
    let next = |i: usize| order[(i + 1) % order.len()];
    let alternate = (0..order.len()).all(|i| order[i].2 != next(i).2 && order[i].0 != next(i).0);
    if !alternate || !order.len().is_multiple_of(2) {
        return None;
    }
    let against = (0..order.len()).filter(|i| !order[*i].2);
    Some(against.map(|i| [order[i].1, next(i).1]).collect())
}
