//! Cuts a patch open into a topological disk, so that it can be mapped to the plane.

use std::collections::{HashMap, VecDeque};

use isomend_core::mesh::DisjointSets;

/// A surface with one border loop and no handles. A vertex on a cut is duplicated, once for each side of the cut.
pub(super) struct Disk {
    /// The vertex of the patch (slot) that each vertex of the disk comes from.
    pub(super) slots: Vec<u32>,
    /// The patch's faces, in the same order, between vertices of the disk.
    pub(super) faces: Vec<[u32; 3]>,
    /// The vertices of the border loop, each once, in the direction of the faces' edges.
    pub(super) border: Vec<u32>,
}

impl Disk {
    /// Cuts a connected patch along a cut graph: the edges that a spanning tree of the faces does not cross, without dangling branches.
    /// `None` if an edge has more than two faces, neighbouring faces have opposite orientations, or the patch has no rim.
    pub(super) fn cut(faces: &[[u32; 3]]) -> Option<Self> {
        let across = across(faces)?;
        let cut = pruned(faces, &across, crossed_by_tree(&across));
        // Corners at a vertex that are connected across uncut edges form one vertex of the disk.
        let mut corners = DisjointSets::new(3 * faces.len());
        for (half, other) in across.iter().enumerate() {
            if let Some(other) = other.filter(|_| !cut[half]) {
                corners.join(half as u32, next(other));
                corners.join(next(half as u32), other);
            }
        }
        let mut number: HashMap<u32, u32> = HashMap::new();
        let mut disk = Self {
            slots: Vec::new(),
            faces: Vec::with_capacity(faces.len()),
            border: Vec::new(),
        };
        for (f, face) in faces.iter().enumerate() {
            disk.faces.push([0, 1, 2].map(|k| {
                let set = corners.find((3 * f + k) as u32);
                *number.entry(set).or_insert_with(|| {
                    disk.slots.push(face[k]);
                    disk.slots.len() as u32 - 1
                })
            }));
        }
        let is_border = |half: usize| across[half].is_none() || cut[half];
        disk.walk_border((0..across.len()).filter(|half| is_border(*half)))?;
        Some(disk)
    }

    /// Orders the half-edges of the border into a loop; `None` if they are not a single loop or the surface is no disk.
    fn walk_border(&mut self, halves: impl Iterator<Item = usize>) -> Option<()> {
        let mut follows: HashMap<u32, u32> = HashMap::new();
        let mut first = None;
        for half in halves {
            let face = self.faces[half / 3];
            let [a, b] = [face[half % 3], face[next(half as u32) as usize % 3]];
            first = first.or(Some(a));
            if follows.insert(a, b).is_some() {
                return None;
            }
        }
        let first = first?;
        let mut at = first;
        for _ in 0..follows.len() {
            self.border.push(at);
            at = *follows.get(&at)?;
            if at == first {
                break;
            }
        }
        // Euler: V − E + F = 1, with 2 E = 3 F + border edges.
        let edges = (3 * self.faces.len() + self.border.len()) / 2;
        let is_disk = self.slots.len() + self.faces.len() == edges + 1;
        (at == first && self.border.len() == follows.len() && is_disk).then_some(())
    }
}

/// The next half-edge of the same face.
fn next(half: u32) -> u32 {
    half / 3 * 3 + (half + 1) % 3
}

/// The opposite half-edge of each half-edge (three per face), `None` at rims. No result if an edge has more than two faces or neighbouring
/// faces have opposite orientations.
fn across(faces: &[[u32; 3]]) -> Option<Vec<Option<u32>>> {
    let mut halves: HashMap<(u32, u32), u32> = HashMap::new();
    let edge = |half: usize| {
        let face = faces[half / 3];
        (face[half % 3], face[next(half as u32) as usize % 3])
    };
    for half in 0..3 * faces.len() {
        let (a, b) = edge(half);
        if a == b || halves.insert((a, b), half as u32).is_some() {
            return None;
        }
    }
    let other = |half| {
        let (a, b) = edge(half);
        halves.get(&(b, a)).copied()
    };
    Some((0..3 * faces.len()).map(other).collect())
}

/// Whether a spanning tree of the faces, grown breadth first from the first face, crosses each half-edge.
fn crossed_by_tree(across: &[Option<u32>]) -> Vec<bool> {
    let mut crossed = vec![false; across.len()];
    let mut reached = vec![false; across.len() / 3];
    let mut queue = VecDeque::from([0usize]);
    if let Some(first) = reached.first_mut() {
        *first = true;
    }
    while let Some(face) = queue.pop_front() {
        for half in 3 * face..3 * face + 3 {
            let Some(other) = across[half].map(|o| o as usize) else {
                continue;
            };
            if !std::mem::replace(&mut reached[other / 3], true) {
                crossed[half] = true;
                crossed[other] = true;
                queue.push_back(other / 3);
            }
        }
    }
    crossed
}

/// The half-edges along which the surface is cut: inner ones that the tree of faces does not cross. Branches that end at an inner vertex
/// are removed edge by edge.
fn pruned(faces: &[[u32; 3]], across: &[Option<u32>], crossed: Vec<bool>) -> Vec<bool> {
    let ends = |half: usize| {
        let face = faces[half / 3];
        [face[half % 3], face[next(half as u32) as usize % 3]]
    };
    let mut cut: Vec<bool> = (0..across.len())
        .map(|half| across[half].is_some() && !crossed[half])
        .collect();
    // The cut edges at each vertex, and the vertices on rims, where branches may end.
    let mut at_vertex: HashMap<u32, Vec<usize>> = HashMap::new();
    let mut on_rim: HashMap<u32, bool> = HashMap::new();
    for half in 0..across.len() {
        match across[half] {
            None => ends(half).iter().for_each(|v| _ = on_rim.insert(*v, true)),
            // Counts each edge once.
            Some(other) if cut[half] && half < other as usize => {
                for v in ends(half) {
                    at_vertex.entry(v).or_default().push(half);
                }
            }
            Some(_) => {}
        }
    }
    // Remove the last cut edge of each inner vertex, then examine the edge's other end.
    let mut leaves: Vec<u32> = at_vertex.keys().copied().collect();
    leaves.sort_unstable();
    while let Some(vertex) = leaves.pop() {
        let Some(edges) = at_vertex.get_mut(&vertex) else {
            continue;
        };
        edges.retain(|half| cut[*half]);
        if let ([half], false) = (&edges[..], on_rim.contains_key(&vertex)) {
            let half = *half;
            cut[half] = false;
            if let Some(other) = across[half] {
                cut[other as usize] = false;
            }
            leaves.extend(ends(half).iter().filter(|v| **v != vertex));
        }
    }
    cut
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of `n` by `m` squares, periodic in the first direction if `ring` and in the second if `torus`, without the squares for which
    /// `gone` holds.
    fn grid(
        n: u32,
        m: u32,
        [ring, torus]: [bool; 2],
        gone: impl Fn(u32, u32) -> bool,
    ) -> Vec<[u32; 3]> {
        let (wide, high) = (n + u32::from(!ring), m + u32::from(!torus));
        let at = |i: u32, j: u32| (j % high) * wide + i % wide;
        let mut faces = Vec::new();
        for j in 0..m {
            for i in (0..n).filter(|i| !gone(*i, j)) {
                let [a, b] = [at(i, j), at(i + 1, j)];
                let [c, d] = [at(i, j + 1), at(i + 1, j + 1)];
                faces.extend([[a, b, c], [b, d, c]]);
            }
        }
        faces
    }

    #[test]
    fn a_disk_is_left_as_it_is() {
        let disk = Disk::cut(&grid(5, 4, [false; 2], |_, _| false)).unwrap();
        assert_eq!((disk.slots.len(), disk.border.len()), (30, 18));
    }

    #[test]
    fn rings_holes_and_handles_are_cut_open() {
        let cases = [
            grid(8, 3, [true, false], |_, _| false),
            grid(9, 9, [false; 2], |i, j| i == 4 && (j == 2 || j == 6)),
            grid(8, 8, [true, true], |i, j| i == 2 && j == 5),
        ];
        for faces in cases {
            let disk = Disk::cut(&faces).unwrap();
            assert_eq!(disk.faces.len(), faces.len());
            for (new, old) in disk.faces.iter().zip(&faces) {
                assert_eq!(new.map(|v| disk.slots[v as usize]), *old);
            }
        }
    }

    #[test]
    fn what_is_no_surface_with_a_rim_is_refused() {
        assert!(Disk::cut(&[[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]).is_none());
        assert!(Disk::cut(&[[0, 1, 2], [0, 1, 3]]).is_none());
        assert!(Disk::cut(&[[0, 0, 1]]).is_none());
    }
}
