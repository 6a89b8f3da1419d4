//! Disjoint sets (union-find), and groups of connected faces.

use std::collections::BTreeMap;

use super::Mesh;

/// Disjoint sets of the numbers below a count (union-find with path halving). The representative of a set is its smallest member,
/// so it does not depend on the order of joins.
#[derive(Clone, Debug)]
pub struct DisjointSets {
    /// Another member of the set, smaller than the number itself; the smallest member is its own parent.
    parent: Vec<u32>,
}

impl DisjointSets {
    /// Each number below `count` in a set of its own.
    pub fn new(count: usize) -> Self {
        Self {
            parent: (0..count as u32).collect(),
        }
    }

    /// The smallest member of a number's set.
    ///
    /// # Panics
    /// If the number is out of range.
    pub fn find(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            self.parent[i as usize] = self.parent[self.parent[i as usize] as usize];
            i = self.parent[i as usize];
        }
        i
    }

    /// Joins the sets of two numbers; returns whether they were different.
    ///
    /// # Panics
    /// If a number is out of range.
    pub fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
        a != b
    }
}

/// Groups of the given faces that are connected across edges, in the order of their first faces.
///
/// # Panics
/// If a face is out of range.
pub fn connected(mesh: &Mesh, faces: &[u32]) -> Vec<Vec<u32>> {
    let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * faces.len());
    for (i, f) in (0..).zip(faces) {
        let corners = mesh.faces[*f as usize];
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], i));
        }
    }
    edges.sort_unstable();
    let mut sets = DisjointSets::new(faces.len());
    for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        sets.join(pair[0].1, pair[1].1);
    }
    let mut place: BTreeMap<u32, usize> = BTreeMap::new();
    let mut groups: Vec<Vec<u32>> = Vec::new();
    for (i, f) in (0..).zip(faces) {
        let group = *place.entry(sets.find(i)).or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(*f);
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn representatives_are_the_smallest_members_in_any_order_of_joins() {
        let joins = [(7, 3), (9, 7), (1, 8), (3, 8), (4, 5)];
        let mut forth = DisjointSets::new(10);
        let new = joins.map(|(a, b)| forth.join(a, b));
        let mut back = DisjointSets::new(10);
        joins.iter().rev().for_each(|&(a, b)| _ = back.join(b, a));
        let names = |sets: &mut DisjointSets| (0..10).map(|i| sets.find(i)).collect::<Vec<_>>();
        assert_eq!(names(&mut forth), [0, 1, 2, 1, 4, 4, 6, 1, 1, 1]);
        assert_eq!(names(&mut back), names(&mut forth));
        assert_eq!(new, [true; 5]);
        assert!(!forth.join(9, 1));
    }
}
