//! The course of the edge of a wall between two places.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::creases::circle;
use crate::elementary::{angle_of, rotation};
use crate::linalg::{second_moments, symmetric_eigen};
use crate::tuning::{Tunable, tunable};

/// Cosine between the chord from end to end and the directions of the edge at both, at least.
const LEAST_TOWARDS: Tunable<f64> = tunable("fill.lip.least_towards", 0.14);
/// Chords. The curve is at most this long.
const LONGEST: Tunable<f64> = tunable("fill.lip.longest", 1.35);
/// Fits of the curve, each with the length of the one before.
const FITS: usize = 4;
/// Parts of the curve by which its length is measured.
const PARTS: usize = 32;
/// Part of a cubic curve's misfit. An arc is taken whose misfit is smaller.
const CLEARLY_LESS: f64 = 0.5;
/// Radians. Arcs turn at least this far: shorter ones are as well cubic curves.
const LEAST_TURN: f64 = 1.0;

/// How the edge goes on from end to end.
pub(super) enum Course {
    /// Through its further places, from each end into the mesh.
    Through {
        places: [Vec<DVec3>; 2],
        /// Root mean square distance of the places from the curve, over their distance from its ends, at most.
        most_off: f64,
    },
    Straight,
}

impl Course {
    /// The curve between two ends; none where the places have no such curve.
    pub(super) fn curve(&self, ends: [DVec3; 2]) -> Option<Curve> {
        let Self::Through { places, most_off } = self else {
            return Some(Curve::Cubic(Cubic::straight(ends)));
        };
        let cubic = Cubic::fitted(ends, places);
        let off = cubic.as_ref().map_or(f64::INFINITY, |(_, off)| *off);
        let arc = Arc::fitted(ends, places).filter(|(_, own)| *own < CLEARLY_LESS * off);
        log::debug!(
            "edge of a wall: cubic curve off by {off:.4}, arc {:.4?}",
            arc.as_ref().map(|a| a.1)
        );
        let arc = arc.map(|(arc, off)| (Curve::Arc(arc), off));
        let curve = arc.or(cubic.map(|(cubic, off)| (Curve::Cubic(cubic), off)));
        curve
            .filter(|(_, off)| off < most_off)
            .map(|(curve, _)| curve)
    }
}

/// A curve from end to end.
#[derive(Clone, Copy, Debug)]
pub(super) enum Curve {
    Cubic(Cubic),
    Arc(Arc),
}

impl Curve {
    /// The point at a parameter: 0 at the first end, 1 at the second.
    pub(super) fn at(&self, u: f64) -> DVec3 {
        match self {
            Self::Cubic(cubic) => cubic.at(u),
            Self::Arc(arc) => arc.at(u),
        }
    }

    /// Unit tangent.
    pub(super) fn tangent(&self, u: f64) -> DVec3 {
        match self {
            Self::Cubic(cubic) => cubic.tangent(u),
            Self::Arc(arc) => arc.tangent(u),
        }
    }

    pub(super) fn length(&self) -> f64 {
        match self {
            Self::Cubic(cubic) => cubic.length(),
            Self::Arc(arc) => arc.start.length() * arc.turn.abs(),
        }
    }

    /// The direction at a parameter between the directions at the ends, which turn with an arc.
    pub(super) fn between(&self, [first, second]: [DVec3; 2], u: f64) -> DVec3 {
        match self {
            Self::Cubic(_) => first.lerp(second, u),
            Self::Arc(arc) => {
                let turned = |part: f64, v: DVec3| rotation(part * arc.turn * arc.axis) * v;
                turned(u, first).lerp(turned(u - 1.0, second), u)
            }
        }
    }
}

/// A part of a circle, which misses the ends by the gaps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    /// Unit vector.
    axis: DVec3,
    centre: DVec3,
    /// From the centre to the beginning of the arc.
    start: DVec3,
    /// Angle about the axis.
    turn: f64,
    gaps: [DVec3; 2],
}

impl Arc {
    /// The circle through the ends and the further places, by least squares, and how far it is off; none where the places are not on the
    /// other part of it, or the arc hardly turns.
    fn fitted(ends: [DVec3; 2], places: &[Vec<DVec3>; 2]) -> Option<(Self, f64)> {
        let all: Vec<DVec3> = ends
            .iter()
            .chain(&places[0])
            .chain(&places[1])
            .copied()
            .collect();
        let middle = all.iter().sum::<DVec3>() / all.len() as f64;
        let ([..], [axis, _, x]) =
            symmetric_eigen(&second_moments(all.iter().map(|p| *p - middle)));
        let y = axis.cross(x);
        let flat = |p: DVec3| DVec2::new((p - middle).dot(x), (p - middle).dot(y));
        let (of_flat, radius) = circle(&all.iter().map(|p| flat(*p)).collect::<Vec<_>>())?;
        let angle = |p: DVec3| angle_of(flat(p) - of_flat);
        // From −π to π.
        let from = |a: f64, b: f64| (b - a) - ((b - a) / TAU).round() * TAU;
        let beyond = [0, 1].map(|k| {
            places[k]
                .last()
                .map_or(0.0, |p| from(angle(ends[k]), angle(*p)))
        });
        let sign = -beyond[0].signum();
        (sign * beyond[1] > 0.0).then_some(())?;
        let turn = sign * (sign * (angle(ends[1]) - angle(ends[0]))).rem_euclid(TAU);
        let whole = turn.abs() + beyond[0].abs() + beyond[1].abs();
        (turn.abs() > LEAST_TURN && whole < TAU).then_some(())?;
        let out = flat(ends[0]) - of_flat;
        let mut arc = Self {
            axis,
            centre: middle + of_flat.x * x + of_flat.y * y,
            start: radius * (out.x * x + out.y * y).normalize_or_zero(),
            turn,
            gaps: [DVec3::ZERO; 2],
        };
        arc.gaps = [0.0, 1.0].map(|u| ends[u as usize] - arc.at(u));
        let mut sums = [0.0; 2];
        for (end, p) in [0, 1]
            .into_iter()
            .flat_map(|k| places[k].iter().map(move |p| (ends[k], *p)))
        {
            let height = (p - arc.centre).dot(axis);
            sums[0] +=
                height.powi(2) + ((p - arc.centre - height * axis).length() - radius).powi(2);
            sums[1] += end.distance_squared(p);
        }
        Some((arc, (sums[0] / sums[1]).sqrt()))
    }

    fn at(&self, u: f64) -> DVec3 {
        let turned = rotation(u * self.turn * self.axis) * self.start;
        self.centre + turned + self.gaps[0].lerp(self.gaps[1], u)
    }

    fn tangent(&self, u: f64) -> DVec3 {
        let turned = rotation(u * self.turn * self.axis) * self.start;
        (self.turn * self.axis.cross(turned)).normalize_or_zero()
    }
}

/// A cubic curve from end to end, by its ends and its derivatives there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic {
    ends: [DVec3; 2],
    slopes: [DVec3; 2],
}

/// The four cubic Hermite polynomials: of the values at 0 and 1, and of the slopes there.
fn hermite(u: f64) -> [f64; 4] {
    let (v, uu) = (1.0 - u, u * u);
    [
        v * v * (1.0 + 2.0 * u),
        uu * (3.0 - 2.0 * u),
        u * v * v,
        -uu * v,
    ]
}

impl Cubic {
    fn straight(ends: [DVec3; 2]) -> Self {
        Self {
            ends,
            slopes: [ends[1] - ends[0]; 2],
        }
    }

    /// The curve between two ends that fits further places before the first and after the second one, by least squares, and how far it is
    /// off; places count less the farther they are. None if it turns back or is much longer than its chord.
    fn fitted(ends: [DVec3; 2], places: &[Vec<DVec3>; 2]) -> Option<(Self, f64)> {
        let mut curve = Self::straight(ends);
        let chord = ends[1] - ends[0];
        let mut length = chord.length();
        for _ in 0..FITS {
            curve = curve.refitted(places, length)?;
            length = curve.length();
        }
        let towards = |slope: DVec3| slope.normalize_or_zero().dot(chord.normalize_or_zero());
        let is_curve = curve
            .slopes
            .iter()
            .all(|s| towards(*s) > LEAST_TOWARDS.get())
            && length < LONGEST.get() * chord.length();
        is_curve.then(|| (curve, curve.misfit(places, length)))
    }

    /// Places beyond the ends: the end, the parameter of the curve there, and the place.
    fn beyond(
        &self,
        places: &[Vec<DVec3>; 2],
        length: f64,
    ) -> impl Iterator<Item = (DVec3, f64, DVec3)> {
        let [before, after] = [0, 1].map(|k| {
            let (end, mut last, mut way) = (self.ends[k], self.ends[k], 0.0);
            places[k].iter().map(move |p| {
                way += last.distance(*p) / length;
                last = *p;
                (end, if k == 0 { -way } else { 1.0 + way }, *p)
            })
        });
        before.chain(after)
    }

    /// Root mean square distance of the places from the curve, over their distance from its ends.
    fn misfit(&self, places: &[Vec<DVec3>; 2], length: f64) -> f64 {
        let mut sums = [0.0; 2];
        for (end, u, p) in self.beyond(places, length) {
            sums[0] += self.at(u).distance_squared(p);
            sums[1] += end.distance_squared(p);
        }
        (sums[0] / sums[1]).sqrt()
    }

    fn refitted(&self, places: &[Vec<DVec3>; 2], length: f64) -> Option<Self> {
        // Normal equations of both slopes.
        let (mut matrix, mut sides) = ([0.0; 3], [DVec3::ZERO; 2]);
        for (_, u, p) in self.beyond(places, length) {
            let [a, b, c, d] = hermite(u);
            let way = f64::max(-u, u - 1.0);
            let weight = 1.0 / (1.0 + (4.0 * way).powi(2));
            let rest = p - a * self.ends[0] - b * self.ends[1];
            matrix[0] += weight * c * c;
            matrix[1] += weight * c * d;
            matrix[2] += weight * d * d;
            sides[0] += weight * c * rest;
            sides[1] += weight * d * rest;
        }
        let [a, b, c] = matrix;
        let determinant = a * c - b * b;
        (determinant > 1e-9 * a * c).then(|| Self {
            slopes: [
                (c * sides[0] - b * sides[1]) / determinant,
                (a * sides[1] - b * sides[0]) / determinant,
            ],
            ..*self
        })
    }

    fn at(&self, u: f64) -> DVec3 {
        let [a, b, c, d] = hermite(u);
        a * self.ends[0] + b * self.ends[1] + c * self.slopes[0] + d * self.slopes[1]
    }

    /// Unit tangent.
    fn tangent(&self, u: f64) -> DVec3 {
        let [v, chord] = [1.0 - u, 6.0 * u * (1.0 - u)];
        let slopes = v * (1.0 - 3.0 * u) * self.slopes[0] + u * (3.0 * u - 2.0) * self.slopes[1];
        (chord * (self.ends[1] - self.ends[0]) + slopes).normalize_or_zero()
    }

    fn length(&self) -> f64 {
        let at = |i: usize| self.at(i as f64 / PARTS as f64);
        (0..PARTS).map(|i| at(i).distance(at(i + 1))).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_between_two_parts_of_a_circle_is_an_arc() {
        let at = |degrees: f64| {
            let t = degrees.to_radians();
            10.0 * DVec3::new(t.cos(), t.sin(), 0.0)
        };
        let beyond = [-20.0, 20.0].map(|end: f64| {
            let places = (1..=8).map(|k| at(end + end.signum() * 2.0 * f64::from(k)));
            places.collect::<Vec<_>>()
        });
        let (curve, off) = Cubic::fitted([at(-20.0), at(20.0)], &beyond).unwrap();
        assert!(off < 0.1, "{off}");
        for i in 0..=20 {
            let off = curve.at(f64::from(i) / 20.0).length() - 10.0;
            assert!(off.abs() < 0.02, "{off}");
        }
        // The tangent is the derivative.
        let step = (curve.at(0.3 + 1e-6) - curve.at(0.3 - 1e-6)).normalize();
        assert!(step.distance(curve.tangent(0.3)) < 1e-6);
    }

    #[test]
    fn most_of_a_circle_is_an_arc_and_what_is_no_circle_is_none() {
        let at = |degrees: f64| {
            let t = degrees.to_radians();
            DVec3::new(3.0 + 10.0 * t.cos(), 10.0 * t.sin(), 7.0)
        };
        for half in [40.0, 90.0, 140.0] {
            let ends = [at(-half), at(half)];
            let places = [-half, half].map(|end: f64| {
                let places = (1..=8).map(|k| at(end + end.signum() * 4.0 * f64::from(k)));
                places.collect::<Vec<_>>()
            });
            let (arc, off) = Arc::fitted(ends, &places).unwrap();
            assert!(off < 1e-9, "{off}");
            let course = Course::Through {
                places: places.clone(),
                most_off: 0.25,
            };
            let curve = course.curve(ends).unwrap();
            assert!((curve.length() - 20.0 * half.to_radians()).abs() < 1e-9);
            for i in 0..=20 {
                let u = f64::from(i) / 20.0;
                assert!(curve.at(u).distance(at((2.0 * u - 1.0) * half)) < 1e-9);
                let step = (arc.at(u + 1e-6) - arc.at(u - 1e-6)).normalize();
                assert!(step.distance(arc.tangent(u)) < 1e-6);
                let out = [0.0, 1.0].map(|u| curve.at(u) - DVec3::new(3.0, 0.0, 7.0));
                let here = curve.at(u) - DVec3::new(3.0, 0.0, 7.0);
                assert!(curve.between(out, u).distance(here) < 1e-9);
            }
            // Places on the arc itself are no continuation of it.
            let [a, b] = places;
            assert!(Arc::fitted(ends, &[b, a]).is_none());
        }
    }
}
