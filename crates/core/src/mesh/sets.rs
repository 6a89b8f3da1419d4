//! Disjoint sets (union-find).

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
