//! Redistancing on a square grid: signed distances to the zero line of the bicubic spline through φ.

use super::grid::SquareGrid;
use super::spline::Spline;

/// Upper bound of the number of Newton steps to a closest point.
const NEWTON_STEPS: usize = 12;
/// Upper bound of the length of a Newton step, in cells.
const LONGEST_STEP: f64 = 0.5;

/// The largest number K of steps between redistancings that the rule `(2Kτ)^¼ < 0.45 r` allows, at least 1; r is the smallest
/// radius of the zero line.
///
/// In K steps a point grows to a circle of radius `(2Kτ)^¼` under the flow, so inner level lines spread to this radius. See
/// [`keeps_rule`].
#[doc(hidden)]
pub fn redistance_interval(tau: f64, smallest_radius: f64) -> usize {
    let steps = (SPREAD * smallest_radius).powi(4) / (2.0 * tau);
    (steps.ceil() as usize).saturating_sub(1).max(1)
}

/// Whether redistancing every `interval` steps satisfies `(2Kτ)^¼ < 0.45 r`, with r the smallest radius of the zero line.
#[doc(hidden)]
pub fn keeps_rule(interval: usize, tau: f64, smallest_radius: f64) -> bool {
    (2.0 * interval as f64 * tau).powf(0.25) < SPREAD * smallest_radius
}

/// Bound of the spread of inner level lines between redistancings, as a fraction of the smallest radius of the zero line.
const SPREAD: f64 = 0.45;

/// Points of the zero line: intersections with grid edges by linear interpolation, then moved to the spline's zero line by Newton's
/// method.
#[doc(hidden)]
pub fn zero_points(grid: &SquareGrid, field: &[f64], spline: &Spline) -> Vec<[f64; 2]> {
    let n = grid.cells();
    let mut points = Vec::new();
    let mut edge = |a: (usize, usize), b: (usize, usize)| {
        let (u, v) = (field[grid.index(a.0, a.1)], field[grid.index(b.0, b.1)]);
        if (u < 0.0) == (v < 0.0) {
            return;
        }
        let t = u / (u - v);
        let (p, q) = (grid.position(a.0, a.1), grid.position(b.0, b.1));
        let mut x = [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])];
        for _ in 0..4 {
            let jet = spline.jet(x);
            let [gx, gy] = jet.gradient;
            let s = jet.value / (gx * gx + gy * gy).max(f64::MIN_POSITIVE);
            x = [x[0] - s * gx, x[1] - s * gy];
        }
        points.push(x);
    };
    for j in 0..=n {
        for i in 0..=n {
            if i < n {
                edge((i, j), (i + 1, j));
            }
            if j < n {
                edge((i, j), (i, j + 1));
            }
        }
    }
    points
}

/// The signed distance to the zero line of φ at every node, with the signs of φ. None if φ has no zero line.
#[doc(hidden)]
pub fn redistance(grid: &SquareGrid, field: &[f64]) -> Option<Vec<f64>> {
    redistance_at(grid, field, grid.nodes())
}

/// As [`redistance`], but only at the given nodes; zero at the others.
pub fn redistance_at(
    grid: &SquareGrid,
    field: &[f64],
    nodes: impl IntoIterator<Item = (usize, usize)>,
) -> Option<Vec<f64>> {
    let spline = Spline::new(grid, field);
    let points = zero_points(grid, field, &spline);
    if points.is_empty() {
        return None;
    }
    let mut out = vec![0.0; field.len()];
    for (i, j) in nodes {
        let (at, x) = (grid.index(i, j), grid.position(i, j));
        let squared = |p: &[f64; 2]| (p[0] - x[0]).powi(2) + (p[1] - x[1]).powi(2);
        let nearest = points
            .iter()
            .min_by(|p, q| squared(p).total_cmp(&squared(q)))?;
        let known = squared(nearest).sqrt();
        let distance = closest(&spline, x, *nearest, grid.h())
            .map(|p| squared(&p).sqrt())
            .filter(|d| *d <= known * (1.0 + 1e-4) + 1e-12)
            .unwrap_or(known);
        out[at] = distance.copysign(if field[at] < 0.0 { -1.0 } else { 1.0 });
    }
    Some(out)
}

/// The closest point to `x` on the spline's zero line: Newton's method for `φ(c) = 0`, `(x − c) × ∇φ(c) = 0`, started at `from`. None
/// if it does not converge.
fn closest(spline: &Spline, x: [f64; 2], from: [f64; 2], h: f64) -> Option<[f64; 2]> {
    let mut c = from;
    for _ in 0..NEWTON_STEPS {
        let jet = spline.jet(c);
        let ([gx, gy], [xx, xy, yy]) = (jet.gradient, jet.second);
        let w = [x[0] - c[0], x[1] - c[1]];
        let cross = w[0] * gy - w[1] * gx;
        // Derivatives of the cross product along x and y. Where the Newton system is nearly singular, take a gradient step to the zero
        // line instead.
        let (kx, ky) = (w[0] * xy - w[1] * xx - gy, w[0] * yy - w[1] * xy + gx);
        let determinant = gx * ky - gy * kx;
        let square = gx * gx + gy * gy;
        let step = if determinant.abs() > 0.05 * square {
            [
                (-jet.value * ky + cross * gy) / determinant,
                (-cross * gx + jet.value * kx) / determinant,
            ]
        } else {
            let s = jet.value / square.max(f64::MIN_POSITIVE);
            [-s * gx, -s * gy]
        };
        let length = step[0].hypot(step[1]);
        let part = (LONGEST_STEP * h / length.max(f64::MIN_POSITIVE)).min(1.0);
        c = [c[0] + part * step[0], c[1] + part * step[1]];
        if length < 1e-12 * h {
            return Some(c);
        }
    }
    (spline.jet(c).value.abs() < 1e-9 * h).then_some(c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_of_a_circle_comes_back_from_its_square() {
        let grid = SquareGrid::centred(64);
        let r: f64 = 0.2;
        let warped = grid.field(|[x, y]| (x * x + y * y - r * r) * (2.0 + x - y));
        let distance = redistance(&grid, &warped).expect("a zero line");
        for (i, j) in grid.nodes() {
            let [x, y] = grid.position(i, j);
            let exact = x.hypot(y) - r;
            // The centre has no closest point.
            if x.hypot(y) > 0.02 {
                let error = distance[grid.index(i, j)] - exact;
                assert!(error.abs() < 2e-4 * grid.h(), "{x} {y}: {error:e}");
            }
        }
    }

    #[test]
    fn a_field_of_one_sign_has_no_distance() {
        let grid = SquareGrid::centred(8);
        assert!(redistance(&grid, &grid.field(|_| 1.0)).is_none());
    }

    #[test]
    fn the_rule_gives_the_longest_interval_that_keeps_it() {
        let h: f64 = 1.0 / 64.0;
        let tau = 10.0 * h.powi(4);
        let k = redistance_interval(tau, 0.13);
        assert!(
            keeps_rule(k, tau, 0.13) && !keeps_rule(k + 1, tau, 0.13),
            "{k}"
        );
        assert!(!keeps_rule(50, tau, 0.13));
    }
}
