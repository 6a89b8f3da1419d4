//! Triangulations between the vertices of a rim that cross nothing.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::edges;
use crate::check::{is_flat, meets};
use crate::mend::Inspection;
use crate::mesh::triangulate::triangulate_loop_beside;
use crate::mesh::{Mesh, area_vector};
use crate::spatial::{Bounds, BoxTree, intersecting};

/// Rims with more edges are first reduced by cutting ears. The memory of a search goes with the cube of it: 1 MB.
const MOST_EDGES: usize = 200;
/// A search is given up after so many rounds, each of which rules some triangles out. On two
/// scans with rims of hundreds of edges 300 rounds and 450 edges closed no hole more.
const ROUNDS: usize = 60;
/// Faces that lie on one side of a triangle's plane by this part of what their coordinates measure cannot cross it, by rounded
/// numbers too.
const CLEARLY: f64 = 1e-9;
/// What the square of a diagonal's length counts beside the area: of triangulations of the same area the one with short diagonals
/// is taken.
const DIAGONAL: f64 = 0.1;

/// A welded mesh, and new faces on its vertices that cross nothing of it and one another.
pub(super) struct Ground<'a> {
    mesh: &'a Mesh,
    /// Its faces but for degenerate ones.
    faces: Vec<[u32; 3]>,
    boxes: Vec<Bounds>,
    tree: BoxTree,
    /// Edges of all faces, the smaller number first: no diagonal repeats one.
    edges: HashSet<(u32, u32)>,
    new: Vec<([u32; 3], Bounds)>,
}

impl<'a> Ground<'a> {
    pub(super) fn new(found: &'a Inspection) -> Self {
        let mesh = &found.mesh;
        let proper = found.topology.faces();
        let faces: Vec<[u32; 3]> = proper.map(|f| mesh.faces[f as usize]).collect();
        let boxes: Vec<Bounds> = faces.iter().map(|f| bounds(mesh, *f)).collect();
        Self {
            mesh,
            tree: BoxTree::new(&boxes),
            edges: mesh.faces.iter().flat_map(|f| edges(f)).collect(),
            faces,
            boxes,
            new: Vec::new(),
        }
    }

    /// Adds faces if they cross nothing, nor one another; says whether it did.
    pub(super) fn takes(&mut self, faces: &[[u32; 3]]) -> bool {
        let clear = intersecting(&self.mesh.positions, faces, faces.len()).is_empty()
            && faces.iter().all(|f| self.is_clear(*f));
        if clear {
            faces.iter().for_each(|f| self.add(*f));
        }
        clear
    }

    /// Closes a rim with triangles between its vertices that cross nothing, and adds these: the triangulation with the least angles
    /// between faces if that one is such, else the one of least area and short diagonals. None where none was found.
    pub(super) fn close(&mut self, rim: &[u32]) -> Option<Vec<[u32; 3]>> {
        let others: Vec<[u32; 3]> = self.new.iter().map(|(f, _)| *f).collect();
        if let Ok(faces) = triangulate_loop_beside(self.mesh, rim, &others)
            && self.takes(&faces)
        {
            return Some(faces);
        }
        let before = self.new.len();
        let found = self.search(rim);
        if found.is_none() {
            // Edges of ears that were given up may be there still: they are those of diagonals, which no other rim has.
            for (face, _) in self.new.drain(before..) {
                let own: HashSet<_> = edges(rim).collect();
                let cut: Vec<_> = edges(&face).filter(|e| !own.contains(e)).collect();
                cut.iter().for_each(|e| _ = self.edges.remove(e));
            }
        }
        found
    }

    fn add(&mut self, face: [u32; 3]) {
        self.edges.extend(edges(&face));
        self.new.push((face, bounds(self.mesh, face)));
    }

    /// The faces whose boxes meet that of a face.
    fn near(&self, face: [u32; 3]) -> Vec<[u32; 3]> {
        let own = bounds(self.mesh, face);
        let mut near = Vec::new();
        self.tree.for_each(&self.boxes, &own, |i| {
            near.push(self.faces[i as usize]);
        });
        near.extend(
            (self.new.iter())
                .filter(|(_, b)| b.meets(&own))
                .map(|n| n.0),
        );
        near
    }

    fn is_clear(&self, face: [u32; 3]) -> bool {
        if is_flat(corners(self.mesh, face)) {
            return false;
        }
        let [a, b, c] = corners(self.mesh, face);
        let normal = area_vector([a, b, c]);
        let size = a.abs().max(b.abs()).max(c.abs()).max_element();
        let margin = CLEARLY * normal.length() * size;
        let may_cross = |f: &[u32; 3]| {
            let heights = corners(self.mesh, *f).map(|p| normal.dot(p - a));
            let apart = heights.iter().all(|h| *h > margin) || heights.iter().all(|h| *h < -margin);
            !apart
        };
        let near = self.near(face).into_iter().filter(may_cross);
        let all: Vec<[u32; 3]> = std::iter::once(face).chain(near).collect();
        intersecting(&self.mesh.positions, &all, 1).is_empty()
    }

    /// Whether an edge goes through a face, by rounded numbers.
    fn is_pierced(&self, a: u32, b: u32) -> bool {
        let [from, to] = [a, b].map(|v| self.mesh.positions[v as usize]);
        self.near([a, b, b]).iter().any(|f| {
            let apart = !f.contains(&a) && !f.contains(&b);
            apart && meets(from, to - from, corners(self.mesh, *f)).is_some_and(|t| t < 1.0)
        })
    }

    /// The triangulation of least area among those that cross nothing.
    fn search(&mut self, rim: &[u32]) -> Option<Vec<[u32; 3]>> {
        let mut faces = Vec::new();
        let ring = self.without_ears(rim, &mut faces)?;
        let mut table = Table::new(self, &ring);
        for _ in 0..ROUNDS {
            let found = table.solve()?;
            if !table.rule_out(self, &found) {
                let own = found.iter().map(|t| t.map(|i| ring[i]));
                own.clone().for_each(|f| self.add(f));
                faces.extend(own);
                return Some(faces);
            }
        }
        None
    }

    /// Cuts ears that cross nothing, those with short diagonals first, until few edges are left; adds them.
    fn without_ears(&mut self, rim: &[u32], faces: &mut Vec<[u32; 3]>) -> Option<Vec<u32>> {
        let mut ring = rim.to_vec();
        let mut clear: HashMap<[u32; 3], bool> = HashMap::new();
        while ring.len() > MOST_EDGES {
            let n = ring.len();
            let at = |k: usize| self.mesh.positions[ring[k % n] as usize];
            let ear = |k: usize| [ring[(k + n - 1) % n], ring[k], ring[(k + 1) % n]];
            let mut order: Vec<(f64, usize)> = (0..n)
                .map(|k| (at(k + n - 1).distance(at(k + 1)), k))
                .collect();
            order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let mut best = None;
            for (_, k) in order {
                let [a, b, c] = ear(k);
                if a == c || self.edges.contains(&(a.min(c), a.max(c))) {
                    continue;
                }
                // What crosses once crosses ever after.
                let is_clear = clear.get(&[a, b, c]) != Some(&false) && self.is_clear([a, b, c]);
                clear.insert([a, b, c], is_clear);
                if is_clear {
                    best = Some(k);
                    break;
                }
            }
            let k = best?;
            let face = ear(k);
            self.add(face);
            faces.push(face);
            ring.remove(k);
        }
        Some(ring)
    }
}

fn corners(mesh: &Mesh, face: [u32; 3]) -> [DVec3; 3] {
    face.map(|v| mesh.positions[v as usize])
}

fn bounds(mesh: &Mesh, face: [u32; 3]) -> Bounds {
    Bounds::of(corners(mesh, face))
}

/// What is known of the triangles between the corners of a ring.
struct Table<'a> {
    ring: &'a [u32],
    at: Vec<DVec3>,
    /// Diagonals that must not be used, by `i * n + k`.
    blocked: Vec<bool>,
    /// A bit for each triangle, by `(i * n + m) * n + k`: whether it is known to cross something.
    crosses: Vec<u64>,
    /// Triangles that were looked at.
    known: HashSet<[usize; 3]>,
}

impl<'a> Table<'a> {
    fn new(ground: &Ground, ring: &'a [u32]) -> Self {
        let n = ring.len();
        let mut blocked = vec![false; n * n];
        for i in 0..n {
            for k in (i + 2..n).filter(|k| k - i < n - 1) {
                let (v, w) = (ring[i], ring[k]);
                blocked[i * n + k] = v == w || ground.edges.contains(&(v.min(w), v.max(w)));
            }
        }
        Self {
            ring,
            at: (ring.iter())
                .map(|v| ground.mesh.positions[*v as usize])
                .collect(),
            blocked,
            crosses: vec![0; (n * n * n).div_ceil(64)],
            known: HashSet::new(),
        }
    }

    fn crosses(&self, [i, m, k]: [usize; 3]) -> bool {
        let bit = (i * self.ring.len() + m) * self.ring.len() + k;
        self.crosses[bit / 64] >> (bit % 64) & 1 == 1
    }

    fn set_crossing(&mut self, [i, m, k]: [usize; 3]) {
        let bit = (i * self.ring.len() + m) * self.ring.len() + k;
        self.crosses[bit / 64] |= 1 << (bit % 64);
    }

    /// The best triangulation of triangles that are not known to cross anything (Barequet and Sharir 1995).
    fn solve(&self) -> Option<Vec<[usize; 3]>> {
        let n = self.ring.len();
        let mut cost = vec![0.0; n * n];
        let mut apex = vec![0; n * n];
        for span in 2..n {
            for i in 0..n - span {
                let k = i + span;
                let mut best = (f64::INFINITY, i + 1);
                if !self.blocked[i * n + k] {
                    let diagonal = DIAGONAL * self.at[i].distance_squared(self.at[k]);
                    for m in i + 1..k {
                        let parts = cost[i * n + m] + cost[m * n + k] + diagonal;
                        if parts >= best.0 || self.crosses([i, m, k]) {
                            continue;
                        }
                        let all = parts + self.area([i, m, k]);
                        if all < best.0 {
                            best = (all, m);
                        }
                    }
                }
                (cost[i * n + k], apex[i * n + k]) = best;
            }
        }
        if n < 3 || !cost[n - 1].is_finite() {
            return None;
        }
        let (mut faces, mut stack) = (Vec::with_capacity(n), vec![(0, n - 1)]);
        while let Some((i, k)) = stack.pop() {
            if k - i > 1 {
                let m = apex[i * n + k];
                faces.push([i, m, k]);
                stack.extend([(i, m), (m, k)]);
            }
        }
        Some(faces)
    }

    fn area(&self, triangle: [usize; 3]) -> f64 {
        0.5 * area_vector(triangle.map(|i| self.at[i])).length()
    }

    /// Rules those of some triangles out that cross something or one another; says whether there were any.
    fn rule_out(&mut self, ground: &Ground, triangles: &[[usize; 3]]) -> bool {
        let n = self.ring.len();
        let mut wrong = false;
        for &t in triangles {
            if !self.known.insert(t) {
                continue;
            }
            if ground.is_clear(t.map(|i| self.ring[i])) {
                continue;
            }
            wrong = true;
            self.set_crossing(t);
            let [i, m, k] = t;
            for (i, k) in [(i, m), (m, k), (i, k)] {
                let is_diagonal = k - i > 1 && k - i < n - 1;
                if is_diagonal && ground.is_pierced(self.ring[i], self.ring[k]) {
                    self.blocked[i * n + k] = true;
                }
            }
        }
        if wrong {
            return true;
        }
        let faces: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|i| self.ring[i])).collect();
        let pairs = intersecting(&ground.mesh.positions, &faces, faces.len());
        for (f, g) in &pairs {
            let [t, u] = [*f, *g].map(|f| triangles[f as usize]);
            let larger = if self.area(t) < self.area(u) { u } else { t };
            self.set_crossing(larger);
        }
        !pairs.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four corners of a square, two of them raised, and triangles that stand where the diagonals cross, at some heights.
    fn square(heights: &[f64]) -> Mesh {
        let p = DVec3::new;
        let mut positions = vec![
            p(-1.0, -1.0, 0.0),
            p(1.0, -1.0, 1.0),
            p(1.0, 1.0, 0.0),
            p(-1.0, 1.0, 1.0),
        ];
        let mut faces = Vec::new();
        for z in heights {
            let first = positions.len() as u32;
            positions.extend([
                p(-0.1, 0.02, z - 0.1),
                p(0.1, 0.03, z - 0.1),
                p(0.0, 0.01, z + 0.1),
            ]);
            faces.push([first, first + 1, first + 2]);
        }
        Mesh::new(positions, faces)
    }

    #[test]
    fn a_triangulation_goes_round_what_is_in_the_way() {
        let rim = [0, 1, 2, 3];
        let closed = |heights: &[f64]| {
            let mesh = square(heights);
            let found = Inspection::new(&mesh).unwrap();
            Ground::new(&found).close(&rim)
        };
        let has = |faces: &[[u32; 3]], a, b| faces.iter().all(|f| f.contains(&a) && f.contains(&b));
        assert!(has(&closed(&[0.0]).unwrap(), 1, 3));
        assert!(has(&closed(&[1.0]).unwrap(), 0, 2));
        assert_eq!(closed(&[0.0, 1.0]), None);
    }

    #[test]
    fn long_rims_are_closed_and_new_faces_cross_no_earlier_ones() {
        let n = 700;
        let at = |i: u32, z: f64| {
            let angle = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
            DVec3::new(angle.cos(), angle.sin(), z + 0.2 * (3.0 * angle).cos())
        };
        let needle = [at(0, 9.0), at(1, 9.0), at(2, 9.0)];
        let rims = (0..n)
            .map(|i| at(i, 0.0))
            .chain((0..n).map(|i| at(i, 0.01)));
        let positions: Vec<DVec3> = rims.chain(needle).collect();
        let mesh = Mesh::new(positions.clone(), vec![[2 * n, 2 * n + 1, 2 * n + 2]]);
        let found = Inspection::new(&mesh).unwrap();
        let mut ground = Ground::new(&found);
        let mut all = Vec::new();
        for rim in [0..n, n..2 * n] {
            let rim: Vec<u32> = rim.collect();
            let faces = ground.close(&rim).expect("a triangulation");
            assert_eq!(faces.len(), n as usize - 2);
            all.extend(faces);
        }
        assert_eq!(intersecting(&positions, &all, all.len()), []);
        let unlike = Mesh::new(positions, all);
        assert_eq!(
            Inspection::new(&unlike)
                .unwrap()
                .topology
                .crowded_edges(&unlike)
                .len(),
            0
        );
    }
}
