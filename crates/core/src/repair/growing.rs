//! A box tree that supports insertion.

use crate::spatial::{Bounds, BoxTree};

/// Number of boxes that are searched linearly before a tree is built over them.
const LINEAR_SEARCH: usize = 64;

/// A sequence of static trees of decreasing size (J. L. Bentley and J. B. Saxe, "Decomposable searching problems I", Journal of
/// Algorithms 1, 1980): each box is built into a logarithmic number of trees.
#[derive(Default)]
pub(super) struct GrowingTree {
    boxes: Vec<Bounds>,
    /// The trees, ascending by the number of their first box; the last few boxes are in none.
    trees: Vec<(usize, BoxTree)>,
    /// Number of boxes in trees.
    in_trees: usize,
}

impl GrowingTree {
    pub(super) fn push(&mut self, one: Bounds) {
        self.boxes.push(one);
        let count = self.boxes.len();
        if count - self.in_trees < LINEAR_SEARCH {
            return;
        }
        let mut first = self.in_trees;
        while let Some((start, _)) = self.trees.last()
            && first - start <= count - first
        {
            first = *start;
            self.trees.pop();
        }
        self.trees
            .push((first, BoxTree::new(&self.boxes[first..count])));
        self.in_trees = count;
    }

    /// Removes all boxes after the first `count`.
    pub(super) fn truncate(&mut self, count: usize) {
        self.boxes.truncate(count);
        let mut cut = false;
        while self.in_trees > count {
            self.in_trees = self.trees.pop().map_or(0, |(first, _)| first);
            cut = true;
        }
        if cut && count - self.in_trees >= LINEAR_SEARCH {
            let first = self.in_trees;
            self.trees
                .push((first, BoxTree::new(&self.boxes[first..count])));
            self.in_trees = count;
        }
    }

    /// Whether `accept` accepts the number of any box that intersects a query box.
    pub(super) fn any(&self, query: &Bounds, mut accept: impl FnMut(u32) -> bool) -> bool {
        let mut trees = self.trees.iter();
        if trees.any(|(first, t)| t.find(query, |i| accept(*first as u32 + i)).is_some()) {
            return true;
        }
        let mut last = (self.in_trees..self.boxes.len()).filter(|i| self.boxes[*i].meets(query));
        last.any(|i| accept(i as u32))
    }

    /// Visits the numbers of the boxes that intersect a query box.
    pub(super) fn for_each(&self, query: &Bounds, mut visit: impl FnMut(u32)) {
        self.any(query, |i| {
            visit(i);
            false
        });
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::mesh::shapes::noise;

    #[test]
    fn the_boxes_that_meet_one_are_those_of_a_search_through_all() {
        let mut value = noise(7);
        let mut next = || DVec3::new(value(), value(), value());
        let mut tree = GrowingTree::default();
        let mut all: Vec<Bounds> = Vec::new();
        for count in [10, 700, 300, 301, 1500, 64, 200] {
            tree.truncate(count);
            all.truncate(count);
            while all.len() < count {
                let one = Bounds::of_ball(next(), 0.05);
                tree.push(one);
                all.push(one);
            }
            let query = Bounds::of_ball(next(), 0.3);
            let mut found = Vec::new();
            tree.for_each(&query, |i| found.push(i));
            found.sort_unstable();
            let meets = |i: &u32| all[*i as usize].meets(&query);
            let expected: Vec<u32> = (0..count as u32).filter(meets).collect();
            assert_eq!(found, expected, "{count} boxes");
        }
    }
}
