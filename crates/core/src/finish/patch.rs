//! A patch and its neighbourhood as a local mesh, in units of the hole's diameter.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::OnceLock;

use glam::DVec3;
use sprs::CsMat;

use super::COLLAR;
use super::geometry::{Faces, vertex_normals};
use super::report::Refusal;
use super::surroundings::Surroundings;
use crate::cancel::Cancel;
use crate::linalg::LdlPattern;
use crate::tuning::{Tunable, tunable};

/// Rings of edges. Least width of the neighbourhood of a patch.
const RINGS: Tunable<usize> = tunable("finish.rings", 4);

/// Mean edges. The neighbourhood is wider than the data by this, so that normals are known at the data.
const DATA_MARGIN: Tunable<f64> = tunable("finish.data_margin", 3.0);

/// Diameters. Lower bound of an edge length in distances along edges.
const LEAST_EDGE: Tunable<f64> = tunable("finish.least_edge", 1e-12);

/// Points. Up to this many points their diameter is the maximum over all pairs; above, it is found by repeatedly going to
/// the farthest point.
const ALL_PAIRS: Tunable<usize> = tunable("finish.all_pairs", 1500);

/// Diameters. Width of the narrow test ring: known vertices closer to the rim than this. It tests the rim alone; the wide
/// ring has more data where there is noise. With either ring alone errors were larger by 0.7 to 1.5 % on 143 holes of
/// scans.
const NARROW_RING: Tunable<f64> = tunable("finish.narrow_ring", 0.06);

/// Mean edges. Least width of the narrow ring: just above 1, so that it holds the first ring of vertices of a small hole
/// and no other. On four holes of scans 0.7, which leaves the ring of a small hole empty, made the error larger by 9.5 %,
/// 1.4 by 4.6 %.
const NARROW_RING_EDGES: Tunable<f64> = tunable("finish.narrow_ring_edges", 1.01);
const _: () = assert!(NARROW_RING_EDGES.chosen() > 1.0 && NARROW_RING_EDGES.chosen() < 1.1);

/// Diameters. Width of the wide test ring. On 12 holes of scans 0.08 made patches 3 % worse, 0.17 changed less than 1 %.
const WIDE_RING: Tunable<f64> = tunable("finish.wide_ring", 0.12);

/// Mean edges. Least width of the wide ring.
const WIDE_RING_EDGES: Tunable<f64> = tunable("finish.wide_ring_edges", 1.5);

/// The rings of the ring test: known vertices closer to the rim than this fraction of the diameter, or this number of mean edges,
/// whichever is farther.
pub(super) fn test_rings() -> [(f64, f64); 2] {
    [
        (NARROW_RING.get(), NARROW_RING_EDGES.get()),
        (WIDE_RING.get(), WIDE_RING_EDGES.get()),
    ]
}

/// A patch and the mesh around it; the origin is the middle of the rim, the unit its diameter.
#[derive(Clone)]
pub(super) struct Patch {
    /// Positions of the vertices.
    pub(super) points: Vec<DVec3>,
    /// All faces, including the patch's.
    pub(super) faces: Vec<[u32; 3]>,
    /// Whether a vertex may move.
    pub(super) moving: Vec<bool>,
    /// Whether a vertex may serve as data.
    pub(super) known: Vec<bool>,
    /// Whether a vertex is on an open border of the neighbourhood.
    pub(super) border: Vec<bool>,
    /// Distance along edges of each vertex from the moving vertices.
    pub(super) distance: Vec<f64>,
    /// Fixed vertices that share a face with moving ones.
    pub(super) rim: Vec<u32>,
    /// The largest distance between two rim vertices: 1, except for the wider holes of the ring test.
    pub(super) diameter: f64,
    /// Mean length of the edges around the patch.
    pub(super) edge: f64,
    /// The faces on which the energy of the patch depends.
    pub(super) closure: PatchSupport,
    /// Cancels computations on the patch.
    pub(super) cancel: Cancel,
}

/// The vertices whose curvature depends on the patch, and all faces around them, with local numbers.
#[derive(Clone)]
pub(super) struct PatchSupport {
    /// The patch's number of each vertex, in rising order.
    pub(super) vertices: Vec<u32>,
    /// All faces.
    pub(super) faces: Vec<[u32; 3]>,
    /// The faces with a moving vertex.
    pub(super) patch_faces: Vec<[u32; 3]>,
    /// Moving vertices, in rising order.
    pub(super) moving: Vec<u32>,
    /// Moving vertices and rim vertices, in rising order.
    pub(super) acting: Vec<u32>,
    /// Rim vertices, in rising order.
    pub(super) rim: Vec<u32>,
    /// For systems whose equations reach one, two and three rings of vertices, the analysis of their matrix.
    patterns: [OnceLock<LdlPattern>; 3],
}

impl PatchSupport {
    fn new(count: usize, faces: &Faces, moving: &[bool]) -> Self {
        let any = |mask: &[bool], f: &[u32; 3]| f.iter().any(|&v| mask[v as usize]);
        let mut acting = vec![false; count];
        for face in faces.iter().filter(|f| any(moving, f)) {
            face.iter().for_each(|&v| acting[v as usize] = true);
        }
        let near: Vec<[u32; 3]> = faces.iter().copied().filter(|f| any(&acting, f)).collect();
        let mut vertices: Vec<u32> = near.iter().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let own = |v: u32| vertices.partition_point(|&w| w < v) as u32;
        let local = |f: &[u32; 3]| f.map(own);
        let chosen = |mask: &dyn Fn(u32) -> bool| {
            let all = vertices.iter().enumerate();
            all.filter(|(_, v)| mask(**v))
                .map(|(i, _)| i as u32)
                .collect()
        };
        Self {
            faces: near.iter().map(local).collect(),
            patch_faces: near.iter().filter(|f| any(moving, f)).map(local).collect(),
            moving: chosen(&|v| moving[v as usize]),
            acting: chosen(&|v| acting[v as usize]),
            rim: chosen(&|v| acting[v as usize] && !moving[v as usize]),
            vertices,
            patterns: Default::default(),
        }
    }

    /// The values of the moving vertices.
    pub(super) fn moved<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.moving.iter().map(|&v| values[v as usize]).collect()
    }
}

/// A patch and some rings of faces around it, with local numbers.
pub(super) struct Neighbourhood {
    pub(super) points: Vec<DVec3>,
    pub(super) faces: Vec<[u32; 3]>,
    /// Moving vertices, in rising order.
    pub(super) moving: Vec<u32>,
}

impl Patch {
    /// The analysis of a matrix with an equation and an unknown for each moving vertex, in their order, whose equations reach `rings`
    /// rings of vertices: at most three, and all such matrices have one pattern. It is done once.
    pub(super) fn pattern(&self, rings: usize, matrix: &CsMat<f64>) -> &LdlPattern {
        let analyse = || LdlPattern::new(matrix, &self.cancel);
        self.closure.patterns[rings - 1].get_or_init(analyse)
    }

    /// The patch in the given shape, with `rings` rings of faces around its own.
    pub(super) fn neighbourhood(&self, rings: usize, shape: &[DVec3]) -> Neighbourhood {
        let mut inside = self.moving.clone();
        for _ in 0..rings {
            let before = inside.clone();
            let any = |f: &&[u32; 3]| f.iter().any(|&v| before[v as usize]);
            for &v in self.faces.iter().filter(any).flatten() {
                inside[v as usize] = true;
            }
        }
        let all = 0..self.points.len() as u32;
        let ids: Vec<u32> = all.filter(|&v| inside[v as usize]).collect();
        let mut number = vec![0; self.points.len()];
        for (&v, i) in ids.iter().zip(0u32..) {
            number[v as usize] = i;
        }
        let own = |v: u32| number[v as usize];
        let whole = |f: &&[u32; 3]| f.iter().all(|&v| inside[v as usize]);
        let faces = self.faces.iter().filter(whole).map(|f| f.map(own));
        let mut points: Vec<DVec3> = ids.iter().map(|&v| self.points[v as usize]).collect();
        let moving = self.closure.moving.iter();
        let moving: Vec<u32> = moving
            .map(|&v| own(self.closure.vertices[v as usize]))
            .collect();
        for (&v, p) in moving.iter().zip(shape) {
            points[v as usize] = *p;
        }
        Neighbourhood {
            faces: faces.collect(),
            points,
            moving,
        }
    }

    /// Mean edge length of the known faces within half a diameter or at the rim; `None` if there are none.
    fn mean_edge(&self) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0.0);
        for face in &self.faces {
            let is_near =
                |&v: &u32| self.distance[v as usize] < 0.5 || self.rim.binary_search(&v).is_ok();
            let near = face.iter().any(is_near);
            if near && !face.iter().any(|&v| self.moving[v as usize]) {
                let [a, b, c] = face.map(|v| self.points[v as usize]);
                sum += a.distance(b) + b.distance(c) + c.distance(a);
                count += 3.0;
            }
        }
        (sum > 0.0).then_some(sum / count)
    }

    /// Positions of the moving vertices.
    pub(super) fn shape(&self) -> Vec<DVec3> {
        let moving = self.closure.moving.iter();
        moving
            .map(|&v| self.points[self.closure.vertices[v as usize] as usize])
            .collect()
    }

    /// Positions of all vertices, with the moving ones in the given shape.
    pub(super) fn placed(&self, shape: &[DVec3]) -> Vec<DVec3> {
        let mut points = self.points.clone();
        for (&v, p) in self.closure.moving.iter().zip(shape) {
            points[self.closure.vertices[v as usize] as usize] = *p;
        }
        points
    }

    /// Positions of the closure's vertices, with the moving ones in the given shape.
    pub(super) fn closure_points(&self, shape: &[DVec3]) -> Vec<DVec3> {
        let vertices = self.closure.vertices.iter();
        let mut points: Vec<DVec3> = vertices.map(|&v| self.points[v as usize]).collect();
        for (&v, p) in self.closure.moving.iter().zip(shape) {
            points[v as usize] = *p;
        }
        points
    }

    /// Distances along edges of the moving vertices from the rim.
    pub(super) fn depth(&self) -> Vec<f64> {
        let points = self.closure_points(&self.shape());
        let mut from = vec![false; points.len()];
        self.closure
            .rim
            .iter()
            .for_each(|&v| from[v as usize] = true);
        let distances = edge_distances(&points, &self.closure.patch_faces, &from);
        self.closure.moved(&distances)
    }

    /// Positions of the rim vertices.
    pub(super) fn rim_points(&self) -> Vec<DVec3> {
        let rim = self.rim.iter();
        rim.map(|&v| self.points[v as usize]).collect()
    }

    /// Unit vertex normals, computed without the faces of the patch.
    pub(super) fn known_normals(&self) -> Vec<DVec3> {
        let is_patch = |f: &&[u32; 3]| f.iter().any(|&v| self.moving[v as usize]);
        let faces = self.faces.iter().filter(|f| !is_patch(f));
        vertex_normals(&self.points, &faces.copied().collect::<Vec<_>>())
    }

    /// The patch of the wider hole without the known vertices in `ring`. `shape` has the positions of this patch's own vertices;
    /// those deeper than `deepest` (distance from the rim) stay fixed there.
    pub(super) fn enlarged(&self, ring: &[u32], shape: &[DVec3], deepest: f64) -> Self {
        let points = self.placed(shape);
        let (mut moving, mut known) = (self.moving.clone(), self.known.clone());
        if deepest.is_finite() {
            for (&v, depth) in self.closure.moving.iter().zip(self.depth()) {
                moving[self.closure.vertices[v as usize] as usize] = depth <= deepest;
            }
        }
        for &v in ring {
            moving[v as usize] = true;
            known[v as usize] = false;
        }
        let closure = PatchSupport::new(points.len(), &self.faces, &moving);
        let rim: Vec<u32> = closure
            .rim
            .iter()
            .map(|&v| closure.vertices[v as usize])
            .collect();
        let at: Vec<DVec3> = rim.iter().map(|&v| points[v as usize]).collect();
        Self {
            distance: edge_distances(&points, &self.faces, &moving),
            diameter: diameter(&at),
            faces: self.faces.clone(),
            border: self.border.clone(),
            edge: self.edge,
            points,
            moving,
            known,
            rim,
            closure,
            cancel: self.cancel.clone(),
        }
    }
}

/// How far data may be from the patch along edges, in diameters of the hole. The wider hole of a ring test is wider by two widths
/// of the ring, and its data are within the collar's fraction of its diameter from the ring.
fn reach(edge: f64) -> f64 {
    let [_, widest] = test_rings();
    let ring = widest.0.max(widest.1 * edge);
    COLLAR.get() * (1.0 + 2.0 * ring) + ring
}

/// A patch and its place in the mesh.
pub(super) struct Located {
    /// The patch.
    pub(super) patch: Patch,
    /// The origin of the patch's coordinates.
    pub(super) centre: DVec3,
    /// The unit of the patch's coordinates: the diameter of the hole.
    pub(super) scale: f64,
}

impl Located {
    /// The patch of some vertices (in rising order) of a mesh.
    pub(super) fn new(around: &Surroundings<'_>, vertices: &[u32]) -> Result<Self, Refusal> {
        // Origin and unit of the patch: the mean of the rim's vertices, and the rim's diameter in units of the mesh.
        let rim = around.rim(vertices);
        if rim.is_empty() {
            return Err(Refusal::NothingKnown);
        }
        let at: Vec<DVec3> = rim.iter().map(|&v| around.position(v)).collect();
        let first = at[0];
        let centre = first + at.iter().map(|p| *p - first).sum::<DVec3>() / at.len() as f64;
        let scale = diameter(&at);
        if !(scale > 0.0 && scale.is_finite() && centre.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        // The vertices needed for data, test rings and their normals, by distance along edges in units of the mesh.
        let edge = around.edge(&rim) / scale;
        let limit = (reach(edge) + DATA_MARGIN.get() * edge) * scale;
        let (ids, distance) = around.within(vertices, limit, RINGS.get(), LEAST_EDGE.get() * scale);
        let faces = around.faces_within(&ids);
        // From here on, numbers are local and lengths in diameters of the hole.
        let own = |v: u32| ids.partition_point(|&w| w < v) as u32;
        let faces: Vec<[u32; 3]> = faces.iter().map(|f| f.map(own)).collect();
        let points: Vec<DVec3> = ids
            .iter()
            .map(|&v| (around.position(v) - centre) / scale)
            .collect();
        if !points.iter().all(|p| p.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        // The moving vertices, and the known ones among the others.
        let mut moving = vec![false; ids.len()];
        vertices
            .iter()
            .for_each(|&v| moving[own(v) as usize] = true);
        let known = ids.iter().zip(&moving);
        let known = known.map(|(&v, m)| around.is_known(v) && !m).collect();
        let closure = PatchSupport::new(ids.len(), &faces, &moving);
        let mut patch = Patch {
            border: border(ids.len(), &faces),
            points,
            faces,
            moving,
            known,
            distance: distance.iter().map(|d| d / scale).collect(),
            rim: rim.iter().map(|&v| own(v)).collect(),
            diameter: 1.0,
            edge: 0.0,
            closure,
            cancel: around.cancel().clone(),
        };
        // The mean edge depends on distances and rim, so it is measured last.
        patch.edge = patch.mean_edge().ok_or(Refusal::NothingKnown)?;
        Ok(Self {
            patch,
            centre,
            scale,
        })
    }

    /// Converts a point from the patch's to the mesh's coordinates.
    pub(super) fn outward(&self, point: DVec3) -> DVec3 {
        self.centre + point * self.scale
    }
}

/// Marks the vertices of edges that have only one face.
fn border(count: usize, faces: &Faces) -> Vec<bool> {
    let mut edges: Vec<(u32, u32)> = faces
        .iter()
        .flat_map(|f| [0, 1, 2].map(|k| (f[k], f[(k + 1) % 3])))
        .map(|(a, b)| (a.min(b), a.max(b)))
        .collect();
    edges.sort_unstable();
    let mut border = vec![false; count];
    for same in edges.chunk_by(|a, b| a == b).filter(|same| same.len() < 2) {
        border[same[0].0 as usize] = true;
        border[same[0].1 as usize] = true;
    }
    border
}

/// The largest distance between two points. With many points it is a lower bound, found by going from farthest point to farthest
/// point.
fn diameter(points: &[DVec3]) -> f64 {
    let farthest = |p: DVec3| {
        let distances = points.iter().map(|q| p.distance_squared(*q));
        distances.enumerate().fold(
            (0, 0.0),
            |best, (i, d)| if d > best.1 { (i, d) } else { best },
        )
    };
    if points.len() <= ALL_PAIRS.get() {
        let largest = points.iter().map(|p| farthest(*p).1).fold(0.0, f64::max);
        return largest.sqrt();
    }
    let (mut at, mut largest) = (0, 0.0);
    loop {
        let (next, distance) = farthest(points[at]);
        if distance <= largest {
            return largest.sqrt();
        }
        (at, largest) = (next, distance);
    }
}

/// Distances along edges from the marked vertices (Dijkstra); infinite if not reachable.
fn edge_distances(points: &[DVec3], faces: &Faces, from: &[bool]) -> Vec<f64> {
    // Adjacency lists.
    let mut starts = vec![0u32; points.len() + 1];
    for f in faces.iter().flatten() {
        starts[*f as usize + 1] += 2;
    }
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let (mut at, mut neighbours) = (starts.clone(), vec![0u32; 6 * faces.len()]);
    for face in faces {
        for k in 0..3 {
            let v = face[k] as usize;
            for other in [face[(k + 1) % 3], face[(k + 2) % 3]] {
                neighbours[at[v] as usize] = other;
                at[v] += 1;
            }
        }
    }
    // Dijkstra's algorithm; bit patterns of non-negative numbers sort like the values.
    let mut distance = vec![f64::INFINITY; points.len()];
    let mut queue = BinaryHeap::new();
    for i in (0..points.len()).filter(|&i| from[i]) {
        distance[i] = 0.0;
        queue.push(Reverse((0u64, i as u32)));
    }
    while let Some(Reverse((bits, i))) = queue.pop() {
        let (d, i) = (f64::from_bits(bits), i as usize);
        if d > distance[i] {
            continue;
        }
        for &j in &neighbours[starts[i] as usize..starts[i + 1] as usize] {
            let j = j as usize;
            let through = d + points[i].distance(points[j]).max(LEAST_EDGE.get());
            if through < distance[j] {
                distance[j] = through;
                queue.push(Reverse((through.to_bits(), j as u32)));
            }
        }
    }
    distance
}
