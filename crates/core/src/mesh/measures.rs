//! Area vectors and cotangents of triangles, and eigenvalues of 3 × 3 matrices.

use crate::elementary::{acos, cos};
use glam::DVec3;

/// The normal of a triangle; its length is twice the area.
#[inline]
pub fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Half the cotangents of the angles at the corners of a triangle, given twice its area. The weight of an edge is the sum of the two values
/// at the corners opposite to it (U. Pinkall, K. Polthier, "Computing discrete minimal surfaces and their conjugates", 1993).
#[inline]
pub fn half_cotangents(p: [DVec3; 3], twice_area: f64) -> [f64; 3] {
    [[0, 1, 2], [1, 2, 0], [2, 0, 1]]
        .map(|[k, i, j]| 0.5 * (p[i] - p[k]).dot(p[j] - p[k]) / twice_area)
}

/// The smallest eigenvalue of a symmetric 3 × 3 matrix, by the trigonometric solution of the characteristic cubic.
pub fn smallest_eigenvalue(m: &[[f64; 3]; 3]) -> f64 {
    let off = m[0][1].powi(2) + m[0][2].powi(2) + m[1][2].powi(2);
    let q = (m[0][0] + m[1][1] + m[2][2]) / 3.0;
    if off == 0.0 {
        return m[0][0].min(m[1][1]).min(m[2][2]);
    }
    let d = [m[0][0] - q, m[1][1] - q, m[2][2] - q];
    let p = ((d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + 2.0 * off) / 6.0).sqrt();
    let b = |i: usize, j: usize| if i == j { d[i] / p } else { m[i][j] / p };
    let determinant = b(0, 0) * (b(1, 1) * b(2, 2) - b(1, 2) * b(1, 2))
        - b(0, 1) * (b(0, 1) * b(2, 2) - b(1, 2) * b(0, 2))
        + b(0, 2) * (b(0, 1) * b(1, 2) - b(1, 1) * b(0, 2));
    let angle = acos((0.5 * determinant).clamp(-1.0, 1.0)) / 3.0;
    q + 2.0 * p * cos(angle + 2.0 * std::f64::consts::PI / 3.0)
}
