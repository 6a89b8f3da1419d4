//! Faces whose corners lie exactly on a line: they bound nothing, but the edges of their neighbours must be divided where they had
//! corners, so that what is left stays closed.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DVec3;
use rayon::prelude::*;
use robust::{Coord, orient2d};

use crate::mesh::DisjointSets;
use crate::repair::{Edge, edges};
use crate::threads::CollectFiltered;

/// What is left of a list of faces without those whose corners are collinear.
pub(super) struct Proper {
    /// The faces to divide: the proper ones of the list, then neighbours of the collinear ones that were not in it.
    pub(super) divided: Vec<u32>,
    /// The collinear faces, also those that were not in the list: the edges of their neighbours may be divided.
    pub(super) collinear: Vec<u32>,
    /// Vertices on edges of `divided[i]`, as pairs of `i` and the vertex.
    pub(super) cuts: Vec<(u32, u32)>,
}

impl Proper {
    /// Sorts the faces `list` of `faces`, all on welded vertices; `own` are the faces of all clusters.
    pub(super) fn of(positions: &[DVec3], faces: &[[u32; 3]], own: &[u32], list: Vec<u32>) -> Self {
        let corners = |f: u32| faces[f as usize].map(|v| positions[v as usize]);
        let is_collinear = |f: &u32| is_collinear(corners(*f));
        let all = own.par_iter().copied();
        let mut proper = Self {
            collinear: all.filter(is_collinear).collect_filtered(),
            divided: list.into_iter().filter(|f| !is_collinear(f)).collect(),
            cuts: Vec::new(),
        };
        if !proper.collinear.is_empty() {
            proper.divide_neighbours(positions, faces, own);
        }
        proper
    }

    /// Divides each edge of a collinear face at all corners of the collinear faces that are connected with it by edges.
    fn divide_neighbours(&mut self, positions: &[DVec3], faces: &[[u32; 3]], own: &[u32]) {
        let at = |v: u32| positions[v as usize];
        let mut sets = DisjointSets::new(self.collinear.len());
        let mut first: HashMap<Edge, u32> = HashMap::new();
        for (i, &f) in (0..).zip(&self.collinear) {
            for e in edges(&faces[f as usize]) {
                let known = *first.entry(e).or_insert(i);
                sets.join(known, i);
            }
        }
        let mut on_line: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
        for (i, &f) in (0..).zip(&self.collinear) {
            let points = on_line.entry(sets.find(i)).or_default();
            points.extend(faces[f as usize]);
        }
        let gone: BTreeSet<u32> = self.collinear.iter().copied().collect();
        let mut place: HashMap<u32, u32> = (0..).zip(&self.divided).map(|(i, f)| (*f, i)).collect();
        for &f in own.iter().filter(|f| !gone.contains(f)) {
            for e in edges(&faces[f as usize]) {
                let Some(&line) = first.get(&e) else {
                    continue;
                };
                let is_between = |v: &&u32| between([e.0, e.1].map(at), at(**v));
                let found: Vec<u32> = on_line[&sets.find(line)]
                    .iter()
                    .filter(is_between)
                    .copied()
                    .collect();
                if found.is_empty() {
                    continue;
                }
                let i = *place.entry(f).or_insert_with(|| {
                    self.divided.push(f);
                    self.divided.len() as u32 - 1
                });
                self.cuts.extend(found.into_iter().map(|v| (i, v)));
            }
        }
    }
}

/// Whether the corners lie exactly on a line.
fn is_collinear(corners: [DVec3; 3]) -> bool {
    (0..3).all(|axis| {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let [a, b, c] = corners.map(|p| Coord { x: p[i], y: p[j] });
        orient2d(a, b, c) == 0.0
    })
}

/// Whether a point of the line through two others lies between them.
fn between([a, b]: [DVec3; 2], p: DVec3) -> bool {
    let span = (b - a).abs();
    let axis = (0..3)
        .max_by(|i, j| span[*i].total_cmp(&span[*j]))
        .unwrap_or(0);
    let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
    low < p[axis] && p[axis] < high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_beside_collinear_faces_are_divided_at_all_their_corners() {
        let x = [0.0, 1.0, 2.0, 3.0].map(|x| DVec3::new(x, 0.0, 0.0));
        let mut positions = x.to_vec();
        positions.push(DVec3::new(1.0, 1.0, 0.0));
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [1, 0, 4]];
        let proper = Proper::of(&positions, &faces, &[0, 1, 2, 3], vec![0, 1, 2]);
        assert_eq!(proper.collinear, [0, 1]);
        assert_eq!(proper.divided, [2]);
        assert_eq!(proper.cuts, [(0, 1), (0, 2)]);
        // Also of those that intersect nothing.
        let proper = Proper::of(&positions, &faces, &[0, 1, 2, 3], vec![0, 2]);
        assert_eq!(proper.collinear, [0, 1]);
        assert_eq!(proper.divided, [2]);
        assert_eq!(proper.cuts, [(0, 1), (0, 2)]);
        // Of a neighbour that intersects nothing too.
        let proper = Proper::of(&positions, &faces, &[0, 1, 2, 3], vec![0, 1]);
        assert_eq!(proper.divided, [2]);
    }
}
