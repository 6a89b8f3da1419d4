//! Triangulation of a polygon that may touch itself, by cutting ears.

use std::collections::HashSet;

use glam::DVec3;

use super::edges::{Used, sides};
use super::half_edge::PatchMesh;
use super::rim::Rims;

/// Weight of the lean of an ear against the square of its diagonal.
const LEAN_WEIGHT: f64 = 20.0;

/// The triangulation of a polygon of patch vertices with its inside to the left, seen against the normals.
///
/// The ear with the shortest diagonal goes first, among those that hold no other vertex; each test is made in the plane
/// across the mean normal at the ear. Where every diagonal would repeat an edge, a vertex is put on one. None if that does
/// not come to an end. Takes time with the square of the number of vertices.
pub(super) fn cut(mesh: &mut PatchMesh, rims: &Rims, polygon: &[u32]) -> Option<Vec<[u32; 3]>> {
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
    let mut spare = polygon.len();
    while work.ring.len() > 3 {
        let (cost, mut k) = work.cheapest()?;
        let ear = work.ear(k);
        if cost.is_finite() {
            faces.push(ear);
            work.used.extend(sides(ear));
            work.ring.remove(k);
            work.cost.remove(k);
        } else {
            spare = spare.checked_sub(1)?;
            k = (0..work.ring.len()).find(|&k| work.ear(k)[0] != work.ear(k)[2])?;
            faces.extend(work.cut_with_vertex(k)?);
        }
        work.rate_near(k);
    }
    let last = work.ear(1);
    let distinct = last[0] != last[1] && last[1] != last[2] && last[2] != last[0];
    if sides(last).iter().all(|e| !work.used.contains(e)) {
        faces.push(last);
    } else {
        let m = work.add_vertex(last)?;
        faces.extend(sides(last).map(|(a, b)| [a, b, m]));
    }
    distinct.then_some(faces)
}

struct Ears<'a> {
    mesh: &'a mut PatchMesh,
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

    fn cheapest(&self) -> Option<(f64, usize)> {
        let all = self.cost.iter().copied().zip(0..);
        all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }

    /// Rates the ears about position `k` again.
    fn rate_near(&mut self, k: usize) {
        let n = self.ring.len();
        for i in [(k + n - 1) % n, k % n, (k + 1) % n] {
            self.cost[i] = self.rate(i);
        }
    }

    /// Cuts the ear at `k` with a new vertex on its diagonal, which takes the place of its tip.
    fn cut_with_vertex(&mut self, k: usize) -> Option<[[u32; 3]; 2]> {
        let [a, b, c] = self.ear(k);
        let m = self.add_vertex([a, c, c])?;
        let faces = [[a, b, m], [b, c, m]];
        faces.iter().for_each(|&f| self.used.extend(sides(f)));
        self.ring[k] = m;
        Some(faces)
    }

    /// A new vertex amid three others.
    fn add_vertex(&mut self, of: [u32; 3]) -> Option<u32> {
        let mesh = &mut *self.mesh;
        let mean = |all: &[DVec3]| of.iter().map(|&v| all[v as usize]).sum::<DVec3>() / 3.0;
        let (position, normal) = (mean(&mesh.position), mean(&mesh.normal).normalize_or_zero());
        mesh.position.push(position);
        mesh.normal.push(normal);
        mesh.size.push(mesh.size[of[0] as usize]);
        position
            .is_finite()
            .then_some(mesh.position.len() as u32 - 1)
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
