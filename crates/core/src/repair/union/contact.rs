//! Contact faces of bodies that coincide except for rounding, as in an assembly that was rotated: each body is grown slightly
//! there, so that the bodies overlap and their faces lie in different planes.
//!
//! If two planes differ by rounding errors only, the exact union follows every intersection of the two, which leaves gaps and
//! folds that floating-point coordinates cannot represent. Each body therefore grows by its own length where it touches others.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::{DMat3, DVec3};

use super::clusters::paired_components;
use crate::mend::{FillError, Inspection};
use crate::mesh::topology::NONE;
use crate::mesh::{DisjointSets, Mesh, VertexFaces, area_vector};
use crate::repair::cracks::across;
use crate::repair::draft::Draft;
use crate::repair::rounding::is_single;
use crate::spatial::{Bounds, BoxTree, closest_on_triangle};
use crate::tuning::{Tunable, tunable};

/// Pairs of faces whose boxes meet, each counted twice. A union is attempted up to this many: it bounds the time, a few
/// microseconds each. 1000 boxes in a heap have 0.6 million.
pub(super) const UNION_PAIRS: Tunable<usize> = tunable("repair.union_pairs", 20_000_000);

/// Diagonals of the mesh's bounding box. Shorter edges at new vertices of unions are collapsed: they come from
/// intersection curves that pass a vertex by a rounding error.
pub(super) const SHORT_EDGE: Tunable<f64> = tunable("repair.short_edge", 1e-9);

/// Units in the last place of the largest coordinate as a 32-bit float. Bodies that touch up to rounding are grown by at
/// least this much.
const CONTACT_UNITS: Tunable<f64> = tunable("repair.contact_units", 8.0);

/// Least cosine of the angle between the planes of two faces in contact.
const MIN_CONTACT_COSINE: f64 = 0.99;
/// Tikhonov term of the equations for a vertex's shift, as a fraction of the matrix trace. The shift is 0 along directions
/// without a contact face.
const TIKHONOV: f64 = 1e-9;
/// Growth lengths. Upper bound of a vertex's shift, for contact faces that meet at a sharp angle.
const MAX_SHIFT: f64 = 4.0;

/// The number of moved vertices and the largest displacement, in mesh units.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::repair) struct Moved {
    pub(in crate::repair) vertices: usize,
    pub(in crate::repair) largest: f64,
}

impl Moved {
    /// Edges of the union shorter than this are caused by the displacements alone.
    pub(in crate::repair) fn reach(&self) -> f64 {
        2.0 * self.largest
    }
}

/// Grows closed bodies where they touch in faces; bodies that share vertices get their own copies. `draft` is the mesh as given.
/// Bodies are distinguished by connectivity if they share no edge there, else by the order of their faces round edges. They
/// grow by `factor` times the smallest length that exceeds rounding errors. None if no bodies touch in faces, or `in_vertices`: in a
/// vertex on a face. Such vertices are moved off the face in any case.
pub(in crate::repair) fn grow(
    draft: &mut Draft,
    factor: f64,
    in_vertices: bool,
) -> Result<Option<Moved>, FillError> {
    let found = draft.inspect()?;
    let mut bodies = Touching::of(draft, &found, factor)?;
    bodies.find();
    bodies.flood();
    if bodies.faces.is_empty() && !in_vertices {
        return Ok(None);
    }
    let Some(shifts) = bodies.shifts() else {
        return Ok(None);
    };
    let moved = bodies.separate(draft, &shifts);
    draft.forget_positions();
    Ok(Some(moved))
}

/// Whether faces of two bodies that share an edge lie on each other there. They need not intersect.
pub(in crate::repair) fn touch_at_edges(draft: &mut Draft) -> Result<bool, FillError> {
    let found = draft.inspect()?;
    let mesh = &found.mesh;
    let edges = found.topology.non_manifold_edges(mesh);
    if edges.is_empty() {
        return Ok(false);
    }
    let touching = Touching::of(draft, &found, 1.0)?;
    let lie = |h: u32, o: u32| {
        let [a, b] = [h / 3, o / 3].map(|f| touching.body[f as usize]);
        let differ = a != b && a != NONE && b != NONE;
        differ && across(mesh, h).dot(across(mesh, o)) > 0.0 && touching.lies_on(h / 3, o / 3)
    };
    let touch = |edge: &Vec<u32>| {
        let mut firsts = edge.iter().enumerate();
        firsts.any(|(i, h)| edge[..i].iter().any(|o| lie(*h, *o)))
    };
    Ok(edges.iter().any(touch))
}

/// The body of each face; `u32::MAX` if the body is not closed or none of its faces intersects others.
fn bodies(given: &Mesh, found: &Inspection, crossing: &[u32]) -> Vec<u32> {
    let topology = &found.topology;
    let mut body = connected(given);
    if crossing.iter().any(|f| body[*f as usize] == NONE) {
        let mut sets = paired_components(&found.mesh, topology);
        let of = |p: &u32| if *p == NONE { NONE } else { sets.find(*p) };
        body = topology.component.iter().map(of).collect();
    }
    let take_part: BTreeSet<u32> = crossing.iter().map(|f| body[*f as usize]).collect();
    for (body, component) in body.iter_mut().zip(&topology.component) {
        if !take_part.contains(body) || *component == NONE {
            *body = NONE;
        }
    }
    body
}

/// The set of faces of each face that are connected by edges between the same vertex numbers; `u32::MAX` if the set is not a closed
/// surface or an edge has more than two faces.
fn connected(given: &Mesh) -> Vec<u32> {
    let mut sets = DisjointSets::new(given.faces.len());
    // The first face of each edge, its number of faces, and how often it runs up more than down.
    let mut edges: HashMap<[u32; 2], (u32, usize, i32)> = HashMap::new();
    for (f, face) in (0..).zip(&given.faces) {
        for k in 0..3 {
            let (v, w) = (face[k], face[(k + 1) % 3]);
            let edge = edges.entry([v.min(w), v.max(w)]).or_insert((f, 0, 0));
            sets.join(edge.0, f);
            edge.1 += 1;
            edge.2 += if v < w { 1 } else { -1 };
        }
    }
    let bad = edges
        .into_values()
        .filter(|(_, count, sum)| *count > 2 || *sum != 0);
    let bad: BTreeSet<u32> = bad.map(|(f, ..)| sets.find(f)).collect();
    let mut of = |f: u32| Some(sets.find(f)).filter(|s| !bad.contains(s));
    (0..given.faces.len() as u32)
        .map(|f| of(f).unwrap_or(NONE))
        .collect()
}

/// The smallest growth, in mesh units: several roundings of single-precision coordinates, else a fraction of the diagonal.
pub(super) fn length(draft: &Draft) -> f64 {
    let mesh = &draft.mesh;
    let [low, high] = mesh.bounds();
    let largest = low.abs().max(high.abs()).max_element();
    let are_single = draft.rounding.is_single() || mesh.positions.iter().all(|p| is_single(*p));
    let unit = if are_single {
        f64::from(f32::EPSILON)
    } else {
        0.0
    };
    (CONTACT_UNITS.get() * unit * largest).max(SHORT_EDGE.get() * (high - low).length())
}

/// Bodies in contact: their pairs and contact faces.
struct Touching<'a> {
    found: &'a Inspection<'a>,
    /// The body of each face, see [`bodies`].
    body: Vec<u32>,
    /// Pairs of bodies in contact.
    pairs: BTreeSet<[u32; 2]>,
    /// The contact faces.
    faces: BTreeSet<u32>,
    /// Welded vertices that lie on a face of another body, with the body they belong to and that face.
    on: BTreeSet<(u32, u32, u32)>,
    length: f64,
}

impl<'a> Touching<'a> {
    /// The bodies of faces that intersect others, or meet at an edge of more than two. Contact is what lies within `factor` times the
    /// smallest length that exceeds rounding errors; it is not yet searched.
    fn of(draft: &mut Draft, found: &'a Inspection, factor: f64) -> Result<Self, FillError> {
        let mut faces = draft.self_intersections()?;
        let edges = found.topology.non_manifold_edges(&found.mesh);
        faces.extend(edges.into_iter().flatten().map(|h| h / 3));
        Ok(Self {
            found,
            body: bodies(&draft.mesh, found, &faces),
            pairs: BTreeSet::new(),
            faces: BTreeSet::new(),
            on: BTreeSet::new(),
            length: factor * length(draft),
        })
    }

    /// Adds faces of the same bodies round the contact faces that lie in the planes of these.
    fn flood(&mut self) {
        let around = VertexFaces::new(&self.found.mesh);
        // Faces to expand, each with the contact face whose plane it lies in.
        let mut left: Vec<[u32; 2]> = self.faces.iter().map(|f| [*f, *f]).collect();
        while let Some([f, seed]) = left.pop() {
            let corners = self.found.mesh.faces[f as usize];
            for &g in corners.iter().flat_map(|v| around.of(*v)) {
                let is_one = self.body[seed as usize] == self.body[g as usize];
                if is_one && !self.faces.contains(&g) && self.lies_on(seed, g) {
                    self.faces.insert(g);
                    left.push([g, seed]);
                }
            }
        }
    }

    /// Finds the faces of different bodies that coincide in a plane.
    fn find(&mut self) {
        let mesh = &self.found.mesh;
        let own: Vec<u32> = (0..self.body.len() as u32)
            .filter(|f| self.body[*f as usize] != NONE)
            .collect();
        let boxes: Vec<Bounds> = (own.iter())
            .map(|f| Bounds::of(mesh.corners(*f)).widened(self.length))
            .collect();
        let tree = BoxTree::new(&boxes);
        let mut left = UNION_PAIRS.get();
        for (f, own_box) in own.iter().zip(&boxes) {
            let mut near = Vec::new();
            tree.for_each(own_box, |i| near.push(own[i as usize]));
            left = left.saturating_sub(near.len());
            if left == 0 {
                return;
            }
            for g in near.into_iter().filter(|g| g > f) {
                let [a, b] = [*f, g].map(|f| self.body[f as usize]);
                if a == b {
                    continue;
                }
                let lie = self.lies_on(*f, g);
                if lie {
                    self.faces.extend([*f, g]);
                }
                let touch = [[*f, g], [g, *f]].map(|pair| self.add_vertices_on(pair));
                if lie || touch.contains(&true) {
                    self.pairs.insert([a.min(b), a.max(b)]);
                }
            }
        }
    }

    /// Whether one of two faces lies in the plane of the other, within the length, and the two are nearly parallel.
    fn lies_on(&self, f: u32, g: u32) -> bool {
        let corners = [f, g].map(|f| self.found.mesh.corners(f));
        let normals = corners.map(|c| area_vector(c).normalize_or_zero());
        let in_plane = |k: usize| {
            let [a, ..] = corners[k];
            corners[1 - k]
                .iter()
                .all(|p| (*p - a).dot(normals[k]).abs() <= self.length)
        };
        normals[0].dot(normals[1]).abs() > MIN_CONTACT_COSINE && (in_plane(0) || in_plane(1))
    }

    /// Adds the vertices of a face that lie on another face, within the length; returns whether there are any. Vertices that the
    /// two share touch nothing.
    fn add_vertices_on(&mut self, [f, g]: [u32; 2]) -> bool {
        let mesh = &self.found.mesh;
        let corners = mesh.faces[g as usize];
        let [a, b, c] = mesh.corners(g);
        let own = mesh.faces[f as usize].into_iter();
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let is_on = |v: &u32| {
            let p = mesh.positions[*v as usize];
            !corners.contains(v)
                && (p - a).dot(normal).abs() <= self.length
                && p.distance(closest_on_triangle(p, a, b, c).0) <= self.length
        };
        let found: Vec<u32> = own.filter(is_on).collect();
        let body = self.body[f as usize];
        self.on.extend(found.iter().map(|v| (*v, body, g)));
        !found.is_empty()
    }

    /// The growth of each body, by greedy colouring: bodies in contact grow by different lengths.
    fn lengths(&self) -> BTreeMap<u32, f64> {
        let mut neighbours: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
        for [a, b] in &self.pairs {
            neighbours.entry(*a).or_default().insert(*b);
            neighbours.entry(*b).or_default().insert(*a);
        }
        let mut step: BTreeMap<u32, usize> = BTreeMap::new();
        for (body, near) in &neighbours {
            let taken: BTreeSet<usize> = near.iter().filter_map(|b| step.get(b).copied()).collect();
            let free = (0..).find(|s| !taken.contains(s)).unwrap_or(0);
            step.insert(*body, free);
        }
        let length = |s: usize| self.length * (1.0 + s as f64);
        step.into_iter()
            .map(|(body, s)| (body, length(s)))
            .collect()
    }

    /// The shift of each welded vertex of each body: the least-squares solution of minimum norm that moves its contact faces
    /// outward by the body's growth. None if there is no contact.
    fn shifts(&self) -> Option<HashMap<(u32, u32), DVec3>> {
        let lengths = self.lengths();
        let mut sums: HashMap<(u32, u32), (DMat3, DVec3)> = HashMap::new();
        let mut add = |key: (u32, u32), area: DVec3| {
            let normal = area.normalize_or_zero();
            let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
            let sum = sums.entry(key).or_default();
            *sum = (sum.0 + outer, sum.1 + lengths[&key.1] * normal);
        };
        for &f in &self.faces {
            let area = area_vector(self.found.mesh.corners(f));
            for v in self.found.mesh.faces[f as usize] {
                add((v, self.body[f as usize]), area);
            }
        }
        for &(v, body, g) in &self.on {
            add((v, body), area_vector(self.found.mesh.corners(g)));
        }
        let shift = |body: u32, (matrix, right): (DMat3, DVec3)| {
            let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
            let matrix = matrix + DMat3::from_diagonal(DVec3::splat(TIKHONOV * trace));
            (matrix.inverse() * right).clamp_length_max(MAX_SHIFT * lengths[&body])
        };
        (!sums.is_empty()).then(|| {
            sums.into_iter()
                .map(|(key, sum)| (key, shift(key.1, sum)))
                .collect()
        })
    }

    /// Gives each body its own vertices where bodies share them, and applies the shifts.
    fn separate(&self, draft: &mut Draft, shifts: &HashMap<(u32, u32), DVec3>) -> Moved {
        let weld = &self.found.weld;
        let rounding = draft.rounding;
        let mut own: HashMap<(u32, u32), u32> = HashMap::new();
        let mut owner: HashMap<u32, u32> = HashMap::new();
        for (f, body) in self.body.iter().enumerate().filter(|(_, b)| **b == NONE) {
            draft.mesh.faces[f]
                .iter()
                .for_each(|v| _ = owner.insert(*v, *body));
        }
        let mut moved = Moved::default();
        for (f, body) in self.body.iter().enumerate().filter(|(_, b)| **b != NONE) {
            for k in 0..3 {
                let v = draft.mesh.faces[f][k];
                let new = *own.entry((v, *body)).or_insert_with(|| {
                    let from = self.found.mesh.positions[weld[v as usize] as usize];
                    let is_first = *owner.entry(v).or_insert(*body) == *body;
                    let vertex = if is_first {
                        v
                    } else {
                        draft.copy_vertex(v, from)
                    };
                    if let Some(shift) = shifts.get(&(weld[v as usize], *body)) {
                        let to = rounding.moved(from, *shift);
                        moved.vertices += 1;
                        moved.largest = moved.largest.max(to.distance(from));
                        draft.mesh.positions[vertex as usize] = to;
                    }
                    vertex
                });
                draft.mesh.faces[f][k] = new;
            }
        }
        moved
    }
}
