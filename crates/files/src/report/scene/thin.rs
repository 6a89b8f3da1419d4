//! Simplifies a scene far from patches and rims by vertex clustering, so that drawings have a bounded size.

use std::collections::{HashMap, HashSet};

use glam::{DVec3, Vec3};

use isomend_core::mesh::bounds;

/// Rings of vertices around patches and rims that stay unchanged in the first attempt.
const RINGS: usize = 16;
/// Cells along the diagonal of the bounding box in the first attempt.
const CELLS: f64 = 640.0;
/// Factor by which cells grow, and the number of unchanged rings shrinks, from attempt to attempt.
const GROWTH: f64 = 1.4;
/// After this many attempts the surface near patches is simplified too.
const PATIENCE: i32 = 10;
/// Size of the cells near patches over the size of the others.
const NEAR_PART: f64 = 0.1;

/// The faces to draw, at most `limit`, each with its index. All vertices of a cell are replaced by the first one in it. `classes` are the
/// end of the faces that both meshes have and the end of the new faces; near `rims` nothing is simplified.
pub fn thinned(
    (positions, normals): (&[DVec3], &[Vec3]),
    faces: &[[u32; 3]],
    classes: [usize; 2],
    rims: &[DVec3],
    limit: usize,
) -> Vec<(u32, [u32; 3])> {
    let whole = || (0..).zip(faces.iter().copied());
    if faces.len() <= limit {
        return whole().collect();
    }
    let rings = rings(positions, faces, classes[0], rims);
    let (low, high) = bounds(faces.iter().flatten().map(|&v| positions[v as usize]));
    let diagonal = low.distance(high);
    for attempt in 0.. {
        let cell = diagonal / CELLS * GROWTH.powi(attempt);
        let reach = (RINGS as f64 / GROWTH.powi(attempt)) as u8;
        let near = (attempt > PATIENCE).then_some(NEAR_PART * cell);
        let size = |v: usize| if rings[v] <= reach { near } else { Some(cell) };
        let stands = representatives(positions, low, size);
        let drawn: Vec<(u32, [u32; 3])> = whole()
            .map(|(i, f)| (i, f.map(|v| stands[v as usize])))
            .filter(|(_, [a, b, c])| a != b && b != c && c != a)
            .filter(|(i, f)| *f == faces[*i as usize] || !is_folded(positions, normals, f))
            .collect();
        if drawn.len() <= limit {
            return drawn;
        }
    }
    Vec::new()
}

/// Whether the simplification flipped a face: it would cover others and show its inside.
fn is_folded(positions: &[DVec3], normals: &[Vec3], face: &[u32; 3]) -> bool {
    let [a, b, c] = face.map(|v| positions[v as usize]);
    let outward: Vec3 = face.iter().map(|&v| normals[v as usize]).sum();
    (b - a).cross(c - a).dot(outward.as_dvec3()) < 0.0
}

/// For each vertex, the number of edges between it and the nearest patch or rim, at most `RINGS` + 1.
fn rings(positions: &[DVec3], faces: &[[u32; 3]], kept: usize, rims: &[DVec3]) -> Vec<u8> {
    let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
    let rims: HashSet<[u64; 3]> = rims.iter().map(bits).collect();
    let far = RINGS as u8 + 1;
    let mut rings: Vec<u8> = positions
        .iter()
        .map(|p| if rims.contains(&bits(p)) { 0 } else { far })
        .collect();
    let own = if kept == 0 { &[][..] } else { &faces[kept..] };
    own.iter().flatten().for_each(|&v| rings[v as usize] = 0);
    for ring in 1..far {
        for face in faces {
            if face.iter().any(|&v| rings[v as usize] == ring - 1) {
                for &v in face {
                    rings[v as usize] = rings[v as usize].min(ring);
                }
            }
        }
    }
    rings
}

/// For each vertex, the first vertex in its cell; the vertex itself if `size` gives it no cell.
fn representatives(
    positions: &[DVec3],
    low: DVec3,
    size: impl Fn(usize) -> Option<f64>,
) -> Vec<u32> {
    let mut first: HashMap<([i64; 3], u64), u32> = HashMap::new();
    (0..positions.len())
        .map(|v| match size(v) {
            Some(cell) if cell > 0.0 => {
                let place = ((positions[v] - low) / cell).floor();
                let place = place.to_array().map(|x| x as i64);
                *first.entry((place, cell.to_bits())).or_insert(v as u32)
            }
            _ => v as u32,
        })
        .collect()
}
