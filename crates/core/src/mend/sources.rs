//! Surroundings of each region: the components of the mesh that it takes as data, and where it searches for nearest points.

use crate::fill::widest_growth;
use crate::mesh::topology::NONE;
use std::collections::BTreeMap;

use glam::DVec3;

use super::Inspection;
use super::hole_group::HoleGroup;
use crate::mesh::{DisjointSets, Hole, Mesh, Topology};
use crate::region::{BoxSize, Region, Sphere, VoxelSize};
use crate::sdf::{JET_RINGS, Sampler, SearchArea, faces_at};
use crate::spatial::Bounds;

/// Upper bound of the faces in all restricted hierarchies together, in numbers of the mesh's faces.
const MOST_COPIES: usize = 8;
/// Sizes of a region's box. Faces up to this far outside the box are tested for intersections with the patch: farther than
/// `STITCH_MARGIN.get()`.
pub(super) const PATCH_MARGIN: f64 = 0.25;
/// Faces. A smaller mesh has one hierarchy over all of its faces, which takes at most 150 MB and a second.
const MANY_FACES: usize = 500_000;
/// Regions have hierarchies of their own if these together hold at most one in this many of the faces.
const NEAR_PART: usize = 2;
/// Sizes of the box of a region's first attempt. A region usually searches this far outside the box: the nearest surface point to
/// a corner of the box is half a size away where the surface is flat.
const USUAL_MARGIN: f64 = 0.6;
/// The same, for the few queries from corners of the box that are farther away. On tori with ten holes they went up to 1.42 sizes.
const WIDE_MARGIN: f64 = 1.5;

/// Rings of faces around the known faces that distances need: one more than jets, for the normals at the vertices that jets are
/// fitted to.
const RINGS: usize = JET_RINGS + 1;

/// The surroundings of each region.
///
/// A region knows the components that its rims are on. Others that merely pass through its box (fragments inside each other, a
/// second layer of a scan) would be inconsistent with them, and are left out.
pub(super) struct RegionSources<'a> {
    all: Sampler<'a>,
    restricted: Vec<Sampler<'a>>,
    /// For each group the index of its restricted sampler, if it needs one.
    of_group: Vec<Option<usize>>,
    /// For each group the bodies that it knows, if it has a restricted sampler.
    own: Vec<Option<Vec<u32>>>,
    /// For each group its search area; none where one hierarchy over the whole mesh is better.
    places: Option<Vec<SearchArea>>,
    bodies: Bodies,
}

impl<'a> RegionSources<'a> {
    /// `asked` is true for the groups that will sample distances. With `in_boxes`, a voxel, they search for nearest points only
    /// near their boxes.
    pub(super) fn new(
        found: &'a Inspection,
        groups: &[HoleGroup],
        asked: &dyn Fn(usize) -> bool,
        in_boxes: Option<VoxelSize>,
    ) -> Self {
        let all = Sampler::new(&found.mesh, &found.topology);
        let bodies = Bodies::new(found);
        let mut sets: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
        let mut restricted = Vec::new();
        let mut room = MOST_COPIES * found.mesh.faces.len();
        let mut restrict = |own: &Vec<u32>| {
            if let Some(&at) = sets.get(own) {
                return Some(at);
            }
            let faces: usize = own.iter().map(|&b| bodies.faces[b as usize]).sum();
            room = room.checked_sub(faces)?;
            let wanted = |component: u32| {
                own.binary_search(&bodies.of_component[component as usize])
                    .is_ok()
            };
            restricted.push(all.restricted(&wanted));
            sets.insert(own.clone(), restricted.len() - 1);
            Some(restricted.len() - 1)
        };
        let (mut of_group, mut of_bodies) = (Vec::new(), Vec::new());
        for (i, group) in groups.iter().enumerate() {
            let own = asked(i)
                .then(|| bodies.others_near(found, &group.holes))
                .flatten();
            let at = own.as_ref().and_then(&mut restrict);
            of_group.push(at);
            of_bodies.push(own.filter(|_| at.is_some()));
        }
        let large = found.mesh.faces.len() >= MANY_FACES;
        let places = in_boxes.filter(|_| large).and_then(|voxel| {
            let most = found.mesh.faces.len() / NEAR_PART;
            let hole = |h: &usize| &found.holes[*h];
            let holes = |group: &HoleGroup| group.holes.iter().map(hole).collect();
            let groups: Vec<Vec<&Hole>> = groups.iter().map(holes).collect();
            places(&found.mesh, &found.topology, &groups, voxel, most)
        });
        Self {
            all,
            restricted,
            of_group,
            own: of_bodies,
            places,
            bodies,
        }
    }

    /// For each component whether a group knows it; none where it knows the whole mesh.
    pub(super) fn known_components(&self, group: usize) -> Option<Vec<bool>> {
        let own = self.own[group].as_ref()?;
        let is_own = |body: &u32| own.binary_search(body).is_ok();
        Some(self.bodies.of_component.iter().map(is_own).collect())
    }

    /// The mesh's degenerate faces, in ascending order.
    pub(super) fn degenerate(&self) -> &[u32] {
        self.all.degenerate()
    }

    /// Adds the rings of faces that normals and jets of these faces need.
    pub(super) fn with_rings(&self, faces: &[u32]) -> Vec<u32> {
        self.all.with_rings(faces, RINGS)
    }

    /// The points relative to which distances are computed: for the surroundings of a group, and for the whole mesh.
    pub(super) fn centres(&self, group: usize) -> [DVec3; 2] {
        self.of(group).map(|sampler| sampler.centre())
    }

    /// The samplers of a group: of its surroundings, and of the whole mesh.
    pub(super) fn of(&self, group: usize) -> [Sampler<'a>; 2] {
        let known = self.of_group[group].map_or(&self.all, |at| &self.restricted[at]);
        [known, &self.all].map(|sampler| match &self.places {
            Some(places) => sampler.at(places[group].clone()),
            None => sampler.clone(),
        })
    }
}

/// The search areas of the regions of groups of holes; none if they hold more than `most` faces.
pub(super) fn places(
    mesh: &Mesh,
    topology: &Topology,
    groups: &[Vec<&Hole>],
    voxel: VoxelSize,
    most: usize,
) -> Option<Vec<SearchArea>> {
    let boxes = |holes: &Vec<&Hole>| search_boxes(mesh, holes, voxel);
    let boxes: Vec<[Bounds; 3]> = groups.iter().map(boxes).collect();
    let usual: Vec<Bounds> = boxes.iter().map(|boxes| boxes[0]).collect();
    let faces = faces_at(mesh, topology, &usual, most)?;
    let place = |(boxes, faces)| SearchArea { boxes, faces };
    Some(boxes.into_iter().zip(faces).map(place).collect())
}

/// The boxes in which a region with these holes searches for nearest points, in order; the last has the nearest points of all points of
/// the region.
pub(super) fn search_boxes(mesh: &Mesh, holes: &[&Hole], voxel: VoxelSize) -> [Bounds; 3] {
    let of = |voxel, growth| grown_box(mesh, holes, voxel, false, growth);
    let both = |growth| of(VoxelSize::Auto, growth).join(&of(voxel, growth));
    let (first, last) = (both(1.0), both(widest_growth()));
    let size = (first.high - first.low).max_element();
    // The rims are in the region: no nearest point is farther away than the region's diagonal.
    let diagonal = last.low.distance(last.high);
    let [usual, wide] = [USUAL_MARGIN, WIDE_MARGIN].map(|margin| first.widened(margin * size));
    [usual, wide, last.widened(diagonal)]
}

/// Components that share vertices, merged into bodies: non-manifold edges divide one surface into several components.
struct Bodies {
    of_component: Vec<u32>,
    faces: Vec<usize>,
    boxes: Vec<Bounds>,
}

impl Bodies {
    fn new(found: &Inspection) -> Self {
        let (mesh, topology) = (&found.mesh, &found.topology);
        let mut sets = DisjointSets::new(topology.component_faces.len());
        let mut first = vec![NONE; mesh.positions.len()];
        for (face, &component) in mesh.faces.iter().zip(&topology.component) {
            if component == NONE {
                continue;
            }
            for &v in face {
                let other = &mut first[v as usize];
                if *other == NONE {
                    *other = component;
                } else {
                    sets.join(*other, component);
                }
            }
        }
        let count = topology.component_faces.len();
        let of_component: Vec<u32> = (0..count as u32).map(|p| sets.find(p)).collect();
        let mut faces = vec![0; count];
        let nothing = Bounds {
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
        };
        let mut boxes = vec![nothing; count];
        for (face, &component) in mesh.faces.iter().zip(&topology.component) {
            if component == NONE || topology.is_loose(component) {
                continue;
            }
            let body = of_component[component as usize] as usize;
            faces[body] += 1;
            let corners = face.map(|v| mesh.positions[v as usize]);
            boxes[body] = boxes[body].join(&Bounds::of(corners));
        }
        Self {
            of_component,
            faces,
            boxes,
        }
    }

    /// The bodies of a group's rims, in ascending order, if the box of another body meets the region's; else none.
    fn others_near(&self, found: &Inspection, group: &[usize]) -> Option<Vec<u32>> {
        let component = |h: &usize| found.holes[*h].component as usize;
        let mut own: Vec<u32> = group
            .iter()
            .map(|h| self.of_component[component(h)])
            .collect();
        own.sort_unstable();
        own.dedup();
        let holes: Vec<_> = group.iter().map(|&h| &found.holes[h]).collect();
        let around = grown_box(&found.mesh, &holes, VoxelSize::Auto, false, widest_growth());
        let another = |(i, b): (usize, &Bounds)| {
            own.binary_search(&(i as u32)).is_err() && self.faces[i] > 0 && around.meets(b)
        };
        self.boxes.iter().enumerate().any(another).then_some(own)
    }
}

/// The box of a region whose margin has grown by a factor, on a fine or a coarse grid.
pub(super) fn grown_box(
    mesh: &Mesh,
    holes: &[&Hole],
    voxel: VoxelSize,
    coarse: bool,
    growth: f64,
) -> Bounds {
    let sphere = Sphere::new(mesh, holes).map(|s| s.bounds());
    let size = BoxSize {
        voxel,
        coarse,
        growth,
        refine: 1.0,
    };
    let region = Region::new(mesh, holes, &size, sphere);
    let low = region.lattice.origin;
    let size = DVec3::from_array(region.dims.map(f64::from)) * region.lattice.voxel;
    Bounds {
        low,
        high: low + size,
    }
}
