//! Charts: sets of faces over which texture coordinates are continuous.

use rayon::prelude::*;

use super::FieldSource;
use crate::mesh::attributes::{Labels, same_value};
use crate::mesh::{DisjointSets, Mesh};
use crate::threads::CollectIndexed;

/// The chart of each face. Two faces are in the same chart if they share an edge, with the same texture coordinates at
/// its ends, and have the same material. `weld` maps each vertex to the first one at the same position.
pub(super) fn charts(
    mesh: &Mesh,
    weld: &[u32],
    uv: &FieldSource<'_>,
    materials: Option<&Labels>,
) -> Vec<u32> {
    let mut edges: Vec<(u64, u32)> = (0..3 * mesh.faces.len() as u32)
        .into_par_iter()
        .map(|half| {
            let [a, b] = ends(half).map(|(f, k)| weld[mesh.faces[f][k] as usize]);
            ((u64::from(a.min(b)) << 32) | u64::from(a.max(b)), half)
        })
        .collect_indexed();
    edges.par_sort_unstable();
    let mut charts = DisjointSets::new(mesh.faces.len());
    let material = |half: u32| materials.map(|m| m.of_face[half as usize / 3]);
    for pair in edges.windows(2) {
        let [(key, one), (other_key, other)] = [pair[0], pair[1]];
        if key == other_key && material(one) == material(other) && agree(mesh, weld, uv, one, other)
        {
            charts.join(one / 3, other / 3);
        }
    }
    (0..mesh.faces.len() as u32)
        .map(|f| charts.find(f))
        .collect()
}

/// The two ends of a half-edge, as face and corner.
fn ends(half: u32) -> [(usize, usize); 2] {
    let (face, corner) = (half as usize / 3, half as usize % 3);
    [(face, corner), (face, (corner + 1) % 3)]
}

fn agree(mesh: &Mesh, weld: &[u32], uv: &FieldSource<'_>, one: u32, other: u32) -> bool {
    let vertex = |(f, k): (usize, usize)| weld[mesh.faces[f][k] as usize];
    let [a, b] = ends(one);
    let [mut c, mut d] = ends(other);
    if vertex(a) != vertex(c) {
        std::mem::swap(&mut c, &mut d);
    }
    [(a, c), (b, d)].into_iter().all(|(x, y)| {
        let value = uv.at(mesh, x.0, x.1);
        value.is_some() && same_value(value, uv.at(mesh, y.0, y.1))
    })
}
