//! Bodies whose faces lie on each other but for rounding, as those of an assembly do that was turned: they are made to overlap, and faces in
//! one plane to lie in different ones, by a little more than rounding.
//!
//! Where two planes differ by rounding alone, the exact union follows every crossing of the two, and what is left are gaps and folds
//! that no coordinates can hold. So each body grows, where it touches others, by a length of its own.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::{DMat3, DVec3};

use super::clusters::paired_components;
use crate::mend::{FillError, Inspection};
use crate::mesh::topology::NONE;
use crate::mesh::{DisjointSets, Mesh, VertexFaces, area_vector};
use crate::repair::draft::Draft;
use crate::repair::rounding::is_single;
use crate::spatial::{Bounds, BoxTree};
use crate::tuning::tuning;

/// Cosine of the angle between faces that may lie on each other.
const PARALLEL: f64 = 0.99;
/// Tikhonov term of the equations for a vertex's shift, in parts of their trace: along directions without a face that touches the shift is 0.
const STAYS: f64 = 1e-9;
/// Lengths by which a vertex moves at most, where the faces at it that touch others make a blade.
const MOST: f64 = 4.0;

/// Vertices that were moved, and the longest way of one.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::repair) struct Moved {
    pub(in crate::repair) vertices: usize,
    pub(in crate::repair) largest: f64,
}

impl Moved {
    /// The length below which edges of the union come from the moves alone.
    pub(in crate::repair) fn reach(&self) -> f64 {
        2.0 * self.largest
    }
}

/// Lets closed bodies that touch in faces grow there; those that share vertices get their own. `draft` is the mesh as it was given: bodies that
/// share no vertex there are known by that, others by how their faces follow each other round edges. They grow by `factor` times the
/// least length that rounding asks for. None where none touch so.
pub(in crate::repair) fn grow(draft: &mut Draft, factor: f64) -> Result<Option<Moved>, FillError> {
    let found = draft.inspect()?;
    let crossing = draft.crossing()?;
    let bodies = bodies(&draft.mesh, &found, &crossing);
    let bodies = Touching::new(&found, bodies, factor * length(draft));
    let Some(shifts) = bodies.shifts() else {
        return Ok(None);
    };
    let moved = bodies.separate(draft, &shifts);
    draft.forget_positions();
    Ok(Some(moved))
}

/// For each face its body; `u32::MAX` where no face of its body intersects others, or it is not closed.
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

/// For each face the set of faces that it is connected with by vertices as they are numbered; `u32::MAX` where that is no closed surface.
fn connected(mesh: &Mesh) -> Vec<u32> {
    let mut sets = DisjointSets::new(mesh.positions.len());
    let mut runs: HashMap<[u32; 2], i32> = HashMap::new();
    for f in &mesh.faces {
        for k in 0..3 {
            let (v, w) = (f[k], f[(k + 1) % 3]);
            sets.join(v, w);
            *runs.entry([v.min(w), v.max(w)]).or_default() += if v < w { 1 } else { -1 };
        }
    }
    let open = runs.into_iter().filter(|(_, sum)| *sum != 0);
    let open: BTreeSet<u32> = open.map(|(e, _)| sets.find(e[0])).collect();
    let of = |f: &[u32; 3]| Some(sets.find(f[0])).filter(|s| !open.contains(s));
    mesh.faces
        .iter()
        .map(of)
        .map(|s| s.unwrap_or(NONE))
        .collect()
}

/// The length by which bodies grow at least: several roundings of coordinates in single precision, else a part of the diagonal.
fn length(draft: &Draft) -> f64 {
    let mesh = &draft.mesh;
    let [low, high] = mesh.bounds();
    let largest = low.abs().max(high.abs()).max_element();
    let are_single = draft.rounding.is_single() || mesh.positions.iter().all(|p| is_single(*p));
    let unit = if are_single {
        f64::from(f32::EPSILON)
    } else {
        0.0
    };
    (tuning().repair.contact_units * unit * largest)
        .max(tuning().repair.short_edge * (high - low).length())
}

/// Bodies that touch in faces.
struct Touching<'a> {
    found: &'a Inspection<'a>,
    /// As [`bodies`] gives it.
    body: Vec<u32>,
    /// Pairs of bodies that touch.
    pairs: BTreeSet<[u32; 2]>,
    /// The faces in which they do.
    faces: BTreeSet<u32>,
    length: f64,
}

impl<'a> Touching<'a> {
    fn new(found: &'a Inspection, body: Vec<u32>, length: f64) -> Self {
        let mut touching = Self {
            found,
            body,
            pairs: BTreeSet::new(),
            faces: BTreeSet::new(),
            length,
        };
        touching.find();
        touching.flood();
        touching
    }

    /// Takes in the faces round those that touch, of the same bodies, that lie in the planes of these.
    fn flood(&mut self) {
        let around = VertexFaces::new(&self.found.mesh);
        // Faces, each with the one that touches in whose plane it lies.
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

    /// Finds the faces of different bodies that lie on each other.
    fn find(&mut self) {
        let mesh = &self.found.mesh;
        let own: Vec<u32> = (0..self.body.len() as u32)
            .filter(|f| self.body[*f as usize] != NONE)
            .collect();
        let boxes: Vec<Bounds> = (own.iter())
            .map(|f| Bounds::of(mesh.corners(*f)).widened(self.length))
            .collect();
        let tree = BoxTree::new(&boxes);
        let mut left = tuning().repair.union_pairs;
        for (f, own_box) in own.iter().zip(&boxes) {
            let mut near = Vec::new();
            tree.for_each(own_box, |i| near.push(own[i as usize]));
            left = left.saturating_sub(near.len());
            if left == 0 {
                return;
            }
            for g in near.into_iter().filter(|g| g > f) {
                let bodies = [*f, g].map(|f| self.body[f as usize]);
                if bodies[0] != bodies[1] && self.lies_on(*f, g) {
                    self.faces.extend([*f, g]);
                    self.pairs
                        .insert([bodies[0].min(bodies[1]), bodies[0].max(bodies[1])]);
                }
            }
        }
    }

    /// Whether one of two faces lies in the plane of the other one.
    fn lies_on(&self, f: u32, g: u32) -> bool {
        let corners = [f, g].map(|f| self.found.mesh.corners(f));
        let normals = corners.map(|c| area_vector(c).normalize_or_zero());
        let in_plane = |k: usize| {
            let [a, ..] = corners[k];
            corners[1 - k]
                .iter()
                .all(|p| (*p - a).dot(normals[k]).abs() <= self.length)
        };
        normals[0].dot(normals[1]).abs() > PARALLEL && (in_plane(0) || in_plane(1))
    }

    /// By how much each body grows: bodies that touch by different lengths.
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

    /// The shift of each welded vertex of each body, of least length, by which its faces that lie on others move outwards. None where
    /// nothing touches.
    fn shifts(&self) -> Option<HashMap<(u32, u32), DVec3>> {
        let lengths = self.lengths();
        let mut sums: HashMap<(u32, u32), (DMat3, DVec3)> = HashMap::new();
        for &f in &self.faces {
            let body = self.body[f as usize];
            let normal = area_vector(self.found.mesh.corners(f)).normalize_or_zero();
            let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
            for v in self.found.mesh.faces[f as usize] {
                let sum = sums.entry((v, body)).or_default();
                *sum = (sum.0 + outer, sum.1 + lengths[&body] * normal);
            }
        }
        let shift = |body: u32, (matrix, right): (DMat3, DVec3)| {
            let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
            let matrix = matrix + DMat3::from_diagonal(DVec3::splat(STAYS * trace));
            (matrix.inverse() * right).clamp_length_max(MOST * lengths[&body])
        };
        (!sums.is_empty()).then(|| {
            sums.into_iter()
                .map(|(key, sum)| (key, shift(key.1, sum)))
                .collect()
        })
    }

    /// Gives bodies vertices of their own where others have the same, and moves those that have a shift.
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
