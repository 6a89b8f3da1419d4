//! Search structures for ear clipping: the next candidate, and the corners in an ear, without visiting every corner.

use glam::DVec2;

/// A set of numbers below a limit with fast search for the next member: a bit for each number, and on each further level a bit
/// for each nonzero word.
#[derive(Default)]
pub(super) struct Marks {
    /// The members; then, for each level, the nonzero words of the level before.
    levels: Vec<Vec<u64>>,
}

impl Marks {
    /// Makes it the set of all numbers below `count`.
    pub(super) fn fill(&mut self, count: usize) {
        self.levels.clear();
        let mut count = count;
        loop {
            let mut words = vec![u64::MAX; count / 64];
            if !count.is_multiple_of(64) {
                words.push((1 << (count % 64)) - 1);
            }
            count = words.len();
            self.levels.push(words);
            if count <= 1 {
                return;
            }
        }
    }

    pub(super) fn set(&mut self, mut at: usize) {
        for level in &mut self.levels {
            level[at / 64] |= 1 << (at % 64);
            at /= 64;
        }
    }

    pub(super) fn clear(&mut self, mut at: usize) {
        for level in &mut self.levels {
            level[at / 64] &= !(1 << (at % 64));
            if level[at / 64] != 0 {
                return;
            }
            at /= 64;
        }
    }

    /// The first member at or above `at`.
    pub(super) fn from(&self, at: usize) -> Option<usize> {
        let mut at = at;
        for (height, level) in self.levels.iter().enumerate() {
            let word = level.get(at / 64)? & (u64::MAX << (at % 64));
            if word != 0 {
                at = at / 64 * 64 + word.trailing_zeros() as usize;
                for below in self.levels[..height].iter().rev() {
                    at = at * 64 + below[at].trailing_zeros() as usize;
                }
                return Some(at);
            }
            at = at / 64 + 1;
        }
        None
    }
}

/// A k-d tree of the corners of a polygon.
#[derive(Default)]
pub(super) struct Tree {
    /// The corners, ordered so that each node has a contiguous run.
    order: Vec<u32>,
    /// The children of node `i` are `2 i + 1` and `2 i + 2`.
    nodes: Vec<Node>,
    /// The leaf of each corner.
    leaf: Vec<u32>,
    stack: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Node {
    low: DVec2,
    high: DVec2,
    /// Start of its run of corners.
    start: u32,
    /// End of the run.
    end: u32,
    /// Number of reflex corners in the run.
    reflex: u32,
}

/// Maximum number of corners of a leaf. 8 and 32 are at most a tenth faster.
const LEAF: usize = 16;

impl Tree {
    pub(super) fn build(&mut self, points: &[DVec2], reflex: &[bool]) {
        self.order.clear();
        self.order.extend(0..points.len() as u32);
        self.leaf.clear();
        self.leaf.resize(points.len(), 0);
        self.nodes.clear();
        let mut stack = vec![(0usize, 0usize, points.len())];
        let point = |i: &u32| points[*i as usize];
        while let Some((at, start, end)) = stack.pop() {
            let run = &mut self.order[start..end];
            let (low, high) = run
                .iter()
                .map(point)
                .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
                    (low.min(p), high.max(p))
                });
            let node = Node {
                low,
                high,
                start: start as u32,
                end: end as u32,
                reflex: run.iter().filter(|i| reflex[**i as usize]).count() as u32,
            };
            self.nodes.resize(self.nodes.len().max(at + 1), node);
            self.nodes[at] = node;
            if run.len() <= LEAF {
                for i in run {
                    self.leaf[*i as usize] = at as u32;
                }
                continue;
            }
            let middle = run.len() / 2;
            let axis = usize::from((high - low).y > (high - low).x);
            run.select_nth_unstable_by(middle, |a, b| point(a)[axis].total_cmp(&point(b)[axis]));
            stack.push((2 * at + 1, start, start + middle));
            stack.push((2 * at + 2, start + middle, end));
        }
    }

    /// Updates the counts when a corner becomes reflex (`by` = 1) or stops being reflex (−1).
    pub(super) fn count(&mut self, corner: usize, by: i32) {
        let mut at = self.leaf[corner] as usize;
        loop {
            let reflex = &mut self.nodes[at].reflex;
            *reflex = reflex.wrapping_add_signed(by);
            if at == 0 {
                return;
            }
            at = (at - 1) / 2;
        }
    }

    /// A reflex corner in the triangle of a corner and its neighbours, ignoring corners at the same position as one of the three.
    /// `small` exceeds the rounding error of an area.
    pub(super) fn inside(
        &mut self,
        points: &[DVec2],
        reflex: &[bool],
        ear: [usize; 3],
        small: f64,
        work: &mut u64,
    ) -> Option<usize> {
        let [a, b, c] = ear.map(|i| points[i]);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        // Through rounding, the test of a corner may accept points outside by up to half the size of a thin ear.
        let margin = high - low;
        let (low, high) = (low - margin, high + margin);
        let sides = [(a, b), (b, c), (c, a)];
        self.stack.clear();
        self.stack.push(0);
        while let Some(at) = self.stack.pop() {
            *work = work.saturating_sub(1);
            let node = &self.nodes[at as usize];
            let apart = node.low.cmpgt(high).any() || node.high.cmplt(low).any();
            let one = node.low == node.high && [a, b, c].contains(&node.low);
            if node.reflex == 0 || apart || one {
                continue;
            }
            let beyond = |(from, to): (DVec2, DVec2)| {
                let side = to - from;
                // The corner of the box that is furthest to the left of the side.
                let x = if side.y > 0.0 {
                    node.low.x
                } else {
                    node.high.x
                };
                let y = if side.x > 0.0 {
                    node.high.y
                } else {
                    node.low.y
                };
                side.perp_dot(DVec2::new(x, y) - from) < -small
            };
            if sides.into_iter().any(beyond) {
                continue;
            }
            let run = &self.order[node.start as usize..node.end as usize];
            if run.len() > LEAF {
                self.stack.extend([2 * at + 1, 2 * at + 2]);
                continue;
            }
            *work = work.saturating_sub(run.len() as u64);
            for &i in run {
                let (i, p) = (i as usize, points[i as usize]);
                if reflex[i] && p != a && p != b && p != c && is_inside(p, a, b, c) {
                    return Some(i);
                }
            }
        }
        None
    }
}

/// Whether `p` is in the counter-clockwise triangle or on its boundary.
fn is_inside(p: DVec2, a: DVec2, b: DVec2, c: DVec2) -> bool {
    (b - a).perp_dot(p - a) >= 0.0
        && (c - b).perp_dot(p - b) >= 0.0
        && (a - c).perp_dot(p - c) >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_member_is_found_at_any_size() {
        for count in [1, 63, 64, 65, 4096, 4097, 300_000] {
            let mut marks = Marks::default();
            marks.fill(count);
            assert_eq!(marks.from(count - 1), Some(count - 1));
            assert_eq!(marks.from(count), None);
            (0..count).for_each(|i| marks.clear(i));
            assert_eq!(marks.from(0), None);
            let members = [count / 7, count / 2, count - 1];
            members.iter().for_each(|m| marks.set(*m));
            for at in (0..count).step_by(count / 50 + 1) {
                let expected = members.iter().copied().filter(|m| *m >= at).min();
                assert_eq!(marks.from(at), expected, "{at} of {count}");
            }
        }
    }
}
