//! Axis-aligned boxes in double precision, and a tree over them.

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

    /// The box with a margin on all sides.
    pub fn widened(&self, margin: f64) -> Self {
        Self {
            low: self.low - margin,
            high: self.high + margin,
        }
    }

    /// The distance of two boxes; 0 where they meet.
    pub fn gap(&self, other: &Self) -> f64 {
        let apart = (self.low - other.high).max(other.low - self.high);
        apart.max(DVec3::ZERO).length()
    }

    /// Whether two closed boxes have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    /// Whether the other box lies in this one.
    pub fn contains(&self, other: &Self) -> bool {
        self.low.cmple(other.low).all() && other.high.cmple(self.high).all()
    }

    /// The smallest box round both.
    #[must_use]
    pub fn join(self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }
}

/// A binary tree of boxes: node `i` covers `order[start..end]`; the children of an inner node follow it.
pub struct BoxTree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

struct Node {
    bounds: Bounds,
    start: u32,
    end: u32,
    /// Index of the second child; the first follows its parent. 0 for a leaf.
    second: u32,
}

const LEAF: usize = 4;

impl BoxTree {
    /// The tree over boxes, which are named by their index.
    pub fn new(boxes: &[Bounds]) -> Self {
        let mut tree = Self {
            nodes: Vec::with_capacity(boxes.len()),
            order: (0..boxes.len() as u32).collect(),
        };
        if !boxes.is_empty() {
            tree.build(boxes, 0, boxes.len());
        }
        tree
    }

    fn build(&mut self, boxes: &[Bounds], start: usize, end: usize) {
        let part = &mut self.order[start..end];
        let middle = |i: u32| boxes[i as usize].low + boxes[i as usize].high;
        let first = boxes[part[0] as usize];
        let bounds = part.iter().fold(first, |b, &i| b.join(&boxes[i as usize]));
        let node = self.nodes.len();
        self.nodes.push(Node {
            bounds,
            start: start as u32,
            end: end as u32,
            second: 0,
        });
        if end - start <= LEAF {
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
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |&a, &b| {
            middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b))
        });
        self.build(boxes, start, start + half);
        self.nodes[node].second = self.nodes.len() as u32;
        self.build(boxes, start + half, end);
    }

    /// The first item, in the order of the tree, whose box meets `query` and for which `accept` holds.
    pub fn find(
        &self,
        boxes: &[Bounds],
        query: &Bounds,
        mut accept: impl FnMut(u32) -> bool,
    ) -> Option<u32> {
        let mut stack = Vec::with_capacity(64);
        if !self.nodes.is_empty() {
            stack.push(0);
        }
        while let Some(i) = stack.pop() {
            let node = &self.nodes[i];
            if !node.bounds.meets(query) {
                continue;
            }
            if node.second == 0 {
                let items = &self.order[node.start as usize..node.end as usize];
                if let Some(&j) = items
                    .iter()
                    .find(|&&j| boxes[j as usize].meets(query) && accept(j))
                {
                    return Some(j);
                }
            } else {
                stack.push(node.second as usize);
                stack.push(i + 1);
            }
        }
        None
    }

    /// Calls `visit` with every item whose box meets `query`.
    pub fn for_each(&self, boxes: &[Bounds], query: &Bounds, mut visit: impl FnMut(u32)) {
        self.find(boxes, query, |item| {
            visit(item);
            false
        });
    }
}
