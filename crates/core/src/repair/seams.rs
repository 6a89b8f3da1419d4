//! Seams: merges the ends of boundary edges that nearly coincide, and splits edges at T-junctions.

use std::collections::HashSet;

use super::draft::Draft;
use crate::check::{Boundary, is_flat};
use crate::mend::{FillError, Inspection};
use crate::mesh::topology::end;
use crate::mesh::{DisjointSets, FaceOrigin, Mesh, VertexFaces, area_vector};
use crate::tuning::{Tunable, tunable};

/// Lengths of the shorter of two boundary edges. The ends of the edges are merged by default only within this distance.
pub(super) const WELD_EDGE: Tunable<f64> = tunable("check.weld_edge", 0.1);

/// Rounds of splits at T-junctions, at most: each splits one edge of a face.
const STITCH_ROUNDS: Tunable<usize> = tunable("repair.stitch_rounds", 12);

/// How near boundary vertices must be to other ones, or to edges, to be merged or to split them.
pub(super) struct Reach<'a> {
    /// Mesh units.
    pub(super) unit: f64,
    /// Lengths of the edges there. Upper bound of the distance from a vertex to an edge that it splits.
    pub(super) part: f64,
    /// Whether any two boundary vertices within reach are merged, not only the ends of two edges that coincide.
    pub(super) vertices: bool,
    /// Welded vertices that are neither merged nor split edges.
    pub(super) blocked: &'a HashSet<u32>,
}

impl Reach<'_> {
    fn boundary<'m>(&self, found: &'m Inspection) -> Boundary<'m> {
        Boundary::with_unit(&found.mesh, &found.topology, self.unit).with_part(self.part)
    }
}

/// Merges the ends of boundary edges that coincide within reach; returns the number of merged vertices.
pub(super) fn merge(draft: &mut Draft, reach: &Reach) -> Result<usize, FillError> {
    let found = draft.inspect()?;
    let boundary = reach.boundary(&found);
    let to = merges(&found, &boundary, reach);
    let merged = (0..).zip(&to).filter(|(v, w)| v != *w).count();
    if merged == 0 {
        return Ok(0);
    }
    // Unmerged corners keep their own vertex, which carries its attributes.
    for corner in draft.mesh.faces.iter_mut().flatten() {
        let place = found.weld[*corner as usize];
        if to[place as usize] != place {
            *corner = to[place as usize];
        }
    }
    Ok(merged)
}

/// For each welded vertex the vertex it is merged into: the first of those that coincide with it. Only corners within reach of
/// each other may become one corner of their face.
fn merges(found: &Inspection, boundary: &Boundary, reach: &Reach) -> Vec<u32> {
    let count = found.mesh.positions.len();
    let around = VertexFaces::new(&found.mesh);
    let at = |v: u32| found.mesh.positions[v as usize];
    let mut sets = DisjointSets::new(count);
    // Join the ends of matching edges.
    let matches = boundary.matches(boundary.unit, WELD_EDGE.get());
    for (ends, other) in boundary.ends.iter().zip(matches) {
        if let Some(other) = other {
            for (v, w) in ends.iter().zip(other.ends) {
                sets.join(*v, w);
            }
        }
    }
    // Join vertices that are much nearer to each other than the edges there are long.
    if reach.vertices {
        let mean = |v: u32| WELD_EDGE.get() * mean_edge(&found.mesh, &around, v);
        boundary.for_each_pair(boundary.unit, |v, w| {
            if at(v).distance(at(w)) <= mean(v).min(mean(w)) {
                sets.join(v, w);
            }
        });
    }
    let mut to: Vec<u32> = (0..count as u32).map(|v| sets.find(v)).collect();
    let near = |v: u32, w: u32| at(v).distance(at(w)) <= 2.0 * boundary.unit;
    // Do not merge sets that are too wide or contain two corners of one face, unless these coincide too.
    let mut spoilt: HashSet<u32> = HashSet::new();
    for v in (0..count as u32).filter(|v| to[*v as usize] != *v) {
        let set = to[v as usize];
        let of_face = |f: &u32| {
            let corners = found.mesh.faces[*f as usize].map(|w| to[w as usize]);
            corners.iter().filter(|w| **w == set).count() > 1
        };
        let collapses = !reach.vertices && around.of(v).iter().any(of_face);
        let is_blocked = reach.blocked.contains(&v) || reach.blocked.contains(&set);
        if is_blocked || collapses || !near(v, set) {
            spoilt.insert(set);
        }
    }
    for v in 0..count as u32 {
        if spoilt.contains(&to[v as usize]) {
            to[v as usize] = v;
        }
    }
    to
}

/// The mean length of the edges of the faces at a vertex, in mesh units.
fn mean_edge(mesh: &Mesh, around: &VertexFaces, v: u32) -> f64 {
    let faces = around.of(v);
    let perimeter = |f: &u32| {
        let [a, b, c] = mesh.corners(*f);
        a.distance(b) + b.distance(c) + c.distance(a)
    };
    faces.iter().map(perimeter).sum::<f64>() / (3 * faces.len().max(1)) as f64
}

/// Splits boundary edges at boundary vertices within reach of them; returns the number of vertices at which edges were split. The
/// face of such an edge is replaced by parts of it.
pub(super) fn split(draft: &mut Draft, reach: &Reach) -> Result<usize, FillError> {
    let mut count = 0;
    for _ in 0..STITCH_ROUNDS.get() {
        let splits = splits(&*draft.inspect()?, reach);
        if splits.is_empty() {
            break;
        }
        count += splits.iter().map(|s| s.vertices.len()).sum::<usize>();
        splits.into_iter().for_each(|s| s.make(draft));
    }
    Ok(count)
}

/// A face edge to split.
struct Split {
    face: usize,
    /// The corner of the draft's face where the edge begins.
    corner: usize,
    /// The vertices on the edge, starting at that corner.
    vertices: Vec<u32>,
}

/// The edges to split, at most one per face.
fn splits(found: &Inspection, reach: &Reach) -> Vec<Split> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let boundary = reach.boundary(found);
    let mut seen: HashSet<u32> = HashSet::new();
    let mut all = Vec::new();
    for mut junctions in boundary.junctions() {
        junctions.vertices.retain(|v| !reach.blocked.contains(v));
        let h = boundary.half_edges[junctions.edge as usize];
        let (face, k) = (h / 3, h as usize % 3);
        let corners = mesh.faces[face as usize];
        let apex = corners[(k + 2) % 3];
        let [a, b] = [corners[k], end(mesh, h)];
        let chain: Vec<u32> = [a]
            .into_iter()
            .chain(junctions.vertices.iter().copied())
            .chain([b])
            .collect();
        let sound = chain
            .windows(2)
            .all(|pair| is_part(mesh, face, [pair[0], pair[1], apex]));
        if !sound || junctions.vertices.is_empty() || !seen.insert(face) {
            continue;
        }
        // In a face that the inspection reoriented, corners 1 and 2 are swapped with respect to the draft.
        let mut vertices = junctions.vertices;
        let corner = match topology.turned[face as usize] {
            false => k,
            true => {
                vertices.reverse();
                [0, 2, 1][(k + 1) % 3]
            }
        };
        all.push(Split {
            face: face as usize,
            corner,
            vertices,
        });
    }
    all
}

/// Whether a triangle has an area and the orientation of the face that it is a part of.
fn is_part(mesh: &Mesh, face: u32, triangle: [u32; 3]) -> bool {
    let corners = triangle.map(|v| mesh.positions[v as usize]);
    let whole = area_vector(mesh.corners(face));
    !is_flat(corners) && area_vector(corners).dot(whole) > 0.0
}

impl Split {
    /// Replaces the face by its parts: the first in its place, the others appended.
    fn make(self, draft: &mut Draft) {
        let (face, origin) = (draft.mesh.faces[self.face], draft.origins.faces[self.face]);
        let [from, to, apex] = [0, 1, 2].map(|i| (self.corner + i) % 3);
        let own = |corner: usize| (face[corner], origin.corners[corner]);
        let inner = self.vertices.into_iter().map(|v| (v, 3));
        let chain: Vec<(u32, u8)> = [own(from)]
            .into_iter()
            .chain(inner)
            .chain([own(to)])
            .collect();
        for (i, pair) in chain.windows(2).enumerate() {
            let part = [pair[0], pair[1], own(apex)];
            let corners = part.map(|(v, _)| v);
            let origin = FaceOrigin {
                face: origin.face,
                corners: part.map(|(_, corner)| corner),
            };
            if i == 0 {
                draft.mesh.faces[self.face] = corners;
                draft.origins.faces[self.face] = origin;
            } else {
                draft.mesh.faces.push(corners);
                draft.origins.faces.push(origin);
                draft.region.push(draft.region[self.face]);
            }
        }
    }
}
