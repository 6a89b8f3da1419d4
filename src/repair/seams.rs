//! Seams: welds boundary edges that coincide except for rounding and splits edges at T-junctions.

use std::collections::HashSet;

use super::RepairReport;
use super::draft::Draft;
use crate::check::{Boundary, Match, is_flat};
use crate::mend::{FillError, Inspection};
use crate::mesh::topology::end;
use crate::mesh::{DisjointSets, FaceOrigin, Mesh, VertexFaces, area_vector};
use crate::tuning::tuning;

/// Welds boundary edges that coincide within the precision of the coordinates, if nothing gets worse; returns the number of
/// merged vertices.
pub(super) fn weld(draft: &mut Draft) -> Result<usize, FillError> {
    let (to, merged) = {
        let found = draft.inspect()?;
        let boundary = Boundary::with_unit(&found.mesh, &found.topology, draft.unit);
        let matches = boundary.matches(boundary.unit, tuning().check.weld_edge);
        let to = merges(&found, &boundary, &matches);
        let merged = (0..).zip(&to).filter(|(v, w)| v != *w).count();
        let of_file: Vec<u32> = found.weld.iter().map(|v| to[*v as usize]).collect();
        (of_file, merged)
    };
    if merged == 0 {
        return Ok(0);
    }
    let mut new = draft.clone();
    new.forget_inspection();
    // Unmerged corners keep their own vertex, which carries its attributes.
    let found = draft.inspect()?;
    for corner in new.mesh.faces.iter_mut().flatten() {
        let place = found.weld[*corner as usize];
        if to[*corner as usize] != place {
            *corner = to[*corner as usize];
        }
    }
    drop(found);
    Ok(if replace(draft, new)? { merged } else { 0 })
}

/// For each welded vertex the vertex it is merged into: the first of those that coincide with it. No face loses a corner.
fn merges(found: &Inspection, boundary: &Boundary, matches: &[Option<Match>]) -> Vec<u32> {
    let count = found.mesh.positions.len();
    // Join the ends of matching edges.
    let mut sets = DisjointSets::new(count);
    for (ends, other) in boundary.ends.iter().zip(matches) {
        if let Some(other) = other {
            for (v, w) in ends.iter().zip(other.ends) {
                sets.join(*v, w);
            }
        }
    }
    let mut to: Vec<u32> = (0..count as u32).map(|v| sets.find(v)).collect();
    let near = |v: u32, w: u32| {
        let apart = found.mesh.positions[v as usize].distance(found.mesh.positions[w as usize]);
        apart <= 2.0 * boundary.unit
    };
    let around = VertexFaces::new(&found.mesh);
    // Do not merge sets that are too wide or contain two corners of one face.
    let mut spoilt: HashSet<u32> = HashSet::new();
    for v in (0..count as u32).filter(|v| to[*v as usize] != *v) {
        let set = to[v as usize];
        let of_face = |f: &u32| {
            let corners = found.mesh.faces[*f as usize].map(|w| to[w as usize]);
            corners.iter().filter(|w| **w == set).count() > 1
        };
        if !near(v, set) || around.of(v).iter().any(of_face) {
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

/// Splits boundary edges at boundary vertices on them, if nothing gets worse. The face of the edge is replaced by parts of it.
pub(super) fn stitch(draft: &mut Draft, report: &mut RepairReport) -> Result<(), FillError> {
    let mut new: Option<Draft> = None;
    let mut split = 0;
    for _ in 0..tuning().repair.stitch_rounds {
        let current = new.as_ref().unwrap_or(draft);
        let splits = splits(&*current.inspect()?, draft.unit);
        if splits.is_empty() {
            break;
        }
        let target = new.get_or_insert_with(|| {
            let mut copy = draft.clone();
            copy.forget_inspection();
            copy
        });
        split += splits.iter().map(|s| s.vertices.len()).sum::<usize>();
        splits.into_iter().for_each(|s| s.make(target));
    }
    if let Some(new) = new
        && replace(draft, new)?
    {
        report.stitched_junctions += split;
    }
    Ok(())
}

/// Replaces the draft by another one if that has no more faults, holes not considered, and fewer boundary edges; returns whether
/// it did.
fn replace(draft: &mut Draft, mut new: Draft) -> Result<bool, FillError> {
    let before = draft.faults()?;
    let better = new.faults()?.is_no_worse_but_for_holes(&before)
        && boundary_edges(&*new.inspect()?) < boundary_edges(&*draft.inspect()?);
    if better {
        *draft = new;
    }
    Ok(better)
}

fn boundary_edges(found: &Inspection) -> usize {
    found.topology.boundary.iter().filter(|b| **b).count()
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
fn splits(found: &Inspection, unit: f64) -> Vec<Split> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let boundary = Boundary::with_unit(mesh, topology, unit);
    let mut seen: HashSet<u32> = HashSet::new();
    let mut all = Vec::new();
    for junctions in boundary.junctions() {
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
        if !sound || !seen.insert(face) {
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
