//! Cutting polygons into triangles without losing a corner.
//!
//! Every corner stays a corner of some triangle, collinear ones too: a corner left out would open a crack towards the
//! neighbour that uses it, and cracks are what this program looks for.

use glam::{DVec2, DVec3};

/// How many steps the polygons of one file may cost; what remains is then cut without looking for clean ears.
const WORK_LIMIT: u64 = 400_000_000;

/// Cuts polygons by ear clipping in the plane of their Newell normal.
pub(crate) struct Triangulator {
    flat: Vec<DVec2>,
    next: Vec<usize>,
    prev: Vec<usize>,
    reflex: Vec<bool>,
    reflex_count: usize,
    small: f64,
    work_left: u64,
}

impl Triangulator {
    pub(crate) fn new() -> Self {
        Self {
            flat: Vec::new(),
            next: Vec::new(),
            prev: Vec::new(),
            reflex: Vec::new(),
            reflex_count: 0,
            small: 0.0,
            work_left: WORK_LIMIT,
        }
    }

    /// Cuts one polygon of n ≥ 3 corners into n - 2 triangles with the polygon's orientation, given as positions in
    /// `corners`. Returns whether the cut is clean: false for a polygon that crosses itself or has no area.
    pub(crate) fn cut(&mut self, corners: &[DVec3], emit: &mut impl FnMut([usize; 3])) -> bool {
        match corners.len() {
            0..=2 => true,
            3 => {
                emit([0, 1, 2]);
                true
            }
            4 => cut_quad(corners, emit),
            _ => self.cut_many(corners, emit),
        }
    }

    fn cut_many(&mut self, corners: &[DVec3], emit: &mut impl FnMut([usize; 3])) -> bool {
        if !self.project(corners) {
            cut_fan(corners.len(), emit);
            return false;
        }
        self.link(corners.len());
        let (mut left, mut at, mut clean) = (corners.len(), 1, true);
        let mut since_last = 0;
        while left > 3 {
            if self.is_ear(at) || since_last > left {
                clean &= since_last <= left;
                emit([self.prev[at], at, self.next[at]]);
                at = self.unlink(at);
                left -= 1;
                since_last = 0;
            } else {
                at = self.next[at];
                since_last += 1;
            }
        }
        emit([self.prev[at], at, self.next[at]]);
        clean && self.work_left > 0
    }

    /// Projects the corners along the Newell normal; false when the polygon has no area.
    fn project(&mut self, corners: &[DVec3]) -> bool {
        let origin = corners[0];
        let normal: DVec3 = corners
            .iter()
            .zip(corners.iter().cycle().skip(1))
            .map(|(a, b)| (a - origin).cross(b - origin))
            .sum();
        let size = corners
            .iter()
            .map(|p| (p - origin).length_squared())
            .fold(0.0, f64::max);
        let area = normal.length();
        if !area.is_finite() || area <= size * 1e-14 {
            return false;
        }
        let (u, v) = (normal / area).any_orthonormal_pair();
        let handed = if u.cross(v).dot(normal) < 0.0 {
            -1.0
        } else {
            1.0
        };
        self.flat.clear();
        self.flat.extend(
            corners
                .iter()
                .map(|p| DVec2::new((p - origin).dot(u), handed * (p - origin).dot(v))),
        );
        self.small = size * 1e-14;
        true
    }

    fn link(&mut self, count: usize) {
        self.next.clear();
        self.next.extend((0..count).map(|i| (i + 1) % count));
        self.prev.clear();
        self.prev
            .extend((0..count).map(|i| (i + count - 1) % count));
        self.reflex.clear();
        self.reflex.resize(count, false);
        self.reflex_count = 0;
        for i in 0..count {
            self.update_reflex(i);
        }
    }

    fn turn(&self, i: usize) -> f64 {
        let (a, b, c) = (
            self.flat[self.prev[i]],
            self.flat[i],
            self.flat[self.next[i]],
        );
        (b - a).perp_dot(c - b)
    }

    fn update_reflex(&mut self, i: usize) {
        let reflex = self.turn(i) <= self.small;
        match (self.reflex[i], reflex) {
            (false, true) => self.reflex_count += 1,
            (true, false) => self.reflex_count -= 1,
            _ => {}
        }
        self.reflex[i] = reflex;
    }

    /// Takes corner `i` out and returns where to look for the next ear: one corner further on, so that ears alternate
    /// round the polygon instead of forming a fan of slivers.
    fn unlink(&mut self, i: usize) -> usize {
        let (before, after) = (self.prev[i], self.next[i]);
        if self.reflex[i] {
            self.reflex_count -= 1;
        }
        self.next[before] = after;
        self.prev[after] = before;
        self.update_reflex(before);
        self.update_reflex(after);
        self.next[after]
    }

    fn is_ear(&mut self, i: usize) -> bool {
        if self.work_left == 0 {
            return true;
        }
        self.work_left -= 1;
        if self.reflex[i] {
            return false;
        }
        if self.reflex_count == 0 {
            return true;
        }
        let (a, b, c) = (
            self.flat[self.prev[i]],
            self.flat[i],
            self.flat[self.next[i]],
        );
        let mut other = self.next[self.next[i]];
        let mut work = 0;
        let mut free = true;
        while free && other != self.prev[i] {
            if self.reflex[other] {
                let p = self.flat[other];
                free = p == a || p == b || p == c || !is_inside(p, a, b, c);
            }
            work += 1;
            other = self.next[other];
        }
        self.work_left = self.work_left.saturating_sub(work);
        free
    }
}

/// Whether `p` lies in the counter-clockwise triangle or on its border.
fn is_inside(p: DVec2, a: DVec2, b: DVec2, c: DVec2) -> bool {
    (b - a).perp_dot(p - a) >= 0.0
        && (c - b).perp_dot(p - b) >= 0.0
        && (a - c).perp_dot(p - c) >= 0.0
}

/// Takes the diagonal from the first corner unless only the other one keeps both halves facing the same way.
fn cut_quad(p: &[DVec3], emit: &mut impl FnMut([usize; 3])) -> bool {
    let normal = |a: usize, b: usize, c: usize| (p[b] - p[a]).cross(p[c] - p[a]);
    let agreement = |n: DVec3, m: DVec3| n.dot(m);
    let first = agreement(normal(0, 1, 2), normal(0, 2, 3));
    let second = agreement(normal(1, 2, 3), normal(1, 3, 0));
    if first <= 0.0 && second > 0.0 {
        emit([1, 2, 3]);
        emit([1, 3, 0]);
    } else {
        emit([0, 1, 2]);
        emit([0, 2, 3]);
    }
    first > 0.0 || second > 0.0
}

fn cut_fan(count: usize, emit: &mut impl FnMut([usize; 3])) {
    for i in 1..count - 1 {
        emit([0, i, i + 1]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(points: &[(f64, f64)]) -> (Vec<[usize; 3]>, bool) {
        let axis = DVec3::new(1.0, 2.0, -0.5).normalize();
        let (u, v) = axis.any_orthonormal_pair();
        let corners: Vec<DVec3> = points
            .iter()
            .map(|&(x, y)| DVec3::new(5.0, -3.0, 1.0) + u * x + v * y)
            .collect();
        let mut triangles = Vec::new();
        let clean = Triangulator::new().cut(&corners, &mut |t| triangles.push(t));
        (triangles, clean)
    }

    fn area(p: &[(f64, f64)], t: [usize; 3]) -> f64 {
        let [a, b, c] = t.map(|i| DVec2::new(p[i].0, p[i].1));
        0.5 * (b - a).perp_dot(c - a)
    }

    /// Every triangle faces the polygon's way, together they have its area, and every side is used once.
    fn assert_tiles(points: &[(f64, f64)], expected_area: f64) {
        let (triangles, clean) = cut(points);
        assert!(clean);
        assert_eq!(triangles.len(), points.len() - 2);
        let areas: Vec<f64> = triangles.iter().map(|&t| area(points, t)).collect();
        assert!(
            areas.iter().all(|a| a * expected_area > 0.0),
            "{triangles:?} {areas:?}"
        );
        assert!((areas.iter().sum::<f64>() - expected_area).abs() < 1e-9);
        for i in 0..points.len() {
            let side = (i, (i + 1) % points.len());
            let used = triangles
                .iter()
                .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
            assert_eq!(
                used.filter(|edge| *edge == side).count(),
                1,
                "side {side:?} of {triangles:?}"
            );
        }
    }

    #[test]
    fn concave_polygons_are_tiled() {
        assert_tiles(&[(0., 0.), (4., 0.), (4., 4.), (2., 1.), (0., 4.)], 10.0);
        assert_tiles(
            &[
                (0., 0.),
                (3., 0.),
                (3., 3.),
                (2., 3.),
                (2., 1.),
                (1., 1.),
                (1., 3.),
                (0., 3.),
            ],
            7.0,
        );
        assert_tiles(&[(0., 0.), (2., 2.), (0., 1.), (-2., 2.)], 2.0);
        assert_tiles(&[(2., 2.), (0., 1.), (-2., 2.), (0., 0.)], 2.0);
    }

    #[test]
    fn clockwise_polygons_stay_clockwise() {
        assert_tiles(&[(0., 4.), (2., 1.), (4., 4.), (4., 0.), (0., 0.)], -10.0);
    }

    #[test]
    fn collinear_corners_are_kept() {
        assert_tiles(
            &[
                (0., 0.),
                (1., 0.),
                (2., 0.),
                (2., 1.),
                (2., 2.),
                (1., 2.),
                (0., 2.),
                (0., 1.),
            ],
            4.0,
        );
    }

    #[test]
    fn a_large_comb_is_tiled() {
        let mut points = vec![(0.0, -1.0), (400.0, -1.0)];
        points.extend(
            (0..400)
                .rev()
                .flat_map(|i| [(f64::from(i) + 0.7, 5.0), (f64::from(i), 0.0)]),
        );
        let expected = points
            .iter()
            .zip(points.iter().cycle().skip(1))
            .map(|(a, b)| 0.5 * (a.0 * b.1 - b.0 * a.1))
            .sum();
        assert_tiles(&points, expected);
    }

    #[test]
    fn a_polygon_without_ears_ends_in_time() {
        let count = 300_000;
        let star: Vec<DVec3> = (0..count)
            .map(|i| {
                let (angle, radius) = (f64::from(i) * 2.4, f64::from(i % 7 + 1));
                DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
            })
            .collect();
        let (mut triangles, start) = (0, std::time::Instant::now());
        Triangulator::new().cut(&star, &mut |_| triangles += 1);
        assert_eq!(triangles, star.len() - 2);
        assert!(start.elapsed().as_secs() < 10);
    }

    #[test]
    fn polygons_without_area_or_crossing_themselves_still_give_every_triangle() {
        let (line, clean) = cut(&[(0., 0.), (1., 0.), (2., 0.), (3., 0.), (4., 0.)]);
        assert_eq!((line.len(), clean), (3, false));
        let (star, _) = cut(&[(0., 3.), (2., -3.), (-3., 1.), (3., 1.), (-2., -3.)]);
        assert_eq!(star.len(), 3);
        let same = [(1., 1.); 6];
        assert_eq!(cut(&same).0.len(), 4);
    }
}
