//! Flakes: loose triangles that lie on the surface of a larger component. They bound nothing and cover what is there already.

use glam::DVec3;
use rayon::prelude::*;

use super::draft::Draft;
use crate::mend::FillError;
use crate::spatial::Bvh;
use crate::threads::CollectIndexed;

/// Faces of a component, at most, that may be a flake, or a sliver that shrinks to nothing.
pub(super) const SLIVER: usize = 2;

/// Removes the components of one or two faces that lie within a distance (mesh units) of larger ones; returns how many faces.
pub(super) fn drop(draft: &mut Draft, distance: f64) -> Result<usize, FillError> {
    let removed: Vec<bool> = {
        let found = draft.inspect()?;
        let (mesh, topology) = (&found.mesh, &found.topology);
        let is_small =
            |f: u32| topology.component_faces[topology.component[f as usize] as usize] <= SLIVER;
        let (loose, larger): (Vec<u32>, Vec<u32>) = topology.faces().partition(|f| is_small(*f));
        if loose.is_empty() || larger.is_empty() {
            return Ok(0);
        }
        let bvh = Bvh::new(mesh, larger.into_iter());
        let lies = |f: &u32| {
            let mut points = across(mesh.corners(*f)).into_iter();
            points.all(|p| bvh.closest(p, distance).is_some())
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
    if removed.contains(&true) {
        Ok(draft.remove(&removed))
    } else {
        Ok(0)
    }
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
