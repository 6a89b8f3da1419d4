//! Triangulation of a boundary loop in space: smallest dihedral angles, then least area (Liepa).

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::Triangulator;
use crate::mesh::{Mesh, area_vector};

/// Polygons with more edges are first reduced by cutting ears.
const MOST_EDGES: usize = 300;
/// Polygons are triangulated in a plane if their corners are closer to it than this fraction of their size.
const FLAT: f64 = 1e-3;

/// Why a loop could not be triangulated.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum TriangulationError {
    /// An index is out of range.
    #[error("a rim loop refers to vertex {vertex}, but there are only {len}; check the input")]
    Index {
        /// The index.
        vertex: u32,
        /// The number of vertices.
        len: usize,
    },
    /// Every triangulation of the loop would repeat an edge of the mesh.
    #[error(
        "the loop of {edges} edges cannot be triangulated without repeating edges of the mesh; refine the mesh there"
    )]
    Blocked {
        /// Number of edges of the loop.
        edges: usize,
    },
}

/// A polygon to be triangulated.
pub(crate) struct Polygon<'a> {
    pub(crate) position: &'a [DVec3],
    /// Unit normal of the face on the other side of edge `i → i + 1`, if there is one.
    pub(crate) beyond: &'a [Option<DVec3>],
    /// Whether the diagonal between two corners is forbidden.
    pub(crate) blocked: &'a (dyn Fn(usize, usize) -> bool + Sync),
}

/// Triangulates a boundary loop of `mesh` without new vertices. Faces have the direction of `rim`, whose edges
/// `rim[i] → rim[i + 1]` are opposite to the mesh's half-edges.
///
/// Minimises the largest angle between adjacent faces, including the mesh's faces at the rim, and among those triangulations the
/// area (Liepa 2003, section 3). No diagonal repeats an edge of the mesh. The time is cubic in the number of edges up to 300;
/// longer loops are triangulated in their plane if they are planar, otherwise first reduced by cutting ears.
pub fn triangulate_loop(mesh: &Mesh, rim: &[u32]) -> Result<Vec<[u32; 3]>, TriangulationError> {
    triangulate_loop_with_neighbours(mesh, rim, &[])
}

/// [`triangulate_loop`] next to other new faces, whose edges no diagonal repeats. Otherwise two loops that touch at two vertices
/// might both get the diagonal between them, which would then have four faces.
pub(crate) fn triangulate_loop_with_neighbours(
    mesh: &Mesh,
    rim: &[u32],
    others: &[[u32; 3]],
) -> Result<Vec<[u32; 3]>, TriangulationError> {
    let len = mesh.positions.len();
    if let Some(&vertex) = rim.iter().find(|&&v| v as usize >= len) {
        return Err(TriangulationError::Index { vertex, len });
    }
    // Edges between rim vertices, which diagonals must not repeat, and normals of the faces at the rim.
    let mut corner = FxHashMap::default();
    rim.iter().enumerate().for_each(|(i, &v)| {
        corner.entry(v).or_insert(i);
    });
    let mut edges = FxHashSet::default();
    let mut normals = FxHashMap::default();
    for f in mesh.faces.iter().chain(others) {
        for k in 0..3 {
            let (a, b) = (f[k], f[(k + 1) % 3]);
            if corner.contains_key(&a) && corner.contains_key(&b) {
                let normal = area_vector(f.map(|v| mesh.positions[v as usize]));
                edges.insert((a.min(b), a.max(b)));
                normals.insert((b, a), normal.normalize_or_zero());
            }
        }
    }
    let n = rim.len();
    let position: Vec<DVec3> = rim.iter().map(|&v| mesh.positions[v as usize]).collect();
    let beyond: Vec<_> = (0..n)
        .map(|i| normals.get(&(rim[i], rim[(i + 1) % n])).copied())
        .collect();
    let blocked = |i: usize, j: usize| {
        rim[i] == rim[j] || edges.contains(&(rim[i].min(rim[j]), rim[i].max(rim[j])))
    };
    // Long planar loops are cut in their plane, the others by dynamic programming.
    if n > MOST_EDGES
        && let Some(faces) = cut_flat(&position, &blocked)
    {
        return Ok(faces.into_iter().map(|f| f.map(|i| rim[i])).collect());
    }
    let polygon = Polygon {
        position: &position,
        beyond: &beyond,
        blocked: &blocked,
    };
    let faces = triangulate(&polygon).ok_or(TriangulationError::Blocked { edges: n })?;
    Ok(faces.into_iter().map(|f| f.map(|i| rim[i])).collect())
}

/// The triangulation; `None` if each has a forbidden diagonal or the polygon is too short.
pub(crate) fn triangulate(polygon: &Polygon) -> Option<Vec<[usize; 3]>> {
    let n = polygon.position.len();
    if n < 3 || polygon.position.iter().any(|p| !p.is_finite()) {
        return None;
    }
    let mut faces = Vec::with_capacity(n);
    let (ring, beyond) = reduce(polygon, &mut faces);
    let table = Table::new(polygon, &ring, &beyond);
    table.collect(&mut faces).then_some(faces)
}

/// The triangulation of a polygon that is planar within [`FLAT`] of its size. `None` if it is not planar, intersects itself, or a
/// diagonal is forbidden.
fn cut_flat(position: &[DVec3], blocked: &dyn Fn(usize, usize) -> bool) -> Option<Vec<[usize; 3]>> {
    let n = position.len();
    let middle = position.iter().sum::<DVec3>() / n as f64;
    let area: DVec3 = (0..n)
        .map(|i| (position[i] - middle).cross(position[(i + 1) % n] - middle))
        .sum();
    let normal = area.try_normalize()?;
    let size = position
        .iter()
        .fold(0.0, |m: f64, p| m.max(p.distance(middle)));
    let is_flat = |p: &DVec3| (*p - middle).dot(normal).abs() < FLAT * size;
    if !position.iter().all(is_flat) {
        return None;
    }
    let mut faces = Vec::with_capacity(n);
    let clean = Triangulator::default().cut(position, &mut |f| faces.push(f));
    let is_rim = |a: usize, b: usize| (a + 1) % n == b || (b + 1) % n == a;
    let allowed = |a: usize, b: usize| is_rim(a, b) || !blocked(a, b);
    let fits = |f: &[usize; 3]| (0..3).all(|k| allowed(f[k], f[(k + 1) % 3]));
    (clean && faces.iter().all(fits)).then_some(faces)
}

/// Cuts ears with short diagonals and small bends until [`MOST_EDGES`] edges remain; returns the remaining corners and the faces
/// next to their edges. Among ears of equal cost the first is cut. The ears wait in a heap, which takes n log n steps.
fn reduce(polygon: &Polygon, faces: &mut Vec<[usize; 3]>) -> (Vec<usize>, Vec<Option<DVec3>>) {
    let n = polygon.position.len();
    if n <= MOST_EDGES {
        return ((0..n).collect(), polygon.beyond.to_vec());
    }
    let mut ring = Ring::new(polygon);
    // The number of times that the ear at a corner was rated; entries of the heap from before are stale.
    let mut rated = vec![0u32; n];
    let mut heap: BinaryHeap<_> = (0..n).map(|k| Reverse((ring.cost(k), k, 0))).collect();
    let mut is_cut = vec![false; n];
    let mut left = n;
    while left > MOST_EDGES
        && let Some(Reverse((Cost(cost), k, when))) = heap.pop()
    {
        if is_cut[k] || when != rated[k] {
            continue;
        }
        if !cost.is_finite() {
            break;
        }
        is_cut[k] = true;
        left -= 1;
        let [a, c] = ring.cut(k);
        faces.push([a, k, c]);
        for corner in [a, c] {
            rated[corner] += 1;
            heap.push(Reverse((ring.cost(corner), corner, rated[corner])));
        }
    }
    let corners: Vec<usize> = (0..n).filter(|&k| !is_cut[k]).collect();
    let beyond = corners.iter().map(|&k| ring.beyond[k]).collect();
    (corners, beyond)
}

/// The corners of a polygon that are not cut yet, as a circular list.
struct Ring<'a> {
    polygon: &'a Polygon<'a>,
    previous: Vec<usize>,
    next: Vec<usize>,
    /// Unit normal of the face on the other side of the edge from a corner to the next.
    beyond: Vec<Option<DVec3>>,
}

impl<'a> Ring<'a> {
    fn new(polygon: &'a Polygon<'a>) -> Self {
        let n = polygon.position.len();
        Self {
            polygon,
            previous: (0..n).map(|k| (k + n - 1) % n).collect(),
            next: (0..n).map(|k| (k + 1) % n).collect(),
            beyond: polygon.beyond.to_vec(),
        }
    }

    /// The cost of cutting the ear at a corner: the length of its diagonal, increased by its bend against the faces at its sides.
    /// Infinite if the diagonal is forbidden.
    fn cost(&self, k: usize) -> Cost {
        let [a, c] = [self.previous[k], self.next[k]];
        if (self.polygon.blocked)(a, c) {
            return Cost(f64::INFINITY);
        }
        let normal = normal(self.polygon, a, k, c);
        let bend: f64 = [self.beyond[a], self.beyond[k]]
            .iter()
            .flatten()
            .map(|m| (1.0 - m.dot(normal)).powi(2))
            .sum();
        let diagonal = self.polygon.position[a].distance(self.polygon.position[c]);
        Cost(diagonal * (1.0 + 20.0 * bend))
    }

    /// Cuts the ear at a corner and returns the ends of its diagonal.
    fn cut(&mut self, k: usize) -> [usize; 2] {
        let [a, c] = [self.previous[k], self.next[k]];
        self.beyond[a] = Some(normal(self.polygon, a, k, c));
        self.next[a] = c;
        self.previous[c] = a;
        [a, c]
    }
}

/// A cost in the total order of floating-point numbers.
#[derive(PartialEq)]
struct Cost(f64);

impl Eq for Cost {}

impl PartialOrd for Cost {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cost {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

fn normal(polygon: &Polygon, a: usize, b: usize, c: usize) -> DVec3 {
    area_vector([a, b, c].map(|i| polygon.position[i])).normalize_or_zero()
}

/// Weight of a partial triangulation: largest angle (as 1 − cosine), then twice the area.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Weight(f64, f64);

/// The weight of an impossible triangulation.
const NEVER: Weight = Weight(f64::INFINITY, f64::INFINITY);
/// Angles (as 1 − cosine) that differ by less are equal.
const SAME_ANGLE: f64 = 1e-9;

impl Weight {
    fn is_less(self, other: Self) -> bool {
        if (self.0 - other.0).abs() > SAME_ANGLE || !self.0.is_finite() {
            self.0 < other.0
        } else {
            self.1 < other.1
        }
    }
}

/// The dynamic programme over sub-polygons `i..=k`: weight, apex and normal of the triangle at edge `i, k`.
struct Table<'a> {
    ring: &'a [usize],
    n: usize,
    weight: Vec<Weight>,
    apex: Vec<u32>,
    normal: Vec<DVec3>,
}

impl<'a> Table<'a> {
    fn new(polygon: &Polygon, ring: &'a [usize], beyond: &[Option<DVec3>]) -> Self {
        let n = ring.len();
        let size = n * n;
        let mut table = Self {
            ring,
            n,
            weight: vec![Weight(0.0, 0.0); size],
            apex: vec![0; size],
            normal: vec![DVec3::ZERO; size],
        };
        for (i, normal) in beyond.iter().enumerate().take(n - 1) {
            table.normal[i * n + i + 1] = normal.unwrap_or_default();
        }
        for span in 2..n {
            for i in 0..n - span {
                let closing = (i == 0 && span == n - 1).then(|| beyond[n - 1].unwrap_or_default());
                table.solve(polygon, i, i + span, closing);
            }
        }
        table
    }

    /// Finds the best triangle for the sub-polygon `i..=k`; `closing` is the face beyond its last edge if it is the whole
    /// polygon.
    fn solve(&mut self, polygon: &Polygon, i: usize, k: usize, closing: Option<DVec3>) {
        let n = self.n;
        let mut best = (NEVER, i + 1, DVec3::ZERO);
        if closing.is_some() || !(polygon.blocked)(self.ring[i], self.ring[k]) {
            let [p, r] = [i, k].map(|v| polygon.position[self.ring[v]]);
            for m in i + 1..k {
                let (left, right) = (i * n + m, m * n + k);
                let so_far = self.weight[left].0.max(self.weight[right].0);
                if so_far > best.0.0 + SAME_ANGLE || so_far == f64::INFINITY {
                    continue;
                }
                let q = polygon.position[self.ring[m]];
                let cross = area_vector([p, q, r]);
                let length = cross.length();
                let normal = if length > 0.0 {
                    cross / length
                } else {
                    DVec3::ZERO
                };
                let mut angle = so_far
                    .max(turn(normal, self.normal[left]))
                    .max(turn(normal, self.normal[right]));
                if let Some(beyond) = closing {
                    angle = angle.max(turn(normal, beyond));
                }
                let weight = Weight(angle, self.weight[left].1 + self.weight[right].1 + length);
                if weight.is_less(best.0) {
                    best = (weight, m, normal);
                }
            }
        }
        self.weight[i * n + k] = best.0;
        self.apex[i * n + k] = best.1 as u32;
        self.normal[i * n + k] = best.2;
    }

    /// Collects the triangles of the best triangulation; false if there is none.
    fn collect(&self, faces: &mut Vec<[usize; 3]>) -> bool {
        let n = self.n;
        if !self.weight[n - 1].0.is_finite() {
            return false;
        }
        let mut stack = vec![(0, n - 1)];
        while let Some((i, k)) = stack.pop() {
            if k - i > 1 {
                let m = self.apex[i * n + k] as usize;
                faces.push([self.ring[i], self.ring[m], self.ring[k]]);
                stack.extend([(i, m), (m, k)]);
            }
        }
        true
    }
}

/// 1 − cosine of the angle between two faces. A degenerate new face counts as a right angle; a missing or degenerate neighbour as
/// no angle.
fn turn(a: DVec3, b: DVec3) -> f64 {
    if a == DVec3::ZERO {
        1.0
    } else if b == DVec3::ZERO {
        0.0
    } else {
        1.0 - a.dot(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangulation_repeats_no_edge_of_the_mesh() {
        // A tetrahedron without one face: all edges exist; the loop is the missing face.
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mesh = Mesh::new(p.to_vec(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2]]);
        assert_eq!(triangulate_loop(&mesh, &[1, 2, 3]), Ok(vec![[1, 2, 3]]));
        // A loop of four edges with one diagonal in the mesh.
        let blocked = Mesh::new(p.to_vec(), vec![[0, 2, 1], [1, 3, 0]]);
        let faces = triangulate_loop(&blocked, &[0, 2, 1, 3]).expect("a triangulation");
        assert!(faces.iter().all(|f| !(f.contains(&0) && f.contains(&1))));
    }

    #[test]
    fn ears_are_cut_in_the_order_of_their_cost() {
        let n = MOST_EDGES + 150;
        let at = |i: usize| {
            let t = i as f64 * std::f64::consts::TAU / n as f64;
            let r = 1.0 + 0.2 * (9.0 * t).cos();
            DVec3::new(r * t.cos(), r * t.sin(), 0.3 * (5.0 * t).sin())
        };
        let position: Vec<DVec3> = (0..n).map(at).collect();
        let beyond: Vec<_> = (0..n).map(|i| (i % 7 > 0).then_some(DVec3::Z)).collect();
        let blocked = |i: usize, j: usize| (i + j).is_multiple_of(11);
        let polygon = Polygon {
            position: &position,
            beyond: &beyond,
            blocked: &blocked,
        };
        let mut faces = Vec::new();
        let (corners, _) = reduce(&polygon, &mut faces);
        assert_eq!((corners.len(), faces.len()), (MOST_EDGES, 150));
        // Each face is the cheapest ear of the rest of the polygon; among ears of equal cost the first.
        let mut ring = Ring::new(&polygon);
        let mut left: Vec<usize> = (0..n).collect();
        for face in faces {
            let best = left.iter().min_by_key(|k| (ring.cost(**k), **k));
            assert_eq!(best, Some(&face[1]));
            ring.cut(face[1]);
            left.retain(|k| *k != face[1]);
        }
        assert_eq!(corners, left);
    }

    #[test]
    fn loops_that_touch_twice_share_no_diagonal() {
        // Two arrowheads in perpendicular planes, both with tip 2 and concave corner 0.
        let p = [
            DVec3::ZERO,
            DVec3::new(-1.0, -1.0, 0.0),
            DVec3::new(0.0, 2.0, 0.0),
            DVec3::new(1.0, -1.0, 0.0),
            DVec3::new(0.0, -1.0, -1.0),
            DVec3::new(0.0, -1.0, 1.0),
        ];
        let mesh = Mesh::new(p.to_vec(), Vec::new());
        let has = |faces: &[[u32; 3]]| faces.iter().any(|f| f.contains(&0) && f.contains(&2));
        let first = triangulate_loop(&mesh, &[0, 1, 2, 3]).expect("a triangulation");
        let alone = triangulate_loop(&mesh, &[0, 4, 2, 5]).expect("a triangulation");
        assert!(has(&first) && has(&alone));
        let second =
            triangulate_loop_with_neighbours(&mesh, &[0, 4, 2, 5], &first).expect("another");
        assert!(!has(&second));
    }
}
