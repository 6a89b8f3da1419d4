//! Topology of a triangle mesh: half-edge connectivity, components, orientation and defects.

use std::collections::VecDeque;

use glam::DVec3;
use rayon::prelude::*;

use super::{Mesh, area_vector};
use crate::threads::CollectIndexed;

/// Marks a missing half-edge or component.
pub const NONE: u32 = u32::MAX;

/// Faces of a component of loose triangles, at most.
pub(crate) const LOOSE_FACES: usize = 2;

/// Defects of a mesh's connectivity; counts are for the mesh as given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Defects {
    /// Faces that repeat a vertex.
    pub degenerate_faces: usize,
    /// Edges with more than two faces.
    pub non_manifold_edges: usize,
    /// Edges whose two faces use them in the same direction.
    pub misoriented_edges: usize,
    /// Vertices that the boundary passes more than once.
    pub non_manifold_boundary_vertices: usize,
    /// Vertices at the position of an earlier vertex.
    pub duplicate_vertices: usize,
    /// Components of one or two triangles.
    pub small_components: usize,
    /// Faces that had to be reversed (only for the computation) to agree with their component.
    pub reoriented_faces: usize,
}

/// The connectivity of a mesh.
///
/// Half-edge `3 f + k` runs from corner `k` to corner `k + 1` of face `f`.
#[derive(Clone)]
pub struct Topology {
    /// For each half-edge, the opposite half-edge, or `u32::MAX` (boundary, non-manifold edge or degenerate face).
    pub opposite: Vec<u32>,
    /// Edge-connected component of each face; `u32::MAX` for degenerate faces.
    pub component: Vec<u32>,
    /// Number of faces of each component.
    pub component_faces: Vec<usize>,
    /// Marks the faces that were reversed to agree with their component.
    pub turned: Vec<bool>,
    /// Marks the half-edges that are the only one on their edge.
    pub boundary: Vec<bool>,
    /// Defects of the mesh.
    pub defects: Defects,
}

/// One number for an undirected edge.
fn edge_key(a: u32, b: u32) -> u64 {
    (u64::from(a.min(b)) << 32) | u64::from(a.max(b))
}

impl Topology {
    /// Computes the topology of a welded mesh, and reverses in `mesh` the faces that disagree with the majority of their
    /// component, if the component is orientable.
    pub fn new(mesh: &mut Mesh) -> Self {
        let mut topology = Self::without_orienting(mesh);
        if topology.defects.misoriented_edges > 0 {
            topology.orient(mesh);
        }
        topology
    }

    /// Computes the topology of a welded mesh without reversing faces.
    pub fn without_orienting(mesh: &Mesh) -> Self {
        let degenerate: Vec<bool> = mesh.faces.par_iter().map(is_degenerate).collect_indexed();
        let mut defects = Defects {
            degenerate_faces: degenerate.iter().filter(|&&d| d).count(),
            ..Defects::default()
        };
        let mut topology = Self {
            opposite: vec![NONE; 3 * mesh.faces.len()],
            component: vec![NONE; mesh.faces.len()],
            component_faces: Vec::new(),
            turned: vec![false; mesh.faces.len()],
            boundary: vec![false; 3 * mesh.faces.len()],
            defects: Defects::default(),
        };
        topology.pair(mesh, &degenerate, &mut defects);
        topology.defects = defects;
        topology.find_components(&degenerate);
        topology
    }

    /// The faces that belong to a component: all but degenerate ones.
    pub fn faces(&self) -> impl Iterator<Item = u32> {
        (0..self.component.len() as u32).filter(|f| self.component[*f as usize] != NONE)
    }

    /// Whether a component has one or two faces: loose triangles, which bound nothing.
    pub(crate) fn is_loose(&self, component: u32) -> bool {
        self.component_faces[component as usize] <= LOOSE_FACES
    }

    /// The area of each component.
    #[doc(hidden)]
    pub fn component_areas(&self, mesh: &Mesh) -> Vec<f64> {
        let mut areas = vec![0.0; self.component_faces.len()];
        for f in self.faces() {
            areas[self.component[f as usize] as usize] +=
                0.5 * area_vector(mesh.corners(f)).length();
        }
        areas
    }

    /// The bounding box of each component, as lowest and highest corner.
    pub fn component_bounds(&self, mesh: &Mesh) -> Vec<(DVec3, DVec3)> {
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut boxes = vec![empty; self.component_faces.len()];
        for f in self.faces() {
            let (low, high) = &mut boxes[self.component[f as usize] as usize];
            for p in mesh.corners(f) {
                (*low, *high) = (low.min(p), high.max(p));
            }
        }
        boxes
    }

    /// The half-edges of each non-manifold edge, not counting degenerate faces, in the order of edges.
    pub fn non_manifold_edges(&self, mesh: &Mesh) -> Vec<Vec<u32>> {
        let crowded = |h: &u32| {
            let h = *h as usize;
            self.opposite[h] == NONE && !self.boundary[h] && self.component[h / 3] != NONE
        };
        let mut all: Vec<(u64, u32)> = (0..self.opposite.len() as u32)
            .filter(crowded)
            .map(|h| (edge_key(start(mesh, h), end(mesh, h)), h))
            .collect();
        all.sort_unstable();
        let same = |a: &(u64, u32), b: &(u64, u32)| a.0 == b.0;
        let groups = all.chunk_by(same);
        groups
            .map(|g| g.iter().map(|(_, h)| *h).collect())
            .collect()
    }

    /// Pairs half-edges on the same edge; marks boundary half-edges and counts defective edges.
    fn pair(&mut self, mesh: &Mesh, degenerate: &[bool], defects: &mut Defects) {
        let (first, edges) = edges_by_vertex(mesh, degenerate);
        let mut at_vertex: Vec<(u32, u32)> = Vec::new();
        for range in first.windows(2) {
            let edges = &edges[range[0] as usize..range[1] as usize];
            let larger = |h: u32| start(mesh, h).max(end(mesh, h));
            at_vertex.clear();
            at_vertex.extend(edges.iter().map(|&h| (larger(h), h)));
            at_vertex.sort_unstable();
            for edge in at_vertex.chunk_by(|a, b| a.0 == b.0) {
                match *edge {
                    [(_, h)] => self.boundary[h as usize] = true,
                    [(_, a), (_, b)] => {
                        self.opposite[a as usize] = b;
                        self.opposite[b as usize] = a;
                        if start(mesh, a) == start(mesh, b) {
                            defects.misoriented_edges += 1;
                        }
                    }
                    _ => defects.non_manifold_edges += 1,
                }
            }
        }
    }

    /// Finds edge-connected components by depth-first search.
    fn find_components(&mut self, degenerate: &[bool]) {
        let mut stack = Vec::new();
        for (f, &degenerate) in degenerate.iter().enumerate() {
            if self.component[f] != NONE || degenerate {
                continue;
            }
            let id = self.component_faces.len() as u32;
            let mut count = 0;
            self.component[f] = id;
            stack.push(f);
            while let Some(g) = stack.pop() {
                count += 1;
                for k in 0..3 {
                    let o = self.opposite[3 * g + k];
                    if o != NONE && self.component[o as usize / 3] == NONE {
                        self.component[o as usize / 3] = id;
                        stack.push(o as usize / 3);
                    }
                }
            }
            self.component_faces.push(count);
        }
        let components = 0..self.component_faces.len() as u32;
        self.defects.small_components = components.filter(|c| self.is_loose(*c)).count();
    }

    /// Reverses the minority of the faces in every orientable component.
    pub(crate) fn orient(&mut self, mesh: &mut Mesh) {
        let n = mesh.faces.len();
        let mut side = vec![0i8; n];
        // The side of each face relative to the first of its component.
        for seed in 0..n {
            if side[seed] != 0 || self.component[seed] == NONE {
                continue;
            }
            let mut queue = VecDeque::from([seed]);
            let mut members = vec![];
            let mut orientable = true;
            side[seed] = 1;
            while let Some(f) = queue.pop_front() {
                members.push(f);
                for k in 0..3 {
                    let h = 3 * f + k;
                    let o = self.opposite[h];
                    if o == NONE {
                        continue;
                    }
                    let g = o as usize / 3;
                    let same = start(mesh, h as u32) != start(mesh, o);
                    let wanted = if same { side[f] } else { -side[f] };
                    if side[g] == 0 {
                        side[g] = wanted;
                        queue.push_back(g);
                    } else if side[g] != wanted {
                        orientable = false;
                    }
                }
            }
            // The smaller side is reversed.
            let minority = members.iter().filter(|&&f| side[f] < 0).count();
            let turn = if 2 * minority <= members.len() { -1 } else { 1 };
            if orientable {
                for &f in members.iter().filter(|&&f| side[f] == turn) {
                    self.turned[f] = true;
                }
            }
        }
        for f in 0..n {
            if self.turned[f] {
                self.defects.reoriented_faces += 1;
                self.turn(mesh, f);
            }
        }
    }

    /// Reverses a face by swapping corners 1 and 2; half-edges 0 and 2 are swapped too.
    fn turn(&mut self, mesh: &mut Mesh, f: usize) {
        mesh.faces[f].swap(1, 2);
        self.boundary.swap(3 * f, 3 * f + 2);
        self.opposite.swap(3 * f, 3 * f + 2);
        for k in [0, 2] {
            let o = self.opposite[3 * f + k];
            if o != NONE {
                self.opposite[o as usize] = (3 * f + k) as u32;
            }
        }
    }
}

/// Whether a face repeats a vertex.
fn is_degenerate(f: &[u32; 3]) -> bool {
    f[0] == f[1] || f[1] == f[2] || f[2] == f[0]
}

/// The vertex at which a half-edge starts.
pub fn start(mesh: &Mesh, half_edge: u32) -> u32 {
    mesh.faces[half_edge as usize / 3][half_edge as usize % 3]
}

/// The vertex at which a half-edge ends.
pub fn end(mesh: &Mesh, half_edge: u32) -> u32 {
    mesh.faces[half_edge as usize / 3][(half_edge as usize % 3 + 1) % 3]
}

/// The vertex opposite to a half-edge in its face.
pub(crate) fn apex(mesh: &Mesh, half_edge: u32) -> u32 {
    mesh.faces[half_edge as usize / 3][(half_edge as usize % 3 + 2) % 3]
}

/// The half-edges of non-degenerate faces, sorted by the smaller vertex of their edge. The first list has the start of each
/// vertex in the second. Sorting pairs of key and half-edge would take six times the memory.
fn edges_by_vertex(mesh: &Mesh, degenerate: &[bool]) -> (Vec<u32>, Vec<u32>) {
    let all = || {
        let faces = (0..mesh.faces.len()).filter(|&f| !degenerate[f]);
        faces.flat_map(|f| (0..3).map(move |k| (3 * f + k) as u32))
    };
    let smaller = |h: u32| start(mesh, h).min(end(mesh, h)) as usize;
    let mut first = vec![0u32; mesh.positions.len() + 1];
    all().for_each(|h| first[smaller(h)] += 1);
    let mut sum = 0;
    for count in &mut first {
        sum += *count;
        *count = sum;
    }
    let mut edges = vec![0u32; sum as usize];
    // Each start is counted down from the end of its vertex's range, so half-edges are in falling order.
    all().for_each(|h| {
        let at = &mut first[smaller(h)];
        *at -= 1;
        edges[*at as usize] = h;
    });
    (first, edges)
}
