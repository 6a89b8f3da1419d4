//! The curve of a crease across a hole: the intersection of two sheets, from one end to the other.

use glam::DVec3;

use super::CreaseRefusal;
use super::network::{FARTHEST_CORNER, LONGEST_STEP, Network, ON_BOTH};
use super::sheet::{Sheet, onto};
use crate::tuning::{Tunable, tunable};

/// Maximum length of a crease found from its chord: this times the chord, plus two edges.
const MOST_DETOUR: Tunable<f64> = tunable("creases.curve.most_detour", 1.8);
/// Maximum length of a crease that is followed step by step, in diameters of the hole.
const MOST_FOLLOWED: Tunable<f64> = tunable("creases.curve.most_followed", 4.0);
/// A point of a crease closer than this (in edges) to a vertex of the mesh that is not on the rim counts as on the mesh;
const ON_MESH: Tunable<f64> = tunable("creases.curve.on_mesh", 0.6);
/// at most this fraction of the points of a crease may be on the mesh.
const MOST_KNOWN: Tunable<f64> = tunable("creases.curve.most_known", 0.5);
/// A crease is not followed where the sine of the angle between its sheets is below this.
const GRAZING: Tunable<f64> = tunable("creases.curve.grazing", 0.05);

impl Network<'_> {
    /// The points of a crease between two points, at the distance of rim vertices: projected from the chord, or if that gives no
    /// short curve, by following the crease.
    pub(super) fn curve(
        &self,
        from: DVec3,
        to: DVec3,
        sides: [usize; 2],
    ) -> Result<Vec<DVec3>, CreaseRefusal> {
        let longest = LONGEST_STEP.get() * self.collar.diameter;
        let sheets = sides.map(|s| self.sheet(s));
        let chord = from.distance(to);
        let on_chord = (0..9).map(|i| from.lerp(to, f64::from(i) / 8.0));
        let points = on_chord.map(|p| onto(&sheets, p, 20, longest)).collect();
        let most = MOST_DETOUR.get() * chord + 2.0 * self.collar.rim_edge;
        self.evened(points, sheets, most).or_else(|why| {
            let followed = self.followed(from, to, sheets).ok_or(why)?;
            self.evened(followed, sheets, MOST_FOLLOWED.get() * self.collar.diameter)
        })
    }

    /// Points of a crease at equal distances. Refused if they are off a sheet, or the crease is longer than `most`.
    fn evened(
        &self,
        mut points: Vec<DVec3>,
        sheets: [&Sheet; 2],
        most: f64,
    ) -> Result<Vec<DVec3>, CreaseRefusal> {
        let (edge, longest) = (
            self.collar.rim_edge,
            LONGEST_STEP.get() * self.collar.diameter,
        );
        for _ in 0..2 {
            let again = resampled(&points, edge).into_iter();
            points = again.map(|p| onto(&sheets, p, 8, longest)).collect();
        }
        let length: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
        let off = |s: &Sheet| {
            points
                .iter()
                .map(|p| s.distance(*p).abs())
                .fold(0.0, f64::max)
        };
        let is_on_both = off(sheets[0]) + off(sheets[1]) <= ON_BOTH.get() * edge;
        match points.iter().all(|p| p.is_finite()) && is_on_both {
            true if length > most => Err(CreaseRefusal::LongCrease),
            true if self.known(&points) > MOST_KNOWN.get() => Err(CreaseRefusal::NoCrease),
            true => Ok(points),
            false => Err(CreaseRefusal::NoCrease),
        }
    }

    /// Fraction of the points of a crease that are on the mesh: close to vertices that are not on the rim.
    fn known(&self, points: &[DVec3]) -> f64 {
        let near = ON_MESH.get() * self.collar.rim_edge;
        let is_on = |p: &&DVec3| {
            let mut inner = self.collar.inner_points();
            inner.any(|q| q.distance_squared(**p) < near * near)
        };
        points.iter().filter(is_on).count() as f64 / points.len().max(1) as f64
    }

    /// The crease followed from one point to another, for example to the end of a groove that runs out. Of the two directions,
    /// the path with fewer points on the mesh. `None` if neither arrives.
    fn followed(&self, from: DVec3, to: DVec3, sheets: [&Sheet; 2]) -> Option<Vec<DVec3>> {
        let ways = [1.0, -1.0].map(|sign| self.way(from, to, sheets, sign));
        let ways = ways.into_iter().flatten();
        ways.min_by(|a, b| self.known(a).total_cmp(&self.known(b)))
    }

    /// Follows the crease in one direction (predictor: the cross product of both normals; corrector: Gauss-Newton).
    fn way(&self, from: DVec3, to: DVec3, sheets: [&Sheet; 2], sign: f64) -> Option<Vec<DVec3>> {
        let step = self.collar.rim_edge;
        let most = (MOST_FOLLOWED.get() * self.collar.diameter / step) as usize;
        let mut points = vec![from];
        let mut at = from;
        let mut direction = DVec3::ZERO;
        for _ in 0..most {
            let [a, b] = sheets.map(|s| s.normal(at));
            let along = a.cross(b);
            if along.length() < GRAZING.get() {
                return None;
            }
            let along = along.normalize();
            let forward = if direction == DVec3::ZERO {
                sign
            } else {
                along.dot(direction).signum()
            };
            direction = along * forward;
            at = onto(&sheets, at + step * direction, 8, step);
            if at.length() > FARTHEST_CORNER.get() * self.collar.diameter {
                return None;
            }
            if at.distance(to) < step {
                points.push(to);
                return Some(points);
            }
            points.push(at);
        }
        None
    }
}

/// Points at equal distances along a polyline, about `edge` apart; at least two segments.
fn resampled(points: &[DVec3], edge: f64) -> Vec<DVec3> {
    let mut along = vec![0.0];
    for w in points.windows(2) {
        along.push(along[along.len() - 1] + w[0].distance(w[1]));
    }
    let length = along[along.len() - 1];
    let stretches = (length / edge).round_ties_even().clamp(2.0, 1e4) as usize;
    let mut at = 0;
    let point = |i: usize| {
        let t = length * i as f64 / stretches as f64;
        while at + 2 < along.len() && along[at + 1] < t {
            at += 1;
        }
        let stretch = along[at + 1] - along[at];
        let part = if stretch > 0.0 {
            (t - along[at]) / stretch
        } else {
            0.0
        };
        points[at].lerp(points[at + 1], part.clamp(0.0, 1.0))
    };
    (0..=stretches).map(point).collect()
}
