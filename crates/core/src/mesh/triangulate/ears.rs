//! Ear cutting: triangulation of a polygon in space that may touch itself.

use std::collections::HashSet;

use glam::DVec3;

use crate::mesh::area_vector;

/// Weight of an ear's tilt relative to the square of its diagonal. The tilt is the amount by which the ear's cosine with the
/// surface normal is below a half, times the square of its longest edge.
const TILT_WEIGHT: f64 = 20.0;

/// The vertices of a polygon and their surroundings.
pub(crate) struct Ground<'a> {
    /// Positions of the vertices.
    pub(crate) position: &'a [DVec3],
    /// Unit normals of the surface at the vertices.
    pub(crate) normal: &'a [DVec3],
    /// Existing faces: no new face may repeat one of their directed edges.
    pub(crate) faces: &'a [[u32; 3]],
    /// Whether an edge between two vertices is forbidden.
    pub(crate) taken: &'a dyn Fn(u32, u32) -> bool,
}

/// A polygon cut into triangles.
pub(crate) struct EarCut {
    /// The triangles. Indices past the vertices of the ground are new vertices.
    pub(crate) faces: Vec<[u32; 3]>,
    /// New vertices.
    pub(crate) new: Vec<NewVertex>,
}

/// A new vertex, added where every diagonal would repeat an edge.
pub(crate) struct NewVertex {
    pub(crate) position: DVec3,
    /// The unit normal of the surface.
    pub(crate) normal: DVec3,
    /// An adjacent vertex, possibly an earlier new one.
    pub(crate) neighbour: u32,
}

/// Triangulates a polygon with its inside on the left, seen from the tips of the normals.
///
/// The ear with the shortest diagonal is cut first, among those that contain no other vertex; each test is in the plane normal to
/// the ear's mean normal. If every diagonal would repeat an edge, a new vertex is put on one. `None` if that does not end. The
/// time is quadratic in the number of vertices.
pub(crate) fn cut_ears(ground: &Ground, polygon: &[u32]) -> Option<EarCut> {
    // Directed edges of existing faces between the polygon's vertices.
    let corners: HashSet<u32> = polygon.iter().copied().collect();
    let edges = ground.faces.iter().flat_map(|&f| sides(f));
    let used = edges
        .filter(|(a, b)| corners.contains(a) && corners.contains(b))
        .collect();
    let mut work = Ears {
        ground,
        ring: polygon.to_vec(),
        cost: Vec::new(),
        used,
        new: Vec::new(),
    };
    let mut faces = Vec::with_capacity(polygon.len());
    work.cost = (0..work.ring.len()).map(|k| work.rate(k)).collect();
    // Limit on new vertices, so that the loop ends.
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
    // The last triangle; a new vertex divides it if it would repeat an edge.
    let last = work.ear(1);
    let distinct = last[0] != last[1] && last[1] != last[2] && last[2] != last[0];
    if sides(last).iter().all(|e| !work.used.contains(e)) {
        faces.push(last);
    } else {
        let m = work.add_vertex(last)?;
        faces.extend(sides(last).map(|(a, b)| [a, b, m]));
    }
    let new = work.new;
    distinct.then_some(EarCut { faces, new })
}

/// Directed edges of a face.
fn sides(face: [u32; 3]) -> [(u32, u32); 3] {
    [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])]
}

/// A polygon that is being cut.
struct Ears<'a> {
    ground: &'a Ground<'a>,
    ring: Vec<u32>,
    cost: Vec<f64>,
    /// Directed edges in use.
    used: HashSet<(u32, u32)>,
    new: Vec<NewVertex>,
}

/// Added to the cost of an ear that contains another vertex or is reversed: used only if there is no other.
const LAST_RESORT: f64 = 1e12;

impl Ears<'_> {
    /// The ear at position `k` of the ring: the vertex and its neighbours.
    fn ear(&self, k: usize) -> [u32; 3] {
        let n = self.ring.len();
        [
            self.ring[(k + n - 1) % n],
            self.ring[k],
            self.ring[(k + 1) % n],
        ]
    }

    /// The lowest cost and its position.
    fn cheapest(&self) -> Option<(f64, usize)> {
        let all = self.cost.iter().copied().zip(0..);
        all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }

    /// Updates the costs of the ears around position `k`.
    fn rate_near(&mut self, k: usize) {
        let n = self.ring.len();
        for i in [(k + n - 1) % n, k % n, (k + 1) % n] {
            self.cost[i] = self.rate(i);
        }
    }

    /// Cuts the ear at `k` with a new vertex on its diagonal, which replaces its tip in the ring.
    fn cut_with_vertex(&mut self, k: usize) -> Option<[[u32; 3]; 2]> {
        let [a, b, c] = self.ear(k);
        let m = self.add_vertex([a, c, c])?;
        let faces = [[a, b, m], [b, c, m]];
        faces.iter().for_each(|&f| self.used.extend(sides(f)));
        self.ring[k] = m;
        Some(faces)
    }

    /// Adds a new vertex at the mean of three vertices, which may repeat.
    fn add_vertex(&mut self, of: [u32; 3]) -> Option<u32> {
        let position = of.iter().map(|&v| self.position(v)).sum::<DVec3>() / 3.0;
        let normal = of.iter().map(|&v| self.normal(v)).sum::<DVec3>() / 3.0;
        self.new.push(NewVertex {
            position,
            normal: normal.normalize_or_zero(),
            neighbour: of[0],
        });
        let count = self.ground.position.len() + self.new.len();
        position.is_finite().then_some(count as u32 - 1)
    }

    fn position(&self, v: u32) -> DVec3 {
        let new = || self.new[v as usize - self.ground.position.len()].position;
        let own = self.ground.position.get(v as usize);
        own.copied().unwrap_or_else(new)
    }

    fn normal(&self, v: u32) -> DVec3 {
        let new = || self.new[v as usize - self.ground.normal.len()].normal;
        let own = self.ground.normal.get(v as usize);
        own.copied().unwrap_or_else(new)
    }

    /// The cost of an ear; infinite if it may not be cut.
    fn rate(&self, k: usize) -> f64 {
        let ear = self.ear(k);
        let [a, b, c] = ear.map(|v| self.position(v));
        if !self.may_cut(ear) {
            return f64::INFINITY;
        }
        let normal = ear
            .iter()
            .map(|&v| self.normal(v))
            .sum::<DVec3>()
            .normalize_or_zero();
        let cross = area_vector([a, b, c]);
        let cosine = cross.normalize_or_zero().dot(normal);
        let longest = a
            .distance_squared(b)
            .max(b.distance_squared(c))
            .max(c.distance_squared(a));
        let cost = a.distance_squared(c) + TILT_WEIGHT * (0.5 - cosine).max(0.0) * longest;
        // Slivers and inward ears are postponed.
        let flat = cross.dot(normal) < 1e-3 * longest;
        if flat || self.holds_vertex(ear, normal, longest) {
            LAST_RESORT * (1.0 + cost)
        } else {
            cost
        }
    }

    /// Whether the ear can be cut: its diagonal would be a new edge.
    fn may_cut(&self, [a, b, c]: [u32; 3]) -> bool {
        let count = self.ground.position.len();
        let of_ground = (a.max(c) as usize) < count;
        let taken = of_ground && (self.ground.taken)(a, c);
        let distinct = a != b && b != c && c != a;
        distinct
            && !taken
            && !self.used.contains(&(c, a))
            && !self.used.contains(&(a, c))
            && sides([a, b, c]).iter().all(|e| !self.used.contains(e))
            && !self.is_side(a, c)
    }

    /// Whether the polygon already has an edge between `a` and `c`.
    fn is_side(&self, a: u32, c: u32) -> bool {
        let n = self.ring.len();
        n > 4
            && (0..n).any(|i| {
                let (x, y) = (self.ring[i], self.ring[(i + 1) % n]);
                (x, y) == (a, c) || (x, y) == (c, a)
            })
    }

    /// Whether another vertex of the polygon is in the ear, seen along `normal`.
    fn holds_vertex(&self, ear: [u32; 3], normal: DVec3, longest: f64) -> bool {
        let t = ear.map(|v| self.position(v));
        self.ring.iter().any(|&v| {
            let p = self.position(v);
            p.distance_squared(t[0]) < 2.0 * longest
                && !t.contains(&p)
                && (0..3).all(|k| (t[(k + 1) % 3] - t[k]).cross(p - t[k]).dot(normal) >= 0.0)
        })
    }
}
