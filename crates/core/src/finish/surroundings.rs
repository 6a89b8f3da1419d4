//! Index of a mesh that finds the neighbourhood of a patch without visiting the whole mesh.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::geometry::median;
use crate::cancel::Cancel;
use crate::mesh::{DisjointSets, Mesh, VertexFaces};

/// An index of a mesh, built once for all of its patches: the faces around each vertex, and which vertices may be data.
pub struct Surroundings<'a> {
    mesh: &'a Mesh,
    around: VertexFaces,
    known: Vec<bool>,
    cancel: Cancel,
}

impl<'a> Surroundings<'a> {
    /// Indexes a mesh. `known` marks the vertices that were measured and may serve as data for missing ones; vertices of other
    /// patches are not known.
    pub fn new(mesh: &'a Mesh, known: impl Fn(u32) -> bool) -> Self {
        let count = mesh.positions.len() as u32;
        Self {
            mesh,
            around: VertexFaces::new(mesh),
            known: (0..count).map(known).collect(),
            cancel: Cancel::new(),
        }
    }

    /// Sets the token that cancels computations on the patches.
    #[must_use]
    pub fn stopped_by(mut self, cancel: &Cancel) -> Self {
        self.cancel = cancel.clone();
        self
    }

    /// The token that cancels computations on the patches.
    pub(super) fn cancel(&self) -> &Cancel {
        &self.cancel
    }

    /// The mesh.
    pub fn mesh(&self) -> &'a Mesh {
        self.mesh
    }

    /// The unknown vertices of some faces, grouped into patches: components of faces connected by edges. Each group is finished
    /// on its own. Groups are in rising order and not empty. Faces between known vertices also connect their neighbours.
    pub fn patches(&self, faces: &[[u32; 3]]) -> Vec<Vec<u32>> {
        let sides = |(f, face): (usize, &[u32; 3])| {
            let [a, b, c] = *face;
            [(a, b), (b, c), (c, a)].map(|(v, w)| (v.min(w), v.max(w), f as u32))
        };
        let mut edges: Vec<_> = faces.iter().enumerate().flat_map(sides).collect();
        edges.sort_unstable();
        let mut sets = DisjointSets::new(faces.len());
        for both in edges.windows(2) {
            if (both[0].0, both[0].1) == (both[1].0, both[1].1) {
                sets.join(both[0].2, both[1].2);
            }
        }
        let mut patches: Vec<Vec<u32>> = Vec::new();
        let mut place = FxHashMap::default();
        for (f, face) in faces.iter().enumerate() {
            let first = sets.find(f as u32);
            let unknown = face.iter().filter(|&&v| !self.is_known(v));
            let at = *place.entry(first).or_insert_with(|| {
                patches.push(Vec::new());
                patches.len() - 1
            });
            patches[at].extend(unknown);
        }
        for one in &mut patches {
            one.sort_unstable();
            one.dedup();
        }
        patches.retain(|p| !p.is_empty());
        patches
    }

    pub(super) fn position(&self, vertex: u32) -> DVec3 {
        self.mesh.positions[vertex as usize]
    }

    pub(super) fn is_known(&self, vertex: u32) -> bool {
        self.known[vertex as usize]
    }

    /// Whether the vertex exists and has a face with three different corners.
    pub(super) fn is_used(&self, vertex: u32) -> bool {
        (vertex as usize) < self.mesh.positions.len() && self.faces(vertex).next().is_some()
    }

    /// The faces around a vertex that have three different corners.
    fn faces(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let whole = |f: &u32| {
            let [a, b, c] = self.mesh.faces[*f as usize];
            a != b && b != c && c != a
        };
        self.around.of(vertex).iter().copied().filter(whole)
    }

    /// The vertices that share a face with `vertex`; some occur more than once.
    fn neighbours(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let corners = self.faces(vertex).flat_map(|f| self.mesh.faces[f as usize]);
        corners.filter(move |&w| w != vertex)
    }

    /// The vertices that share a face with some of the given (sorted) ones and are not among them, in rising order.
    pub(super) fn rim(&self, vertices: &[u32]) -> Vec<u32> {
        let all = vertices.iter().flat_map(|&v| self.neighbours(v));
        let mut rim: Vec<u32> = all.filter(|w| vertices.binary_search(w).is_err()).collect();
        rim.sort_unstable();
        rim.dedup();
        rim
    }

    /// The median length of the edges at some vertices; a median, because a few long edges should not count.
    pub(super) fn edge(&self, vertices: &[u32]) -> f64 {
        let at = |v: u32| self.neighbours(v).map(move |w| (v, w));
        let lengths = vertices.iter().flat_map(|&v| at(v));
        median(lengths.map(|(v, w)| self.position(v).distance(self.position(w))))
    }

    /// All vertices within distance `limit` of the given ones along edges, and those up to `rings` edges away; in rising order,
    /// with their distances. Edges shorter than `least` count as `least`.
    pub(super) fn within(
        &self,
        vertices: &[u32],
        limit: f64,
        rings: usize,
        least: f64,
    ) -> (Vec<u32>, Vec<f64>) {
        // Dijkstra's algorithm from all given vertices at once. For non-negative numbers the bit patterns sort like the values.
        let mut numbers = FxHashMap::default();
        let (mut found, mut distance) = (Vec::new(), Vec::new());
        let mut queue = BinaryHeap::new();
        for &v in vertices {
            numbers.insert(v, found.len() as u32);
            queue.push(Reverse((0u64, found.len() as u32)));
            found.push(v);
            distance.push(0.0);
        }
        // The first rings belong to the result at any distance.
        self.add_rings(rings, &mut numbers, &mut found);
        let always = found.len();
        distance.resize(always, f64::INFINITY);
        // Skips entries that a shorter path has replaced; beyond the limit only the first rings are expanded.
        while let Some(Reverse((bits, i))) = queue.pop() {
            let (d, i) = (f64::from_bits(bits), i as usize);
            if d > distance[i] || d > limit && i >= always {
                continue;
            }
            let from = self.position(found[i]);
            for w in self.neighbours(found[i]) {
                // Edges of length 0 count as `least`, so distances grow along every path.
                let through = d + from.distance(self.position(w)).max(least);
                if through.is_nan() || through > limit && !numbers.contains_key(&w) {
                    continue;
                }
                let j = *numbers.entry(w).or_insert(found.len() as u32) as usize;
                if j == found.len() {
                    found.push(w);
                    distance.push(f64::INFINITY);
                }
                if through < distance[j] {
                    distance[j] = through;
                    queue.push(Reverse((through.to_bits(), j as u32)));
                }
            }
        }
        // Sorted by vertex, so that the result does not depend on the order of the search.
        let mut both: Vec<(u32, f64)> = found.into_iter().zip(distance).collect();
        both.sort_unstable_by_key(|b| b.0);
        both.into_iter().unzip()
    }

    fn add_rings(&self, rings: usize, numbers: &mut FxHashMap<u32, u32>, found: &mut Vec<u32>) {
        let mut first = 0;
        for _ in 0..rings {
            let last = found.len();
            for i in first..last {
                for w in self.neighbours(found[i]) {
                    numbers.entry(w).or_insert_with(|| {
                        found.push(w);
                        found.len() as u32 - 1
                    });
                }
            }
            first = last;
        }
    }

    /// The faces with all corners among the given sorted vertices, in the mesh's order.
    pub(super) fn faces_within(&self, vertices: &[u32]) -> Vec<[u32; 3]> {
        let inside: FxHashMap<u32, u32> = vertices.iter().map(|&v| (v, 0)).collect();
        let mut faces = Vec::new();
        for &v in vertices {
            let own = self.faces(v).filter(|&f| {
                let face = self.mesh.faces[f as usize];
                face.iter().all(|w| *w >= v && inside.contains_key(w))
            });
            faces.extend(own);
        }
        faces.sort_unstable();
        faces.iter().map(|&f| self.mesh.faces[f as usize]).collect()
    }
}
