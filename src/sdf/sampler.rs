//! Signed distance samples of a mesh with holes.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::DVec3;

use super::jets::{Jet, fit_jet};
use crate::mesh::{
    Hole, Mesh, Part, Topology, VertexFaces, bounds, face_normal, topology::NONE, vertex_normal,
};
use crate::spatial::{Bvh, Closest, WindingTree};

/// What the mesh says about one point.
#[derive(Clone, Copy, Debug)]
pub struct DistanceSample {
    /// Signed distance, negative inside; to the smooth surface through the vertices where there is one.
    pub signed: f64,
    /// Distance to the triangles.
    pub distance: f64,
    /// The face that is closest, or one of them.
    pub face: u32,
    /// The closest point of the triangles.
    pub closest: DVec3,
    /// Whether the closest point lies on the rim of one of the region's holes: then the surface that is to be found may
    /// be closer, and `signed` is only a guess.
    pub on_rim: bool,
}

/// Where on the mesh a closest point lies.
enum Feature {
    Face,
    /// Half-edge.
    Edge(u32),
    Vertex(u32),
}

/// Signed distances of a welded mesh for one or more regions.
pub struct Sampler<'a> {
    mesh: &'a Mesh,
    topology: &'a Topology,
    smooth: Arc<Smooth>,
    bvh: Bvh,
    /// Small components, of one or two faces: no data, but the patch must be cut round them.
    small: Bvh,
    /// Gathered when it is first asked for.
    winding: OnceLock<WindingTree>,
    /// For pieces that were asked for, the winding number between their two sides.
    levels: Mutex<HashMap<u32, f64>>,
}

/// Faces of a piece at which the winding numbers of its two sides are looked up. On a surface that encloses something the
/// median of so many is right when less than half of them are near an opening.
const LEVEL_SAMPLES: usize = 33;

/// What all samplers of a mesh share: the smooth surface through the vertices, fitted where it is asked for.
struct Smooth {
    around: VertexFaces,
    jets: Vec<OnceLock<Option<Box<Jet>>>>,
    /// Faces that are in no hierarchy.
    degenerate: Vec<u32>,
    /// Up to [`LEVEL_SAMPLES`] faces of each piece, spread over it.
    spread: Vec<Vec<u32>>,
}

impl Smooth {
    fn new(mesh: &Mesh, topology: &Topology) -> Self {
        let mut degenerate = Vec::new();
        let mut spread: Vec<Vec<u32>> = vec![Vec::new(); topology.piece_faces.len()];
        let mut seen = vec![0usize; topology.piece_faces.len()];
        for (face, &piece) in topology.piece.iter().enumerate() {
            let Some(count) = topology.piece_faces.get(piece as usize) else {
                degenerate.push(face as u32);
                continue;
            };
            if seen[piece as usize].is_multiple_of(count.div_ceil(LEVEL_SAMPLES)) {
                spread[piece as usize].push(face as u32);
            }
            seen[piece as usize] += 1;
        }
        Self {
            around: VertexFaces::new(mesh),
            jets: (0..mesh.positions.len()).map(|_| OnceLock::new()).collect(),
            degenerate,
            spread,
        }
    }
}

impl<'a> Sampler<'a> {
    /// Prepares the queries over all faces but degenerate ones and small components (of at most two faces).
    pub fn new(mesh: &'a Mesh, topology: &'a Topology) -> Self {
        let smooth = Smooth::new(mesh, topology);
        Self::over(mesh, topology, Arc::new(smooth), &|_| true)
    }

    /// Queries over the faces of some pieces only.
    pub fn restricted(&self, wanted: &dyn Fn(u32) -> bool) -> Self {
        Self::over(self.mesh, self.topology, self.smooth.clone(), wanted)
    }

    fn over(
        mesh: &'a Mesh,
        topology: &'a Topology,
        smooth: Arc<Smooth>,
        wanted: &dyn Fn(u32) -> bool,
    ) -> Self {
        let faces = |small: bool| {
            (0..mesh.faces.len() as u32).filter(move |&f| {
                let piece = topology.piece[f as usize];
                piece != NONE
                    && wanted(piece)
                    && (topology.piece_faces[piece as usize] <= 2) == small
            })
        };
        let bvh = Bvh::new(mesh, faces(false));
        let small = Bvh::new(mesh, faces(true));
        Self {
            mesh,
            topology,
            smooth,
            bvh,
            small,
            winding: OnceLock::new(),
            levels: Mutex::default(),
        }
    }

    /// The hierarchy over the mesh's faces.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// The part of the mesh that meets the box from `low` to `high`, small components and degenerate faces included, with the given
    /// vertices.
    pub fn part(&self, low: DVec3, high: DVec3, vertices: impl Iterator<Item = u32>) -> Part {
        let mut faces = self.smooth.degenerate.clone();
        for tree in [&self.bvh, &self.small] {
            tree.for_each_in_box(low, high, |f| faces.push(f));
        }
        faces.sort_unstable();
        Part::new(self.mesh, &faces, vertices)
    }

    /// The part of the mesh round some rims.
    pub fn part_round(&self, rims: &[Vec<u32>]) -> Part {
        let vertices = || rims.iter().flatten().copied();
        let at = |v: u32| self.mesh.positions[v as usize];
        let (low, high) = bounds(vertices().map(at));
        let margin = DVec3::splat(0.01 * (high - low).max_element());
        self.part(low - margin, high + margin, vertices())
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        self.mesh
    }

    /// The closest point of the mesh without its small components, and whether it lies on a rim of the region.
    fn closest(&self, rims: &RimSet, x: DVec3, limit: f64) -> Option<(Closest, bool)> {
        let closest = self.bvh.closest(x, limit)?;
        let on_rim = self.on_rim(rims, &closest);
        Some((closest, on_rim))
    }

    /// The closest point of the mesh with its small components, and whether it lies on a rim of the region.
    pub fn closest_of_all(&self, rims: &RimSet, x: DVec3) -> Option<(Closest, bool)> {
        let whole = self.bvh.closest(x, f64::INFINITY);
        let limit = whole.map_or(f64::INFINITY, |c| c.distance);
        let closest = self.small.closest(x, limit).or(whole)?;
        let on_rim = self.on_rim(rims, &closest);
        Some((closest, on_rim))
    }

    fn on_rim(&self, rims: &RimSet, closest: &Closest) -> bool {
        match self.feature(closest) {
            Feature::Face => false,
            Feature::Edge(h) => rims.has_edge(self.mesh, h),
            Feature::Vertex(v) => rims.has_vertex(v),
        }
    }

    /// Samples the distance at `x`; `limit` is an upper bound of the distance that the caller knows. With `rough` the sign is
    /// that of the nearest face's side where a rim is nearest, which is cheap but often wrong.
    pub fn sample(
        &self,
        rims: &RimSet,
        x: DVec3,
        limit: f64,
        rough: bool,
    ) -> Option<DistanceSample> {
        self.sample_within(rims, x, limit, rough, f64::INFINITY)
    }

    /// The same, with the distance to the triangles instead of that to the smooth surface beyond `reach`.
    pub fn sample_within(
        &self,
        rims: &RimSet,
        x: DVec3,
        limit: f64,
        rough: bool,
        reach: f64,
    ) -> Option<DistanceSample> {
        let (closest, on_rim) = self.closest(rims, x, limit)?;
        let sign = match (on_rim, rough) {
            (true, true) => self.side(&closest, x),
            (true, false) if rims.closed => self.sign_by_winding(rims, x),
            _ => self.sign(rims, &closest, x),
        };
        let raw = sign * closest.distance;
        let signed = if on_rim || closest.distance > reach {
            raw
        } else {
            self.smooth(&closest, x, raw)
        };
        Some(DistanceSample {
            signed,
            distance: closest.distance,
            face: closest.face,
            closest: closest.point,
            on_rim,
        })
    }

    /// The winding number at a point.
    pub fn winding_number(&self, x: DVec3) -> f64 {
        let tree = self.winding.get_or_init(|| WindingTree::new(&self.bvh));
        tree.winding_number(&self.bvh, x)
    }

    /// The winding number between the two sides of a piece: what exceeds it is inside.
    ///
    /// One half where faces are counter-clockwise seen from outside and no other surface encloses the piece, less by one
    /// where the piece is inside out.
    pub fn level(&self, piece: u32) -> f64 {
        let known = || self.levels.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(&level) = known().get(&piece) {
            return level;
        }
        let outside = |&f: &u32| {
            let [a, b, c] = self.mesh.corners(f);
            let edge = (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0;
            let off = 1e-3 * edge * face_normal(self.mesh, f);
            self.winding_number((a + b + c) / 3.0 + off)
        };
        let mut outside: Vec<f64> = self.smooth.spread[piece as usize]
            .iter()
            .map(outside)
            .collect();
        outside.sort_by(f64::total_cmp);
        let median = outside.get(outside.len() / 2).copied().unwrap_or(0.0);
        let level = median.round() + 0.5;
        known().insert(piece, level);
        level
    }

    fn feature(&self, closest: &Closest) -> Feature {
        let w = closest.barycentric;
        let face = self.mesh.faces[closest.face as usize];
        match [w[0] == 0.0, w[1] == 0.0, w[2] == 0.0] {
            [false, false, false] => Feature::Face,
            [true, true, _] => Feature::Vertex(face[2]),
            [true, _, true] => Feature::Vertex(face[1]),
            [_, true, true] => Feature::Vertex(face[0]),
            [true, ..] => Feature::Edge(3 * closest.face + 1),
            [_, true, _] => Feature::Edge(3 * closest.face + 2),
            [_, _, true] => Feature::Edge(3 * closest.face),
        }
    }

    /// −1 inside, 1 outside: by the pseudonormal of the closest feature (Bærentzen and Aanæs, "Signed distance
    /// computation using the angle weighted pseudonormal", 2005), or by the winding number where it is of no use.
    fn sign(&self, rims: &RimSet, closest: &Closest, x: DVec3) -> f64 {
        let face = face_normal(self.mesh, closest.face);
        let normal = match self.feature(closest) {
            Feature::Face => face,
            Feature::Vertex(v) => vertex_normal(self.mesh, &self.smooth.around, v),
            Feature::Edge(h) => {
                let opposite = self.topology.opposite[h as usize];
                if opposite != NONE {
                    face + face_normal(self.mesh, opposite / 3)
                } else if self.topology.boundary[h as usize] {
                    face
                } else {
                    DVec3::ZERO
                }
            }
        };
        let side = normal.dot(x - closest.point);
        if side.abs() > 1e-3 * closest.distance * normal.length() || closest.distance == 0.0 {
            return if side < 0.0 { -1.0 } else { 1.0 };
        }
        self.sign_by_winding(rims, x)
    }

    fn sign_by_winding(&self, rims: &RimSet, x: DVec3) -> f64 {
        if self.winding_number(x) > rims.level {
            -1.0
        } else {
            1.0
        }
    }

    /// The side of the closest face on which a point lies.
    fn side(&self, closest: &Closest, x: DVec3) -> f64 {
        let along = face_normal(self.mesh, closest.face).dot(x - closest.point);
        if along < 0.0 { -1.0 } else { 1.0 }
    }

    fn jet(&self, vertex: u32) -> Option<&Jet> {
        let Smooth { around, jets, .. } = &*self.smooth;
        jets[vertex as usize]
            .get_or_init(|| fit_jet(self.mesh, around, vertex).map(Box::new))
            .as_deref()
    }

    /// The distance to the jets of the three corners, blended by the barycentric coordinates of the closest point.
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

/// The rims of one region's holes.
pub struct RimSet {
    edges: Vec<(u32, u32)>,
    vertices: Vec<u32>,
    /// Whether the pieces of these holes are closed once all their holes are filled.
    pub closed: bool,
    /// The winding number between the two sides of the surface, see [`Sampler::level`].
    pub level: f64,
}

impl RimSet {
    /// The rims of the given holes.
    pub fn new<'h>(holes: impl Iterator<Item = &'h Hole>, closed: bool) -> Self {
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
        Self {
            edges,
            vertices,
            closed,
            level: 0.5,
        }
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
