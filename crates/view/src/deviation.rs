//! Signed distances of vertices from a reference mesh.

use glam::DVec3;
use rayon::prelude::*;

use isomend_core::mesh::Mesh;
use isomend_core::spatial::{Bvh, Closest};

/// Distances of the chosen vertices of a mesh from a reference mesh; 0 for the other vertices. A distance is positive on the side to
/// which the nearest face's normal points, negative on the other side.
///
/// If the nearest point is on an edge or a corner, the face that the closest-point query returns gives the sign. At sharp edges the
/// faces may disagree on the sign.
pub fn deviation(mesh: &Mesh, chosen: &[bool], reference: &Mesh) -> Vec<f32> {
    let bvh = Bvh::new(reference, 0..reference.faces.len() as u32);
    let sign = |p: DVec3, found: &Closest| {
        let [a, b, c] = reference.corners(found.face);
        let side = (p - found.point).dot((b - a).cross(c - a));
        if side < 0.0 { -1.0 } else { 1.0 }
    };
    let points = mesh.positions.par_iter().zip(chosen);
    let signed = |(&p, is_chosen): (&DVec3, &bool)| {
        let found = is_chosen.then(|| bvh.closest(p, f64::INFINITY)).flatten();
        found.map_or(0.0, |found| (sign(p, &found) * found.distance) as f32)
    };
    points.map(signed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_gives_the_side_of_a_vertex() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|p| 4.0 * p);
        let reference = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]);
        let at = |z: f64| DVec3::new(1.0, 1.0, z);
        let mesh = Mesh::new(vec![at(0.5), at(-0.25), at(2.0)], vec![[0, 1, 2]]);
        let values = deviation(&mesh, &[true, true, false], &reference);
        assert_eq!(values, [0.5, -0.25, 0.0]);
    }
}
