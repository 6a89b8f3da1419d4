//! Topological welding of vertices that share their exact position.

use rayon::prelude::*;

use super::Mesh;

/// For each vertex the first vertex at exactly the same position (`-0.0` equals `0.0`).
///
/// Files that split vertices at seams, or that have no indices at all, become connected through this map; the mesh
/// itself keeps its vertices.
pub fn weld_map(mesh: &Mesh) -> Vec<u32> {
    let key = |v: u32| {
        let p = mesh.positions[v as usize] + glam::DVec3::ZERO;
        (p.x.to_bits(), p.y.to_bits(), p.z.to_bits())
    };
    let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    order.par_sort_unstable_by_key(|&v| (key(v), v));
    let mut map = vec![0; mesh.positions.len()];
    let mut first = 0;
    for (i, &v) in order.iter().enumerate() {
        if i == 0 || key(v) != key(first) {
            first = v;
        }
        map[v as usize] = first;
    }
    map
}

/// The mesh with its faces on welded vertices, and the number of vertices that were merged into another.
pub fn welded(mesh: &Mesh) -> (Mesh, usize) {
    let map = weld_map(mesh);
    let merged = map
        .iter()
        .enumerate()
        .filter(|&(v, &w)| v as u32 != w)
        .count();
    let faces = mesh
        .faces
        .iter()
        .map(|f| f.map(|v| map[v as usize]))
        .collect();
    (Mesh::new(mesh.positions.clone(), faces), merged)
}
