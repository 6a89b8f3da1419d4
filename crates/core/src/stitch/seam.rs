//! Closing of a seam: triangles between two coincident rims.

use crate::mesh::Mesh;
use crate::tuning::{Tunable, tunable};

/// Mean edges. Rims whose vertices are closer than this coincide.
const SEAM_APART: Tunable<f64> = tunable("stitch.seam_apart", 1e-3);

/// The thin triangles between two boundary loops of `mesh` that coincide vertex by vertex but share no vertex, for example the
/// two sides of a seam whose coordinates were rounded differently. `None` if they do not coincide.
///
/// Faces use the directed edges `loop[i] → loop[i + 1]` of both loops.
pub fn close_seam(mesh: &Mesh, first: &[u32], second: &[u32]) -> Option<Vec<[u32; 3]>> {
    let n = first.len();
    if n < 3 || second.len() != n || first.iter().any(|v| second.contains(v)) {
        return None;
    }
    let position = |v: u32| mesh.positions[v as usize];
    let length: f64 = (0..n)
        .map(|i| position(first[i]).distance(position(first[(i + 1) % n])))
        .sum();
    let close =
        |a: u32, b: u32| position(a).distance(position(b)) < SEAM_APART.get() * length / n as f64;
    // The loops run in opposite directions.
    let partner = |start: usize, i: usize| second[(start + n - i) % n];
    let start = (0..n).find(|&start| (0..n).all(|i| close(first[i], partner(start, i))))?;
    let quad = |i: usize| {
        let next = (i + 1) % n;
        let (a, b) = (first[i], first[next]);
        let (c, d) = (partner(start, i), partner(start, next));
        [[a, b, c], [d, c, b]]
    };
    Some((0..n).flat_map(quad).collect())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use glam::DVec3;

    use super::*;

    fn two_rings(apart: f64) -> (Mesh, Vec<u32>, Vec<u32>) {
        let n = 12;
        let ring = |z: f64| {
            (0..n).map(move |i| {
                let (y, x) = (f64::from(i) * std::f64::consts::TAU / f64::from(n)).sin_cos();
                DVec3::new(x, y, z)
            })
        };
        let mesh = Mesh::new(ring(0.0).chain(ring(apart)).collect(), Vec::new());
        let second = (0..12).map(|i| 12 + (17 - i) % 12).collect();
        (mesh, (0..12).collect(), second)
    }

    #[test]
    fn a_seam_is_closed_with_every_edge_of_both_rims() {
        let (mesh, first, second) = two_rings(1e-6);
        let faces = close_seam(&mesh, &first, &second).expect("a seam");
        let mut edges = BTreeMap::new();
        for f in &faces {
            for k in 0..3 {
                *edges.entry((f[k], f[(k + 1) % 3])).or_insert(0) += 1;
            }
        }
        assert!(edges.values().all(|&uses| uses == 1));
        let border: Vec<_> = edges
            .keys()
            .filter(|(a, b)| !edges.contains_key(&(*b, *a)))
            .collect();
        assert_eq!(border.len(), 24);
        for rim in [first, second] {
            for i in 0..12 {
                assert!(border.contains(&&(rim[i], rim[(i + 1) % 12])));
            }
        }
    }

    #[test]
    fn rims_that_are_apart_are_no_seam() {
        let (mesh, first, second) = two_rings(0.01);
        assert_eq!(close_seam(&mesh, &first, &second), None);
    }
}
