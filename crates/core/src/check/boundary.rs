//! Boundary edges of a mesh and what would close them: T-junctions (boundary vertices on boundary edges) and boundary edges that
//! nearly coincide.

use std::collections::{BTreeSet, HashMap};

use glam::DVec3;
use rayon::prelude::*;

use super::defects::self_intersections;
use super::edge_tree::EdgeTree;
use super::resolution::weld_length;
use crate::elementary::{log10, powf};
use crate::mesh::topology::{Topology, end, start};
use crate::mesh::{DisjointSets, Hole, Mesh, VertexFaces};
use crate::spatial::{Bounds, BoxTree};
use crate::threads::{CollectFiltered, CollectIndexed};
use crate::tuning::{Tunable, tunable};

/// Edge lengths. A boundary vertex within this distance of an edge lies on it (T-junction). In CAD files with 64-bit
/// floats
/// T-junction vertices lay within 1e-12 of the edge; after rounding to 32-bit floats, within 3e-7 where edges are a
/// hundredth of the largest coordinate. The resolution of the file's coordinates is used where it is larger.
const JUNCTION: Tunable<f64> = tunable("check.junction", 1e-6);

/// Edge lengths. Upper bound of the T-junction tolerance.
pub(crate) const JUNCTION_MOST: Tunable<f64> = tunable("check.junction_most", 1e-3);

/// T-junction tolerances. A vertex closer than this to an end of an edge counts as at the end, not on the edge.
const JUNCTION_ENDS: Tunable<f64> = tunable("check.junction_ends", 4.0);

/// Lengths of the shorter of two boundary edges. Edges whose ends are within this distance count as nearly coinciding in
/// the merge advice. On 20 000 triangles at random places 0.25 took ten times as long.
const WELD_PART: Tunable<f64> = tunable("check.weld_part", 0.1);

/// Fraction of the boundary edges. A merge distance is advised only if it closes at least this fraction.
const WELD_LEAST: Tunable<f64> = tunable("check.weld_least", 0.05);

/// Medians of the distances at which edges close. A larger one is of another kind: corners that were each moved at random by up to a
/// length close within 2 medians, and T-junctions beside them have distances up to a tenth of an edge.
const WELD_SPREAD: Tunable<f64> = tunable("check.weld_spread", 4.0);

/// Boundary edges. A merge distance is tried before it is advised only where there are at most this many: in a heap of loose
/// triangles this takes seconds.
const WELD_TESTED: Tunable<usize> = tunable("check.weld_tested", 5000);

/// Diagonals of the mesh's bounding box. Cracks up to this width are closed. Of 24 solids of a program that makes boolean
/// operations with a tolerance of 1e-5 the widest cracks were 3e-5.
pub(crate) const CRACK: Tunable<f64> = tunable("check.crack", 1e-3);

/// The boundary of a welded mesh: its edges with exactly one face.
pub(crate) struct Boundary<'a> {
    mesh: &'a Mesh,
    /// The boundary half-edges, ascending.
    pub(crate) half_edges: Vec<u32>,
    /// Start and end vertex of each half-edge.
    pub(crate) ends: Vec<[u32; 2]>,
    /// The boundary vertices, ascending, and a tree over their positions.
    vertices: Vec<u32>,
    tree: BoxTree,
    /// For each boundary vertex the indices of its edges in `half_edges`.
    at: HashMap<u32, Vec<u32>>,
    /// Vertices closer than this (mesh units) count as one: the distance is explained by rounding.
    pub(crate) unit: f64,
    /// Edge lengths. Upper bound of the distance from a vertex to an edge on which it lies (T-junction).
    part: f64,
}

/// A boundary edge with boundary vertices on it (T-junctions).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Junctions {
    /// Index of the edge in [`Boundary::half_edges`].
    pub(crate) edge: u32,
    /// The vertices on the edge, from its start to its end.
    pub(crate) vertices: Vec<u32>,
}

/// The best partner of a boundary edge: another boundary edge that nearly coincides with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Match {
    /// The larger of the two distances between matched end points, in mesh units.
    pub(crate) distance: f64,
    /// The partner's vertices that would be merged with the start and with the end of the edge.
    pub(crate) ends: [u32; 2],
}

/// How much of the boundary T-junction splits and welding would close.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Closing {
    /// Number of boundary vertices that lie on boundary edges.
    pub(super) junctions: usize,
    /// Number of holes that splitting these edges closes.
    pub(super) junction_holes: usize,
    /// The welding distance to recommend and the number of edges that it closes; none if it closes too few.
    pub(super) weld: Option<(f64, usize)>,
    /// Whether a repair welds within that distance by default.
    pub(super) by_default: bool,
}

impl<'a> Boundary<'a> {
    /// The boundary of a mesh, with the welding tolerance that the precision of its coordinates suggests.
    pub(super) fn new(mesh: &'a Mesh, topology: &Topology) -> Self {
        let is_open = topology.boundary.contains(&true);
        let unit = if is_open { weld_length(mesh) } else { 0.0 };
        Self::with_unit(mesh, topology, unit)
    }

    /// The boundary of a mesh with a given welding tolerance, in mesh units.
    pub(crate) fn with_unit(mesh: &'a Mesh, topology: &Topology, unit: f64) -> Self {
        let half_edges = 0..topology.boundary.len() as u32;
        let half_edges: Vec<u32> = half_edges
            .filter(|h| topology.boundary[*h as usize])
            .collect();
        let ends = half_edges.iter().map(|&h| [start(mesh, h), end(mesh, h)]);
        let ends: Vec<[u32; 2]> = ends.collect();
        let mut at: HashMap<u32, Vec<u32>> = HashMap::new();
        for (e, i) in ends.iter().zip(0..) {
            e.iter().for_each(|v| at.entry(*v).or_default().push(i));
        }
        let mut vertices: Vec<u32> = at.keys().copied().collect();
        vertices.sort_unstable();
        let point = |v: &u32| Bounds::of_ball(mesh.positions[*v as usize], 0.0);
        let points: Vec<Bounds> = vertices.iter().map(point).collect();
        Self {
            unit,
            part: JUNCTION_MOST.get(),
            tree: BoxTree::new(&points),
            mesh,
            half_edges,
            ends,
            vertices,
            at,
        }
    }

    /// The same boundary with another upper bound of the distance from a vertex to an edge on which it lies, in edge lengths.
    pub(crate) fn with_part(self, part: f64) -> Self {
        Self { part, ..self }
    }

    /// Calls `visit` with each boundary vertex in a box.
    fn near(&self, query: &Bounds, mut visit: impl FnMut(u32)) {
        self.tree.for_each(query, |i| {
            visit(self.vertices[i as usize]);
        });
    }

    /// Calls `visit` with each pair of boundary vertices within a distance, the smaller number first.
    pub(crate) fn for_each_pair(&self, distance: f64, mut visit: impl FnMut(u32, u32)) {
        for &v in &self.vertices {
            let p = self.position(v);
            self.near(&Bounds::of_ball(p, distance), |w| {
                if v < w && p.distance(self.position(w)) <= distance {
                    visit(v, w);
                }
            });
        }
    }

    fn position(&self, v: u32) -> DVec3 {
        self.mesh.positions[v as usize]
    }

    /// The boundary edges with T-junctions. A vertex counts only if one of its own boundary edges runs along the edge, so that
    /// splitting the edge there may close it.
    pub(crate) fn junctions(&self) -> Vec<Junctions> {
        let edges = 0..self.ends.len() as u32;
        let own = edges.into_par_iter().filter_map(|edge| {
            let vertices = self.on_edge(edge);
            (!vertices.is_empty()).then_some(Junctions { edge, vertices })
        });
        own.collect()
    }

    /// The distance from an edge of this length within which a vertex lies on it, in mesh units.
    fn tolerance(&self, length: f64) -> f64 {
        let part = (JUNCTION.get() * length).max(self.unit);
        part.min(self.part * length)
    }

    fn on_edge(&self, edge: u32) -> Vec<u32> {
        let [a, b] = self.ends[edge as usize];
        let segment = [a, b].map(|v| self.position(v));
        let tolerance = self.tolerance(segment[0].distance(segment[1]));
        let face = self.mesh.faces[self.half_edges[edge as usize] as usize / 3];
        let mut on: Vec<(f64, u32)> = Vec::new();
        self.tree.for_each_along(segment, tolerance, |i| {
            let v = self.vertices[i as usize];
            let place = along(self.position(v), segment, tolerance);
            on.extend(place.filter(|_| !face.contains(&v)).map(|p| (p, v)));
        });
        on.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        // Of vertices that coincide within the tolerance only the first is kept.
        on.dedup_by(|later, first| later.0 - first.0 <= tolerance);
        let known: Vec<u32> = on.iter().map(|(_, v)| *v).chain([a, b]).collect();
        on.retain(|(_, v)| self.goes_on(*v, &known, segment, tolerance));
        on.into_iter().map(|(_, v)| v).collect()
    }

    /// Whether one of the boundary edges of a vertex runs along the segment: it leads to one of the `known` vertices on it, or
    /// past one of its ends.
    fn goes_on(&self, v: u32, known: &[u32], segment: [DVec3; 2], tolerance: f64) -> bool {
        self.at[&v].iter().any(|i| {
            let [c, d] = self.ends[*i as usize];
            let other = if c == v { d } else { c };
            let own = [self.position(v), self.position(other)];
            let over = |end: DVec3| along(end, own, tolerance).is_some();
            known.contains(&other) || segment.into_iter().any(over)
        })
    }

    /// For each boundary edge whether it has two faces after the edges are split at the junctions.
    fn closed_by(&self, junctions: &[Junctions]) -> Vec<bool> {
        let mut split: Vec<&[u32]> = vec![&[]; self.ends.len()];
        junctions
            .iter()
            .for_each(|j| split[j.edge as usize] = &j.vertices);
        let parts = |i: usize| {
            let [a, b] = self.ends[i];
            let inner = split[i].iter().copied();
            let all: Vec<u32> = [a].into_iter().chain(inner).chain([b]).collect();
            let pairs = all.windows(2).map(|p| (p[0].min(p[1]), p[0].max(p[1])));
            pairs.collect::<Vec<_>>()
        };
        let mut count: HashMap<(u32, u32), usize> = HashMap::new();
        for i in 0..self.ends.len() {
            for part in parts(i) {
                *count.entry(part).or_insert(0) += 1;
            }
        }
        let is_closed = |i| parts(i).iter().all(|part| count[part] == 2);
        (0..self.ends.len()).map(is_closed).collect()
    }

    /// For each boundary edge the nearest other one whose end points are both within `most` (mesh units) and within `part` times
    /// the length of the shorter edge.
    pub(crate) fn matches(&self, most: f64, part: f64) -> Vec<Option<Match>> {
        if self.ends.is_empty() {
            return Vec::new();
        }
        let around = VertexFaces::new(self.mesh);
        let adjacent = |v: u32, w: u32| self.are_adjacent(&around, v, w);
        let nearest = |i: u32| {
            let [a, b] = self.ends[i as usize];
            let length = |[a, b]: [u32; 2]| self.position(a).distance(self.position(b));
            let own = length([a, b]);
            let reach = most.min(part * own);
            let mut best: Option<Match> = None;
            let around_start = Bounds::of_ball(self.position(a), reach);
            self.near(&around_start, |v| {
                for &j in self.at[&v].iter().filter(|j| **j != i) {
                    let [c, d] = self.ends[j as usize];
                    let ends = if c == v { [c, d] } else { [d, c] };
                    let distance = length([a, ends[0]]).max(length([b, ends[1]]));
                    let nearer = best.is_none_or(|m| distance < m.distance);
                    // Both ends must be near, and a merge must not collapse a face.
                    let is_near = distance <= reach.min(part * length([c, d]));
                    if is_near && nearer && !adjacent(a, ends[0]) && !adjacent(b, ends[1]) {
                        best = Some(Match { distance, ends });
                    }
                }
            });
            best
        };
        let edges = 0..self.ends.len() as u32;
        edges.into_par_iter().map(nearest).collect_indexed()
    }

    /// Whether two different vertices share a face.
    fn are_adjacent(&self, around: &VertexFaces, v: u32, w: u32) -> bool {
        let faces = around.of(v).iter();
        let mut faces = faces.map(|f| self.mesh.faces[*f as usize]);
        v != w && faces.any(|f| f.contains(&w))
    }

    /// For each boundary edge that has a matching edge within `part` times the shorter length (see [`Boundary::matches`]), the
    /// distance to the nearest one.
    fn match_distances(&self, part: f64) -> Vec<f64> {
        if self.ends.is_empty() {
            return Vec::new();
        }
        let around = VertexFaces::new(self.mesh);
        let segment = |ends: [u32; 2]| ends.map(|v| self.position(v));
        let length = |[a, b]: [DVec3; 2]| a.distance(b);
        let tree = EdgeTree::new(self.ends.iter().map(|ends| segment(*ends)));
        let nearest = |i: u32| {
            let own = self.ends[i as usize];
            let most = part * length(segment(own));
            let mut best = None;
            for [a, b] in [own, [own[1], own[0]]] {
                let reach = best.unwrap_or(most);
                tree.near(segment([a, b]), reach, &mut |j, distance| {
                    let ends = self.ends[j as usize];
                    let is_near = j != i
                        && distance <= part * length(segment(ends))
                        && !self.are_adjacent(&around, a, ends[0])
                        && !self.are_adjacent(&around, b, ends[1]);
                    if is_near {
                        best = Some(distance);
                    }
                    best.unwrap_or(most)
                });
            }
            best
        };
        let edges = 0..self.ends.len() as u32;
        edges.into_par_iter().filter_map(nearest).collect_filtered()
    }

    /// The diagonal of the bounding box of the mesh's faces, in mesh units.
    fn diagonal(&self) -> f64 {
        let corners = self.mesh.faces.iter().flatten();
        let (low, high) = crate::mesh::bounds(corners.map(|v| self.position(*v)));
        low.distance(high)
    }

    /// Whether merging boundary vertices within a length leaves fewer boundary edges, and no more edges with several faces or faces
    /// that intersect others.
    fn is_closed_by_welding(&self, length: f64) -> bool {
        let around = VertexFaces::new(self.mesh);
        let mut sets = DisjointSets::new(self.mesh.positions.len());
        self.for_each_pair(length, |v, w| {
            if !self.are_adjacent(&around, v, w) {
                sets.join(v, w);
            }
        });
        let faces = self.mesh.faces.iter().map(|f| f.map(|v| sets.find(v)));
        let welded = Mesh::new(self.mesh.positions.clone(), faces.collect());
        let faults = |mesh: &Mesh| {
            let topology = Topology::without_orienting(mesh);
            let open = topology.boundary.iter().filter(|b| **b).count();
            let crowded = topology.non_manifold_edges(mesh).len();
            (open, crowded, self_intersections(mesh, &topology).len())
        };
        let (before, after) = (faults(self.mesh), faults(&welded));
        after.0 < before.0 && after.1 <= before.1 && after.2 <= before.2
    }

    /// What would close the boundary, which consists of these holes.
    pub(super) fn closing(&self, holes: &[Hole]) -> Closing {
        let junctions = self.junctions();
        let closed = self.closed_by(&junctions);
        let mut is_closed: HashMap<(u32, u32), bool> = HashMap::new();
        for ([a, b], closed) in self.ends.iter().zip(closed) {
            is_closed.insert((*a.min(b), *a.max(b)), closed);
        }
        let closes = |hole: &&Hole| {
            let next = hole.rim.iter().cycle().skip(1);
            let mut edges = hole.rim.iter().zip(next);
            edges.all(|(a, b)| is_closed.get(&(*a.min(b), *a.max(b))) == Some(&true))
        };
        let vertices: BTreeSet<u32> = junctions
            .iter()
            .flat_map(|j| &j.vertices)
            .copied()
            .collect();
        let distances = self.match_distances(WELD_PART.get());
        let weld = weld_advice(distances, self.ends.len());
        let is_tested = self.ends.len() <= WELD_TESTED.get();
        let weld = weld.filter(|(length, _)| !is_tested || self.is_closed_by_welding(*length));
        let most = self.unit.max(CRACK.get() * self.diagonal());
        Closing {
            junctions: vertices.len(),
            junction_holes: holes.iter().filter(closes).count(),
            by_default: weld.is_some_and(|(length, _)| length <= most),
            weld,
        }
    }
}

/// The position of a point along a segment (mesh units from its start) if the point is within the tolerance of the segment and
/// away from its ends.
fn along(p: DVec3, [a, b]: [DVec3; 2], tolerance: f64) -> Option<f64> {
    let length = a.distance(b);
    let way = (b - a) / length;
    let place = (p - a).dot(way);
    let beside = (p - a - place * way).length();
    let margin = JUNCTION_ENDS.get() * tolerance;
    (beside <= tolerance && place > margin && place < length - margin).then_some(place)
}

/// The welding distance that closes most of the edges that can be closed, and how many it closes; none if these are too few of
/// the `edges` boundary edges. `distances` are the distances at which edges close.
///
/// The distances are sorted; at least half of them are taken, then more until two successive ones differ by a factor over 10, or one
/// is more than [`WELD_SPREAD`] times the median. Cracks in one file have one cause and one size; intended narrow slits are a
/// considerable part of an edge wide.
fn weld_advice(mut distances: Vec<f64>, edges: usize) -> Option<(f64, usize)> {
    distances.sort_by(f64::total_cmp);
    let few = (WELD_LEAST.get() * edges as f64).max(2.0);
    if (distances.len() as f64) < few {
        return None;
    }
    let half = distances.len().div_ceil(2);
    let most = WELD_SPREAD.get() * distances[half - 1];
    let gap = |pair: &[f64]| pair[1] > 10.0 * pair[0] || pair[1] > most;
    let cut = (half..distances.len()).find(|i| gap(&distances[i - 1..=*i]));
    let count = cut.unwrap_or(distances.len());
    let longest = *distances.get(count.checked_sub(1)?)?;
    (longest > 0.0).then(|| (rounded_up(longest), count))
}

/// The next larger number with two significant digits.
fn rounded_up(length: f64) -> f64 {
    let step = powf(10.0, log10(length).floor() - 1.0);
    let digits = (length / step).floor() + 1.0;
    // Parse the printed number, so that it is exactly what a user would type.
    format!("{:.1e}", digits * step)
        .parse()
        .unwrap_or(digits * step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_advice_leaves_slits_of_the_size_of_edges_out() {
        let cracks = (1..=60).map(|i| 1e-6 * f64::from(i) / 60.0);
        let slits = (0..30).map(|i| 0.1 + 0.001 * f64::from(i));
        let all: Vec<f64> = cracks.chain(slits).collect();
        assert_eq!(weld_advice(all, 100), Some((1.1e-6, 60)));
        let edges = (0..30).map(|i| 1e-5 * f64::powf(1.2, f64::from(i)));
        let beside: Vec<f64> = (1..=60)
            .map(|i| 1e-6 * f64::from(i) / 60.0)
            .chain(edges)
            .collect();
        assert_eq!(weld_advice(beside, 100), Some((1.1e-6, 60)));
        assert_eq!(weld_advice(vec![1e-6; 3], 1000), None);
        assert_eq!(weld_advice(Vec::new(), 10), None);
        assert_eq!(weld_advice(vec![0.0379; 5], 10), Some((0.038, 5)));
    }
}
