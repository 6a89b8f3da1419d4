//! Triangulation of a polygon that may touch itself, by cutting ears.

use std::collections::HashSet;

use glam::DVec3;

use super::gap::{Used, sides};
use super::half_edge::PatchMesh;
use super::rim::Rims;

/// Weight of the lean of an ear against the square of its diagonal.
const LEAN_WEIGHT: f64 = 20.0;

/// The triangulation of a polygon of patch vertices with its inside to the left, seen against the normals; None if no ear
/// is left that repeats no edge.
///
/// The ear with the shortest diagonal goes first, among those that hold no other vertex; each test is made in the plane
/// across the mean normal at the ear. Takes time with the square of the number of vertices.
pub(super) fn cut(mesh: &PatchMesh, rims: &Rims, polygon: &[u32]) -> Option<Vec<[u32; 3]>> {
    let corners: HashSet<u32> = polygon.iter().copied().collect();
    let edges = mesh.faces.iter().flat_map(|&f| sides(f));
    let used = edges
        .filter(|(a, b)| corners.contains(a) && corners.contains(b))
        .collect();
    let mut work = Ears {
        mesh,
        rims,
        ring: polygon.to_vec(),
        cost: Vec::new(),
        used,
    };
    let mut faces = Vec::with_capacity(polygon.len());
    work.cost = (0..work.ring.len()).map(|k| work.rate(k)).collect();
    while work.ring.len() > 3 {
        let n = work.ring.len();
        let (cost, k) = (0..n)
            .map(|k| (work.cost[k], k))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
        if !cost.is_finite() {
            return None;
        }
        let ear = work.ear(k);
        faces.push(ear);
        work.used.extend(sides(ear));
        work.ring.remove(k);
        work.cost.remove(k);
        for i in [(k + n - 2) % (n - 1), k % (n - 1)] {
            work.cost[i] = work.rate(i);
        }
    }
    let last = work.ear(1);
    let fits = last[0] != last[1] && last[1] != last[2] && last[2] != last[0];
    (fits && sides(last).iter().all(|e| !work.used.contains(e))).then(|| {
        faces.push(last);
        faces
    })
}

struct Ears<'a> {
    mesh: &'a PatchMesh,
    rims: &'a Rims,
    ring: Vec<u32>,
    cost: Vec<f64>,
    used: Used,
}

/// Added to the cost of an ear that holds another vertex, or that is turned over: taken only if there is no other.
const LAST_RESORT: f64 = 1e12;

impl Ears<'_> {
    fn ear(&self, k: usize) -> [u32; 3] {
        let n = self.ring.len();
        [
            self.ring[(k + n - 1) % n],
            self.ring[k],
            self.ring[(k + 1) % n],
        ]
    }

    fn rate(&self, k: usize) -> f64 {
        let ear = self.ear(k);
        let [a, b, c] = ear.map(|v| self.mesh.position[v as usize]);
        if !self.may_cut(ear) {
            return f64::INFINITY;
        }
        let normal = ear
            .iter()
            .map(|&v| self.mesh.normal[v as usize])
            .sum::<DVec3>()
            .normalize_or_zero();
        let cross = (b - a).cross(c - a);
        let cosine = cross.normalize_or_zero().dot(normal);
        let longest = a
            .distance_squared(b)
            .max(b.distance_squared(c))
            .max(c.distance_squared(a));
        let cost = a.distance_squared(c) + LEAN_WEIGHT * (0.5 - cosine).max(0.0) * longest;
        // slivers and ears that turn inwards wait
        let flat = cross.dot(normal) < 1e-3 * longest;
        if flat || self.holds_vertex(ear, normal, longest) {
            LAST_RESORT * (1.0 + cost)
        } else {
            cost
        }
    }

    /// Whether the diagonal would be a new edge, in the patch and in the mesh.
    fn may_cut(&self, [a, b, c]: [u32; 3]) -> bool {
        let rim = |v: u32| self.mesh.is_rim(v).then(|| self.mesh.origin[v as usize]);
        let taken = match (rim(a), rim(c)) {
            (Some(u), Some(v)) => u == v || self.rims.has_edge(u, v),
            _ => false,
        };
        let distinct = a != b && b != c && c != a;
        distinct
            && !taken
            && !self.used.contains(&(c, a))
            && !self.used.contains(&(a, c))
            && sides([a, b, c]).iter().all(|e| !self.used.contains(e))
            && !self.is_side(a, c)
    }

    /// Whether the polygon has an edge between `a` and `c` already.
    fn is_side(&self, a: u32, c: u32) -> bool {
        let n = self.ring.len();
        n > 4
            && (0..n).any(|i| {
                let (x, y) = (self.ring[i], self.ring[(i + 1) % n]);
                (x, y) == (a, c) || (x, y) == (c, a)
            })
    }

    /// Whether another vertex of the polygon lies in the ear, seen along `normal`.
    fn holds_vertex(&self, ear: [u32; 3], normal: DVec3, longest: f64) -> bool {
        let t = ear.map(|v| self.mesh.position[v as usize]);
        self.ring.iter().any(|&v| {
            let p = self.mesh.position[v as usize];
            p.distance_squared(t[0]) < 2.0 * longest
                && !t.contains(&p)
                && (0..3).all(|k| (t[(k + 1) % 3] - t[k]).cross(p - t[k]).dot(normal) >= 0.0)
        })
    }
}
