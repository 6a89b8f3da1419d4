//! Ear clipping of plane polygons into triangles that keep every corner.
//!
//! Every corner stays a corner of some triangle, including collinear ones: a missing corner would open a crack to the
//! neighbouring face that uses it, and the program would report the crack as a hole.

mod search;

use glam::{DVec2, DVec3};

use crate::mesh::area_vector;
use search::{Marks, Tree};

/// Maximum number of steps for all polygons of one file: tests of corners and boxes against ears, about 0.5 s. Beyond it,
/// remaining polygons are cut without testing ears.
const WORK_LIMIT: u64 = 40_000_000;

/// Ear clipping of polygons in the plane of their Newell normal.
pub struct Triangulator {
    flat: Vec<DVec2>,
    next: Vec<usize>,
    prev: Vec<usize>,
    reflex: Vec<bool>,
    reflex_count: usize,
    small: f64,
    work_left: u64,
    /// Corners that may be ears: all but those that were found not to be, as long as the reason persists.
    likely: Marks,
    /// For each corner, the corners that are not ears because it is inside their triangle.
    blocks: Vec<Vec<u32>>,
    tree: Tree,
}

impl Default for Triangulator {
    fn default() -> Self {
        Self {
            flat: Vec::new(),
            next: Vec::new(),
            prev: Vec::new(),
            reflex: Vec::new(),
            reflex_count: 0,
            small: 0.0,
            work_left: WORK_LIMIT,
            likely: Marks::default(),
            blocks: Vec::new(),
            tree: Tree::default(),
        }
    }
}

impl Triangulator {
    /// Cuts a polygon of n ≥ 3 corners, given as positions, into n - 2 triangles with the polygon's orientation. Returns whether
    /// the result is valid: false for a polygon that intersects itself or has no area, or if the step limit is reached.
    pub fn cut(&mut self, corners: &[DVec3], emit: &mut impl FnMut([usize; 3])) -> bool {
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
        while left > 3 {
            at = match self.next_ear(at) {
                Some(ear) => ear,
                // A polygon without ears intersects itself.
                None => {
                    clean = false;
                    self.next[at]
                }
            };
            emit([self.prev[at], at, self.next[at]]);
            at = self.unlink(at);
            left -= 1;
        }
        emit([self.prev[at], at, self.next[at]]);
        clean && self.work_left > 0
    }

    /// The first ear at or after corner `at`, in the polygon's order.
    fn next_ear(&mut self, at: usize) -> Option<usize> {
        let mut from = at;
        loop {
            if self.work_left == 0 {
                return Some(at);
            }
            let corner = self.likely.from(from).or_else(|| self.likely.from(0))?;
            match self.obstacle(corner) {
                None => return Some(corner),
                Some(obstacle) => {
                    self.likely.clear(corner);
                    if obstacle != corner {
                        self.blocks[obstacle].push(corner as u32);
                    }
                    from = corner;
                }
            }
        }
    }

    /// Projects the corners along the Newell normal; false if the polygon has no area.
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

    /// Resets the linked list and the search structures for a polygon.
    fn link(&mut self, count: usize) {
        self.next.clear();
        self.next.extend((0..count).map(|i| (i + 1) % count));
        self.prev.clear();
        self.prev
            .extend((0..count).map(|i| (i + count - 1) % count));
        self.likely.fill(count);
        self.blocks.iter_mut().take(count).for_each(Vec::clear);
        self.blocks
            .resize_with(self.blocks.len().max(count), Vec::new);
        self.reflex.clear();
        self.reflex
            .extend((0..count).map(|i| turn(&self.flat, &self.prev, &self.next, i) <= self.small));
        self.reflex_count = self.reflex.iter().filter(|r| **r).count();
        self.tree.build(&self.flat, &self.reflex);
    }

    /// Updates a corner whose neighbours changed.
    fn update(&mut self, i: usize) {
        let reflex = turn(&self.flat, &self.prev, &self.next, i) <= self.small;
        if self.reflex[i] != reflex {
            self.reflex[i] = reflex;
            if reflex {
                self.reflex_count += 1;
                self.tree.count(i, 1);
            } else {
                self.release(i);
            }
        }
        self.likely.set(i);
    }

    /// Handles a corner that is no longer reflex or was removed: corners that it blocked may be ears now.
    fn release(&mut self, i: usize) {
        self.reflex_count -= 1;
        self.tree.count(i, -1);
        for blocked in std::mem::take(&mut self.blocks[i]) {
            // A corner that was removed already must stay cleared.
            let blocked = blocked as usize;
            if self.next[self.prev[blocked]] == blocked {
                self.likely.set(blocked);
            }
        }
    }

    /// Removes corner `i` and returns where to search for the next ear: one corner further on, so that ears alternate around the
    /// polygon instead of forming a fan of slivers.
    fn unlink(&mut self, i: usize) -> usize {
        let (before, after) = (self.prev[i], self.next[i]);
        self.likely.clear(i);
        self.next[before] = after;
        self.prev[after] = before;
        if self.reflex[i] {
            self.reflex[i] = false;
            self.release(i);
        }
        self.update(before);
        self.update(after);
        self.next[after]
    }

    /// A corner that prevents corner `i` from being an ear: a reflex corner in its triangle, or `i` itself if it is reflex.
    fn obstacle(&mut self, i: usize) -> Option<usize> {
        self.work_left = self.work_left.saturating_sub(1);
        if self.reflex[i] {
            return Some(i);
        }
        if self.reflex_count == 0 {
            return None;
        }
        let ear = [self.prev[i], i, self.next[i]];
        self.tree.inside(
            &self.flat,
            &self.reflex,
            ear,
            self.small,
            &mut self.work_left,
        )
    }
}

/// Twice the area of the triangle of a corner and its neighbours; negative at a reflex corner.
fn turn(flat: &[DVec2], prev: &[usize], next: &[usize], i: usize) -> f64 {
    let (a, b, c) = (flat[prev[i]], flat[i], flat[next[i]]);
    (b - a).perp_dot(c - b)
}

/// Cuts a quadrilateral along the diagonal from the first corner, unless only the other diagonal gives two triangles with the
/// same orientation.
fn cut_quad(p: &[DVec3], emit: &mut impl FnMut([usize; 3])) -> bool {
    let normal = |a: usize, b: usize, c: usize| area_vector([p[a], p[b], p[c]]);
    let first = normal(0, 1, 2).dot(normal(0, 2, 3));
    let second = normal(1, 2, 3).dot(normal(1, 3, 0));
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
        let clean = Triangulator::default().cut(&corners, &mut |t| triangles.push(t));
        (triangles, clean)
    }

    fn area(p: &[(f64, f64)], t: [usize; 3]) -> f64 {
        let [a, b, c] = t.map(|i| DVec2::new(p[i].0, p[i].1));
        0.5 * (b - a).perp_dot(c - a)
    }

    /// Asserts that every triangle has the polygon's orientation, the areas add up, and every side is used once.
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
        Triangulator::default().cut(&star, &mut |_| triangles += 1);
        assert_eq!(triangles, star.len() - 2);
        assert!(start.elapsed().as_secs() < 10);
    }

    #[test]
    fn polygons_without_area_or_with_self_intersections_still_give_every_triangle() {
        let (line, clean) = cut(&[(0., 0.), (1., 0.), (2., 0.), (3., 0.), (4., 0.)]);
        assert_eq!((line.len(), clean), (3, false));
        let (star, _) = cut(&[(0., 3.), (2., -3.), (-3., 1.), (3., 1.), (-2., -3.)]);
        assert_eq!(star.len(), 3);
        let same = [(1., 1.); 6];
        assert_eq!(cut(&same).0.len(), 4);
    }

    /// The same algorithm with a test of every corner for every ear.
    fn by_testing_all(corners: &[DVec3]) -> (Vec<[usize; 3]>, bool) {
        let mut t = Triangulator::default();
        assert!(t.project(corners));
        let n = corners.len();
        let mut next: Vec<usize> = (0..n).map(|i| (i + 1) % n).collect();
        let mut prev: Vec<usize> = (0..n).map(|i| (i + n - 1) % n).collect();
        let (mut triangles, mut clean) = (Vec::new(), true);
        let (mut left, mut at, mut since) = (n, 1, 0);
        while left > 3 {
            let is_reflex = |i: usize| turn(&t.flat, &prev, &next, i) <= t.small;
            let ear = [prev[at], at, next[at]];
            let [a, b, c] = ear.map(|i| t.flat[i]);
            let covers = |i: usize| {
                let p = t.flat[i];
                let left_of = |(a, b): (DVec2, DVec2)| (b - a).perp_dot(p - a) >= 0.0;
                ![a, b, c].contains(&p) && [(a, b), (b, c), (c, a)].into_iter().all(left_of)
            };
            let others = std::iter::successors(Some(next[ear[2]]), |i| Some(next[*i]));
            let mut others = others.take_while(|i| *i != ear[0]);
            let found = !is_reflex(at) && !others.any(|i| is_reflex(i) && covers(i));
            if !found && since <= left {
                at = next[at];
                since += 1;
                continue;
            }
            clean &= since <= left;
            triangles.push(ear);
            (next[ear[0]], prev[ear[2]]) = (ear[2], ear[0]);
            at = next[ear[2]];
            left -= 1;
            since = 0;
        }
        triangles.push([prev[at], at, next[at]]);
        (triangles, clean)
    }

    /// Pseudo-random numbers from 0 to 1.
    fn noise(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    }

    #[test]
    fn the_ears_are_those_that_testing_all_corners_finds() {
        let mut seed = 7;
        for round in 0..300 {
            let count = 5 + (noise(&mut seed) * 120.0) as usize;
            let kind = round % 4;
            let corners: Vec<DVec3> = (0..count)
                .map(|i| {
                    let angle = std::f64::consts::TAU * i as f64 / count as f64;
                    let (sin, cos) = angle.sin_cos();
                    match kind {
                        // Round and simple, with and without corners on a lattice.
                        0 => DVec3::new(cos, sin, 0.0) * (0.2 + noise(&mut seed)),
                        1 => (DVec3::new(cos, sin, 0.0) * (2.0 + 7.0 * noise(&mut seed))).round(),
                        // With self-intersections, with and without coincident corners.
                        2 => DVec3::new(noise(&mut seed), noise(&mut seed), 0.0),
                        _ => (5.0 * DVec3::new(noise(&mut seed), noise(&mut seed), 0.0)).round(),
                    }
                })
                .collect();
            if !Triangulator::default().project(&corners) {
                continue;
            }
            let mut triangles = Vec::new();
            let clean = Triangulator::default().cut(&corners, &mut |t| triangles.push(t));
            assert_eq!((triangles, clean), by_testing_all(&corners), "{corners:?}");
        }
    }

    /// A band with `count` corners that spirals inwards.
    fn spiral(count: usize) -> Vec<(f64, f64)> {
        let side = |i: usize, inner: f64| {
            let t = i as f64 / (count / 2) as f64;
            let (angle, radius) = (40.0 * t, 10.0 - 8.0 * t - inner);
            (radius * angle.cos(), radius * angle.sin())
        };
        let out = (0..count / 2).map(|i| side(i, 0.0));
        out.chain((0..count / 2).rev().map(|i| side(i, 0.4)))
            .collect()
    }

    #[test]
    fn large_polygons_are_cut_in_time() {
        let count = 30_000;
        let ring = |radius: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
            let angle = |i: usize| std::f64::consts::TAU * i as f64 / count as f64;
            (0..count)
                .map(|i| (radius(i) * angle(i).cos(), radius(i) * angle(i).sin()))
                .collect()
        };
        let mut seed = 3;
        let rough: Vec<f64> = (0..count).map(|_| 1.0 + noise(&mut seed)).collect();
        let mut comb = vec![(0.0, -1.0), (15_000.0, -1.0)];
        comb.extend((0..15_000).rev().flat_map(|i| {
            let x = f64::from(i);
            [(x + 0.7, 500.0), (x, 0.0)]
        }));
        let shapes = [
            ("convex", ring(&|_| 1.0)),
            ("star", ring(&|i| 1.0 + (i % 2) as f64)),
            ("rough", ring(&|i| rough[i])),
            ("comb", comb),
            ("spiral", spiral(count)),
        ];
        for (name, points) in shapes {
            let start = std::time::Instant::now();
            let (triangles, clean) = cut(&points);
            let time = start.elapsed().as_secs_f64();
            println!("{name}: {time:.3} s");
            assert!(clean, "{name}");
            assert_eq!(triangles.len(), points.len() - 2);
            assert!(time < 2.0, "{name}: {time} s");
        }
    }
}
