//! Axis-aligned boxes in double precision, and a tree over them.

use std::sync::atomic::{AtomicBool, AtomicIsize, Ordering::Relaxed};

use glam::DVec3;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Smallest coordinates.
    pub low: DVec3,
    /// Largest coordinates.
    pub high: DVec3,
}

impl Bounds {
    /// The box of a ball.
    pub fn of_ball(centre: DVec3, radius: f64) -> Self {
        Self {
            low: centre - radius,
            high: centre + radius,
        }
    }

    /// The box of a triangle.
    pub fn of(t: [DVec3; 3]) -> Self {
        Self {
            low: t[0].min(t[1]).min(t[2]),
            high: t[0].max(t[1]).max(t[2]),
        }
    }

    /// The box enlarged by a margin on all sides.
    pub fn widened(&self, margin: f64) -> Self {
        Self {
            low: self.low - margin,
            high: self.high + margin,
        }
    }

    /// Distance between two boxes; 0 if they intersect.
    pub fn gap(&self, other: &Self) -> f64 {
        let apart = (self.low - other.high).max(other.low - self.high);
        apart.max(DVec3::ZERO).length()
    }

    /// Whether two closed boxes intersect.
    pub fn meets(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    /// Whether this box contains the other one.
    pub fn contains(&self, other: &Self) -> bool {
        self.low.cmple(other.low).all() && other.high.cmple(self.high).all()
    }

    /// The bounding box of both.
    #[must_use]
    pub fn join(self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }
}

/// A binary tree over boxes. The items are sorted so that each node covers a contiguous range of them.
pub struct BoxTree {
    nodes: Vec<Node>,
    items: Vec<Item>,
}

/// A box and its index in the input.
#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    index: u32,
}

#[derive(Clone, Copy)]
struct Node {
    bounds: Bounds,
    start: u32,
    end: u32,
    /// Index of the second child; the first follows its parent. 0 for a leaf.
    second: u32,
}

/// Maximum number of items in a leaf.
const LEAF: usize = 4;
/// Nodes with at least this many items process their two halves in parallel.
const PARALLEL_ITEMS: usize = 4096;
/// Size of the traversal stack: it must exceed the depth of the tree, which is below this for 32-bit indices.
const STACK: usize = 40;

/// Number of nodes of a tree over this many items.
fn node_count(items: usize) -> usize {
    match items {
        0 => 0,
        1..=LEAF => 1,
        _ => 1 + node_count(items / 2) + node_count(items - items / 2),
    }
}

fn build(items: &mut [Item], nodes: &mut [Node], start: u32, first: u32) {
    let bounds = items[1..]
        .iter()
        .fold(items[0].bounds, |b, item| b.join(&item.bounds));
    nodes[0] = Node {
        bounds,
        start,
        end: start + items.len() as u32,
        second: 0,
    };
    if items.len() <= LEAF {
        return;
    }
    let size = bounds.high - bounds.low;
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let middle = |item: &Item| item.bounds.low[axis] + item.bounds.high[axis];
    let half = items.len() / 2;
    items.select_nth_unstable_by(half, |a, b| {
        middle(a).total_cmp(&middle(b)).then(a.index.cmp(&b.index))
    });
    let left = node_count(half);
    let second = first + 1 + left as u32;
    nodes[0].second = second;
    let in_parallel = items.len() >= PARALLEL_ITEMS;
    let (low, high) = items.split_at_mut(half);
    let (of_low, of_high) = nodes[1..].split_at_mut(left);
    let mut low = || build(low, of_low, start, first + 1);
    let mut high = || build(high, of_high, start + half as u32, second);
    if in_parallel {
        rayon::join(low, high);
    } else {
        low();
        high();
    }
}

impl BoxTree {
    /// Builds a tree over boxes; items are identified by their index.
    pub fn new(boxes: &[Bounds]) -> Self {
        let items = boxes.iter().zip(0..);
        let items = items.map(|(bounds, index)| Item {
            bounds: *bounds,
            index,
        });
        let mut items: Vec<Item> = items.collect();
        let empty = Node {
            bounds: Bounds::of_ball(DVec3::ZERO, 0.0),
            start: 0,
            end: 0,
            second: 0,
        };
        let mut nodes = vec![empty; node_count(items.len())];
        if !items.is_empty() {
            build(&mut items, &mut nodes, 0, 0);
        }
        Self { nodes, items }
    }

    /// The first item, in tree order, whose box satisfies `meets` and which `accept` accepts. `meets` must hold for every box
    /// that contains a box for which it holds.
    fn first(
        &self,
        meets: impl Fn(&Bounds) -> bool,
        mut accept: impl FnMut(u32) -> bool,
    ) -> Option<u32> {
        let mut stack = [0u32; STACK];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let i = stack[depth];
            let node = &self.nodes[i as usize];
            if !meets(&node.bounds) {
                continue;
            }
            if node.second == 0 {
                for item in &self.items[node.start as usize..node.end as usize] {
                    if meets(&item.bounds) && accept(item.index) {
                        return Some(item.index);
                    }
                }
            } else {
                stack[depth] = node.second;
                stack[depth + 1] = i + 1;
                depth += 2;
            }
        }
        None
    }

    /// The first item, in tree order, whose box intersects `query` and which `accept` accepts.
    pub fn find(&self, query: &Bounds, accept: impl FnMut(u32) -> bool) -> Option<u32> {
        self.first(|bounds| bounds.meets(query), accept)
    }

    /// Calls `visit` with every item whose box intersects `query`.
    pub fn for_each(&self, query: &Bounds, mut visit: impl FnMut(u32)) {
        self.find(query, |item| {
            visit(item);
            false
        });
    }

    /// Calls `visit` with every item whose box is within `margin` of a segment, and possibly with a few others.
    pub fn for_each_along(&self, segment: [DVec3; 2], margin: f64, mut visit: impl FnMut(u32)) {
        let along = Along::new(segment, margin);
        self.first(
            |bounds| along.meets(bounds),
            |item| {
                visit(item);
                false
            },
        );
    }

    /// For each item, by index, whether `hit` holds for it and any other item whose box intersects its own. `hit` must be
    /// symmetric. None if more than `most` pairs of boxes per item intersect: then a search with [`BoxTree::find`], which ends at
    /// the first partner, is faster.
    pub fn hits(&self, most: usize, hit: impl Fn(u32, u32) -> bool + Sync) -> Option<Vec<bool>> {
        let flags: Vec<AtomicBool> = self.items.iter().map(|_| AtomicBool::new(false)).collect();
        let pairs = Pairs {
            tree: self,
            flags: &flags,
            left: AtomicIsize::new((most * self.items.len()).min(isize::MAX as usize) as isize),
            hit: &hit,
        };
        if !self.nodes.is_empty() {
            pairs.within(0);
        }
        let enough = pairs.left.into_inner() >= 0;
        enough.then(|| flags.into_iter().map(AtomicBool::into_inner).collect())
    }
}

/// A segment with a margin.
struct Along {
    from: DVec3,
    way: DVec3,
    /// Bounding box of the segment with its margin.
    around: Bounds,
    margin: f64,
}

impl Along {
    fn new([from, to]: [DVec3; 2], margin: f64) -> Self {
        let size = from.abs().max(to.abs()).max_element();
        // Larger than the rounding errors of the distances below.
        let margin = margin + 1e-12 * size;
        Self {
            from,
            way: to - from,
            around: Bounds::of([from, to, from]).widened(margin),
            margin,
        }
    }

    /// Whether a box is within the margin, by a separating-axis test with the axes of the box and their cross products with the
    /// segment (Gottschalk et al. 1996).
    fn meets(&self, bounds: &Bounds) -> bool {
        if !self.around.meets(bounds) {
            return false;
        }
        let half = 0.5 * (bounds.high - bounds.low) + self.margin;
        let apart = 0.5 * (bounds.low + bounds.high) - self.from;
        let cross = apart.cross(self.way).abs();
        let w = self.way.abs();
        let reach = DVec3::new(
            half.y * w.z + half.z * w.y,
            half.x * w.z + half.z * w.x,
            half.x * w.y + half.y * w.x,
        );
        let rounding = 1e-12
            * (self.from.abs().max_element()
                + bounds.high.abs().max(bounds.low.abs()).max_element());
        cross.cmple(reach + rounding * w.max_element()).all()
    }
}

/// A search for pairs of items whose boxes intersect.
struct Pairs<'a, H> {
    tree: &'a BoxTree,
    flags: &'a [AtomicBool],
    /// Number of intersecting pairs of boxes left before the search is abandoned; negative once it is.
    left: AtomicIsize,
    hit: &'a H,
}

impl<H: Fn(u32, u32) -> bool + Sync> Pairs<'_, H> {
    /// Tests the pairs within a node.
    fn within(&self, i: u32) {
        let node = &self.tree.nodes[i as usize];
        let items = &self.tree.items[node.start as usize..node.end as usize];
        if node.second == 0 {
            for (k, a) in items.iter().enumerate() {
                self.leaf(a, &items[k + 1..]);
            }
            return;
        }
        let children = || {
            self.between(i + 1, node.second);
        };
        if items.len() >= PARALLEL_ITEMS {
            rayon::join(
                || rayon::join(|| self.within(i + 1), || self.within(node.second)),
                children,
            );
        } else {
            self.within(i + 1);
            self.within(node.second);
            children();
        }
    }

    /// Tests the pairs of an item of one node and an item of another.
    fn between(&self, i: u32, j: u32) {
        let [a, b] = [i, j].map(|i| &self.tree.nodes[i as usize]);
        if !a.bounds.meets(&b.bounds) || self.left.load(Relaxed) < 0 {
            return;
        }
        let count = |n: &Node| n.end - n.start;
        match (a.second, b.second) {
            (0, 0) => {
                let others = &self.tree.items[b.start as usize..b.end as usize];
                for item in &self.tree.items[a.start as usize..a.end as usize] {
                    self.leaf(item, others);
                }
            }
            (second, other) if other == 0 || (second != 0 && count(a) >= count(b)) => {
                self.both(count(a) + count(b), [i + 1, j], [second, j]);
            }
            (_, other) => self.both(count(a) + count(b), [i, j + 1], [i, other]),
        }
    }

    fn both(&self, count: u32, one: [u32; 2], other: [u32; 2]) {
        let [one, other] = [one, other].map(|[i, j]| move || self.between(i, j));
        if count as usize >= PARALLEL_ITEMS {
            rayon::join(one, other);
        } else {
            one();
            other();
        }
    }

    fn leaf(&self, a: &Item, others: &[Item]) {
        let flag = |item: &Item| &self.flags[item.index as usize];
        let mut met = 0;
        for b in others.iter().filter(|b| a.bounds.meets(&b.bounds)) {
            met += 1;
            let known = flag(a).load(Relaxed) && flag(b).load(Relaxed);
            if !known && (self.hit)(a.index, b.index) {
                flag(a).store(true, Relaxed);
                flag(b).store(true, Relaxed);
            }
        }
        if met > 0 {
            self.left.fetch_sub(met, Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::noise;

    /// Edges of about the given length at random places of the unit cube, with their boxes.
    fn edges(count: usize, length: f64) -> Vec<([DVec3; 2], Bounds)> {
        let mut noise = noise(11);
        let mut point = || DVec3::new(noise(), noise(), noise());
        let edge = |_| {
            let from = point();
            let to = from + length * (point() - 0.5);
            ([from, to], Bounds::of([from, to, from]))
        };
        (0..count).map(edge).collect()
    }

    #[test]
    fn items_with_a_partner_are_found_as_by_all_pairs() {
        for length in [0.01, 0.1] {
            let all = edges(9000, length);
            let boxes: Vec<Bounds> = all.iter().map(|e| e.1).collect();
            let tree = BoxTree::new(&boxes);
            let hit = |i: u32, j: u32| (i ^ j).is_multiple_of(3);
            let found = tree.hits(1000, hit).unwrap();
            for i in 0..boxes.len() as u32 {
                let partner = tree.find(&boxes[i as usize], |j| i != j && hit(i, j));
                assert_eq!(found[i as usize], partner.is_some());
            }
            assert_eq!(tree.hits(0, hit), None);
        }
        assert_eq!(BoxTree::new(&[]).hits(1, |_, _| true), Some(Vec::new()));
    }

    #[test]
    fn nothing_along_a_segment_is_missed() {
        let points = edges(3000, 0.0);
        let boxes: Vec<Bounds> = points.iter().map(|e| e.1).collect();
        let tree = BoxTree::new(&boxes);
        let mut near = 0;
        for (segment, _) in edges(100, 1.0) {
            let [a, b] = segment;
            let distance = |p: DVec3| {
                let t = (p - a).dot(b - a) / (b - a).length_squared();
                p.distance(a + t.clamp(0.0, 1.0) * (b - a))
            };
            let mut found = vec![false; boxes.len()];
            tree.for_each_along(segment, 0.05, |i| found[i as usize] = true);
            let visited = found.iter().filter(|f| **f).count();
            assert!(visited < boxes.len() / 10, "{visited}");
            for (found, (point, _)) in found.iter().zip(&points) {
                let is_near = distance(point[0]) <= 0.05;
                assert!(*found || !is_near);
                near += usize::from(is_near);
            }
        }
        assert!(near > 100);
    }
}
