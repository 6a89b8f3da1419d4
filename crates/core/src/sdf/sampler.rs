//! Signed distance sampling of a mesh with holes.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use super::jets::{Jet, fit_jet};
use super::near::{Faces, Near, SearchArea};
use super::side::{Feature, feature, side};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{Hole, Mesh, Part, Topology, VertexNormals, bounds, face_normal};
use crate::spatial::{Bounds, Bvh, Closest};

/// The distance of one point to the mesh.
#[derive(Clone, Copy, Debug)]
pub struct DistanceSample {
    /// Signed distance in world units, negative inside: to the smooth surface through the vertices where one could be fitted.
    pub signed: f64,
    /// Distance to the triangles, in world units.
    pub distance: f64,
    /// The closest point on the triangles, or one of them.
    pub closest: Closest,
    /// Whether the closest point is on the rim of one of the region's holes. Then the unknown surface may be closer, and the sign
    /// of `signed`, which is from the nearest face, is often wrong.
    pub on_rim: bool,
}

/// Signed distance queries on a welded mesh, for one or more regions.
#[derive(Clone)]
pub struct Sampler<'a> {
    mesh: &'a Mesh,
    topology: &'a Topology,
    smooth: Arc<Smooth>,
    /// The queried faces. Small components (one or two faces) are not data, but the patch must be cut around them.
    faces: Arc<Faces<'a>>,
    /// The part of the mesh that is queried, if not all of it.
    near: Option<Arc<Near>>,
}

/// Consecutive vertices whose jets are stored together once one of them is fitted: in a large mesh most never are.
const PAGE: usize = 256;

/// The jets of consecutive vertices, each fitted on demand; none where the fit fails.
type JetPage = Vec<OnceLock<Option<Box<Jet>>>>;

fn unset<T>(count: usize) -> Vec<OnceLock<T>> {
    (0..count).map(|_| OnceLock::new()).collect()
}

/// Data shared by all samplers of a mesh: the smooth surface through the vertices, fitted on demand.
struct Smooth {
    normals: VertexNormals,
    jets: Vec<OnceLock<JetPage>>,
    /// Degenerate faces, which are in no hierarchy.
    degenerate: Vec<u32>,
}

impl Smooth {
    fn new(mesh: &Mesh, topology: &Topology) -> Self {
        let faces = topology.component.iter().zip(0u32..);
        Self {
            normals: VertexNormals::new(mesh),
            jets: unset(mesh.positions.len().div_ceil(PAGE)),
            degenerate: faces.filter(|(p, _)| **p == NONE).map(|(_, f)| f).collect(),
        }
    }
}

impl<'a> Sampler<'a> {
    /// Prepares queries over all faces except degenerate ones and small components (of at most two faces).
    pub fn new(mesh: &'a Mesh, topology: &'a Topology) -> Self {
        let smooth = Smooth::new(mesh, topology);
        Self::over(mesh, topology, Arc::new(smooth), &|_| true)
    }

    /// A sampler of only some components.
    pub fn restricted(&self, wanted: &dyn Fn(u32) -> bool) -> Self {
        Self::over(self.mesh, self.topology, self.smooth.clone(), wanted)
    }

    fn over(
        mesh: &'a Mesh,
        topology: &'a Topology,
        smooth: Arc<Smooth>,
        wanted: &dyn Fn(u32) -> bool,
    ) -> Self {
        Self {
            mesh,
            topology,
            smooth,
            faces: Arc::new(Faces::new(mesh, topology, wanted)),
            near: None,
        }
    }

    /// A sampler for the queries of one region: it gives the same results, and needs less memory as long as queries stay near the
    /// region.
    pub fn at(&self, place: SearchArea) -> Self {
        Self {
            smooth: self.smooth.clone(),
            faces: self.faces.clone(),
            near: Some(Arc::new(Near::new(place))),
            ..*self
        }
    }

    /// The mesh's degenerate faces, which are in no hierarchy, in rising order.
    pub fn degenerate(&self) -> &[u32] {
        &self.smooth.degenerate
    }

    /// The given faces and those up to `rings` rings of vertices away from them, in rising order.
    pub fn with_rings(&self, faces: &[u32], rings: usize) -> Vec<u32> {
        let mut is_in = vec![false; self.mesh.faces.len()];
        let mut is_done = vec![false; self.mesh.positions.len()];
        faces.iter().for_each(|&f| is_in[f as usize] = true);
        let (mut all, mut last) = (faces.to_vec(), 0..faces.len());
        for _ in 0..rings {
            for i in last.clone() {
                let corners = self.mesh.faces[all[i] as usize].into_iter();
                let new = corners.filter(|v| !std::mem::replace(&mut is_done[*v as usize], true));
                for &next in new.flat_map(|v| self.smooth.normals.around().of(v)) {
                    if !std::mem::replace(&mut is_in[next as usize], true) {
                        all.push(next);
                    }
                }
            }
            last = last.end..all.len();
        }
        all.sort_unstable();
        all
    }

    /// The origin of coordinates for distances: samples of a part of the mesh with the same origin are equal to the last bit.
    pub fn centre(&self) -> DVec3 {
        self.faces.centre()
    }

    /// The same sampler with another origin of coordinates.
    #[must_use]
    pub fn about(&self, centre: DVec3) -> Self {
        Self {
            smooth: self.smooth.clone(),
            faces: Arc::new(self.faces.about(centre)),
            near: None,
            ..*self
        }
    }

    /// The hierarchy over the mesh's faces.
    pub fn bvh(&self) -> &Bvh {
        self.faces.all()
    }

    /// Calls `visit` with every face whose bounding box meets the given one, including small components, without degenerate faces.
    pub fn for_each_in_box(&self, bounds: &Bounds, mut visit: impl FnMut(u32)) {
        match &self.near {
            Some(near) => near.for_each_in_box(&self.faces, bounds, visit),
            None => {
                for tree in [self.faces.all(), self.faces.small()] {
                    tree.for_each_in_box(bounds.low, bounds.high, &mut visit);
                }
            }
        }
    }

    /// The part of the mesh that meets the box from `low` to `high`, including small components and degenerate faces, with the
    /// given vertices.
    pub fn part(&self, low: DVec3, high: DVec3, vertices: impl Iterator<Item = u32>) -> Part {
        let mut faces = self.smooth.degenerate.clone();
        self.for_each_in_box(&Bounds { low, high }, |f| faces.push(f));
        faces.sort_unstable();
        Part::new(self.mesh, &faces, vertices)
    }

    /// The part of the mesh around some rims.
    pub fn part_round(&self, rims: &[Vec<u32>]) -> Part {
        let vertices = || rims.iter().flatten().copied();
        let at = |v: u32| self.mesh.positions[v as usize];
        let (low, high) = bounds(vertices().map(at));
        let margin = DVec3::splat(0.01 * (high - low).max_element());
        self.part(low - margin, high + margin, vertices())
    }

    /// Whether a component is small (at most two faces) and therefore not data.
    pub fn is_small(&self, component: u32) -> bool {
        let faces = self.topology.component_faces.get(component as usize);
        faces.is_some_and(|&n| n <= 2)
    }

    /// The unit normal of a vertex.
    pub fn normal(&self, vertex: u32) -> DVec3 {
        self.smooth.normals.of(self.mesh, vertex)
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        self.mesh
    }

    /// The closest point of the mesh without small components, and whether it is on a rim of the region. `None` if nothing is
    /// within `limit` (world units).
    pub fn closest(&self, rims: &RimSet, x: DVec3, limit: f64) -> Option<(Closest, bool)> {
        let closest = self.closest_within(x, limit)?;
        let on_rim = self.on_rim(rims, &closest);
        Some((closest, on_rim))
    }

    /// The closest point of the mesh including small components, and whether it is on a rim of the region. `None` for a mesh
    /// without faces.
    pub fn closest_of_all(&self, rims: &RimSet, x: DVec3) -> Option<(Closest, bool)> {
        let whole = self.closest_within(x, f64::INFINITY);
        let limit = whole.map_or(f64::INFINITY, |c| c.distance);
        let closest = self.faces.small().closest(x, limit).or(whole)?;
        let on_rim = self.on_rim(rims, &closest);
        Some((closest, on_rim))
    }

    fn closest_within(&self, x: DVec3, limit: f64) -> Option<Closest> {
        match &self.near {
            Some(near) => near.closest(&self.faces, x, limit),
            None => self.faces.all().closest(x, limit),
        }
    }

    fn on_rim(&self, rims: &RimSet, closest: &Closest) -> bool {
        match feature(self.mesh, closest) {
            Feature::Face => false,
            Feature::Edge(h) => rims.has_edge(self.mesh, h),
            Feature::Vertex(v) => rims.has_vertex(v),
        }
    }

    /// Whether a closest point is on a boundary edge that belongs to none of the region's rims.
    pub fn on_other_border(&self, rims: &RimSet, closest: &Closest) -> bool {
        let is_border = |h: u32| self.topology.boundary[h as usize];
        match feature(self.mesh, closest) {
            Feature::Face => false,
            Feature::Edge(h) => is_border(h) && !rims.has_edge(self.mesh, h),
            Feature::Vertex(v) => {
                let faces = self.smooth.normals.around().of(v).iter();
                let mut edges = faces.flat_map(|&f| [3 * f, 3 * f + 1, 3 * f + 2]);
                let at_vertex = |h: u32| start(self.mesh, h) == v || end(self.mesh, h) == v;
                !rims.has_vertex(v) && edges.any(|h| at_vertex(h) && is_border(h))
            }
        }
    }

    /// Samples the distance at the world point `x`. `limit` is an upper bound of the distance known to the caller, in world
    /// units. `None` if the mesh is farther away.
    pub fn sample(&self, rims: &RimSet, x: DVec3, limit: f64) -> Option<DistanceSample> {
        self.sample_within(rims, x, limit, f64::INFINITY)
    }

    /// The same, but beyond `reach` with the distance to the triangles instead of the smooth surface.
    pub fn sample_within(
        &self,
        rims: &RimSet,
        x: DVec3,
        limit: f64,
        reach: f64,
    ) -> Option<DistanceSample> {
        let (closest, on_rim) = self.closest(rims, x, limit)?;
        let signed = if on_rim {
            let along = face_normal(self.mesh, closest.face).dot(x - closest.point);
            closest.distance.copysign(along)
        } else {
            let raw = self.sign(&closest, x) * closest.distance;
            if closest.distance > reach {
                raw
            } else {
                self.smooth(&closest, x, raw)
            }
        };
        Some(DistanceSample {
            signed,
            distance: closest.distance,
            closest,
            on_rim,
        })
    }

    /// −1 if a point is on the inner side of the closest point, otherwise 1: by the pseudonormal of face, edge or vertex
    /// (Bærentzen and Aanæs 2005).
    pub fn sign(&self, closest: &Closest, x: DVec3) -> f64 {
        let (mesh, around) = (self.mesh, self.smooth.normals.around());
        let face = || face_normal(mesh, closest.face);
        match feature(mesh, closest) {
            Feature::Face => side(face(), mesh, [], closest, x),
            Feature::Vertex(v) => {
                let faces = around.of(v).iter().copied();
                side(self.smooth.normals.of(mesh, v), mesh, faces, closest, x)
            }
            Feature::Edge(h) => {
                let opposite = self.topology.opposite[h as usize];
                let normal = if opposite != NONE {
                    face() + face_normal(mesh, opposite / 3)
                } else if self.topology.boundary[h as usize] {
                    face()
                } else {
                    DVec3::ZERO
                };
                let (v, w) = (start(mesh, h), end(mesh, h));
                let faces = around.of(v).iter().copied();
                let at_edge = faces.filter(|&f| mesh.faces[f as usize].contains(&w));
                side(normal, mesh, at_edge, closest, x)
            }
        }
    }

    fn jet(&self, vertex: u32) -> Option<&Jet> {
        let Smooth { normals, jets, .. } = &*self.smooth;
        let page = jets[vertex as usize / PAGE].get_or_init(|| unset(PAGE));
        page[vertex as usize % PAGE]
            .get_or_init(|| fit_jet(self.mesh, normals.around(), vertex).map(Box::new))
            .as_deref()
    }

    /// The distances to the jets of the three corners, blended by the barycentric coordinates of the closest point. A jet is used
    /// only if it is trusted and its distance differs little from `raw`.
    fn smooth(&self, closest: &Closest, x: DVec3, raw: f64) -> f64 {
        let face = self.mesh.faces[closest.face as usize];
        let [a, b, c] = face.map(|v| self.mesh.positions[v as usize]);
        let edge = (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0;
        let bound = (0.5 * edge).max(0.1 * raw.abs());
        let mut sum = 0.0;
        for (k, &v) in face.iter().enumerate() {
            let weight = closest.barycentric[k];
            let jet = if weight > 0.0 { self.jet(v) } else { None };
            let smooth = jet
                .filter(|j| j.trust > 0.0)
                .and_then(|j| j.signed_distance(x).map(|d| (d, j.trust)))
                .filter(|(d, _)| (d - raw).abs() < bound);
            sum += weight
                * match smooth {
                    Some((d, trust)) => trust * d + (1.0 - trust) * raw,
                    None => raw,
                };
        }
        sum
    }
}

/// The rims of a region's holes.
pub struct RimSet {
    edges: Vec<(u32, u32)>,
    vertices: Vec<u32>,
}

impl RimSet {
    /// The rims of the given holes.
    pub fn new<'h>(holes: impl Iterator<Item = &'h Hole>) -> Self {
        let (mut edges, mut vertices) = (Vec::new(), Vec::new());
        for hole in holes {
            for (i, &v) in hole.rim.iter().enumerate() {
                let w = hole.rim[(i + 1) % hole.rim.len()];
                edges.push((v.min(w), v.max(w)));
                vertices.push(v);
            }
        }
        edges.sort_unstable();
        vertices.sort_unstable();
        Self { edges, vertices }
    }

    fn has_edge(&self, mesh: &Mesh, half_edge: u32) -> bool {
        let face = mesh.faces[half_edge as usize / 3];
        let k = half_edge as usize % 3;
        let (v, w) = (face[k], face[(k + 1) % 3]);
        self.edges.binary_search(&(v.min(w), v.max(w))).is_ok()
    }

    fn has_vertex(&self, vertex: u32) -> bool {
        self.vertices.binary_search(&vertex).is_ok()
    }
}
