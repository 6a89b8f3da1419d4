//! The signed distance of a mesh at given points.

use glam::DVec3;
use rayon::prelude::*;

use super::VolumeError;
use crate::mesh::{Mesh, Topology, welded};
use crate::spatial::{Bvh, WindingTree};
use crate::threads::CollectIndexed;

/// The signed distances of points from a mesh, in the mesh's units and in the order of the points; negative inside,
/// with the same sign rule as [`super::signed_distance_volume`]. A point with a coordinate that is not finite gets NaN.
///
/// # Errors
/// When the mesh is not valid or has no area.
pub fn signed_distances(mesh: &Mesh, points: &[DVec3]) -> Result<Vec<f64>, VolumeError> {
    mesh.validate()?;
    let (mut mesh, _) = welded(mesh);
    let topology = Topology::new(&mut mesh);
    if topology.faces().next().is_none() {
        return Err(VolumeError::NoSurface);
    }
    let bvh = Bvh::new(&mesh, topology.faces());
    let winding = WindingTree::new(&bvh);
    let distance = |p: &DVec3| {
        if !p.is_finite() {
            return f64::NAN;
        }
        let Some(closest) = bvh.closest(*p, f64::INFINITY) else {
            return f64::NAN;
        };
        match winding.winding_number(&bvh, *p).abs() > 0.5 {
            true => -closest.distance,
            false => closest.distance,
        }
    };
    Ok(points.par_iter().map(distance).collect_indexed())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::cube;
    use crate::volume::{VolumeParams, signed_distance_volume};

    #[test]
    fn distances_at_the_nodes_of_a_volume_are_those_of_the_volume() {
        let mesh = cube();
        let volume = signed_distance_volume(
            &mesh,
            &VolumeParams {
                voxel: crate::region::VoxelSize::Length(0.13),
                band: None,
            },
        );
        let volume = volume.unwrap();
        let [nx, ny, nz] = volume.dims;
        let node = |n: usize| [n % nx, n / nx % ny, n / nx / ny].map(|i| i as f64);
        let points: Vec<DVec3> = (0..nx * ny * nz)
            .map(|n| volume.origin + DVec3::from_array(node(n)) * volume.spacing)
            .collect();
        let distances = signed_distances(&mesh, &points).unwrap();
        assert!(distances.iter().any(|d| *d < -0.4));
        for (a, b) in distances.iter().zip(&volume.values) {
            assert!((a - b).abs() < 1e-12, "{a} instead of {b}");
        }
    }

    #[test]
    fn points_that_are_not_finite_and_meshes_without_area_are_reported() {
        let far = [DVec3::splat(1e200), DVec3::new(0.5, f64::NAN, 0.5)];
        let distances = signed_distances(&cube(), &far).unwrap();
        assert!(
            distances[0] > 1e199 && distances[1].is_nan(),
            "{distances:?}"
        );
        let edge = Mesh::new(vec![DVec3::ZERO, DVec3::X], vec![[0, 1, 1]]);
        assert!(matches!(
            signed_distances(&edge, &far),
            Err(VolumeError::NoSurface)
        ));
    }
}
