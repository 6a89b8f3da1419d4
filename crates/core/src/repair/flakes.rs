//! Flakes: loose triangles that lie on the surface of a larger component. They bound nothing and cover what is there already.

use glam::DVec3;
use rayon::prelude::*;

use super::draft::Draft;
use crate::mend::FillError;
use crate::mesh::area_vector;
use crate::spatial::Bvh;
use crate::threads::CollectIndexed;

/// Removes the components of one or two faces that lie within a distance (mesh units) of larger ones; returns how many faces. Of a
/// triangle that is no higher than this the ends count, since it may lie across a hole.
pub(super) fn drop(draft: &mut Draft, distance: f64) -> Result<usize, FillError> {
    let removed: Vec<bool> = {
        let found = draft.inspect()?;
        let (mesh, topology) = (&found.mesh, &found.topology);
        let is_loose = |f: &u32| topology.is_loose(topology.component[*f as usize]);
        let (loose, larger): (Vec<u32>, Vec<u32>) = topology.faces().partition(is_loose);
        if loose.is_empty() || larger.is_empty() {
            return Ok(0);
        }
        let bvh = Bvh::new(mesh, larger.into_iter());
        let lies = |f: &u32| {
            let corners = mesh.corners(*f);
            let is_on = |p: &DVec3| bvh.closest(*p, distance).is_some();
            let ends = longest(corners);
            match area_vector(corners).length() <= distance * ends[0].distance(ends[1]) {
                true => ends.iter().all(is_on),
                false => across(corners).iter().all(is_on),
            }
        };
        let on: Vec<bool> = loose.par_iter().map(lies).collect_indexed();
        // A component goes as a whole.
        let mut stays = vec![false; topology.component_faces.len()];
        for (f, _) in loose.iter().zip(&on).filter(|(_, on)| !**on) {
            stays[topology.component[*f as usize] as usize] = true;
        }
        let mut removed = vec![false; mesh.faces.len()];
        for f in loose {
            removed[f as usize] = !stays[topology.component[f as usize] as usize];
        }
        removed
    };
    Ok(draft.remove(&removed))
}

/// The ends of the longest edge of a triangle.
fn longest([a, b, c]: [DVec3; 3]) -> [DVec3; 2] {
    let edges = [[a, b], [b, c], [c, a]];
    let length = |[p, q]: [DVec3; 2]| p.distance_squared(q);
    let longer = |one, other| {
        if length(other) > length(one) {
            other
        } else {
            one
        }
    };
    edges.into_iter().fold(edges[0], longer)
}

/// Points spread over a triangle: its corners, the middles of its edges, its centre and the points between.
fn across([a, b, c]: [DVec3; 3]) -> [DVec3; 10] {
    let centre = (a + b + c) / 3.0;
    let half = |p: DVec3, q: DVec3| 0.5 * (p + q);
    [
        a,
        b,
        c,
        half(a, b),
        half(b, c),
        half(c, a),
        centre,
        half(a, centre),
        half(b, centre),
        half(c, centre),
    ]
}
