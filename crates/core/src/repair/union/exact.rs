//! Exact points and planes with integer coordinates, and exact orientation predicates.
//!
//! Input coordinates are floating-point numbers, i.e. multiples of a common power of two, so they are integers in that unit.
//! Intersection points of planes are quotients of integers: homogeneous coordinates with a positive denominator and no common
//! factor, so that equal points have equal coordinates. Each point also stores the nearest double-precision coordinates. Signs
//! are decided from these if the error bound permits, else from the integers.

use std::cmp::Ordering;
use std::collections::HashMap;

use dashu_int::IBig;
use dashu_int::ops::{BitTest, DivRem, Gcd, UnsignedAbs};
use glam::DVec3;

use crate::mesh::topology::NONE;

/// Bits. Upper bound of the ratio of coordinates to their unit; a union with a larger one is not attempted. Double-precision
/// numbers of similar size need less (at most 53 bits plus the difference of their exponents). The work grows with its square.
const MAX_BITS: i32 = 512;
/// Half a unit in the last place of 1.
const HALF_ULP: f64 = f64::EPSILON / 2.0;

/// The unit of integer coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unit {
    /// The unit is 2 to the power of minus this.
    exponent: i32,
}

/// Decomposes a finite number into an odd integer, or zero, and a power of two.
fn decoded(x: f64) -> (i64, i32) {
    let bits = x.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let (mantissa, exponent) = match exponent {
        0 => (fraction, -1074),
        _ => (fraction | (1 << 52), exponent - 1075),
    };
    if mantissa == 0 {
        return (0, 0);
    }
    let zeros = mantissa.trailing_zeros();
    let mantissa = mantissa >> zeros;
    let signed = if x < 0.0 { -mantissa } else { mantissa };
    (signed, exponent + zeros as i32)
}

impl Unit {
    /// The unit in which all coordinates of some points are integers; none if these would be too long.
    pub(super) fn of(points: impl Iterator<Item = DVec3>) -> Option<Self> {
        let (mut low, mut high) = (i32::MAX, i32::MIN);
        for x in points.flat_map(|p| p.to_array()).filter(|x| *x != 0.0) {
            let (mantissa, exponent) = decoded(x);
            let bits = 64 - mantissa.unsigned_abs().leading_zeros() as i32;
            low = low.min(exponent);
            high = high.max(exponent + bits);
        }
        if low > high {
            return Some(Self { exponent: 0 });
        }
        (high - low <= MAX_BITS).then_some(Self { exponent: -low })
    }

    /// A coordinate in this unit, truncated to an integer.
    pub(super) fn integer(self, x: f64) -> IBig {
        let (mantissa, exponent) = decoded(x);
        let shift = exponent + self.exponent;
        match shift {
            0.. => IBig::from(mantissa) << shift as usize,
            _ => IBig::from(mantissa) >> shift.unsigned_abs() as usize,
        }
    }

    pub(super) fn integers(self, p: DVec3) -> [IBig; 3] {
        p.to_array().map(|x| self.integer(x))
    }

    /// The double-precision number nearest to a quotient of integers in this unit; the denominator must be positive.
    fn nearest(self, numerator: &IBig, denominator: &IBig) -> f64 {
        if numerator.is_zero() {
            return 0.0;
        }
        let (n, d) = (numerator.unsigned_abs(), denominator.unsigned_abs());
        // Compute a quotient of 65 to 67 bits. Its last bit also records a remainder (sticky bit), so that rounding it equals
        // rounding the exact value.
        let shift = 66 - (n.bit_len() as i64 - d.bit_len() as i64);
        let (q, r) = match shift {
            0.. => (n << shift as usize).div_rem(&d),
            _ => n.div_rem(&(d << shift.unsigned_abs() as usize)),
        };
        let q = u128::try_from(q).unwrap_or(u128::MAX) | u128::from(!r.is_zero());
        let exponent = -shift - i64::from(self.exponent);
        let half = exponent / 2;
        let power = |e: i64| 2f64.powi(e as i32);
        let x = q as f64 * power(half) * power(exponent - half);
        if numerator.sign() == dashu_int::Sign::Negative {
            -x
        } else {
            x
        }
    }
}

/// A point with exact coordinates.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// Homogeneous coordinates: three numerators and a positive denominator.
    exact: [IBig; 4],
    /// The nearest double-precision coordinates.
    pub(super) nearest: DVec3,
}

impl Point {
    /// An input vertex.
    pub(super) fn vertex(unit: Unit, p: DVec3) -> Self {
        let [x, y, z] = unit.integers(p);
        Self {
            exact: [x, y, z, IBig::ONE],
            nearest: p + DVec3::ZERO,
        }
    }

    /// The point with integer coordinates next to a position.
    pub(super) fn near(unit: Unit, p: DVec3) -> Option<Self> {
        let [x, y, z] = unit.integers(p);
        Self::quotient(unit, [x, y, z, IBig::ONE])
    }

    /// The point with these homogeneous coordinates, reduced to lowest terms; none if the denominator is zero.
    fn quotient(unit: Unit, mut exact: [IBig; 4]) -> Option<Self> {
        if exact[3].is_zero() {
            return None;
        }
        let mut divisor = (&exact[3]).unsigned_abs();
        for x in exact[..3].iter().filter(|x| !x.is_zero()) {
            divisor = divisor.gcd(x.unsigned_abs());
        }
        let mut divisor = IBig::from(divisor);
        if exact[3].sign() == dashu_int::Sign::Negative {
            divisor = -divisor;
        }
        if divisor != IBig::ONE {
            exact.iter_mut().for_each(|x| *x = &*x / &divisor);
        }
        let [x, y, z] = [0, 1, 2].map(|k: usize| unit.nearest(&exact[k], &exact[3]));
        Some(Self {
            nearest: DVec3::new(x, y, z),
            exact,
        })
    }

    /// The intersection of the segment between two input vertices with a plane that separates them.
    pub(super) fn on_segment(unit: Unit, [a, b]: [DVec3; 2], plane: &Plane) -> Option<Self> {
        let (a, b) = (unit.integers(a), unit.integers(b));
        let (s, t) = (plane.height(&a), plane.height(&b));
        let along = |k: usize| &a[k] * &t - &b[k] * &s;
        Self::quotient(unit, [along(0), along(1), along(2), &t - &s])
    }

    /// The intersection point of three planes, by Cramer's rule; none if it is not a single point.
    pub(super) fn of_planes(unit: Unit, [p, q, r]: [&Plane; 3]) -> Option<Self> {
        let (qr, rp, pq) = (
            cross(&q.normal, &r.normal),
            cross(&r.normal, &p.normal),
            cross(&p.normal, &q.normal),
        );
        let along = |k: usize| &p.distance * &qr[k] + &q.distance * &rp[k] + &r.distance * &pq[k];
        let volume = dot(&p.normal, &qr);
        Self::quotient(unit, [along(0), along(1), along(2), volume])
    }

    /// The point inside a triangle with these positive weights of its corners.
    pub(super) fn inside(unit: Unit, corners: [&Self; 3], weights: [u32; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|p| &p.exact[3]);
        let factor = [b * c, c * a, a * b];
        let factor: Vec<IBig> = factor.iter().zip(weights).map(|(f, w)| f * w).collect();
        let sum = |k: usize| -> IBig {
            let of = |i: usize| &corners[i].exact[k] * &factor[i];
            of(0) + of(1) + of(2)
        };
        Self::quotient(unit, [sum(0), sum(1), sum(2), sum(3)])
    }

    /// Compares a coordinate of two points exactly.
    pub(super) fn compare(&self, other: &Self, axis: usize) -> Ordering {
        // Rounding to nearest is monotonic, so only ties need the exact comparison.
        let (x, y) = (self.nearest[axis], other.nearest[axis]);
        x.total_cmp(&y).then_with(|| {
            let left = &self.exact[axis] * &other.exact[3];
            left.cmp(&(&other.exact[axis] * &self.exact[3]))
        })
    }
}

/// Whether three points seen along an axis turn counter-clockwise (1), clockwise (-1) or lie on a line (0).
pub(super) fn turn(axis: usize, points: [&Point; 3]) -> i8 {
    let known = rounded_turn(axis, points.map(|p| p.nearest));
    known.unwrap_or_else(|| exact_turn(axis, points))
}

/// The orientation of three points from their nearest double-precision coordinates; none if these do not decide it.
pub(super) fn rounded_turn(axis: usize, [a, b, c]: [DVec3; 3]) -> Option<i8> {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let (u, v) = (b - a, c - a);
    let det = u[i] * v[j] - u[j] * v[i];
    let size = |p: DVec3| p[i].abs().max(p[j].abs());
    // A coordinate has an error of half a unit in the last place, a difference an error of at most four times that, for the
    // largest coordinate.
    let error = HALF_ULP * size(a).max(size(b)).max(size(c));
    let lengths = u[i].abs() + u[j].abs() + v[i].abs() + v[j].abs();
    let bound = 16.0 * error * lengths + 1024.0 * error * error + f64::MIN_POSITIVE;
    decided(det, bound)
}

/// The sign of a number with an error of at most `bound`; none if undecided.
fn decided(x: f64, bound: f64) -> Option<i8> {
    match x {
        x if x > bound => Some(1),
        x if x < -bound => Some(-1),
        _ => None,
    }
}

fn exact_turn(axis: usize, points: [&Point; 3]) -> i8 {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let [a, b, c] = points.map(|p| &p.exact);
    let minor = |p: &[IBig; 4], q: &[IBig; 4]| &p[i] * &q[j] - &p[j] * &q[i];
    sign(&(minor(b, c) * &a[3] + minor(c, a) * &b[3] + minor(a, b) * &c[3]))
}

/// The side of an input triangle on which a point lies: 1 where the normal points, -1 on the other side, 0 in its plane.
pub(super) fn side(unit: Unit, corners: [DVec3; 3], p: &Point) -> i8 {
    let [u, v, w] = [corners[1], corners[2], p.nearest].map(|q| q - corners[0]);
    let size = |q: DVec3| q.abs().max_element();
    let length = size(u).max(size(v)).max(size(w));
    let error = HALF_ULP
        * corners
            .map(size)
            .into_iter()
            .fold(size(p.nearest), f64::max);
    // Six products of three differences, each with an error of at most four of these units.
    let bound = 256.0 * error * length * length + f64::MIN_POSITIVE;
    let known = decided(u.cross(v).dot(w), bound);
    known.unwrap_or_else(|| Plane::of(unit, corners).side(p))
}

/// The sign of an integer.
pub(super) fn sign(x: &IBig) -> i8 {
    if x.is_zero() {
        0
    } else if x.sign() == dashu_int::Sign::Negative {
        -1
    } else {
        1
    }
}

/// A plane: the points whose dot product with `normal` equals `distance`.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    pub(super) normal: [IBig; 3],
    distance: IBig,
}

impl Plane {
    /// The plane of a triangle, oriented like it.
    pub(super) fn of(unit: Unit, corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners.map(|p| unit.integers(p));
        let between = |p: &[IBig; 3]| [0, 1, 2].map(|k: usize| &p[k] - &a[k]);
        let normal = cross(&between(&b), &between(&c));
        let distance = dot(&normal, &a);
        Self { normal, distance }
    }

    /// The plane through an edge, parallel to an axis.
    pub(super) fn along(unit: Unit, [a, b]: [DVec3; 2], axis: usize) -> Self {
        let (a, b) = (unit.integers(a), unit.integers(b));
        let mut normal = [IBig::ZERO; 3];
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        normal[i] = &b[j] - &a[j];
        normal[j] = &a[i] - &b[i];
        let distance = dot(&normal, &a);
        Self { normal, distance }
    }

    fn height(&self, p: &[IBig; 3]) -> IBig {
        dot(&self.normal, p) - &self.distance
    }

    /// The side on which a point lies: 1 where the normal points, -1 on the other side, 0 in the plane.
    pub(super) fn side(&self, p: &Point) -> i8 {
        let [x, y, z, w] = &p.exact;
        let [a, b, c] = &self.normal;
        sign(&(a * x + b * y + c * z - &self.distance * w))
    }
}

fn cross(a: &[IBig; 3], b: &[IBig; 3]) -> [IBig; 3] {
    [0, 1, 2].map(|k: usize| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        &a[i] * &b[j] - &a[j] * &b[i]
    })
}

fn dot(a: &[IBig; 3], b: &[IBig; 3]) -> IBig {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// The distinct points of an arrangement.
pub(super) struct Points {
    pub(super) unit: Unit,
    pub(super) all: Vec<Point>,
    /// The input vertex of each point; `u32::MAX` for a new one.
    pub(super) vertex: Vec<u32>,
    of_vertex: HashMap<u32, u32>,
    at: HashMap<[u64; 3], Vec<u32>>,
}

impl Points {
    pub(super) fn new(unit: Unit) -> Self {
        Self {
            unit,
            all: Vec::new(),
            vertex: Vec::new(),
            of_vertex: HashMap::new(),
            at: HashMap::new(),
        }
    }

    /// Adds an input vertex; returns its point number. Vertices must be added before other points at their positions.
    pub(super) fn add_vertex(&mut self, vertex: u32, p: DVec3) -> u32 {
        if let Some(known) = self.of_vertex.get(&vertex) {
            return *known;
        }
        let point = self.add(Point::vertex(self.unit, p));
        self.vertex[point as usize] = vertex;
        self.of_vertex.insert(vertex, point);
        point
    }

    /// The point number of a vertex; `u32::MAX` if it was not added.
    pub(super) fn of(&self, vertex: u32) -> u32 {
        self.of_vertex.get(&vertex).copied().unwrap_or(NONE)
    }

    /// The point of a node: an input vertex if the node is below `base`, else a new point numbered after them.
    pub(super) fn node(&self, node: u32, base: u32, positions: &[DVec3]) -> Point {
        match node.checked_sub(base) {
            Some(point) => self.all[point as usize].clone(),
            None => Point::vertex(self.unit, positions[node as usize]),
        }
    }

    /// Adds a point unless it exists; returns its number.
    pub(super) fn add(&mut self, point: Point) -> u32 {
        let key = point.nearest.to_array().map(f64::to_bits);
        let near = self.at.entry(key).or_default();
        let all = &mut self.all;
        let same = |i: &&u32| all[**i as usize].exact == point.exact;
        if let Some(known) = near.iter().find(same) {
            return *known;
        }
        let number = all.len() as u32;
        near.push(number);
        all.push(point);
        self.vertex.push(NONE);
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_come_back_and_quotients_are_rounded_to_the_nearest_number() {
        let points = [
            DVec3::new(0.1, -3.5, 1e-9),
            DVec3::new(7e4, 0.0, -1.0 / 3.0),
        ];
        let unit = Unit::of(points.into_iter()).unwrap();
        for p in points {
            let [x, y, z] = unit.integers(p).map(|x| unit.nearest(&x, &IBig::ONE));
            assert_eq!(DVec3::new(x, y, z), p);
        }
        let third = unit.nearest(&unit.integer(1.0), &IBig::from(3));
        assert_eq!(third, 1.0 / 3.0);
        let range = [DVec3::splat(1e70), DVec3::splat(1e-200)];
        assert!(Unit::of(range.into_iter()).is_none());
    }

    #[test]
    fn three_planes_meet_in_a_point_that_lies_in_each() {
        let corners = |s: f64| {
            let p = |x: f64, y: f64, z: f64| DVec3::new(x * s, y, z);
            [p(0.1, 0.2, 0.7), p(1.3, 0.25, 0.1), p(0.3, 1.9 * s, 0.4)]
        };
        let planes = [0.5, 1.1, -0.7].map(corners);
        let unit = Unit::of(planes.into_iter().flatten()).unwrap();
        let planes = planes.map(|t| Plane::of(unit, t));
        let [p, q, r] = &planes;
        let point = Point::of_planes(unit, [p, q, r]).unwrap();
        assert!(planes.iter().all(|plane| plane.side(&point) == 0));
        let again = Point::of_planes(unit, [r, p, q]).unwrap();
        assert_eq!(point.exact, again.exact);
    }

    #[test]
    fn turns_are_exact_where_rounded_coordinates_cannot_tell() {
        let unit = Unit::of([DVec3::ONE].into_iter()).unwrap();
        let point = |x: i64, y: i64, w: i64| {
            let exact = [x, y, 0, w].map(IBig::from);
            Point::quotient(unit, exact).unwrap()
        };
        let big = 1 << 60;
        let (a, b) = (point(0, 0, 1), point(1, 1, 3));
        assert_eq!(turn(2, [&a, &b, &point(big, big, 7)]), 0);
        assert_eq!(turn(2, [&a, &b, &point(big, big + 1, 7)]), 1);
        assert_eq!(turn(2, [&a, &b, &point(big + 1, big, 7)]), -1);
    }
}
