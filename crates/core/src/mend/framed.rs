//! The part of the mesh that a region needs, in the region's frame and in an order by position, and the way of its patch back.

use super::frame::Frame;
use crate::fill::{FillParams, PlacedPart, RegionPatch, WayBack};
use crate::mesh::topology::{end, start};
use crate::mesh::{Hole, Mesh, Topology, described};
use crate::region::VoxelSize;

/// A part of the mesh in the frame of a region.
pub(super) struct Framed {
    frame: Frame,
    /// The length of the frame's unit, in the mesh's units: the ratio of the diameters of the widest hole before and after rounding.
    unit: f64,
    /// The part: vertices in the order of their coordinates, each face from its lowest vertex on, faces in the order of their vertices.
    pub(super) mesh: Mesh,
    /// The connectivity of the part.
    pub(super) topology: Topology,
    /// The number that each vertex had before.
    vertices: Vec<u32>,
    /// The number of each vertex of the part.
    new_of: Vec<u32>,
    /// The number that each face had before.
    faces: Vec<u32>,
    /// The holes, in the order of their vertices.
    pub(super) holes: Vec<Hole>,
    /// The index that each hole had before.
    places: Vec<usize>,
    /// The parameters with lengths in the frame's unit.
    pub(super) params: FillParams,
}

impl Framed {
    /// A part with its holes; none where the rims have no frame, or are no rims after rounding.
    pub(super) fn new(part: &Mesh, given: &[Hole], params: &FillParams) -> Option<Self> {
        let frame = Frame::new(part, &given.iter().collect::<Vec<_>>())?;
        let (mesh, [vertices, new_of, faces]) = placed(part, &frame);
        let topology = Topology::without_orienting(&mesh);
        let rim = |hole: &Hole| {
            let mut rim: Vec<u32> = hole.rim.iter().map(|&v| new_of[v as usize]).collect();
            if frame.turns_faces() {
                rim.reverse();
            }
            let lowest = (0..rim.len()).min_by_key(|&i| rim[i]).unwrap_or(0);
            rim.rotate_left(lowest);
            rim
        };
        let mut rims: Vec<(Vec<u32>, usize)> = given.iter().map(rim).zip(0..).collect();
        rims.sort_unstable();
        let hole = |(rim, place): &(Vec<u32>, usize)| {
            Some(Hole {
                id: given[*place].id,
                outer_boundary: given[*place].outer_boundary,
                ..described(&mesh, &topology, &half_edges(&mesh, &topology, rim)?)
            })
        };
        let holes = rims.iter().map(hole).collect::<Option<Vec<Hole>>>()?;
        // The unit by which the holes have the diameters that they had before rounding.
        let widest = |holes: &[Hole]| holes.iter().map(|h| h.diameter).fold(0.0, f64::max);
        let unit = widest(given) / widest(&holes);
        let voxel = match params.voxel {
            VoxelSize::Length(length) => VoxelSize::Length(length / unit),
            VoxelSize::Auto => VoxelSize::Auto,
        };
        Some(Self {
            frame,
            unit,
            mesh,
            topology,
            vertices,
            new_of,
            faces,
            holes,
            places: rims.into_iter().map(|(_, place)| place).collect(),
            params: FillParams {
                voxel,
                ..params.clone()
            },
        })
    }

    /// Values of the faces, in their new order.
    pub(super) fn by_face(&self, values: &[bool]) -> Vec<bool> {
        self.faces.iter().map(|&f| values[f as usize]).collect()
    }

    /// Pairs of vertices, in their new numbers and order.
    pub(super) fn pairs(&self, pairs: &[[u32; 2]]) -> Vec<[u32; 2]> {
        let new = |v: u32| self.new_of.get(v as usize).copied().unwrap_or(u32::MAX);
        let mut pairs: Vec<[u32; 2]> = pairs.iter().map(|pair| pair.map(new)).collect();
        pairs.iter_mut().for_each(|pair| pair.sort_unstable());
        pairs.sort_unstable();
        pairs
    }

    /// Parts of a counterpart in the frame.
    pub(super) fn counterparts(&self, parts: &[PlacedPart]) -> Vec<PlacedPart> {
        let moved =
            |part: &PlacedPart| part.moved(|p| self.frame.of_world(p), self.frame.turns_faces());
        parts.iter().map(moved).collect()
    }

    /// A patch in the part's numbers, the mesh's coordinates and units.
    pub(super) fn returned(&self, mut patch: RegionPatch) -> RegionPatch {
        let old = |v: u32| self.vertices.get(v as usize).copied().unwrap_or(v);
        for p in &mut patch.mesh.positions {
            *p = self.frame.to_world(*p);
        }
        for face in &mut patch.mesh.faces {
            *face = face.map(old);
            if self.frame.turns_faces() {
                face.swap(1, 2);
            }
        }
        patch.returned(&WayBack {
            places: &self.places,
            unit: self.unit,
            point: &|p| self.frame.to_world(p),
            vertex: &old,
        })
    }
}

/// A part of the mesh in a frame, the number that each vertex had before and the one that it has now, and the number that each face had
/// before.
fn placed(part: &Mesh, frame: &Frame) -> (Mesh, [Vec<u32>; 3]) {
    let points: Vec<_> = part.positions.iter().map(|p| frame.of_world(*p)).collect();
    // The first coordinate beside the number: comparing seldom reads the others.
    let first = points.iter().map(|p| p.x).zip(0u32..);
    let mut vertices: Vec<(f64, u32)> = first.collect();
    vertices.sort_unstable_by(|(a, v), (x, w)| {
        let [p, q] = [v, w].map(|v| points[*v as usize]);
        let by_others = || p.y.total_cmp(&q.y).then(p.z.total_cmp(&q.z)).then(v.cmp(w));
        a.total_cmp(x).then_with(by_others)
    });
    let vertices: Vec<u32> = vertices.into_iter().map(|(_, v)| v).collect();
    let mut new_of = vec![0; vertices.len()];
    for (new, &old) in vertices.iter().enumerate() {
        new_of[old as usize] = new as u32;
    }
    let turns = frame.turns_faces();
    let face = |face: &[u32; 3]| {
        let mut face = face.map(|v| new_of[v as usize]);
        if turns {
            face.swap(1, 2);
        }
        let lowest = (0..3).min_by_key(|&k| face[k]).unwrap_or(0);
        face.rotate_left(lowest);
        face
    };
    let mut faces: Vec<([u32; 3], u32)> = part.faces.iter().map(face).zip(0..).collect();
    // Both orientations of a mesh have the same order.
    faces.sort_unstable_by_key(|&([a, b, c], number)| ([a, b.min(c), b.max(c)], number));
    let (corners, numbers) = faces.into_iter().unzip();
    let positions = vertices.iter().map(|&v| points[v as usize]).collect();
    (Mesh::new(positions, corners), [vertices, new_of, numbers])
}

/// The boundary half-edges of a rim, in its order; none where an edge of it is no boundary.
pub(super) fn half_edges(mesh: &Mesh, topology: &Topology, rim: &[u32]) -> Option<Vec<u32>> {
    let boundary = (0..topology.boundary.len() as u32).filter(|&h| topology.boundary[h as usize]);
    // In the direction of a patch.
    let mut by_ends: Vec<([u32; 2], u32)> = boundary
        .map(|h| ([end(mesh, h), start(mesh, h)], h))
        .collect();
    by_ends.sort_unstable();
    let edge = |i: usize| {
        let ends = [rim[i], rim[(i + 1) % rim.len()]];
        let at = by_ends.binary_search_by_key(&ends, |(ends, _)| *ends);
        at.ok().map(|at| by_ends[at].1)
    };
    (0..rim.len()).map(edge).collect()
}
