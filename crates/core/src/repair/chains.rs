//! Closes the surface as a chain: along each edge as many faces must run one way as the other. Bodies that share edges may lack a face
//! where no boundary shows it, since other faces lie there.

use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};

use glam::DVec3;

use super::draft::Draft;
use super::rim_triangles::push;
use crate::fill::FEW_EDGES;
use crate::mend::{FillError, Inspection};
use crate::mesh::area_vector;
use crate::mesh::topology::NONE;
use crate::mesh::triangulate::{Polygon, triangulate};
use crate::tuning::{Tunable, tunable};

/// Edges. Where more faces run one way than the other along more edges than this, no faces are added there.
const CHAIN_EDGES: Tunable<usize> = tunable("repair.chain_edges", 2000);

/// Edges. Longer loops of such edges are left to the fill.
const CHAIN_LOOP: Tunable<usize> = tunable("repair.chain_loop", 60);

/// Fraction of the area. Larger loops of more than three edges are left to the fill.
const CHAIN_AREA: Tunable<f64> = tunable("repair.chain_area", 0.01);

/// Adds faces along small loops of edges at which more faces run one way than the other; returns how many. Loops of boundary edges
/// alone are holes, which are left to the fill.
pub(super) fn close(draft: &mut Draft) -> Result<usize, FillError> {
    let faces = {
        let found = draft.inspect()?;
        let open = Open::new(draft, &found);
        if open.next.is_empty() || open.count > CHAIN_EDGES.get() {
            return Ok(0);
        }
        let area = |f: &[u32; 3]| area_vector(f.map(|v| found.mesh.positions[v as usize])).length();
        let all: f64 = found.mesh.faces.iter().map(area).sum();
        let mut faces = Vec::new();
        for rim in open.loops() {
            let new = triangulated(&found.mesh.positions, &rim);
            let is_small = new.iter().map(area).sum::<f64>() <= CHAIN_AREA.get() * all;
            if is_small || rim.len() == 3 {
                faces.extend(new);
            }
        }
        faces
    };
    faces.iter().for_each(|f| push(draft, NONE, *f));
    Ok(faces.len())
}

/// The triangles of a loop; none if it has no triangulation.
pub(super) fn triangulated(positions: &[DVec3], rim: &[u32]) -> Vec<[u32; 3]> {
    let position: Vec<DVec3> = rim.iter().map(|v| positions[*v as usize]).collect();
    let polygon = Polygon {
        position: &position,
        beyond: &vec![None; rim.len()],
        blocked: &|_, _| false,
    };
    let faces = triangulate(&polygon).unwrap_or_default();
    faces.into_iter().map(|f| f.map(|i| rim[i])).collect()
}

/// The edges of faces that are missing: at each vertex as many begin as end.
struct Open {
    /// For each vertex the ends of its edges, with multiplicity, and whether the edge is a boundary edge.
    next: BTreeMap<u32, Vec<(u32, bool)>>,
    count: usize,
}

impl Open {
    fn new(draft: &Draft, found: &Inspection) -> Self {
        let mut balance: HashMap<(u32, u32), (i32, u32)> = HashMap::new();
        let corners = |f: u32| draft.mesh.faces[f as usize].map(|v| found.weld[v as usize]);
        let proper = found.topology.faces().map(corners);
        for (a, b) in proper.flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)]) {
            let sum = balance.entry((a.min(b), a.max(b))).or_default();
            *sum = (sum.0 + if a < b { 1 } else { -1 }, sum.1 + 1);
        }
        let mut next: BTreeMap<u32, Vec<(u32, bool)>> = BTreeMap::new();
        let mut count = 0;
        for ((low, high), (sum, faces)) in balance {
            let (from, to) = if sum > 0 { (high, low) } else { (low, high) };
            let times = sum.unsigned_abs() as usize;
            count += times;
            for _ in 0..times {
                next.entry(from).or_default().push((to, faces == 1));
            }
        }
        next.values_mut().for_each(|ends| ends.sort_unstable());
        Self { next, count }
    }

    /// Takes loops apart, the shortest first; those that are holes, or mostly boundary edges, are left out.
    fn loops(mut self) -> Vec<Vec<u32>> {
        let few = FEW_EDGES.get();
        let mut loops = Vec::new();
        for most in [few, CHAIN_LOOP.get()] {
            let starts: Vec<u32> = self.next.keys().copied().collect();
            for start in starts {
                while let Some(rim) = self.shortest(start, most) {
                    let borders = self.take(&rim);
                    if borders < rim.len() && (rim.len() <= few || 2 * borders <= rim.len()) {
                        loops.push(rim);
                    }
                }
            }
        }
        loops
    }

    /// A shortest loop through a vertex, of at most this many edges.
    fn shortest(&self, start: u32, most: usize) -> Option<Vec<u32>> {
        let mut before: HashMap<u32, u32> = HashMap::new();
        let mut steps: HashMap<u32, usize> = HashMap::from([(start, 0)]);
        let mut queue = VecDeque::from([start]);
        while let Some(v) = queue.pop_front() {
            let far = steps[&v] + 1;
            let ends: BTreeSet<u32> = self
                .next
                .get(&v)
                .into_iter()
                .flatten()
                .map(|e| e.0)
                .collect();
            for w in ends {
                if w == start && far >= 3 {
                    let mut rim = vec![v];
                    while let Some(u) = before.get(&rim[rim.len() - 1]) {
                        rim.push(*u);
                    }
                    rim.reverse();
                    return Some(rim);
                }
                if far < most && !steps.contains_key(&w) {
                    steps.insert(w, far);
                    before.insert(w, v);
                    queue.push_back(w);
                }
            }
        }
        None
    }

    /// Removes the edges of a loop; returns how many were boundary edges.
    fn take(&mut self, rim: &[u32]) -> usize {
        let mut borders = 0;
        for (v, w) in rim.iter().zip(rim.iter().cycle().skip(1)) {
            if let Some(ends) = self.next.get_mut(v)
                && let Some(i) = ends.iter().position(|e| e.0 == *w)
            {
                borders += usize::from(ends.remove(i).1);
            }
        }
        borders
    }
}
