//! Closest-point queries on a part of the mesh: the faces near a region, so that a large mesh needs no hierarchy over all of it.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::topology::NONE;
use crate::mesh::{Mesh, Topology};
use crate::spatial::{Bounds, BoxTree, Bvh, Closest, middle};

/// Faces per unit of work of a thread in [`faces_at`].
const CHUNK: usize = 1 << 16;

/// The part of the mesh that a region queries, and its faces.
#[derive(Clone)]
pub struct SearchArea {
    /// Boxes, tried in order. The first is sufficient for nearly all queries, the last contains the closest points of all points
    /// of the region.
    pub boxes: [Bounds; 3],
    /// The faces whose bounding boxes meet the first box, in rising order, without degenerate ones.
    pub faces: Arc<[u32]>,
}

/// For each box, the faces whose bounding boxes meet it, in rising order, without degenerate ones. `None` if there are more than
/// `most` in total.
pub fn faces_at(
    mesh: &Mesh,
    topology: &Topology,
    boxes: &[Bounds],
    most: usize,
) -> Option<Vec<Arc<[u32]>>> {
    let tree = BoxTree::new(boxes);
    let found = AtomicUsize::new(0);
    let search = |(chunk, faces): (usize, &[[u32; 3]])| {
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        if found.load(Ordering::Relaxed) > most {
            return pairs;
        }
        for (f, face) in (chunk * CHUNK..).zip(faces) {
            if topology.component[f] == NONE {
                continue;
            }
            let around = Bounds::of(face.map(|v| mesh.positions[v as usize]));
            tree.for_each(&around, |place| pairs.push((place, f as u32)));
        }
        found.fetch_add(pairs.len(), Ordering::Relaxed);
        pairs
    };
    let chunks = mesh.faces.par_chunks(CHUNK).enumerate();
    let pairs: Vec<Vec<(u32, u32)>> = chunks.map(search).collect();
    if found.into_inner() > most {
        return None;
    }
    let mut lists = vec![Vec::new(); boxes.len()];
    for &(place, face) in pairs.iter().flatten() {
        lists[place as usize].push(face);
    }
    Some(lists.into_iter().map(Arc::from).collect())
}

/// The faces of a mesh, or of some of its components, that are queried: all but degenerate ones. Small components have a
/// hierarchy of their own.
pub(super) struct Faces<'a> {
    mesh: &'a Mesh,
    topology: &'a Topology,
    /// For each component whether it is queried.
    wanted: Vec<bool>,
    /// The origin of coordinates in every hierarchy.
    centre: OnceLock<DVec3>,
    all: OnceLock<Bvh>,
    small: OnceLock<Bvh>,
}

impl<'a> Faces<'a> {
    pub(super) fn new(
        mesh: &'a Mesh,
        topology: &'a Topology,
        wanted: &dyn Fn(u32) -> bool,
    ) -> Self {
        let components = 0..topology.component_faces.len() as u32;
        Self {
            mesh,
            topology,
            wanted: components.map(wanted).collect(),
            centre: OnceLock::new(),
            all: OnceLock::new(),
            small: OnceLock::new(),
        }
    }

    fn is_wanted(&self, face: u32, small: bool) -> bool {
        let component = self.topology.component[face as usize];
        component != NONE
            && self.wanted[component as usize]
            && (self.topology.component_faces[component as usize] <= 2) == small
    }

    fn list(&self, small: bool) -> impl Iterator<Item = u32> {
        (0..self.mesh.faces.len() as u32).filter(move |&f| self.is_wanted(f, small))
    }

    /// The origin of coordinates.
    pub(super) fn centre(&self) -> DVec3 {
        let middle = || middle(self.mesh, self.list(false));
        *self.centre.get_or_init(middle)
    }

    /// The same faces with another origin of coordinates.
    pub(super) fn about(&self, centre: DVec3) -> Self {
        Self {
            wanted: self.wanted.clone(),
            centre: centre.into(),
            all: OnceLock::new(),
            small: OnceLock::new(),
            ..*self
        }
    }

    fn over(&self, faces: Vec<u32>) -> Bvh {
        Bvh::about(self.mesh, faces, self.centre())
    }

    /// The hierarchy over all queried faces except small components, built at the first use.
    pub(super) fn all(&self) -> &Bvh {
        self.all
            .get_or_init(|| self.over(self.list(false).collect()))
    }

    /// The hierarchy over small components, built at the first use.
    pub(super) fn small(&self) -> &Bvh {
        self.small
            .get_or_init(|| self.over(self.list(true).collect()))
    }
}

/// The closest point to `p` in a hierarchy over the faces that meet a box. `None` if the box is too small to be sure: faces
/// outside the box might be closer.
fn within<'a>(
    bounds: &Bounds,
    p: DVec3,
    limit: f64,
    tree: impl FnOnce() -> &'a Bvh,
) -> Option<Option<Closest>> {
    if !bounds.contains(&Bounds::of_ball(p, 0.0)) {
        return None;
    }
    let found = tree().closest(p, limit);
    let reach = found.map_or(limit, |c| c.distance);
    bounds.contains(&Bounds::of_ball(p, reach)).then_some(found)
}

/// Hierarchies over the faces near a region: for each box of its search area one, built at the first use.
pub(super) struct Near {
    place: SearchArea,
    trees: [OnceLock<Bvh>; 3],
}

impl Near {
    pub(super) fn new(place: SearchArea) -> Self {
        Self {
            place,
            trees: Default::default(),
        }
    }

    /// The closest point to `p` within `limit`: exactly the result of the hierarchy over all faces.
    pub(super) fn closest(&self, faces: &Faces, p: DVec3, limit: f64) -> Option<Closest> {
        let levels = self.place.boxes.iter().zip(&self.trees).enumerate();
        let mut found = levels.map(|(level, (bounds, tree))| {
            within(bounds, p, limit, || {
                tree.get_or_init(|| self.tree(faces, level))
            })
        });
        found
            .find_map(|found| found)
            .unwrap_or_else(|| faces.all().closest(p, limit))
    }

    /// The hierarchy over the queried faces that meet one of the boxes.
    fn tree(&self, faces: &Faces, level: usize) -> Bvh {
        if level == 0 {
            let near = self.place.faces.iter().copied();
            return faces.over(near.filter(|&f| faces.is_wanted(f, false)).collect());
        }
        log::debug!("queries of a region exceed its box: a hierarchy over wider box {level}");
        let meets = |f: &u32| Bounds::of(faces.mesh.corners(*f)).meets(&self.place.boxes[level]);
        let wide = faces.list(false).filter(meets).collect();
        Bvh::for_few(faces.mesh, wide, faces.centre())
    }

    /// Calls `visit` with every face, including small components, whose bounding box meets the given one.
    pub(super) fn for_each_in_box(
        &self,
        faces: &Faces,
        bounds: &Bounds,
        mut visit: impl FnMut(u32),
    ) {
        let mut look = |f: u32| {
            let wanted = faces.is_wanted(f, false) || faces.is_wanted(f, true);
            if wanted && Bounds::of(faces.mesh.corners(f)).meets(bounds) {
                visit(f);
            }
        };
        match self.place.boxes[0].contains(bounds) {
            true => self.place.faces.iter().for_each(|&f| look(f)),
            false => (0..faces.mesh.faces.len() as u32).for_each(look),
        }
    }
}
