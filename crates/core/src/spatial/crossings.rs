//! The winding number by the faces that one ray passes through, and by the boundary.
//!
//! Martens, Trettner, Bessmeltsev, "The antipodal method: fast, accurate, and robust 3D generalized winding numbers", 2026: a surface
//! together with the cone from its boundary to the point at infinity behind a ray is closed, and the ray never meets that cone. The
//! winding number is the closed surface's, the sum of the faces ahead with the signs of their sides, less the cone's, a sum
//! of solid angles over the boundary edges. The predicates are exact: where the ray passes an edge, only one of its faces is met, and
//! the solid angle of a boundary edge has the same side.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use robust::{Coord, Coord3D, orient2d, orient3d};

use super::angles::Angles;
use super::bvh::Bvh;
use crate::mesh::{Welder, bounds};

/// Boundary edges up to which the sum over them is faster than the sum over clusters.
const MOST_EDGES: usize = 512;

/// What rays need beside the hierarchy: an axis, and the boundary.
pub(super) struct Crossings {
    /// The axis of the rays, along the shortest side of the bounding box.
    axis: usize,
    /// The middle of the bounding box along it. Rays leave the box on the nearer side.
    middle: f64,
    /// The edges along which more faces run one way than the other, by ends relative to the hierarchy's centre.
    boundary: Vec<[DVec3; 2]>,
}

impl Crossings {
    /// None if there are too many boundary edges.
    pub(super) fn new(bvh: &Bvh) -> Option<Self> {
        let count = bvh.faces.len();
        let mut welder = Welder::with_capacity(count / 2 + 1);
        let mut edges: Vec<(u64, bool)> = Vec::with_capacity(3 * count);
        for place in 0..count {
            let mut ids = [0; 3];
            for (id, corner) in ids.iter_mut().zip(bvh.corners(place)) {
                *id = welder.index(corner)?;
            }
            for k in 0..3 {
                let (u, v) = (ids[k], ids[(k + 1) % 3]);
                let key = u64::from(u.min(v)) << 32 | u64::from(u.max(v));
                edges.push((key, u < v));
            }
        }
        edges.sort_unstable();
        let points = &welder.points;
        let mut boundary = Vec::new();
        for same in edges.chunk_by(|a, b| a.0 == b.0) {
            let (low, high) = (same[0].0 >> 32, same[0].0 & u64::from(u32::MAX));
            let upward = same.iter().filter(|(_, up)| *up).count();
            let downward = same.len() - upward;
            let ends = [points[low as usize], points[high as usize]];
            // An edge of a face without area, or one that is balanced.
            if low == high || upward == downward {
                continue;
            }
            let ends = if upward > downward {
                ends
            } else {
                [ends[1], ends[0]]
            };
            boundary.extend(std::iter::repeat_n(ends, upward.abs_diff(downward)));
            if boundary.len() > MOST_EDGES {
                return None;
            }
        }
        let (low, high) = bounds(points.iter().copied());
        let size = high - low;
        let axis = (0..3).fold(0, |best, k| if size[k] < size[best] { k } else { best });
        Some(Self {
            axis,
            middle: 0.5 * (low + high)[axis],
            boundary,
        })
    }

    /// The winding number at a point relative to the hierarchy's centre.
    pub(super) fn winding_number(&self, bvh: &Bvh, q: DVec3) -> f64 {
        let axis = self.axis;
        let is_up = q[axis] > self.middle;
        let mut crossed = 0;
        bvh.for_each_along(axis, q, is_up, |corners| {
            let turns = turns(corners, q, axis);
            if turns != 0 {
                let [a, b, c, q] = [corners[0], corners[1], corners[2], q].map(coord3);
                // Positive for points below a triangle that is counter-clockwise seen from above.
                let ahead = orient3d(a, b, c, q) * f64::from(turns);
                if is_up == (ahead > 0.0) && ahead != 0.0 {
                    crossed += if is_up { turns } else { -turns };
                }
            }
        });
        let mut angles = Angles::new();
        for ends in &self.boundary {
            let (sine, cosine) = behind(*ends, q, axis, is_up);
            angles.add(sine, cosine);
        }
        f64::from(crossed) + angles.sum() / (2.0 * PI)
    }
}

/// Multiples of sine and cosine of half the solid angle between an edge and the point at infinity behind a ray, with a denominator
/// (van Oosterom and Strackee, 1983) that loses no digits where the ray passes close to an end.
fn behind([u, v]: [DVec3; 2], q: DVec3, axis: usize, is_up: bool) -> (f64, f64) {
    let (right, up) = ((axis + 1) % 3, (axis + 2) % 3);
    let flat = |e: DVec3| DVec2::new(e[right], e[up]);
    let (a, b) = (u - q, v - q);
    let [along_a, along_b] = [a, b].map(|e| if is_up { e[axis] } else { -e[axis] });
    // The length of a vector less its part along the ray.
    let rest = |e: DVec3, along: f64| match along > 0.0 {
        true => flat(e).length_squared() / (e.length() + along),
        false => e.length() - along,
    };
    let (mut at_a, mut at_b) = (flat(a), flat(b));
    let mut side = side(u, v, q, axis);
    // An end on the ray is seen from a point beside it, as in `side`.
    let [on_a, on_b] = [(at_a, along_a), (at_b, along_b)].map(|(e, l)| e == DVec2::ZERO && l > 0.0);
    match (on_a, on_b) {
        (true, true) => return (0.0, 1.0),
        (true, false) => {
            at_a = -DVec2::X;
            side = if at_b.y == 0.0 {
                0.0_f64.copysign(at_b.x)
            } else {
                -at_b.y
            };
        }
        (false, true) => {
            at_b = -DVec2::X;
            side = if at_a.y == 0.0 {
                0.0_f64.copysign(-at_a.x)
            } else {
                at_a.y
            };
        }
        (false, false) => {}
    }
    let cosine = rest(a, along_a) * rest(b, along_b) + at_a.dot(at_b);
    (if is_up { -side } else { side }, cosine)
}

/// The winding number of a triangle's outline around a point, seen along an axis from its far end: −1, 0 or 1.
///
/// Exact. An edge belongs to only one of the two triangles beside it, so that no passage through a surface is missed or
/// counted twice (Hormann and Agathos, "The point in polygon problem for arbitrary polygons", 2001).
pub(crate) fn turns(corners: [DVec3; 3], p: DVec3, axis: usize) -> i32 {
    let up = (axis + 2) % 3;
    let mut turns = 0;
    for k in 0..3 {
        let (u, v) = (corners[k], corners[(k + 1) % 3]);
        if u[up] <= p[up] && v[up] > p[up] && side(u, v, p, axis) > 0.0 {
            turns += 1;
        } else if v[up] <= p[up] && u[up] > p[up] && side(u, v, p, axis) < 0.0 {
            turns -= 1;
        }
    }
    turns
}

/// Twice the area of the triangle from an edge to a point, seen along an axis from its far end. Where it is zero, a zero with the sign
/// that [`turns`] goes by: as if the point were a little farther along the next axis and much less along the one after it.
fn side(u: DVec3, v: DVec3, p: DVec3, axis: usize) -> f64 {
    let (right, up) = ((axis + 1) % 3, (axis + 2) % 3);
    let flat = |p: DVec3| Coord {
        x: p[right],
        y: p[up],
    };
    let twice = orient2d(flat(u), flat(v), flat(p));
    let is_left = match u[up] == v[up] {
        true => u[right] < v[right],
        false => u[up] > v[up],
    };
    match twice == 0.0 {
        true if is_left => 0.0,
        true => -0.0,
        false => twice,
    }
}

pub(crate) fn coord3(p: DVec3) -> Coord3D<f64> {
    let [x, y, z] = p.to_array();
    Coord3D { x, y, z }
}
