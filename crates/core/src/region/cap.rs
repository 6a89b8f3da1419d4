//! Caps rims with triangulations, to decide whether a point near a hole is inside or outside.
//!
//! The side is determined by the nearest point of the mesh and the triangulations together, by its angle-weighted pseudonormal.
//! So only the surroundings of the hole decide, and a mesh with reversed faces gets reversed signs.

use std::sync::OnceLock;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::distance::Wanted;
use crate::mesh::triangulate::triangulate_loop;
use crate::mesh::{Hole, Mesh, VertexNormals, face_normal};
use crate::sdf::{DistanceSample, Feature, RimSet, Sampler, feature, side};
use crate::spatial::{Bvh, Closest};

/// Relative difference. Two distances that differ by less are equal.
const EQUAL: f64 = 1e-9;

/// Rims of holes, and triangulations that cap them.
pub struct CappedRims {
    /// The rims. Where they are nearest, a part of the surface is missing.
    pub rims: RimSet,
    /// The rims that are triangulated.
    loops: Vec<Vec<u32>>,
    cap: OnceLock<Option<Cap>>,
}

/// Triangulations of rims, joined to the adjacent faces of the mesh.
struct Cap {
    /// The faces of the mesh around the rims, then the faces of the triangulations.
    joined: Mesh,
    normals: VertexNormals,
    /// Sums of the face normals at each edge of the triangulations.
    edges: FxHashMap<(u32, u32), DVec3>,
    /// The faces of the triangulations.
    faces: Bvh,
    /// Whether every rim could be triangulated.
    complete: bool,
}

impl CappedRims {
    /// The rims of these holes; the ones for which `capped` holds are triangulated.
    pub fn new<'h>(holes: &[&'h Hole], capped: impl Fn(&'h Hole) -> bool) -> Self {
        let capped = holes.iter().filter(|h| capped(h));
        Self {
            rims: RimSet::new(holes.iter().copied()),
            loops: capped.map(|h| h.rim.clone()).collect(),
            cap: OnceLock::new(),
        }
    }

    /// The empty set of rims, for a surface without holes.
    pub fn none() -> Self {
        Self::new(&[], |_| false)
    }

    /// The sample of the mesh at a world point; none where the mesh is farther than `limit`. Where a rim is nearest, the
    /// triangulations determine the sign.
    pub fn sample(
        &self,
        sampler: &Sampler,
        x: DVec3,
        limit: f64,
        wanted: &Wanted,
    ) -> Option<DistanceSample> {
        let mut sample = sampler.sample_within(&self.rims, x, limit, wanted.reach)?;
        if sample.on_rim
            && !wanted.any_sign
            && let Some(cap) = self.cap(sampler)
        {
            let limit = sample.distance * (1.0 + EQUAL) + f64::MIN_POSITIVE;
            if let Some(c) = cap.faces.closest(x, limit) {
                sample.signed = sample.distance * cap.side(&c, x);
            }
        }
        Some(sample)
    }

    /// The signed distance to the mesh and the triangulations, in world units; none where a rim could not be triangulated.
    pub fn signed_distance(&self, sampler: &Sampler, x: DVec3) -> Option<f64> {
        let cap = self.cap(sampler).filter(|cap| cap.complete)?;
        let to_cap = cap.faces.closest(x, f64::INFINITY)?;
        let limit = to_cap.distance * (1.0 + EQUAL) + f64::MIN_POSITIVE;
        // Where a face coincides with a triangulation, the mesh's side counts.
        match sampler.closest(&self.rims, x, limit) {
            Some((c, on_rim)) if !on_rim || c.distance < to_cap.distance * (1.0 - EQUAL) => {
                Some(c.distance * sampler.sign(&c, x))
            }
            _ => Some(to_cap.distance * cap.side(&to_cap, x)),
        }
    }

    /// The signed distance to the triangulations in world units; none where it is not less than `below`, or no rim could be
    /// triangulated.
    pub fn distance_to_cap(&self, sampler: &Sampler, x: DVec3, below: f64) -> Option<f64> {
        let cap = self.cap(sampler)?;
        let closest = cap.faces.closest(x, below * (1.0 - EQUAL))?;
        Some(closest.distance * cap.side(&closest, x))
    }

    /// The world positions of the triangulated rims' vertices, rim by rim.
    pub fn positions<'m>(&'m self, mesh: &'m Mesh) -> impl Iterator<Item = DVec3> + 'm {
        let vertices = self.loops.iter().flatten();
        vertices.map(|&v| mesh.positions[v as usize])
    }

    fn cap(&self, sampler: &Sampler) -> Option<&Cap> {
        let make = || Cap::new(sampler, &self.loops);
        self.cap.get_or_init(make).as_ref()
    }
}

impl Cap {
    /// None where no loop could be triangulated.
    fn new(sampler: &Sampler, loops: &[Vec<u32>]) -> Option<Self> {
        let part = sampler.part_round(loops);
        let mut joined = part.mesh.clone();
        let first = joined.faces.len() as u32;
        let mut complete = true;
        for rim in loops {
            let rim: Vec<u32> = rim.iter().map(|&v| part.local(v)).collect();
            match triangulate_loop(&part.mesh, &rim) {
                Ok(faces) => joined.faces.extend(faces),
                Err(_) => complete = false,
            }
        }
        let count = joined.faces.len() as u32;
        if first == count {
            return None;
        }
        let mut edges: FxHashMap<(u32, u32), DVec3> = (first..count)
            .flat_map(|f| face_edges(&joined, f))
            .map(|edge| (edge, DVec3::ZERO))
            .collect();
        for f in 0..count {
            for edge in face_edges(&joined, f) {
                if let Some(sum) = edges.get_mut(&edge) {
                    *sum += face_normal(&joined, f);
                }
            }
        }
        Some(Self {
            normals: VertexNormals::new(&joined),
            faces: Bvh::new(&joined, first..count),
            joined,
            edges,
            complete,
        })
    }

    /// −1 where a point is on the inner side of the closest point of a triangulation, otherwise 1.
    fn side(&self, closest: &Closest, x: DVec3) -> f64 {
        let mesh = &self.joined;
        let around = |v: u32| self.normals.around().of(v).iter().copied();
        match feature(mesh, closest) {
            Feature::Face => side(face_normal(mesh, closest.face), mesh, [], closest, x),
            Feature::Edge(h) => {
                let edge = face_edges(mesh, h / 3)[h as usize % 3];
                let beside = around(edge.0).filter(|&f| mesh.faces[f as usize].contains(&edge.1));
                side(self.edges[&edge], mesh, beside, closest, x)
            }
            Feature::Vertex(v) => side(self.normals.of(mesh, v), mesh, around(v), closest, x),
        }
    }
}

/// The edges of a face, in order, the smaller vertex of each first.
fn face_edges(mesh: &Mesh, face: u32) -> [(u32, u32); 3] {
    let [a, b, c] = mesh.faces[face as usize];
    [(a, b), (b, c), (c, a)].map(|(v, w)| (v.min(w), v.max(w)))
}
