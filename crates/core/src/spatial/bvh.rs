//! Bounding volume hierarchy over the triangles of a mesh: closest-point and box queries in double precision.

use std::ops::Range;

use glam::{DVec3, Vec4};
use obvhs::aabb::Aabb;

use super::slivers::{Nearest, Slivers};
use super::triangle::{Barycentric, closest_on_triangle};

/// Maximum number of children of a node.
pub(super) const WIDTH: usize = 4;

/// A child of a node. Inner nodes come after their parents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Child {
    /// Another node.
    Node(u32),
    /// A leaf.
    Leaf(u32),
}

/// Flag bit of a child index that denotes a leaf.
pub(super) const LEAF: u32 = 1 << 31;

/// The boxes of up to four children, stored component-wise so that they are tested together (SIMD).
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Smallest coordinates, by axis.
    low: [Vec4; 3],
    /// Largest coordinates, by axis.
    high: [Vec4; 3],
    /// Index of a node or, with the flag [`LEAF`], of a leaf; only the first `count` are valid.
    pub(super) children: [u32; WIDTH],
    pub(super) count: u32,
}

/// The closest point of a mesh to a query point.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// The face it lies on.
    pub face: u32,
    /// Its barycentric coordinates in that face; exactly zero on edges and at corners.
    pub barycentric: Barycentric,
    /// The point.
    pub point: DVec3,
    /// Its distance from the query point.
    pub distance: f64,
}

/// Corners of triangles relative to the centre of a hierarchy.
pub(super) enum Corners {
    /// Of each triangle its own: the fastest to read.
    Own(Vec<[DVec3; 3]>),
    /// As indices of vertices, which takes a third of the memory.
    Shared(Vec<[u32; 3]>, Vec<DVec3>),
}

/// A bounding volume hierarchy for closest-point queries in double precision.
///
/// A node has up to four children, as in Wald, Benthin and Boulos, "Getting rid of packets: efficient SIMD single-ray traversal
/// using multi-branching BVHs", 2008. A leaf is one triangle; in hierarchies for few queries it is several, so that there are fewer
/// nodes to make and to store. The boxes are in single precision, rounded outward. The corners are in double precision relative to the
/// mesh's centre, so that coordinates far from the origin lose no accuracy.
pub struct Bvh {
    /// Nodes, parents before their children.
    pub(super) nodes: Vec<Node>,
    /// The mesh face of each triangle, leaf by leaf.
    pub(super) faces: Vec<u32>,
    /// Corners of each triangle, in the same order.
    pub(super) corners: Corners,
    /// Triangles of a leaf; the last leaf may have fewer.
    pub(super) per_leaf: usize,
    /// The origin of the stored coordinates.
    pub(super) centre: DVec3,
    /// If many faces are long and thin: the hierarchy of the others, with the same origin, and these. Closest points and rays are
    /// searched in both, with the same results.
    pub(super) split: Option<Box<(Bvh, Slivers)>>,
}

pub(super) fn round_down(x: f64) -> f32 {
    let y = x as f32;
    if f64::from(y) > x { y.next_down() } else { y }
}

pub(super) fn round_up(x: f64) -> f32 {
    let y = x as f32;
    if f64::from(y) < x { y.next_up() } else { y }
}

impl Bvh {
    /// The places in [`Self::faces`] of a leaf's triangles.
    #[inline]
    pub(super) fn places(&self, leaf: u32) -> Range<usize> {
        let first = leaf as usize * self.per_leaf;
        first..(first + self.per_leaf).min(self.faces.len())
    }

    /// The corners of the triangle at a place, relative to the centre.
    #[inline]
    pub(super) fn corners(&self, place: usize) -> [DVec3; 3] {
        match &self.corners {
            Corners::Own(corners) => corners[place],
            Corners::Shared(corners, points) => corners[place].map(|v| points[v as usize]),
        }
    }

    /// Whether the hierarchy has no faces.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// The closest point to `p` on the mesh, or none if it is farther than `limit`. Ties are resolved to the face of the lowest
    /// number, so that the result does not depend on which other faces the hierarchy holds.
    pub fn closest(&self, p: DVec3, limit: f64) -> Option<Closest> {
        let q = p - self.centre;
        let found = match self.split.as_deref() {
            Some((others, slivers)) => slivers.nearest(q, limit * limit, others.nearest(q, limit)),
            None => self.nearest(q, limit),
        };
        found.map(|(squared, face, barycentric, x)| Closest {
            face,
            barycentric,
            point: x + self.centre,
            distance: squared.sqrt(),
        })
    }

    /// The closest point to a point relative to the centre, by the hierarchy over all faces.
    fn nearest(&self, q: DVec3, limit: f64) -> Option<Nearest> {
        if self.nodes.is_empty() {
            return None;
        }
        // Squared distances, to triangles in double precision and to boxes in single precision. The bound for boxes allows for
        // rounding errors.
        let around = Around::new(q);
        let mut best = limit * limit;
        let mut bound = Around::bound(best);
        let mut found: Option<(usize, Barycentric, DVec3)> = None;
        let mut stack = Stack::new();
        let mut index = 0;
        loop {
            // Push the children whose boxes are within the bound, the nearest on top.
            stack.push_children(&self.nodes[index as usize], &around, bound);
            // Pop entries until one is an inner node; triangles are tested on the way.
            index = loop {
                let Some((lower, child)) = stack.pop() else {
                    return found.map(|(place, w, x)| (best, self.faces[place], w, x));
                };
                if lower > bound {
                    continue;
                }
                if child & LEAF == 0 {
                    break child;
                }
                // A triangle replaces the best one if it is nearer, or equally near with a lower face number.
                for place in self.places(child & !LEAF) {
                    let [a, b, c] = self.corners(place);
                    let (x, w) = closest_on_triangle(q, a, b, c);
                    let d = (q - x).length_squared();
                    let is_first = |at: usize| self.faces[place] < self.faces[at];
                    if d < best || d == best && found.is_none_or(|(at, ..)| is_first(at)) {
                        best = d;
                        bound = Around::bound(best);
                        found = Some((place, w, x));
                    }
                }
            };
        }
    }

    /// Calls `visit` with every face whose bounding box intersects the box from `low` to `high`.
    pub fn for_each_in_box(&self, low: DVec3, high: DVec3, mut visit: impl FnMut(u32)) {
        self.for_each_place(low - self.centre, high - self.centre, |place, _| {
            visit(self.faces[place]);
        });
    }

    /// Calls `visit` with the corners of every triangle whose bounding box a ray along an axis meets, up or down from a point relative to
    /// the centre.
    pub(super) fn for_each_along(
        &self,
        axis: usize,
        q: DVec3,
        is_up: bool,
        mut visit: impl FnMut([DVec3; 3]),
    ) {
        let (mut low, mut high) = (q, q);
        match is_up {
            true => high[axis] = f64::INFINITY,
            false => low[axis] = f64::NEG_INFINITY,
        }
        self.for_each_place(low, high, |_, corners| visit(corners));
    }

    /// Calls `visit` with the place and the corners of every triangle whose bounding box intersects a box relative to the centre.
    #[inline]
    fn for_each_place(&self, low: DVec3, high: DVec3, mut visit: impl FnMut(usize, [DVec3; 3])) {
        let (from, to) = (Around::new(low), Around::new(high));
        let mut stack: Vec<u32> = Vec::with_capacity(WAITING);
        stack.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            let apart = (0..3)
                .map(|k| node.low[k].cmpgt(to.above[k]) | node.high[k].cmplt(from.below[k]))
                .fold(glam::BVec4A::FALSE, |a, b| a | b)
                .bitmask();
            for (i, child) in node.children().enumerate().rev() {
                match child {
                    _ if apart >> i & 1 == 1 => {}
                    Child::Node(child) => stack.push(child),
                    Child::Leaf(leaf) => {
                        for place in self.places(leaf) {
                            let corners = self.corners(place);
                            let [a, b, c] = corners;
                            let (first, last) = (a.min(b).min(c), a.max(b).max(c));
                            if first.cmple(high).all() && last.cmpge(low).all() {
                                visit(place, corners);
                            }
                        }
                    }
                }
            }
        }
    }
}

impl Node {
    pub(super) const EMPTY: Self = Self {
        low: [Vec4::INFINITY; 3],
        high: [Vec4::NEG_INFINITY; 3],
        children: [0; WIDTH],
        count: 0,
    };

    pub(super) fn set_box(&mut self, child: usize, around: &Aabb) {
        for k in 0..3 {
            self.low[k][child] = around.min[k];
            self.high[k][child] = around.max[k];
        }
    }

    /// The box of a child.
    pub(super) fn child_box(&self, child: usize) -> (DVec3, DVec3) {
        let corner =
            |of: &[Vec4; 3]| DVec3::from_array([0, 1, 2].map(|k: usize| f64::from(of[k][child])));
        (corner(&self.low), corner(&self.high))
    }

    /// The children of the node.
    pub fn children(&self) -> impl DoubleEndedIterator<Item = Child> + ExactSizeIterator {
        self.children[..self.count as usize]
            .iter()
            .map(|child| match child & LEAF {
                0 => Child::Node(*child),
                _ => Child::Leaf(child & !LEAF),
            })
    }
}

/// A point enclosed between two single-precision points, replicated for the four children of a node.
struct Around {
    below: [Vec4; 3],
    above: [Vec4; 3],
}

impl Around {
    fn new(p: DVec3) -> Self {
        Self {
            below: p.to_array().map(|x| Vec4::splat(round_down(x))),
            above: p.to_array().map(|x| Vec4::splat(round_up(x))),
        }
    }

    /// Squared distances of the point from the boxes of a node's children; lower bounds except for rounding errors of these few
    /// operations.
    #[inline]
    fn distances_squared(&self, node: &Node) -> Vec4 {
        let along = |k: usize| {
            let below = node.low[k] - self.above[k];
            let above = self.below[k] - node.high[k];
            let d = below.max(above).max(Vec4::ZERO);
            d * d
        };
        along(0) + along(1) + along(2)
    }

    /// Upper bound of [`Self::distances_squared`] for a box that contains a point at this squared distance.
    #[inline]
    fn bound(squared: f64) -> f32 {
        // Allows for six roundings of half a unit in the last place and the rounding of this value, with a margin. Squares below
        // 1e-38 are denormal and rounded more coarsely, hence the absolute term.
        (squared * (1.0 + 8.0 * f64::from(f32::EPSILON)) + 1e-40) as f32
    }
}

/// Number of stack entries that need no allocation.
const WAITING: usize = 64;

/// Stack of children to visit, with the squared distances of their boxes.
///
/// Non-negative floats are ordered like their bit patterns, so distance and child are packed into one integer.
struct Stack {
    few: [u64; WAITING],
    len: usize,
    /// Overflow beyond the fixed-size part.
    more: Vec<u64>,
}

impl Stack {
    #[inline]
    fn new() -> Self {
        Self {
            few: [0; WAITING],
            len: 0,
            more: Vec::new(),
        }
    }

    /// Pushes the children within the bound, the nearest last.
    #[inline]
    fn push_children(&mut self, node: &Node, around: &Around, bound: f32) {
        let lower = around.distances_squared(node).to_array();
        let mut keys = [0u64; WIDTH];
        for k in 0..WIDTH {
            // The root (index 0) is never a child, so a key of 0 marks an empty slot.
            let is_near = (lower[k] <= bound) & (k < node.count as usize);
            let key = u64::from(lower[k].to_bits()) << 32 | u64::from(node.children[k]);
            keys[k] = if is_near { key } else { 0 };
        }
        // Branch-free sorting network, descending.
        for (i, j) in [(0, 1), (2, 3), (0, 2), (1, 3), (1, 2)] {
            (keys[i], keys[j]) = (keys[i].max(keys[j]), keys[i].min(keys[j]));
        }
        let count = keys.iter().map(|key| usize::from(*key != 0)).sum::<usize>();
        match self.few.get_mut(self.len..self.len + WIDTH) {
            Some(room) if self.more.is_empty() => {
                // Copied one by one: a wide load right after narrow stores would stall.
                for (slot, key) in room.iter_mut().zip(keys) {
                    *slot = key;
                }
                self.len += count;
            }
            _ => self.more.extend(&keys[..count]),
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<(f32, u32)> {
        let key = match self.more.pop() {
            Some(key) => key,
            None => {
                self.len = self.len.checked_sub(1)?;
                self.few[self.len]
            }
        };
        Some((f32::from_bits((key >> 32) as u32), key as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::super::middle;
    use super::*;
    use crate::mesh::Mesh;

    fn bumpy_sheet(n: u32, offset: DVec3) -> Mesh {
        let mut mesh = Mesh::default();
        for i in 0..=n {
            for j in 0..=n {
                let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let z = 0.1 * (7.0 * x).sin() * (5.0 * y).cos();
                mesh.positions.push(DVec3::new(x, y, z) + offset);
            }
        }
        for i in 0..n {
            for j in 0..n {
                let a = i * (n + 1) + j;
                let b = a + n + 1;
                mesh.faces.push([a, b, a + 1]);
                mesh.faces.push([a + 1, b, b + 1]);
            }
        }
        mesh
    }

    /// With one triangle in each leaf and with several.
    fn both(mesh: &Mesh) -> [Bvh; 2] {
        let faces = || (0..mesh.faces.len() as u32).collect();
        let centre = middle(mesh, 0..mesh.faces.len() as u32);
        [Bvh::about, Bvh::for_few].map(|build| build(mesh, faces(), centre))
    }

    #[test]
    fn leaves_of_several_triangles_give_the_same_results() {
        for n in [1, 2, 3, 17] {
            let mesh = bumpy_sheet(n, DVec3::ONE);
            let [one, several] = both(&mesh);
            assert!(several.nodes.len() <= one.nodes.len());
            assert!(
                matches!(&several.corners, Corners::Shared(_, p) if p.len() == mesh.positions.len())
            );
            for i in 0..100 {
                let t = f64::from(i);
                let p = DVec3::ONE
                    + DVec3::new((t * 0.37).sin(), (t * 0.73).cos(), 0.5 * (t * 0.11).sin());
                let [a, b] = [&one, &several].map(|bvh| bvh.closest(p, f64::INFINITY).unwrap());
                assert_eq!((a.face, a.distance), (b.face, b.distance));
                let [a, b] = [&one, &several].map(|bvh| {
                    let mut found = Vec::new();
                    bvh.for_each_in_box(p - 0.2, p + 0.2, |f| found.push(f));
                    found.sort_unstable();
                    found
                });
                assert_eq!(a, b);
                let along = DVec3::new(0.1, 0.2, -1.0);
                let [a, b] = [&one, &several].map(|bvh| bvh.first_along(p, along, |f| f % 3 > 0));
                assert_eq!(a, b);
            }
        }
    }

    #[test]
    fn the_closest_point_is_that_of_brute_force_also_far_from_the_origin() {
        for offset in [DVec3::ZERO, DVec3::splat(1e6)] {
            let mesh = bumpy_sheet(17, offset);
            let bvh = Bvh::new(&mesh, 0..mesh.faces.len() as u32);
            for i in 0..200 {
                let t = f64::from(i);
                let p =
                    offset + DVec3::new((t * 0.37).sin(), (t * 0.73).cos(), 0.5 * (t * 0.11).sin());
                let brute = mesh
                    .faces
                    .iter()
                    .map(|f| {
                        let [a, b, c] = f.map(|v| mesh.positions[v as usize] - offset);
                        closest_on_triangle(p - offset, a, b, c)
                            .0
                            .distance(p - offset)
                    })
                    .fold(f64::INFINITY, f64::min);
                let found = bvh.closest(p, f64::INFINITY).unwrap();
                assert!((found.distance - brute).abs() < 1e-9);
                assert!(brute == 0.0 || bvh.closest(p, 0.5 * brute).is_none());
            }
        }
    }
}
