//! Closest points and rays among long, thin triangles, by oriented boxes.

use glam::DVec3;

use super::oriented::{OrientedTree, ROUNDING, Triangles};
use super::triangle::{Barycentric, closest_on_triangle, meets};
use crate::mesh::{Mesh, bounds};

/// Area of the projections of a triangle's axis-aligned box over the triangle's own area from which it is a sliver. Equilateral
/// triangles have at most 8. A point near n sectors of a disc lies in the boxes of n / 8 of them.
const SLIVER: f64 = 100.0;
/// Triangles. With fewer slivers a hierarchy of their own is not worth its cost.
const MIN_SLIVERS: usize = 500;

/// The slivers among the faces of a mesh, in a tree of oriented boxes.
pub(super) struct Slivers {
    tree: OrientedTree,
    /// The face of each sliver.
    faces: Vec<u32>,
    /// Its corners relative to the centre.
    corners: Vec<[DVec3; 3]>,
}

/// The nearest point of triangles: its squared distance, the face, barycentric coordinates, and the point relative to the centre.
pub(super) type Nearest = (f64, u32, Barycentric, DVec3);

/// Whether a triangle is much smaller than its axis-aligned box.
fn is_sliver([a, b, c]: [DVec3; 3]) -> bool {
    let size = a.max(b).max(c) - a.min(b).min(c);
    let sides = size.x * size.y + size.y * size.z + size.z * size.x;
    let area = 0.5 * (b - a).cross(c - a).length();
    sides.is_finite() && sides > SLIVER * area
}

impl Slivers {
    /// The slivers among some faces of a mesh, and the other faces; none if there are few slivers. Coordinates are relative to
    /// `centre`.
    pub(super) fn among(mesh: &Mesh, faces: &[u32], centre: DVec3) -> Option<(Self, Vec<u32>)> {
        let is_sliver = |f: &u32| is_sliver(mesh.corners(*f));
        if faces.iter().filter(|f| is_sliver(f)).count() < MIN_SLIVERS {
            return None;
        }
        let (thin, rest): (Vec<u32>, Vec<u32>) = faces.iter().partition(|f| is_sliver(f));
        let corners = |f: &u32| mesh.corners(*f).map(|p| p - centre);
        let corners: Vec<[DVec3; 3]> = thin.iter().map(corners).collect();
        let (low, high) = bounds(corners.iter().flatten().copied());
        let tree = OrientedTree::new(&Triangles {
            corners: &corners,
            groups: &[],
            margin: ROUNDING * low.abs().max(high.abs()).max_element(),
        });
        let faces = thin;
        let slivers = Self {
            tree,
            faces,
            corners,
        };
        Some((slivers, rest))
    }

    /// The nearest point to `q`, if it is nearer than `found`, or equally near on a face of a lower number. Without `found` it
    /// must lie within the squared distance `limit`.
    pub(super) fn nearest(&self, q: DVec3, limit: f64, found: Option<Nearest>) -> Option<Nearest> {
        let mut found = found;
        let mut best = found.map_or(limit, |(d, ..)| d);
        let mut stack = vec![(0.0, 0u32)];
        while let Some((lower, i)) = stack.pop() {
            if lower > best {
                continue;
            }
            let node = &self.tree.nodes[i as usize];
            if node.second != 0 {
                let lower = |i: u32| (self.tree.nodes[i as usize].bounds.distance_squared(q), i);
                let [first, second] = [i + 1, node.second].map(lower);
                // The nearer child is popped first.
                match first.0 <= second.0 {
                    true => stack.extend([second, first]),
                    false => stack.extend([first, second]),
                }
                continue;
            }
            for &t in self.tree.triangles(node) {
                let face = self.faces[t as usize];
                let [a, b, c] = self.corners[t as usize];
                let (x, barycentric) = closest_on_triangle(q, a, b, c);
                let d = (q - x).length_squared();
                if d < best || d == best && found.is_none_or(|(_, at, ..)| face < at) {
                    best = d;
                    found = Some((d, face, barycentric, x));
                }
            }
        }
        found
    }

    /// The first face along a ray that `counts` accepts and its distance in lengths of `along`, if it comes before `found`; of
    /// equally far ones the face of the lowest number.
    pub(super) fn first_along(
        &self,
        from: DVec3,
        along: DVec3,
        counts: impl Fn(u32) -> bool,
        found: Option<(u32, f64)>,
    ) -> Option<(u32, f64)> {
        let mut best = found;
        let entered = |i: u32| self.tree.nodes[i as usize].bounds.entered(from, along);
        let mut stack: Vec<(f64, u32)> = entered(0).map(|near| (near, 0)).into_iter().collect();
        while let Some((near, i)) = stack.pop() {
            if best.is_some_and(|(_, t)| near > t) {
                continue;
            }
            let node = &self.tree.nodes[i as usize];
            if node.second != 0 {
                let children = [i + 1, node.second].map(|i| entered(i).map(|near| (near, i)));
                // The nearer child is popped first.
                match children {
                    [Some(a), Some(b)] if a.0 <= b.0 => stack.extend([b, a]),
                    others => stack.extend(others.into_iter().flatten()),
                }
                continue;
            }
            for &t in self.tree.triangles(node) {
                let face = self.faces[t as usize];
                let Some(t) = meets(from, along, self.corners[t as usize]) else {
                    continue;
                };
                if best.is_none_or(|(at, least)| (t, face) < (least, at)) && counts(face) {
                    best = Some((face, t));
                }
            }
        }
        best
    }
}
