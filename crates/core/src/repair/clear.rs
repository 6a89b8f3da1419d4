//! Triangulation of a rim without new vertices and without self-intersections.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::edges;
use super::growing::GrowingTree;
use crate::check::is_flat;
use crate::mend::Inspection;
use crate::mesh::triangulate::triangulate_loop_with_neighbours;
use crate::mesh::{Mesh, Part, area_vector};
use crate::spatial::{Bounds, BoxTree, faces_intersect, intersecting, meets};
use crate::tuning::{Tunable, tunable};

/// Edges. Longer rims are first reduced by cutting ears. The memory of a search grows with the cube of their number: 1
/// MB.
const CLEAR_EDGES: Tunable<usize> = tunable("repair.clear_edges", 200);

/// Rounds after which a search is given up; each excludes some triangles. On two scans with rims of hundreds of edges 300
/// rounds and 450 edges closed no further hole.
const CLEAR_ROUNDS: Tunable<usize> = tunable("repair.clear_rounds", 60);

/// Fraction of the size of the coordinates. Faces on one side of a triangle's plane, farther from it than this, do not
/// intersect it in rounded arithmetic.
const CLEARLY: Tunable<f64> = tunable("repair.clearly", 1e-9);

/// Weight of a diagonal's squared length relative to area: among triangulations of equal area the one with short
/// diagonals is taken.
const DIAGONAL: Tunable<f64> = tunable("repair.diagonal", 0.1);

/// A welded mesh and new faces on its vertices that intersect neither the mesh nor one another.
pub(super) struct Ground<'a> {
    mesh: Cow<'a, Mesh>,
    /// Its non-degenerate faces.
    faces: Vec<[u32; 3]>,
    tree: BoxTree,
    /// Edges of all faces (smaller number first) with their face counts; no diagonal may repeat one.
    edges: FxHashMap<(u32, u32), u32>,
    degenerate: Vec<[u32; 3]>,
    new: Vec<[u32; 3]>,
    /// Boxes of the new faces.
    new_tree: GrowingTree,
}

/// A state of a ground to return to.
#[derive(Clone, Copy)]
pub(super) struct Mark {
    vertices: usize,
    faces: usize,
}

impl<'a> Ground<'a> {
    pub(super) fn new(found: &'a Inspection) -> Self {
        let mesh = &found.mesh;
        let proper = found.topology.faces();
        let faces: Vec<[u32; 3]> = proper.map(|f| mesh.faces[f as usize]).collect();
        let boxes: Vec<Bounds> = faces.iter().map(|f| bounds(mesh, *f)).collect();
        let mut count: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        count.reserve(2 * mesh.faces.len());
        for e in mesh.faces.iter().flat_map(|f| edges(f)) {
            *count.entry(e).or_insert(0) += 1;
        }
        let mut degenerate = mesh.faces.clone();
        degenerate.retain(|[a, b, c]| a == b || b == c || c == a);
        Self {
            mesh: Cow::Borrowed(mesh),
            tree: BoxTree::new(&boxes),
            edges: count,
            degenerate,
            faces,
            new: Vec::new(),
            new_tree: GrowingTree::default(),
        }
    }

    /// The vertex positions, new ones last.
    pub(super) fn positions(&self) -> &[DVec3] {
        &self.mesh.positions
    }

    /// A face of the mesh.
    pub(super) fn face(&self, face: u32) -> [u32; 3] {
        self.mesh.faces[face as usize]
    }

    /// The present state.
    pub(super) fn mark(&self) -> Mark {
        Mark {
            vertices: self.mesh.positions.len(),
            faces: self.new.len(),
        }
    }

    /// Removes everything added since a mark.
    pub(super) fn restore(&mut self, to: Mark) {
        for face in self.new.drain(to.faces..) {
            for e in edges(&face) {
                if let Some(count) = self.edges.get_mut(&e) {
                    *count -= 1;
                    if *count == 0 {
                        self.edges.remove(&e);
                    }
                }
            }
        }
        self.new_tree.truncate(to.faces);
        if self.mesh.positions.len() > to.vertices {
            self.mesh.to_mut().positions.truncate(to.vertices);
        }
    }

    /// Adds new vertices.
    pub(super) fn add_vertices(&mut self, positions: &[DVec3]) {
        self.mesh.to_mut().positions.extend(positions);
    }

    /// The faces whose boxes intersect the boxes of some triangles, enlarged by `margin`; without repetition, old faces first.
    pub(super) fn near_all(&self, triangles: &[[u32; 3]], margin: f64) -> Vec<[u32; 3]> {
        let own = triangles.iter();
        let boxes = own.map(|f| bounds(&self.mesh, *f).widened(margin));
        self.in_boxes(boxes)
    }

    /// The faces whose boxes intersect any of the given boxes, without repetition, old faces first.
    fn in_boxes(&self, boxes: impl Iterator<Item = Bounds>) -> Vec<[u32; 3]> {
        let (mut old, mut new) = (Vec::new(), Vec::new());
        for own in boxes {
            self.tree.for_each(&own, |i| old.push(i));
            self.new_tree.for_each(&own, |i| new.push(i));
        }
        let unlike = |numbers: &mut Vec<u32>| {
            numbers.sort_unstable();
            numbers.dedup();
        };
        unlike(&mut old);
        unlike(&mut new);
        let old = old.iter().map(|i| self.faces[*i as usize]);
        old.chain(new.iter().map(|i| self.new[*i as usize]))
            .collect()
    }

    /// Adds faces if they intersect nothing and not one another; returns whether it did.
    pub(super) fn try_add(&mut self, faces: &[[u32; 3]]) -> bool {
        let clear = intersecting(&self.mesh.positions, faces, faces.len()).is_empty()
            && faces.iter().all(|f| self.is_clear(*f));
        if clear {
            faces.iter().for_each(|f| self.add(*f));
        }
        clear
    }

    /// Closes a rim with triangles between its vertices that intersect nothing, and adds them. First the triangulation with the
    /// smallest dihedral angles is tried, then the one with the least area and short diagonals among those that intersect
    /// nothing. None if there is none.
    pub(super) fn close(&mut self, rim: &[u32]) -> Option<Vec<[u32; 3]>> {
        if let Some(faces) = self.least_angles(rim)
            && self.try_add(&faces)
        {
            return Some(faces);
        }
        let before = self.mark();
        let found = self.search(rim);
        if found.is_none() {
            // Remove ears that an abandoned search added.
            self.restore(before);
        }
        found
    }

    /// The triangulation with the smallest dihedral angles, whether or not it intersects anything. It depends only on faces that
    /// share edges or diagonals with the rim; these are looked up, so that the cost does not depend on the size of the mesh.
    fn least_angles(&self, rim: &[u32]) -> Option<Vec<[u32; 3]>> {
        let corners: HashSet<u32> = rim.iter().copied().collect();
        let at = |v: u32| self.mesh.positions[v as usize];
        let mut beside = self.in_boxes(rim.iter().map(|v| Bounds::of_ball(at(*v), 0.0)));
        beside.extend(&self.degenerate);
        beside.retain(|f| f.iter().filter(|v| corners.contains(v)).count() > 1);
        let part = Part::of_faces(&self.mesh.positions, &beside, rim.iter().copied());
        let rim: Vec<u32> = rim.iter().map(|v| part.local(*v)).collect();
        let faces = triangulate_loop_with_neighbours(&part.mesh, &rim, &[]).ok()?;
        let back = |v: u32| part.vertices()[v as usize];
        Some(faces.into_iter().map(|f| f.map(back)).collect())
    }

    /// Adds a face without any test.
    pub(super) fn add(&mut self, face: [u32; 3]) {
        edges(&face).for_each(|e| *self.edges.entry(e).or_insert(0) += 1);
        self.new.push(face);
        self.new_tree.push(bounds(&self.mesh, face));
    }

    /// The faces whose boxes intersect the box of a face.
    fn near(&self, face: [u32; 3]) -> Vec<[u32; 3]> {
        let own = bounds(&self.mesh, face);
        let mut near = Vec::new();
        self.tree.for_each(&own, |i| {
            near.push(self.faces[i as usize]);
        });
        self.new_tree
            .for_each(&own, |i| near.push(self.new[i as usize]));
        near
    }

    fn is_clear(&self, face: [u32; 3]) -> bool {
        if is_flat(corners(&self.mesh, face)) {
            return false;
        }
        let [a, b, c] = corners(&self.mesh, face);
        // Discard faces strictly on one side of the plane, by a margin above the rounding error.
        let normal = area_vector([a, b, c]);
        let size = a.abs().max(b.abs()).max(c.abs()).max_element();
        let margin = CLEARLY.get() * normal.length() * size;
        let may_cross = |f: &[u32; 3]| {
            let height = |k: usize| normal.dot(self.mesh.positions[f[k] as usize] - a);
            let first = height(0);
            let apart = first > margin && height(1) > margin && height(2) > margin
                || first < -margin && height(1) < -margin && height(2) < -margin;
            !apart
        };
        let crosses = |f: [u32; 3]| may_cross(&f) && faces_intersect(&self.mesh.positions, face, f);
        let own = bounds(&self.mesh, face);
        let old = |i: u32| crosses(self.faces[i as usize]);
        self.tree.find(&own, old).is_none()
            && !self.new_tree.any(&own, |i| crosses(self.new[i as usize]))
    }

    /// Whether an edge passes through a face, in floating-point arithmetic.
    fn is_pierced(&self, a: u32, b: u32) -> bool {
        let [from, to] = [a, b].map(|v| self.mesh.positions[v as usize]);
        self.near([a, b, b]).iter().any(|f| {
            let apart = !f.contains(&a) && !f.contains(&b);
            apart && meets(from, to - from, corners(&self.mesh, *f)).is_some_and(|t| t < 1.0)
        })
    }

    /// The triangulation of least area among those that intersect nothing. Solves, rules out the triangles that intersect
    /// something, and repeats.
    fn search(&mut self, rim: &[u32]) -> Option<Vec<[u32; 3]>> {
        let mut faces = Vec::new();
        let ring = self.without_ears(rim, &mut faces)?;
        let mut table = Table::new(self, &ring);
        if !table.has_triangle_at_each_side(self) {
            return None;
        }
        for _ in 0..CLEAR_ROUNDS.get() {
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

    /// Cuts off ears that intersect nothing, shortest diagonals first, until `clear_edges` edges are left; adds them to `faces`.
    fn without_ears(&mut self, rim: &[u32], faces: &mut Vec<[u32; 3]>) -> Option<Vec<u32>> {
        let mut ring = rim.to_vec();
        let mut clear: HashMap<[u32; 3], bool> = HashMap::new();
        while ring.len() > CLEAR_EDGES.get() {
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
                if a == c || self.edges.contains_key(&(a.min(c), a.max(c))) {
                    continue;
                }
                // A triangle that intersects something always will, since faces are only added.
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

/// The faces among the first `count` that intersect any face or have no area, each with the other face if it is in `faces`.
/// `near` are the faces nearby.
pub(super) fn intersecting_or_flat(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    count: usize,
    near: &[[u32; 3]],
) -> Vec<(u32, Option<u32>)> {
    let all: Vec<[u32; 3]> = faces.iter().chain(near).copied().collect();
    let pairs = intersecting(positions, &all, count);
    let other = |g: u32| ((g as usize) < faces.len()).then_some(g);
    let mut wrong: Vec<(u32, Option<u32>)> =
        pairs.into_iter().map(|(f, g)| (f, other(g))).collect();
    let flat = |f: &u32| is_flat(faces[*f as usize].map(|v| positions[v as usize]));
    wrong.extend((0..count as u32).filter(flat).map(|f| (f, None)));
    wrong
}

fn corners(mesh: &Mesh, face: [u32; 3]) -> [DVec3; 3] {
    let [a, b, c] = face;
    [
        mesh.positions[a as usize],
        mesh.positions[b as usize],
        mesh.positions[c as usize],
    ]
}

fn bounds(mesh: &Mesh, face: [u32; 3]) -> Bounds {
    Bounds::of(corners(mesh, face))
}

/// Dynamic-programming table over the triangles between the corners of a ring.
struct Table<'a> {
    ring: &'a [u32],
    at: Vec<DVec3>,
    /// Whether a diagonal is excluded, by `i * n + k`.
    blocked: Vec<bool>,
    /// One bit per triangle, by `(i * n + m) * n + k`: whether it is known to intersect something.
    crosses: Vec<u64>,
    /// Triangles that were tested.
    known: HashSet<[usize; 3]>,
    /// The least cost of a triangulation of the corners from `i` to `k`, by `i * n + k`, and the third corner of its triangle at
    /// this diagonal, from the last solution.
    cost: Vec<f64>,
    /// The same by `k * n + i`, so that what `best` adds lies side by side.
    cost_to: Vec<f64>,
    apex: Vec<usize>,
    /// Entries to recompute, because their triangle or diagonal was ruled out.
    stale: Vec<bool>,
}

impl<'a> Table<'a> {
    fn new(ground: &Ground, ring: &'a [u32]) -> Self {
        let n = ring.len();
        let mut blocked = vec![false; n * n];
        for i in 0..n {
            for k in (i + 2..n).filter(|k| k - i < n - 1) {
                let (v, w) = (ring[i], ring[k]);
                blocked[i * n + k] = v == w || ground.edges.contains_key(&(v.min(w), v.max(w)));
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
            cost: vec![0.0; n * n],
            cost_to: vec![0.0; n * n],
            apex: vec![0; n * n],
            stale: vec![true; n * n],
        }
    }

    fn crosses(&self, [i, m, k]: [usize; 3]) -> bool {
        let bit = (i * self.ring.len() + m) * self.ring.len() + k;
        self.crosses[bit / 64] >> (bit % 64) & 1 == 1
    }

    fn set_crossing(&mut self, [i, m, k]: [usize; 3]) {
        let n = self.ring.len();
        let bit = (i * n + m) * n + k;
        self.crosses[bit / 64] |= 1 << (bit % 64);
        self.stale[i * n + k] |= self.apex[i * n + k] == m;
    }

    /// The best triangulation without triangles that are known to intersect something (Barequet and Sharir 1995).
    ///
    /// Costs only rise from one solution to the next. An entry therefore keeps its triangle unless the triangle was ruled out or
    /// the cost of one of its two sub-polygons rose.
    fn solve(&mut self) -> Option<Vec<[usize; 3]>> {
        let n = self.ring.len();
        let mut rose = vec![false; n * n];
        for span in 2..n {
            for i in 0..n - span {
                let k = i + span;
                let (cell, m) = (i * n + k, self.apex[i * n + k]);
                let is_finite = self.cost[cell].is_finite();
                let is_stale =
                    self.stale[cell] || is_finite && (rose[i * n + m] || rose[m * n + k]);
                if is_stale {
                    let (cost, apex) = self.best(i, k);
                    rose[cell] = cost > self.cost[cell];
                    (self.cost[cell], self.apex[cell]) = (cost, apex);
                    self.cost_to[k * n + i] = cost;
                    self.stale[cell] = false;
                }
            }
        }
        if n < 3 || !self.cost[n - 1].is_finite() {
            return None;
        }
        let (mut faces, mut stack) = (Vec::with_capacity(n), vec![(0, n - 1)]);
        while let Some((i, k)) = stack.pop() {
            if k - i > 1 {
                let m = self.apex[i * n + k];
                faces.push([i, m, k]);
                stack.extend([(i, m), (m, k)]);
            }
        }
        Some(faces)
    }

    /// The least cost of a triangulation of the corners from `i` to `k`, and the third corner of its triangle at this diagonal.
    fn best(&self, i: usize, k: usize) -> (f64, usize) {
        let n = self.ring.len();
        let mut best = (f64::INFINITY, i + 1);
        if self.blocked[i * n + k] {
            return best;
        }
        let diagonal = DIAGONAL.get() * self.at[i].distance_squared(self.at[k]);
        let from = &self.cost[i * n + i + 1..i * n + k];
        let to = &self.cost_to[k * n + i + 1..k * n + k];
        for (m, (from, to)) in (i + 1..k).zip(from.iter().zip(to)) {
            let parts = from + to + diagonal;
            if parts >= best.0 || self.crosses([i, m, k]) {
                continue;
            }
            let all = parts + self.area([i, m, k]);
            if all < best.0 {
                best = (all, m);
            }
        }
        best
    }

    fn area(&self, triangle: [usize; 3]) -> f64 {
        let [i, m, k] = triangle;
        0.5 * area_vector([self.at[i], self.at[m], self.at[k]]).length()
    }

    /// Whether some triangle that intersects nothing stands on each side of the ring; without one there is no triangulation. Most
    /// searches that fail do so here, which takes one test for each corner instead of some for each round.
    fn has_triangle_at_each_side(&mut self, ground: &Ground) -> bool {
        let n = self.ring.len();
        (0..n).all(|side| {
            // Corners next to the side first.
            let others = (1..n - 1).map(|j| match j % 2 {
                1 => (side + 1 + j.div_ceil(2)) % n,
                _ => (side + n - j / 2) % n,
            });
            let mut triangles = others.map(|m| {
                let mut t = [side, (side + 1) % n, m];
                t.sort_unstable();
                t
            });
            triangles.any(|t| self.has_free_sides(t) && self.is_clear(ground, t))
        })
    }

    /// Whether none of a triangle's sides is an excluded diagonal.
    fn has_free_sides(&self, [i, m, k]: [usize; 3]) -> bool {
        let n = self.ring.len();
        [(i, m), (m, k), (i, k)]
            .iter()
            .all(|(i, k)| !self.blocked[i * n + k])
    }

    /// Whether a triangle intersects nothing; what was tested is kept.
    fn is_clear(&mut self, ground: &Ground, t: [usize; 3]) -> bool {
        if !self.known.insert(t) {
            return !self.crosses(t);
        }
        let is_clear = ground.is_clear(t.map(|i| self.ring[i]));
        if !is_clear {
            self.set_crossing(t);
        }
        is_clear
    }

    /// Rules out the triangles that intersect something or one another; returns whether there were any.
    fn rule_out(&mut self, ground: &Ground, triangles: &[[usize; 3]]) -> bool {
        let n = self.ring.len();
        let mut wrong = false;
        for &t in triangles {
            if self.known.contains(&t) || self.is_clear(ground, t) {
                continue;
            }
            wrong = true;
            let [i, m, k] = t;
            for (i, k) in [(i, m), (m, k), (i, k)] {
                let is_diagonal = k - i > 1 && k - i < n - 1;
                if is_diagonal && ground.is_pierced(self.ring[i], self.ring[k]) {
                    self.blocked[i * n + k] = true;
                    self.stale[i * n + k] = true;
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
mod tests;
