//! Ray casting: the first triangle of a bounding volume hierarchy that a ray meets.

use glam::DVec3;

use super::bvh::{Bvh, Child, Node};
use super::triangle::meets;

impl Bvh {
    /// The first face that a ray from `from` in the direction `along` meets, among those that `counts` accepts, and its distance
    /// in lengths of `along`. Ties are resolved to the face of the lowest number.
    ///
    /// Uses the ray-triangle test of Möller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
    pub(crate) fn first_along(
        &self,
        from: DVec3,
        along: DVec3,
        counts: impl Fn(u32) -> bool,
    ) -> Option<(u32, f64)> {
        if let Some((others, slivers)) = self.split.as_deref() {
            let found = others.first_among_all(from, along, &counts);
            return slivers.first_along(from - self.centre, along, counts, found);
        }
        self.first_among_all(from, along, &counts)
    }

    /// The same, by the hierarchy over all faces.
    fn first_among_all(
        &self,
        from: DVec3,
        along: DVec3,
        counts: &impl Fn(u32) -> bool,
    ) -> Option<(u32, f64)> {
        let (from, inverse) = (from - self.centre, along.recip());
        let mut best: Option<(u32, f64)> = None;
        let mut stack: Vec<(f64, u32)> = Vec::new();
        if !self.nodes.is_empty() {
            stack.push((0.0, 0));
        }
        while let Some((near, index)) = stack.pop() {
            if best.is_some_and(|(_, t)| near > t) {
                continue;
            }
            let first = stack.len();
            let node = &self.nodes[index as usize];
            for (i, child) in node.children().enumerate() {
                let Some(near) = entered(node, i, from, inverse) else {
                    continue;
                };
                if best.is_some_and(|(_, t)| near > t) {
                    continue;
                }
                match child {
                    Child::Node(child) => stack.push((near, child)),
                    Child::Leaf(leaf) => {
                        for place in self.places(leaf) {
                            let face = self.faces[place];
                            let t = meets(from, along, self.corners(place));
                            let is_first =
                                |t: &f64| best.is_none_or(|(at, least)| (*t, face) < (least, at));
                            if let Some(t) = t.filter(is_first)
                                && counts(face)
                            {
                                best = Some((face, t));
                            }
                        }
                    }
                }
            }
            // Sort the new children so that the nearest is popped first.
            stack[first..].sort_by(|a, b| b.0.total_cmp(&a.0));
        }
        best
    }
}

/// Where a ray enters the box of a child, in lengths of its direction; none if it misses the box. `inverse` is the component-wise
/// reciprocal of the direction.
fn entered(node: &Node, child: usize, from: DVec3, inverse: DVec3) -> Option<f64> {
    let (low, high) = node.child_box(child);
    let (a, b) = ((low - from) * inverse, (high - from) * inverse);
    // A ray in the plane of a side gives 0 times infinity, a NaN, which `f64::min` and `f64::max` ignore.
    let (mut near, mut far) = (0.0f64, f64::INFINITY);
    for k in 0..3 {
        near = near.max(a[k].min(b[k]));
        far = far.min(a[k].max(b[k]));
    }
    // The tolerance admits boxes without thickness despite rounding.
    (near <= far * (1.0 + 4.0 * f64::EPSILON)).then_some(near)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::icosphere;

    #[test]
    fn the_first_face_is_that_of_brute_force() {
        let mut mesh = icosphere(3);
        mesh.positions.iter_mut().for_each(|p| *p += 100.0);
        let bvh = Bvh::new(&mesh, 0..mesh.faces.len() as u32);
        for i in 0..300 {
            let t = f64::from(i);
            let from =
                DVec3::splat(100.0) + 1.5 * DVec3::new(t.sin(), (2.0 * t).cos(), (0.7 * t).sin());
            let along = match i % 4 {
                0 => DVec3::Z,
                _ => DVec3::new((1.3 * t).cos(), (0.4 * t).sin(), (2.9 * t).sin()),
            };
            let counts = |f: u32| !f.is_multiple_of(3);
            let all = (0..mesh.faces.len() as u32).filter(|f| counts(*f));
            let all = all.filter_map(|f| Some((meets(from, along, mesh.corners(f))?, f)));
            let brute = all.min_by(|a, b| a.partial_cmp(b).unwrap());
            let found = bvh.first_along(from, along, counts);
            match (brute, found) {
                (None, None) => {}
                (Some((t, _)), Some((_, u))) => assert!((t - u).abs() < 1e-9),
                both => panic!("{both:?}"),
            }
        }
    }
}
