//! Collapses very short edges that a union makes where an intersection curve passes a vertex or another curve by a rounding
//! error, and removes the gaps between sides that differ by such errors.

use std::collections::{BTreeSet, HashMap, HashSet};

use glam::DVec3;

use super::contact::{SHORT_EDGE, length};
use crate::check::is_flat;
use crate::mend::FillError;
use crate::mesh::topology::NONE;
use crate::mesh::{Mesh, VertexFaces, area_vector};
use crate::repair::draft::{CLEAN_ROUNDS, Draft};

/// Collapses edges of vertices from `first` on that are shorter than a fraction of the mesh's size or than `reach`, if that does
/// not change the surface. Undone if more faces intersect others afterwards.
pub(super) fn collapse(draft: &mut Draft, first: usize, reach: f64) -> Result<(), FillError> {
    let [low, high] = draft.mesh.bounds();
    let reach = reach.max(SHORT_EDGE.get() * (high - low).length());
    let mut before: Option<(Draft, usize)> = None;
    for _ in 0..CLEAN_ROUNDS.get() {
        let moves = {
            let found = draft.inspect()?;
            moves(&found.mesh, first, reach)
        };
        if moves.is_empty() {
            break;
        }
        if before.is_none() {
            let crossing = draft.self_intersections()?.len();
            before = Some((draft.clone(), crossing));
        }
        make(draft, &moves);
    }
    if let Some((before, crossing)) = before
        && draft.self_intersections()?.len() > crossing
    {
        *draft = before;
    }
    Ok(())
}

/// Removes the closed components that are no thicker than rounding errors: gaps and overlaps between sides that two bodies share.
/// Components of the input keep at least one face. Returns how many faces.
pub(super) fn drop_gaps(draft: &mut Draft) -> Result<usize, FillError> {
    let least = length(draft);
    let removed = {
        let found = draft.inspect()?;
        let (mesh, topology) = (&found.mesh, &found.topology);
        // Volume and area, both twice.
        let count = topology.component_faces.len();
        let mut sums = vec![(0.0, 0.0, None); count];
        for f in topology.faces() {
            let corners = mesh.corners(f);
            let area = area_vector(corners);
            let (volume, whole, centre) = &mut sums[topology.component[f as usize] as usize];
            let centre = *centre.get_or_insert(corners[0]);
            *volume += area.dot(corners[0] - centre) / 3.0;
            *whole += area.length();
        }
        let mut is_thin: Vec<bool> = (sums.iter())
            .map(|(volume, area, _)| 2.0 * f64::abs(*volume) <= least * area)
            .collect();
        let edges = topology.faces().flat_map(|f| [3 * f, 3 * f + 1, 3 * f + 2]);
        for h in edges.filter(|h| topology.opposite[*h as usize] == NONE) {
            is_thin[topology.component[h as usize / 3] as usize] = false;
        }
        let thin = |f: usize| {
            (topology.component.get(f)).is_some_and(|c| *c != NONE && is_thin[*c as usize])
        };
        let faces = 0..mesh.faces.len();
        let kept: HashSet<u32> = faces
            .clone()
            .filter(|f| !thin(*f))
            .map(|f| draft.component(f))
            .collect();
        faces
            .map(|f| thin(f) && kept.contains(&draft.component(f)))
            .collect::<Vec<bool>>()
    };
    Ok(draft.remove(&removed))
}

/// Pairs of a vertex and the neighbour it collapses into, no two pairs adjacent.
fn moves(mesh: &Mesh, first: usize, reach: f64) -> Vec<[u32; 2]> {
    let short = |[v, w]: [u32; 2]| {
        let apart = mesh.positions[v as usize].distance(mesh.positions[w as usize]);
        v as usize >= first && apart <= reach
    };
    let edges = mesh.faces.iter().flat_map(|f| {
        let edge = |k: usize| [f[k], f[(k + 1) % 3]];
        [0, 1, 2]
            .map(edge)
            .into_iter()
            .flat_map(|[v, w]| [[v, w], [w, v]])
    });
    let edges: BTreeSet<[u32; 2]> = edges.filter(|e| short(*e)).collect();
    if edges.is_empty() {
        return Vec::new();
    }
    let around = VertexFaces::new(mesh);
    let mut touched: HashSet<u32> = HashSet::new();
    let mut moves = Vec::new();
    for [v, w] in edges {
        let near = || [v, w].into_iter().flat_map(|v| around.of(v));
        let corners = || near().flat_map(|f| mesh.faces[*f as usize]);
        if corners().any(|c| touched.contains(&c)) || !may_move(mesh, &around, [v, w], reach) {
            continue;
        }
        touched.extend(corners());
        moves.push([v, w]);
    }
    moves
}

/// Whether a vertex can be collapsed into its neighbour: the two have exactly two common faces and two common neighbours, and the
/// other faces at it keep their orientation.
fn may_move(mesh: &Mesh, around: &VertexFaces, [v, w]: [u32; 2], reach: f64) -> bool {
    let neighbours = |v: u32| -> BTreeSet<u32> {
        let corners = around.of(v).iter().flat_map(|f| mesh.faces[*f as usize]);
        corners.filter(|c| *c != v).collect()
    };
    let between = around.of(v).iter();
    let between = between.filter(|f| mesh.faces[**f as usize].contains(&w));
    if between.count() != 2 || neighbours(v).intersection(&neighbours(w)).count() != 2 {
        return false;
    }
    let to = mesh.positions[w as usize];
    around.of(v).iter().all(|f| {
        let face = mesh.faces[*f as usize];
        if face.contains(&w) {
            return true;
        }
        let before = mesh.corners(*f);
        let after: [DVec3; 3] = std::array::from_fn(|k| if face[k] == v { to } else { before[k] });
        let (n, m) = (area_vector(before), area_vector(after));
        let longest = (0..3).map(|k| before[k].distance(before[(k + 1) % 3]));
        let is_sliver = n.length() <= 2.0 * reach * longest.fold(0.0, f64::max);
        !is_flat(after) && (is_sliver || n.dot(m) > 0.5 * n.length() * m.length())
    })
}

fn make(draft: &mut Draft, moves: &[[u32; 2]]) {
    let weld = crate::mesh::weld_map(&draft.mesh);
    let to: HashMap<u32, u32> = moves.iter().map(|[v, w]| (*v, *w)).collect();
    for corner in draft.mesh.faces.iter_mut().flatten() {
        *corner = to.get(&weld[*corner as usize]).copied().unwrap_or(*corner);
    }
    let gone = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| weld[v as usize]);
        a == b || b == c || c == a
    };
    let removed: Vec<bool> = draft.mesh.faces.iter().map(gone).collect();
    draft.remove(&removed);
}
