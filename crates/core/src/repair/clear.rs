//! Triangulation of a rim without new vertices and without self-intersections.

mod rim_table;

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
use rim_table::RimTable;

/// Edges. Longer rims are first reduced by cutting ears. The memory of a search grows with the cube of their number: 1
/// MB.
const CLEAR_EDGES: Tunable<usize> = tunable("repair.clear_edges", 200);

/// Rounds after which a search is given up; each excludes some triangles. On two scans with rims of hundreds of edges 300
/// rounds and 450 edges closed no further hole.
const CLEAR_ROUNDS: Tunable<usize> = tunable("repair.clear_rounds", 60);

/// Fraction of the size of the coordinates. Faces on one side of a triangle's plane, farther from it than this, do not
/// intersect it in rounded arithmetic.
const CLEARLY: Tunable<f64> = tunable("repair.clearly", 1e-9);

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

    /// Whether `accept` accepts any face whose box intersects the box of a face.
    fn any_near(&self, face: [u32; 3], accept: impl Fn([u32; 3]) -> bool) -> bool {
        let own = bounds(&self.mesh, face);
        let old = self.tree.find(&own, |i| accept(self.faces[i as usize]));
        old.is_some() || self.new_tree.any(&own, |i| accept(self.new[i as usize]))
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
        !self.any_near(face, |f| {
            may_cross(&f) && faces_intersect(&self.mesh.positions, face, f)
        })
    }

    /// Whether an edge passes through a face, in floating-point arithmetic.
    fn is_pierced(&self, a: u32, b: u32) -> bool {
        let [from, to] = [a, b].map(|v| self.mesh.positions[v as usize]);
        self.any_near([a, b, b], |f| {
            let apart = !f.contains(&a) && !f.contains(&b);
            apart && meets(from, to - from, corners(&self.mesh, f)).is_some_and(|t| t < 1.0)
        })
    }

    /// The triangulation of least area among those that intersect nothing. Solves, rules out the triangles that intersect
    /// something, and repeats.
    fn search(&mut self, rim: &[u32]) -> Option<Vec<[u32; 3]>> {
        let mut faces = Vec::new();
        let ring = self.without_ears(rim, &mut faces)?;
        let mut table = RimTable::new(self, &ring);
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

#[cfg(test)]
mod tests;
