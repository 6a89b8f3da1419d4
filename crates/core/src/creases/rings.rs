//! Removal of the innermost rings of faces around a rim, so that predictions can be tested against them.

use rustc_hash::FxHashSet;

use crate::mesh::{Mesh, VertexFaces};

/// A mesh with a widened hole.
pub(crate) struct Widened {
    /// Remaining faces, in rising order.
    pub(crate) kept: Vec<u32>,
    /// Vertices of the removed faces, in rising order; they include the vertices of the new rim.
    pub(crate) removed: Vec<u32>,
}

/// Removes the faces within some rings of a rim; `None` if no face would remain.
pub(crate) fn without_rings(mesh: &Mesh, rim: &[u32], rings: u32) -> Option<Widened> {
    let (faces, _) = rings_of(mesh, &VertexFaces::new(mesh), rim, rings);
    let taken: FxHashSet<u32> = faces.iter().copied().collect();
    let kept: Vec<u32> = (0..mesh.faces.len() as u32)
        .filter(|f| !taken.contains(f))
        .collect();
    let mut removed: Vec<u32> = faces.iter().flat_map(|&f| mesh.faces[f as usize]).collect();
    removed.sort_unstable();
    removed.dedup();
    (!kept.is_empty()).then_some(Widened { kept, removed })
}

/// The faces of the innermost `rings` rings around a rim, in rising order, and the ring of each.
pub(super) fn rings_of(
    mesh: &Mesh,
    around: &VertexFaces,
    rim: &[u32],
    rings: u32,
) -> (Vec<u32>, Vec<u32>) {
    let mut is_reached = vec![false; mesh.positions.len()];
    let mut is_taken = vec![false; mesh.faces.len()];
    let mut list: Vec<(u32, u32)> = Vec::new();
    let mut front = rim.to_vec();
    rim.iter().for_each(|&v| is_reached[v as usize] = true);
    for ring in 0..rings {
        let mut next = Vec::new();
        for &f in front.iter().flat_map(|&v| around.of(v)) {
            if std::mem::replace(&mut is_taken[f as usize], true) {
                continue;
            }
            list.push((f, ring));
            for v in mesh.faces[f as usize] {
                if !std::mem::replace(&mut is_reached[v as usize], true) {
                    next.push(v);
                }
            }
        }
        front = next;
    }
    list.sort_unstable();
    list.into_iter().unzip()
}
