//! Exact tests of whether two triangles, or two faces of a mesh, have points in common.

use glam::{DVec2, DVec3, Vec3Swizzles};
use robust::{Coord, Coord3D, orient2d, orient3d};

/// The positions of the corners of a face.
#[inline]
pub(super) fn at(positions: &[DVec3], [a, b, c]: [u32; 3]) -> [DVec3; 3] {
    [
        positions[a as usize],
        positions[b as usize],
        positions[c as usize],
    ]
}

/// Whether two faces of a mesh intersect; see [`intersecting`].
pub(crate) fn faces_intersect(positions: &[DVec3], f: [u32; 3], g: [u32; 3]) -> bool {
    let is_shared = |v: u32| g[0] == v || g[1] == v || g[2] == v;
    match [is_shared(f[0]), is_shared(f[1]), is_shared(f[2])] {
        [false, false, false] => triangles_intersect(at(positions, f), at(positions, g)),
        [true, false, false] => corner_sharers_intersect(positions, f, g),
        [false, true, false] => corner_sharers_intersect(positions, [f[1], f[2], f[0]], g),
        [false, false, true] => corner_sharers_intersect(positions, [f[2], f[0], f[1]], g),
        [true, true, false] => neighbours_intersect(positions, f, g),
        [true, false, true] => neighbours_intersect(positions, [f[0], f[2], f[1]], g),
        [false, true, true] => neighbours_intersect(positions, [f[1], f[2], f[0]], g),
        [true, true, true] => true,
    }
}

/// Whether two faces that share only the vertex `f[0]` have another point in common.
fn corner_sharers_intersect(positions: &[DVec3], f: [u32; 3], g: [u32; 3]) -> bool {
    let g = if g[0] == f[0] {
        g
    } else if g[1] == f[0] {
        [g[1], g[2], g[0]]
    } else {
        [g[2], g[0], g[1]]
    };
    let (p, q) = (at(positions, f), at(positions, g));
    // If both other corners of a triangle are strictly on one side of the other's plane, the vertex is the only common point.
    let beside = |t: &[DVec3; 3], u: &[DVec3; 3]| {
        let first = side(u[0], u[1], u[2], t[1]);
        first != 0.0 && {
            let second = side(u[0], u[1], u[2], t[2]);
            (first > 0.0 && second > 0.0) || (first < 0.0 && second < 0.0)
        }
    };
    let is_flat = || quick_side(q[0], q[1], q[2], p[1]).is_none();
    if (is_flat() && apart_at_corner(p, q)) || beside(&p, &q) || beside(&q, &p) {
        return false;
    }
    segment_meets_triangle(p[1], p[2], q) || segment_meets_triangle(q[1], q[2], p)
}

/// Whether the projections of two triangles with a common first corner lie on different sides of a line through that corner.
/// Exact tests in a plane are many times cheaper than those in space, which nearly coplanar triangles need.
fn apart_at_corner(p: [DVec3; 3], q: [DVec3; 3]) -> bool {
    let flat = Flat::new(p);
    let (p, q) = (p.map(|v| flat.project(v)), q.map(|v| flat.project(v)));
    let splits = |a: DVec2, own: DVec2, [b, c]: [DVec2; 2]| {
        let [own, b, c] = [own, b, c].map(|v| turn(p[0], a, v));
        (own > 0.0 && b < 0.0 && c < 0.0) || (own < 0.0 && b > 0.0 && c > 0.0)
    };
    splits(p[1], p[2], [q[1], q[2]])
        || splits(p[2], p[1], [q[1], q[2]])
        || splits(q[1], q[2], [p[1], p[2]])
        || splits(q[2], q[1], [p[1], p[2]])
}

/// Whether the projections of two triangles lie on different sides of one of their sides.
fn apart_in_plane(p: [DVec3; 3], q: [DVec3; 3]) -> bool {
    let flat = Flat::new(p);
    let (p, q) = (p.map(|v| flat.project(v)), q.map(|v| flat.project(v)));
    let splits = |t: [DVec2; 3], u: [DVec2; 3], k: usize| {
        let of = |v: DVec2| turn(t[k], t[(k + 1) % 3], v);
        let own = of(t[(k + 2) % 3]);
        own != 0.0
            && u.into_iter()
                .all(|v| (own > 0.0 && of(v) < 0.0) || (own < 0.0 && of(v) > 0.0))
    };
    (0..3).any(|k| splits(p, q, k) || splits(q, p, k))
}

/// Whether two faces that share the edge (`f[0]`, `f[1]`) are folded onto each other.
fn neighbours_intersect(positions: &[DVec3], f: [u32; 3], g: [u32; 3]) -> bool {
    let is_other = |v: &u32| *v != f[0] && *v != f[1];
    let own = if is_other(&f[2]) { f[2] } else { f[0] };
    let other = g.into_iter().find(is_other).unwrap_or(f[0]);
    let [a, b, c] = at(positions, [f[0], f[1], own]);
    folded(a, b, c, positions[other as usize])
}

/// Whether the triangles (a, b, c) and (a, b, d) are coplanar and on the same side of (a, b).
fn folded(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> bool {
    if quick_side(a, b, c, d).is_some() {
        return false;
    }
    let flat = Flat::new([a, b, c]);
    let [p, q, r, s] = [a, b, c, d].map(|v| flat.project(v));
    turn(p, q, r) * turn(p, q, s) > 0.0 && side(a, b, c, d) == 0.0
}

/// Whether two triangles without a common vertex have a point in common.
fn triangles_intersect(p: [DVec3; 3], q: [DVec3; 3]) -> bool {
    let apart = |t: &[DVec3; 3], u: &[DVec3; 3]| {
        let own = |k: usize| side(u[0], u[1], u[2], t[k]);
        let first = own(0);
        (first > 0.0 && own(1) > 0.0 && own(2) > 0.0)
            || (first < 0.0 && own(1) < 0.0 && own(2) < 0.0)
    };
    let is_flat = || quick_side(q[0], q[1], q[2], p[0]).is_none();
    if (is_flat() && apart_in_plane(p, q)) || apart(&p, &q) || apart(&q, &p) {
        return false;
    }
    (0..3).any(|k| {
        segment_meets_triangle(p[k], p[(k + 1) % 3], q)
            || segment_meets_triangle(q[k], q[(k + 1) % 3], p)
    })
}

/// Whether a closed segment and a closed triangle have a point in common.
fn segment_meets_triangle(p: DVec3, q: DVec3, t: [DVec3; 3]) -> bool {
    let (above, below) = (side(t[0], t[1], t[2], p), side(t[0], t[1], t[2], q));
    if above * below > 0.0 || (above > 0.0 && below > 0.0) || (above < 0.0 && below < 0.0) {
        return false;
    }
    if above == 0.0 && below == 0.0 {
        return flat_segment_meets_triangle(p, q, t);
    }
    let (first, second) = (side(p, q, t[0], t[1]), side(p, q, t[1], t[2]));
    if (first > 0.0 && second < 0.0) || (first < 0.0 && second > 0.0) {
        return false;
    }
    let third = side(p, q, t[2], t[0]);
    (first >= 0.0 && second >= 0.0 && third >= 0.0)
        || (first <= 0.0 && second <= 0.0 && third <= 0.0)
}

/// The case of five coplanar points or a degenerate triangle.
fn flat_segment_meets_triangle(p: DVec3, q: DVec3, t: [DVec3; 3]) -> bool {
    let flat = Flat::new(t);
    let (a, b) = (flat.project(p), flat.project(q));
    let t = t.map(|v| flat.project(v));
    let s = [0, 1, 2].map(|k: usize| turn(t[k], t[(k + 1) % 3], a));
    let contains = s.iter().all(|&x| x >= 0.0) || s.iter().all(|&x| x <= 0.0);
    (contains && s.iter().any(|&x| x != 0.0))
        || (0..3).any(|k| flat_segments_meet(a, b, t[k], t[(k + 1) % 3]))
}

fn flat_segments_meet(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let (s, t) = (turn(a, b, c), turn(a, b, d));
    let (u, v) = (turn(c, d, a), turn(c, d, b));
    if s == 0.0 && t == 0.0 && u == 0.0 && v == 0.0 {
        let (low, high) = (a.min(b), a.max(b));
        return low.cmple(c.max(d)).all() && high.cmpge(c.min(d)).all();
    }
    let splits = |x: f64, y: f64| !((x > 0.0 && y > 0.0) || (x < 0.0 && y < 0.0));
    splits(s, t) && splits(u, v)
}

/// Projection along the coordinate axis closest to a triangle's normal.
struct Flat(usize);

impl Flat {
    fn new(t: [DVec3; 3]) -> Self {
        let n = (t[1] - t[0]).cross(t[2] - t[0]).abs();
        Self(if n.x >= n.y && n.x >= n.z {
            0
        } else if n.y >= n.z {
            1
        } else {
            2
        })
    }

    fn project(&self, p: DVec3) -> DVec2 {
        DVec2::new(p[(self.0 + 1) % 3], p[(self.0 + 2) % 3])
    }
}

/// The sign of [`side`], as any number of that sign, if rounding cannot change it; none for points that are nearly coplanar.
#[inline]
fn quick_side(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Option<f64> {
    /// Bound of the rounding error, relative to the sum of the products' magnitudes: Shewchuk's (7 + 56 ε) ε, doubled.
    const ERROR: f64 = 16.0 * 0.5 * f64::EPSILON;
    let [p, q, r] = [a - d, b - d, c - d];
    let (first, second) = (q.yzx() * r.zxy(), q.zxy() * r.yzx());
    let bound = ERROR * p.abs().dot(first.abs() + second.abs());
    let volume = p.dot(first - second);
    (volume.abs() > bound).then_some(volume)
}

/// A number of the sign of six times the volume of (a, b, c, d), exactly: positive if `d` is below the plane of (a, b, c) seen from
/// where they turn left.
#[inline]
fn side(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    if let Some(volume) = quick_side(a, b, c, d) {
        return volume;
    }
    // Flat sides across an axis are frequent, and exact arithmetic is slow where the volume is zero.
    if (a.cmpeq(b) & a.cmpeq(c) & a.cmpeq(d)).any() {
        return 0.0;
    }
    let of = |p: DVec3| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    };
    orient3d(of(a), of(b), of(c), of(d))
}

#[inline]
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let of = |p: DVec2| Coord { x: p.x, y: p.y };
    orient2d(of(a), of(b), of(c))
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    fn p(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    #[test]
    fn triangles_that_cross_or_touch_intersect() {
        assert!(triangles_intersect(
            T,
            [p(0.2, 0.2, -1.0), p(0.2, 0.2, 1.0), p(5.0, 5.0, 0.0)]
        ));
        assert!(triangles_intersect(
            T,
            [p(0.5, 0.5, 0.0), p(1.0, 1.0, 0.0), p(1.0, 1.0, 1.0)]
        ));
        assert!(triangles_intersect(
            T,
            [p(0.1, 0.1, 0.0), p(0.2, 0.1, 0.0), p(0.1, 0.2, 0.0)]
        ));
        assert!(!triangles_intersect(
            T,
            [
                p(0.0, 0.0, 1e-300),
                p(1.0, 0.0, 1e-300),
                p(0.0, 1.0, 1e-300)
            ]
        ));
        assert!(!triangles_intersect(
            T,
            [p(1.0, 1.0, 0.0), p(2.0, 1.0, 0.0), p(1.0, 2.0, 0.0)]
        ));
        assert!(!triangles_intersect(
            T,
            [p(0.6, 0.6, -1.0), p(0.6, 0.6, 1.0), p(5.0, 5.0, 0.0)]
        ));
    }

    #[test]
    fn coplanar_faces_intersect_in_any_plane_alike() {
        let mut noise = crate::mesh::shapes::noise(11);
        let mut whole = || (7.0 * noise()).floor();
        let mut counts = [0; 2];
        for k in 0..4000_usize {
            let corners: Vec<DVec2> = (0..6).map(|_| DVec2::new(whole(), whole())).collect();
            // No, one or two common vertices.
            let (f, g) = ([0, 1, 2], [[3, 4, 5], [0, 4, 5], [1, 0, 5]][k % 3]);
            let has_area = |f: [usize; 3]| {
                let [a, b, c] = f.map(|i| corners[i]);
                (b - a).perp_dot(c - a) != 0.0
            };
            if !has_area(f) || !has_area(g) {
                continue;
            }
            let [f, g] = [f, g].map(|f| f.map(|i| i as u32));
            let flat: Vec<DVec3> = corners.iter().map(|q| q.extend(0.0)).collect();
            // The same points in an inclined plane, exactly.
            let lifted = |q: &DVec2| DVec3::new(q.x, q.y, 3.0 * q.x - 2.0 * q.y);
            let lifted: Vec<DVec3> = corners.iter().map(lifted).collect();
            let hit = faces_intersect(&flat, f, g);
            assert_eq!(faces_intersect(&lifted, f, g), hit, "{corners:?}");
            assert_eq!(faces_intersect(&lifted, g, f), hit, "{corners:?}");
            counts[usize::from(hit)] += 1;
        }
        assert!(counts[0] > 500 && counts[1] > 500, "{counts:?}");
    }

    #[test]
    fn faces_with_common_vertices() {
        let positions = [
            T[0],
            T[1],
            T[2],
            p(0.3, 0.3, 0.0),
            p(0.3, 0.3, 1.0),
            p(1.0, 1.0, 0.0),
            p(0.5, -1.0, 0.1),
        ];
        let hit = |f, g| faces_intersect(&positions, f, g);
        assert!(hit([0, 1, 2], [1, 0, 3]), "folded onto the other");
        assert!(!hit([0, 1, 2], [2, 1, 5]), "flat neighbours");
        assert!(!hit([0, 1, 2], [1, 0, 4]), "neighbours at an angle");
        assert!(
            hit([0, 1, 2], [0, 3, 4]),
            "a common corner and a vertex on the face"
        );
        assert!(hit([0, 1, 2], [0, 5, 4]), "an edge along the face");
        assert!(!hit([0, 1, 2], [0, 6, 4]), "a common corner only");
        assert!(hit([0, 1, 2], [2, 1, 0]), "the same face twice");
    }
}
