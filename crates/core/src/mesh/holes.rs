//! Boundary loops and the holes that they bound.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::hole_id::HoleId;
use super::{
    Mesh, OpenChain,
    chains::describe_chains,
    topology::{NONE, Topology, end, start},
};
use crate::elementary::sin_cos;
use crate::tuning::{Tunable, tunable};

/// A vector area below this fraction of the sum of its parts' areas is a rounding error.
const FLAT: f64 = 1e-9;

/// Cosine. The conormals of a rim in a flat side deviate from the rim's plane by less.
const FLAT_SIDE: Tunable<f64> = tunable("mesh.flat_side", 0.02);

/// Diameters. The vertices of such a rim deviate from its plane by less.
const FLAT_OPENING: Tunable<f64> = tunable("mesh.flat_opening", 1e-3);

/// Diameters. The two ends of a bore differ by less in size and place.
const SAME_BORE: Tunable<f64> = tunable("mesh.same_bore", 1e-3);

/// Cosine between the normals of the sides at the two ends of a bore, at least.
const PARALLEL_SIDES: Tunable<f64> = tunable("mesh.parallel_sides", 0.9999);

/// A hole: one simple boundary loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Hole {
    /// Number of the hole, from 1, in falling order of length.
    pub id: HoleId,
    /// Its vertices, in the direction in which the faces of a patch use its edges (opposite to the mesh's).
    pub rim: Vec<u32>,
    /// For each edge `rim[i] → rim[i + 1]`, the direction in which the surface would continue: a unit vector in the plane of the
    /// edge's face that points out of the face.
    pub conormals: Vec<DVec3>,
    /// Number of edges.
    pub edges: usize,
    /// Length of the loop.
    pub length: f64,
    /// Largest distance between two vertices.
    pub diameter: f64,
    /// Width: five times the (vector) area over the length, at most the diameter. For a circle whose rim zigzags in the usual way
    /// this is the diameter.
    pub width: f64,
    /// Root mean square distance of the vertices from their best-fit plane, over the diameter; 0 for a planar rim.
    pub planarity: f64,
    /// Extent of the rim along its normal: largest minus smallest height of its vertices; 0 for a planar rim.
    pub height: f64,
    /// Mean of the vertices, weighted by edge length.
    pub centre: DVec3,
    /// Unit normal of the rim, from its vector area, on the outer side of the surface (where the faces of a patch point). Zero if
    /// the rim encloses no area, like the two sides of a slit.
    pub normal: DVec3,
    /// The component of the mesh that it bounds, from 0.
    pub component: u32,
    /// Whether it is classified as the outer border of an open sheet.
    pub outer_boundary: bool,
    /// The object of a 3MF file that it belongs to, and its part; none if the file has one body.
    #[serde(default)]
    pub object: Option<String>,
}

impl Hole {
    /// Whether two rims are the two sides of a wall: they face away from one another, lie nearer together than half their diameters, and
    /// are of similar size; or they are the ends of a bore of any length.
    pub fn is_across_wall(&self, other: &Self) -> bool {
        self.is_opposite(other) && (self.centre - other.centre).dot(self.normal) > 0.0
            || self.is_end_of_bore(other)
    }

    /// Whether the rim is planar and the side that it bounds is flat there.
    pub fn is_in_flat_side(&self) -> bool {
        let leaves = |c: &DVec3| c.dot(self.normal).abs() > FLAT_SIDE.get();
        self.height <= FLAT_OPENING.get() * self.diameter && !self.conormals.iter().any(leaves)
    }

    /// Whether two rims are as the two ends of a bore whose wall is missing: both in flat sides, which face away from one another, with as
    /// many edges, of the same size, and one straight behind the other.
    pub fn is_end_of_bore(&self, other: &Self) -> bool {
        let between = self.centre - other.centre;
        let depth = between.dot(self.normal);
        let most = SAME_BORE.get() * self.diameter;
        self.edges == other.edges
            && (self.diameter - other.diameter).abs() < most
            && (self.length - other.length).abs() < most
            && self.normal.dot(other.normal) < -PARALLEL_SIDES.get()
            && depth > 0.0
            && (between - depth * self.normal).length() < most
            && self.is_in_flat_side()
            && other.is_in_flat_side()
    }

    /// Whether two rims are the two sides of a wall, or would be if the mesh were turned inside out.
    pub fn is_opposite(&self, other: &Self) -> bool {
        let between = self.centre - other.centre;
        let (small, large) = (
            self.diameter.min(other.diameter),
            self.diameter.max(other.diameter),
        );
        let opposite = self.normal.dot(other.normal) < -0.5;
        let away = between.dot(self.normal) * between.dot(other.normal) < 0.0;
        opposite && away && between.length() < 0.5 * small && small > 0.5 * large
    }
}

/// All holes of a mesh, longest first, and the boundary chains that do not close.
///
/// Loops are simple: where the boundary passes a vertex twice, it is cut into loops that touch there. Degenerate faces,
/// faces at non-manifold edges and open chains bound no holes.
pub fn find_holes(mesh: &Mesh, topology: &mut Topology) -> (Vec<Hole>, Vec<OpenChain>) {
    let (loops, chains) = boundary_loops(mesh, topology);
    let open_chains = describe_chains(mesh, topology, &chains);
    let mut holes: Vec<Hole> = loops
        .into_iter()
        .map(|half_edges| described(mesh, topology, &half_edges))
        .collect();
    holes.sort_by(|a, b| {
        b.length
            .total_cmp(&a.length)
            .then_with(|| a.rim.cmp(&b.rim))
    });
    for (i, hole) in holes.iter_mut().enumerate() {
        hole.id = HoleId(i + 1);
    }
    mark_outer_boundaries(mesh, topology, &mut holes);
    (holes, open_chains)
}

/// Simple loops of boundary half-edges, each in the direction of a patch (the mesh's half-edges backwards), and the open chains.
fn boundary_loops(mesh: &Mesh, topology: &mut Topology) -> (Vec<Vec<u32>>, Vec<Vec<u32>>) {
    // Boundary half-edges by the vertex at which they start in the direction of a patch.
    let mut outgoing: Vec<(u32, u32)> = (0..topology.boundary.len() as u32)
        .filter(|&h| topology.boundary[h as usize])
        .map(|h| (end(mesh, h), h))
        .collect();
    outgoing.sort_unstable();
    topology.defects.non_manifold_boundary_vertices = count_repeats(&outgoing);
    let mut used = vec![false; outgoing.len()];
    let mut position = vec![NONE; mesh.positions.len()];
    let (mut loops, mut open_chains) = (Vec::new(), Vec::new());
    for seed in 0..outgoing.len() {
        if used[seed] {
            continue;
        }
        // A path of half-edges; whenever it returns to one of its vertices, the cycle is split off.
        let mut path: Vec<u32> = Vec::new();
        let mut next = Some(seed);
        position[outgoing[seed].0 as usize] = 0;
        while let Some(i) = next {
            used[i] = true;
            path.push(outgoing[i].1);
            let vertex = start(mesh, outgoing[i].1);
            let at = position[vertex as usize];
            if at != NONE {
                let cycle = path.split_off(at as usize);
                for &h in &cycle {
                    position[end(mesh, h) as usize] = NONE;
                }
                loops.push(cycle);
            }
            position[vertex as usize] = path.len() as u32;
            // Continue with an unused half-edge from this vertex.
            let first = outgoing.partition_point(|&(v, _)| v < vertex);
            next = (first..outgoing.len())
                .take_while(|&k| outgoing[k].0 == vertex)
                .find(|&k| !used[k]);
            if next.is_none() {
                position[vertex as usize] = NONE;
            }
        }
        if !path.is_empty() {
            for &h in &path {
                position[end(mesh, h) as usize] = NONE;
            }
            open_chains.push(path);
        }
    }
    (
        loops.into_iter().filter(|l| l.len() >= 3).collect(),
        open_chains,
    )
}

/// Number of distinct first entries that occur more than once in a sorted list.
fn count_repeats(sorted: &[(u32, u32)]) -> usize {
    let mut count = 0;
    for i in 1..sorted.len() {
        let repeats = sorted[i].0 == sorted[i - 1].0;
        let counted = i >= 2 && sorted[i - 2].0 == sorted[i].0;
        count += usize::from(repeats && !counted);
    }
    count
}

/// The hole whose rim is a loop of boundary half-edges, in the direction of a patch; without a number, and not classified.
pub fn described(mesh: &Mesh, topology: &Topology, half_edges: &[u32]) -> Hole {
    let rim: Vec<u32> = half_edges.iter().map(|&h| end(mesh, h)).collect();
    let point = |v: u32| mesh.positions[v as usize];
    let (mut length, mut centre) = (0.0, DVec3::ZERO);
    let mut conormals = Vec::with_capacity(rim.len());
    // Length, centre of gravity of the edges, and conormals.
    for &h in half_edges {
        let (a, b) = (point(end(mesh, h)), point(start(mesh, h)));
        length += a.distance(b);
        centre += (a + b) * (0.5 * a.distance(b));
        conormals.push(conormal(mesh, h));
    }
    let centre = if length > 0.0 {
        centre / length
    } else {
        point(rim[0])
    };
    let points: Vec<DVec3> = rim.iter().map(|&v| point(v)).collect();
    let diameter = diameter(&points);
    // Vector area, width and planarity.
    let area = (0..points.len()).fold(DVec3::ZERO, |sum, i| {
        let (a, b) = (points[i] - centre, points[(i + 1) % points.len()] - centre);
        sum + 0.5 * a.cross(b)
    });
    // Rims of triangles zigzag: they are about a quarter longer than the curve that they follow.
    let width = (1.25 * 4.0 * area.length() / length.max(f64::MIN_POSITIVE)).min(diameter);
    let planarity = if diameter > 0.0 {
        plane_residual(&points) / diameter
    } else {
        0.0
    };
    let normal = normal(&points, centre, diameter);
    let heights = points.iter().map(|p| (*p - centre).dot(normal));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
        (l.min(x), h.max(x))
    });
    Hole {
        id: HoleId::default(),
        edges: rim.len(),
        rim,
        conormals,
        length,
        diameter,
        width,
        planarity,
        height: high - low,
        centre,
        normal,
        component: most_common(
            half_edges
                .iter()
                .map(|h| topology.component[*h as usize / 3]),
        ),
        outer_boundary: false,
        object: None,
    }
}

/// The number that occurs most often, the smallest of several. A rim runs along several components where these share vertices only.
fn most_common(numbers: impl Iterator<Item = u32>) -> u32 {
    let mut all: Vec<u32> = numbers.collect();
    all.sort_unstable();
    let runs = all.chunk_by(|a, b| a == b);
    runs.rev()
        .max_by_key(|run| run.len())
        .map_or(NONE, |run| run[0])
}

/// Unit normal of a closed loop from its vector area; zero if that is only rounding error.
///
/// Computed in diameters, so that squares of very large and very small lengths do not overflow or underflow.
fn normal(points: &[DVec3], centre: DVec3, diameter: f64) -> DVec3 {
    let at = |i: usize| (points[i % points.len()] - centre) / diameter;
    let parts = (0..points.len()).map(|i| at(i).cross(at(i + 1)));
    let (sum, size) = parts.fold((DVec3::ZERO, 0.0), |(sum, size), part| {
        (sum + part, size + part.length())
    });
    if sum.length() > FLAT * size {
        sum.normalize()
    } else {
        DVec3::ZERO
    }
}

/// Unit vector in the plane of a face, perpendicular to its half-edge, out of the face.
fn conormal(mesh: &Mesh, half_edge: u32) -> DVec3 {
    let face = mesh.faces[half_edge as usize / 3];
    let [a, b, c] = face.map(|v| mesh.positions[v as usize]);
    let normal = (b - a).cross(c - a);
    let along = mesh.positions[end(mesh, half_edge) as usize]
        - mesh.positions[start(mesh, half_edge) as usize];
    along.cross(normal).normalize_or_zero()
}

/// Largest distance between two points; for many points, between points that are extreme in one of 49 directions.
fn diameter(points: &[DVec3]) -> f64 {
    let mut candidates: Vec<DVec3> = points.to_vec();
    if points.len() > 200 {
        candidates.clear();
        for i in 0..49 {
            let z = 1.0 - (f64::from(i) + 0.5) / 49.0;
            let (s, c) = sin_cos(f64::from(i) * 2.399_963);
            let d = DVec3::new(c, s, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z;
            let by = |a: &&DVec3, b: &&DVec3| a.dot(d).total_cmp(&b.dot(d));
            candidates.extend(points.iter().max_by(by));
            candidates.extend(points.iter().min_by(by));
        }
    }
    let mut best: f64 = 0.0;
    for (i, a) in candidates.iter().enumerate() {
        for b in &candidates[..i] {
            best = best.max(a.distance_squared(*b));
        }
    }
    best.sqrt()
}

/// Root mean square distance of points from their least-squares plane.
fn plane_residual(points: &[DVec3]) -> f64 {
    let n = points.len() as f64;
    let mean = points.iter().sum::<DVec3>() / n;
    let mut m = [[0.0; 3]; 3];
    for p in points {
        let d = (*p - mean).to_array();
        for i in 0..3 {
            for j in 0..3 {
                m[i][j] += d[i] * d[j] / n;
            }
        }
    }
    super::measures::smallest_eigenvalue(&m).max(0.0).sqrt()
}

/// Marks the outer border of open sheets: the longest loop of a component, if on average the surface would continue away from the
/// loop's centre, and if its diameter is at least half of the component's.
fn mark_outer_boundaries(mesh: &Mesh, topology: &Topology, holes: &mut [Hole]) {
    let extent = topology.component_bounds(mesh);
    let mut seen = vec![false; topology.component_faces.len()];
    for hole in holes.iter_mut() {
        let component = hole.component as usize;
        if std::mem::replace(&mut seen[component], true) {
            continue;
        }
        let mut outward = 0.0;
        for (i, c) in hole.conormals.iter().enumerate() {
            let a = mesh.positions[hole.rim[i] as usize];
            let b = mesh.positions[hole.rim[(i + 1) % hole.rim.len()] as usize];
            let away = (0.5 * (a + b) - hole.centre).normalize_or_zero();
            outward += away.dot(*c) * a.distance(b) / hole.length;
        }
        let (low, high) = extent[component];
        hole.outer_boundary = outward > 0.25 && hole.diameter >= 0.5 * (high - low).length();
    }
}
