//! Thin parts: faces with a short inward ray to the opposite side.

use glam::DVec3;
use rayon::prelude::*;

use super::{Defect, DefectKind, Subject};
use crate::mesh::{Mesh, Topology, face_normal};
use crate::spatial::{Bvh, meets};
use crate::threads::CollectFiltered;
use crate::tuning::{Tunable, tunable};

/// Cosine of 60 degrees. A ray ends on a face whose normal is within this angle of the ray. At larger angles the two faces are
/// taken for the sides of an edge.
pub(super) const FACING: Tunable<f64> = tunable("check.thin.facing", 0.5);

/// The faces whose inward ray reaches the opposite side within `length` (mesh units).
pub(super) fn thin(subject: &Subject, length: f64) -> Defect {
    let Subject { mesh, topology, .. } = *subject;
    let bvh = Bvh::new(mesh, topology.faces());
    let normal = |f: u32| given_normal(mesh, topology, f);
    let is_thin = |&f: &u32| {
        let inward = -normal(f);
        if inward == DVec3::ZERO {
            return false;
        }
        let centre = centroid(mesh, f);
        let end = centre + length * inward;
        let mut found = false;
        bvh.for_each_in_box(centre.min(end), centre.max(end), |g| {
            found = found
                || (!shares_vertex(mesh, f, g)
                    && normal(g).dot(inward) > FACING.get()
                    && meets(centre, inward, mesh.corners(g)).is_some_and(|t| t < length));
        });
        found
    };
    let all: Vec<u32> = topology.faces().collect();
    let faces: Vec<u32> = all.into_par_iter().filter(is_thin).collect_filtered();
    Defect::new(DefectKind::Thin, faces.len(), faces, mesh)
}

/// The unit normal of a face in the orientation of the input; the inward direction is against it.
pub(super) fn given_normal(mesh: &Mesh, topology: &Topology, face: u32) -> DVec3 {
    match topology.turned[face as usize] {
        true => -face_normal(mesh, face),
        false => face_normal(mesh, face),
    }
}

/// The centroid of a face, the origin of its inward ray.
pub(super) fn centroid(mesh: &Mesh, face: u32) -> DVec3 {
    mesh.corners(face).iter().sum::<DVec3>() / 3.0
}

fn shares_vertex(mesh: &Mesh, f: u32, g: u32) -> bool {
    let corners = mesh.faces[g as usize];
    mesh.faces[f as usize].iter().any(|v| corners.contains(v))
}
