//! A bounding volume hierarchy over the triangles of a mesh.

use std::time::Duration;

use glam::DVec3;
use obvhs::{BvhBuildParams, aabb::Aabb, bvh2::builder::build_bvh2};

use super::triangle::{Barycentric, closest_on_triangle};
use crate::mesh::{Mesh, bounds};

/// One node: a leaf where `count` is not zero, else an inner node whose children are `first` and `first + 1`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub min: [f32; 3],
    pub max: [f32; 3],
    pub first: u32,
    pub count: u32,
}

/// The closest point of a mesh to a query point.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// The face it lies on.
    pub face: u32,
    /// Its barycentric coordinates in that face; exact zeros on edges and at corners.
    pub barycentric: Barycentric,
    /// The point.
    pub point: DVec3,
    /// Its distance from the query point.
    pub distance: f64,
}

/// A bounding volume hierarchy for closest-point queries in double precision.
///
/// The boxes are single precision and widened outward; the triangles are kept in double precision relative to the
/// mesh's centre, so that coordinates far from the origin lose nothing.
pub struct Bvh {
    pub(super) nodes: Vec<Node>,
    /// Face of each primitive, in leaf order.
    pub(super) faces: Vec<u32>,
    /// Corners of each primitive relative to `centre`, in leaf order.
    pub(super) corners: Vec<[DVec3; 3]>,
    /// The point all coordinates are relative to.
    pub(super) centre: DVec3,
}

fn round_down(x: f64) -> f32 {
    let y = x as f32;
    if f64::from(y) > x { y.next_down() } else { y }
}

fn round_up(x: f64) -> f32 {
    let y = x as f32;
    if f64::from(y) < x { y.next_up() } else { y }
}

fn enclosing(corners: &[DVec3; 3]) -> Aabb {
    let low = corners[0].min(corners[1]).min(corners[2]);
    let high = corners[0].max(corners[1]).max(corners[2]);
    Aabb::new(
        [round_down(low.x), round_down(low.y), round_down(low.z)].into(),
        [round_up(high.x), round_up(high.y), round_up(high.z)].into(),
    )
}

impl Bvh {
    /// Builds the hierarchy over the given faces of a mesh.
    ///
    /// # Panics
    /// When a face's index is past the end of the positions.
    pub fn new(mesh: &Mesh, faces: impl Iterator<Item = u32>) -> Self {
        let faces: Vec<u32> = faces.collect();
        let (low, high) = bounds(faces.iter().flat_map(|&f| mesh.corners(f)));
        let centre = if faces.is_empty() {
            DVec3::ZERO
        } else {
            0.5 * (low + high)
        };
        let corners: Vec<[DVec3; 3]> = faces
            .iter()
            .map(|&f| mesh.faces[f as usize].map(|v| mesh.positions[v as usize] - centre))
            .collect();
        Self::from_corners(faces, corners, centre)
    }

    fn from_corners(faces: Vec<u32>, corners: Vec<[DVec3; 3]>, centre: DVec3) -> Self {
        if faces.is_empty() {
            return Self {
                nodes: Vec::new(),
                faces,
                corners,
                centre,
            };
        }
        let boxes: Vec<Aabb> = corners.iter().map(enclosing).collect();
        let built = build_bvh2(
            &boxes,
            BvhBuildParams::fast_build(),
            &mut Duration::default(),
        );
        drop(boxes);
        let nodes = built
            .nodes
            .iter()
            .map(|n| Node {
                min: n.aabb.min.to_array(),
                max: n.aabb.max.to_array(),
                first: n.first_index,
                count: n.prim_count,
            })
            .collect();
        let order = &built.primitive_indices;
        Self {
            nodes,
            faces: order.iter().map(|&i| faces[i as usize]).collect(),
            corners: order.iter().map(|&i| corners[i as usize]).collect(),
            centre,
        }
    }

    /// True where the hierarchy has no face.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// The closest point to `p` on the mesh, or none when it is farther than `limit`.
    pub fn closest(&self, p: DVec3, limit: f64) -> Option<Closest> {
        if self.nodes.is_empty() {
            return None;
        }
        let q = p - self.centre;
        let mut best = limit * limit;
        let mut found: Option<(u32, Barycentric, DVec3)> = None;
        let mut stack = Stack::new();
        stack.push(self.nodes[0].distance_squared(q), 0);
        while let Some((lower, index)) = stack.pop() {
            if lower > best {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for i in node.first..node.first + node.count {
                    let [a, b, c] = self.corners[i as usize];
                    let (x, w) = closest_on_triangle(q, a, b, c);
                    let d = (q - x).length_squared();
                    if d < best || (d == best && found.is_none()) {
                        best = d;
                        found = Some((self.faces[i as usize], w, x));
                    }
                }
                continue;
            }
            let children = &self.nodes[node.first as usize..node.first as usize + 2];
            let mut near = (children[0].distance_squared(q), node.first);
            let mut far = (children[1].distance_squared(q), node.first + 1);
            if near.0 > far.0 {
                std::mem::swap(&mut near, &mut far);
            }
            for (lower, child) in [far, near] {
                if lower <= best {
                    stack.push(lower, child);
                }
            }
        }
        found.map(|(face, barycentric, x)| Closest {
            face,
            barycentric,
            point: x + self.centre,
            distance: best.sqrt(),
        })
    }

    /// Calls `visit` with every face whose bounding box meets the box from `low` to `high`.
    pub fn for_each_in_box(&self, low: DVec3, high: DVec3, mut visit: impl FnMut(u32)) {
        if self.nodes.is_empty() {
            return;
        }
        let (low, high) = (low - self.centre, high - self.centre);
        let mut stack = vec![0u32];
        while let Some(index) = stack.pop() {
            let node = self.nodes[index as usize];
            let apart =
                (0..3).any(|k| f64::from(node.min[k]) > high[k] || f64::from(node.max[k]) < low[k]);
            if apart {
                continue;
            }
            if node.count == 0 {
                stack.push(node.first + 1);
                stack.push(node.first);
                continue;
            }
            for i in node.first..node.first + node.count {
                let c = &self.corners[i as usize];
                let (a, b) = (c[0].min(c[1]).min(c[2]), c[0].max(c[1]).max(c[2]));
                if a.cmple(high).all() && b.cmpge(low).all() {
                    visit(self.faces[i as usize]);
                }
            }
        }
    }
}

impl Node {
    #[inline]
    fn distance_squared(&self, p: DVec3) -> f64 {
        let along = |k: usize| {
            let below = f64::from(self.min[k]) - p[k];
            let above = p[k] - f64::from(self.max[k]);
            // Without the care for NaN that `f64::max` takes.
            let d = if below > above { below } else { above };
            if d > 0.0 { d * d } else { 0.0 }
        };
        along(0) + along(1) + along(2)
    }
}

/// How many nodes wait without an allocation.
const WAITING: usize = 48;

/// The nodes that a query has still to look at, with the squared distances of their boxes.
struct Stack {
    few: [(f64, u32); WAITING],
    len: usize,
    /// Those beyond the first few.
    more: Vec<(f64, u32)>,
}

impl Stack {
    #[inline]
    fn new() -> Self {
        Self {
            few: [(0.0, 0); WAITING],
            len: 0,
            more: Vec::new(),
        }
    }

    #[inline]
    fn push(&mut self, lower: f64, node: u32) {
        match self.few.get_mut(self.len) {
            Some(slot) => {
                *slot = (lower, node);
                self.len += 1;
            }
            None => self.more.push((lower, node)),
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<(f64, u32)> {
        if self.len == WAITING
            && let Some(last) = self.more.pop()
        {
            return Some(last);
        }
        self.len = self.len.checked_sub(1)?;
        Some(self.few[self.len])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
