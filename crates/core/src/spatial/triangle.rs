//! Closest point on a triangle.

use glam::DVec3;

/// Barycentric coordinates of a point in a triangle; exact zeros on edges and at corners.
pub type Barycentric = [f64; 3];

/// The point of triangle `abc` closest to `p`, and its barycentric coordinates.
///
/// A coordinate is exactly zero if the closest point lies on the opposite edge, so that callers can distinguish faces, edges and
/// corners (Ericson, "Real-Time Collision Detection", section 5.1.5).
#[inline]
pub fn closest_on_triangle(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> (DVec3, Barycentric) {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, [1.0, 0.0, 0.0]);
    }
    // Region of corner b.
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, [0.0, 1.0, 0.0]);
    }
    // Region of edge ab.
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return (a + ab * t, [1.0 - t, t, 0.0]);
    }
    // Region of corner c.
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, [0.0, 0.0, 1.0]);
    }
    // Regions of the edges ac and bc.
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return (a + ac * t, [1.0 - t, 0.0, t]);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && (d4 - d3) >= 0.0 && (d5 - d6) >= 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (b + (c - b) * t, [0.0, 1.0 - t, t]);
    }
    // The interior.
    let denominator = 1.0 / (va + vb + vc);
    let (v, w) = (vb * denominator, vc * denominator);
    (a + ab * v + ac * w, [1.0 - v - w, v, w])
}

/// Where a ray meets a triangle, in lengths of its direction; none if it misses it (Möller and Trumbore 1997).
pub(crate) fn meets(from: DVec3, along: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (u, v) = (b - a, c - a);
    let p = along.cross(v);
    let determinant = u.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = from - a;
    let q = s.cross(u);
    let (x, y) = (s.dot(p) / determinant, along.dot(q) / determinant);
    let t = v.dot(q) / determinant;
    (x >= 0.0 && y >= 0.0 && x + y <= 1.0 && t > 0.0).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closest_point_beats_a_dense_sampling_of_the_triangle() {
        let (a, b, c) = (
            DVec3::new(0.1, -0.2, 0.3),
            DVec3::new(1.3, 0.2, -0.1),
            DVec3::new(0.4, 1.1, 0.6),
        );
        let mut state = 7u64;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 * 4.0 - 2.0
        };
        for _ in 0..300 {
            let p = DVec3::new(random(), random(), random());
            let (q, w) = closest_on_triangle(p, a, b, c);
            assert!((a * w[0] + b * w[1] + c * w[2] - q).length() < 1e-12);
            for i in 0..=40 {
                for j in 0..=(40 - i) {
                    let (u, v) = (i as f64 / 40.0, j as f64 / 40.0);
                    let s = a * (1.0 - u - v) + b * u + c * v;
                    assert!((p - q).length() <= (p - s).length() + 1e-12);
                }
            }
        }
    }
}
