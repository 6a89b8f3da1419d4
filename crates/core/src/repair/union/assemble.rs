//! Writes a union into the draft: whole faces are kept, reversed or removed, divided faces are replaced by their kept parts.

use std::collections::HashMap;

use glam::DVec3;

use super::United;
use super::arrange::{Arrangement, Piece};
use super::classify::Fate;
use crate::mesh::FaceOrigin;
use crate::mesh::topology::NONE;
use crate::repair::draft::Draft;
use crate::repair::intersection_cache::sorted;
use crate::repair::rounding::is_single;

/// A computed union: what to do with each face of the clusters.
pub(super) struct Union {
    pub(super) bodies: usize,
    /// The faces of all clusters, each with its cluster.
    pub(super) clusters: Vec<(u32, u32)>,
    /// Faces that intersect no other face, with their fates.
    pub(super) whole: Vec<(u32, Fate)>,
    /// Intersecting faces, in the numbering of the arrangement.
    pub(super) divided: Vec<u32>,
    /// Faces with collinear corners, which go.
    pub(super) collinear: Vec<u32>,
    pub(super) arrangement: Arrangement,
    pub(super) fates: Vec<Fate>,
    /// The welded vertex of each vertex.
    pub(super) weld: Vec<u32>,
}

/// A part of a divided face that is kept.
struct Part {
    /// The divided face of the draft.
    face: u32,
    nodes: [u32; 3],
}

impl Union {
    /// Whether anything of the clusters stays.
    pub(super) fn keeps_any(&self) -> bool {
        let whole = self.whole.iter().map(|(_, fate)| fate);
        whole.chain(&self.fates).any(|fate| *fate != Fate::Goes)
    }

    /// Applies the union to the draft.
    pub(super) fn apply(&self, draft: &mut Draft) -> United {
        let mut removed = vec![false; draft.mesh.faces.len()];
        for &(f, fate) in &self.whole {
            match fate {
                Fate::Stays => {}
                Fate::Goes => removed[f as usize] = true,
                Fate::Turned => draft.reverse_face(f as usize),
            }
        }
        (self.divided.iter().chain(&self.collinear)).for_each(|f| removed[*f as usize] = true);
        // Remove divided faces, except those kept whole.
        let (kept, parts) = self.parts(draft);
        kept.iter().for_each(|f| removed[*f as usize] = false);
        let mut has_parts = vec![false; removed.len()];
        // Add the kept parts, without collapsed ones.
        let place = self.places(draft, &parts);
        let mut added = Vec::new();
        for part in &parts {
            let nodes = part.nodes.map(|n| place.get(&n).copied().unwrap_or(n));
            let [a, b, c] = nodes;
            if a != b && b != c && c != a {
                added.push((part, nodes));
            }
        }
        // Triangles in both orientations cancel.
        let opposed = self.opposed(draft, &kept, &added);
        for (part, nodes) in added {
            let key = sorted(nodes);
            if opposed.contains_key(&key) {
                continue;
            }
            has_parts[part.face as usize] = true;
            self.add(draft, part, nodes);
        }
        for f in kept
            .iter()
            .filter(|f| opposed.contains_key(&self.key(draft, **f)))
        {
            removed[*f as usize] = true;
        }
        let split = has_parts.iter().filter(|p| **p).count();
        let gone = removed.iter().zip(&has_parts).filter(|(r, p)| **r && !**p);
        let gone = gone.count();
        removed.resize(draft.mesh.faces.len(), false);
        draft.remove(&removed);
        United {
            bodies: self.bodies,
            split,
            removed: gone,
        }
    }

    /// The welded corners of a face, ascending.
    fn key(&self, draft: &Draft, face: u32) -> [u32; 3] {
        sorted(draft.mesh.faces[face as usize].map(|v| self.weld[v as usize]))
    }

    /// The divided faces that are kept whole, ascending, and the kept parts of the others.
    fn parts(&self, draft: &Draft) -> (Vec<u32>, Vec<Part>) {
        let (mut kept, mut parts) = (Vec::new(), Vec::new());
        for (piece, fate) in self.arrangement.pieces.iter().zip(&self.fates) {
            let wanted = match fate {
                Fate::Goes => continue,
                Fate::Stays => true,
                Fate::Turned => false,
            };
            let own = || piece.faces.iter().filter(|(_, same)| *same == wanted);
            let face = |f: u32| self.divided[f as usize];
            let is_whole = |f: &u32| self.key(draft, *f) == sorted(piece.nodes);
            if let Some(whole) = own().map(|(f, _)| face(*f)).find(is_whole) {
                kept.push(whole);
            // Around parts that are inside out a face is kept with its other side.
            } else if let Some((f, _)) = own().chain(&piece.faces).next() {
                let Piece {
                    nodes: [a, b, c], ..
                } = *piece;
                parts.push(Part {
                    face: face(*f),
                    nodes: if wanted { [a, b, c] } else { [a, c, b] },
                });
            }
        }
        kept.sort_unstable();
        (kept, parts)
    }

    /// Creates draft vertices for the new points of the parts, rounded to the precision of the mesh. Points at the same rounded
    /// position share a vertex, also with vertices of the divided input faces.
    fn places(&self, draft: &mut Draft, parts: &[Part]) -> HashMap<u32, u32> {
        let base = self.weld.len() as u32;
        let at = |p: DVec3| (p + DVec3::ZERO).to_array().map(f64::to_bits);
        let mut known: HashMap<[u64; 3], u32> = HashMap::new();
        let mut are_single = true;
        for f in &self.divided {
            for v in draft.mesh.faces[*f as usize] {
                let p = draft.mesh.positions[v as usize];
                known.insert(at(p), self.weld[v as usize]);
                are_single &= is_single(p);
            }
        }
        let mut place = HashMap::new();
        // Parts of input faces come first, so that vertices shared with patches inherit from them.
        let is_new = |part: &&Part| draft.region[part.face as usize] != NONE;
        let order: Vec<&Part> = (parts.iter().filter(|p| !is_new(p)))
            .chain(parts.iter().filter(is_new))
            .collect();
        for part in order {
            for node in part.nodes {
                if node < base || place.contains_key(&node) {
                    continue;
                }
                let exact = self.arrangement.points.all[(node - base) as usize].nearest;
                let p = draft.rounding.beside(are_single, exact);
                let vertex = *known.entry(at(p)).or_insert_with(|| {
                    let corners = draft.mesh.faces[part.face as usize];
                    let far = |v: &u32| draft.mesh.positions[*v as usize].distance(p);
                    let nearest = corners.into_iter().min_by(|v, w| far(v).total_cmp(&far(w)));
                    let new = draft.copy_vertex(nearest.unwrap_or(corners[0]), p);
                    draft.expected_error[new as usize] = None;
                    new
                });
                place.insert(node, vertex);
            }
        }
        place
    }

    /// Triangles that occur in both orientations after rounding merged vertices; they cancel.
    fn opposed(
        &self,
        draft: &Draft,
        kept: &[u32],
        added: &[(&Part, [u32; 3])],
    ) -> HashMap<[u32; 3], i32> {
        let mut sums: HashMap<[u32; 3], (i32, u32)> = HashMap::new();
        let mut count = |nodes: [u32; 3]| {
            let key = sorted(nodes);
            let first = nodes.iter().position(|v| *v == key[0]).unwrap_or(0);
            let way = if nodes[(first + 1) % 3] == key[1] {
                1
            } else {
                -1
            };
            let entry = sums.entry(key).or_default();
            *entry = (entry.0 + way, entry.1 + 1);
        };
        for f in kept {
            count(draft.mesh.faces[*f as usize].map(|v| self.weld[v as usize]));
        }
        added.iter().for_each(|(_, nodes)| count(*nodes));
        let both = |(_, (sum, times)): &(_, (i32, u32))| *times > 1 && *sum == 0;
        sums.into_iter()
            .filter(both)
            .map(|(key, (sum, _))| (key, sum))
            .collect()
    }

    /// Adds a part of a face; `nodes` are welded vertices.
    fn add(&self, draft: &mut Draft, part: &Part, nodes: [u32; 3]) {
        let face = part.face as usize;
        let (own, origin) = (draft.mesh.faces[face], draft.origins.faces[face]);
        let place = |v: u32| self.weld.get(v as usize).copied().unwrap_or(v);
        let corner = nodes.map(|n| own.iter().position(|v| place(*v) == n));
        let vertex = |i: usize| corner[i].map_or(nodes[i], |k| own[k]);
        let from = |i: usize| corner[i].map_or(3, |k| origin.corners[k]);
        draft.mesh.faces.push([vertex(0), vertex(1), vertex(2)]);
        draft.origins.faces.push(FaceOrigin {
            face: origin.face,
            corners: [from(0), from(1), from(2)],
        });
        draft.region.push(draft.region[face]);
    }
}
