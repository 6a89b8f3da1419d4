//! Closed polylines that bound a gap, and tests for the gap side.

use std::f64::consts::TAU;

use crate::elementary::angle_between;
use crate::tuning::{Tunable, tunable};
use glam::DVec3;

/// Voxels times the length of a loop. A loop that keeps nothing inside is thin up to this area.
const THIN: Tunable<f64> = tunable("stitch.thin", 2.0);

/// A closed polyline with the gap on its left, seen from the tips of the normals.
#[derive(Clone, Default)]
pub(super) struct Outline {
    pub(super) position: Vec<DVec3>,
    pub(super) normal: Vec<DVec3>,
    sector: Vec<Sector>,
}

impl Outline {
    /// Builds an outline from positions and unit normals.
    pub(super) fn new(vertices: impl Iterator<Item = (DVec3, DVec3)>) -> Self {
        let (position, normal): (Vec<DVec3>, Vec<DVec3>) = vertices.unzip();
        let n = position.len();
        let sector = (0..n)
            .map(|i| {
                Sector::new(
                    position[i],
                    position[(i + 1) % n],
                    position[(i + n - 1) % n],
                    normal[i],
                )
            })
            .collect();
        Self {
            position,
            normal,
            sector,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether the gap at vertex `i` extends in the direction of `p`.
    pub(super) fn opens_towards(&self, i: usize, p: DVec3) -> bool {
        self.sector[i].contains(p)
    }

    /// Whether no point inside can be more than a few voxels from the loop (area over length).
    pub(super) fn is_thin(&self, voxel: f64) -> bool {
        let n = self.len();
        let at = |i: usize| self.position[i % n] - self.position[0];
        let area = (0..n)
            .map(|i| at(i).cross(at(i + 1)))
            .sum::<DVec3>()
            .length()
            / 2.0;
        let length: f64 = (0..n).map(|i| at(i).distance(at(i + 1))).sum();
        area <= THIN.get() * voxel * length
    }

    /// The sum of the turning angles to the left: positive around a hole, negative around an island.
    pub(super) fn turning(&self) -> f64 {
        self.sector.iter().map(|s| TAU / 2.0 - s.angle()).sum()
    }
}

/// The sector at a vertex from one direction counter-clockwise to another.
#[derive(Clone)]
struct Sector {
    at: DVec3,
    first: DVec3,
    last: DVec3,
    normal: DVec3,
    reflex: bool,
}

impl Sector {
    /// The sector at `at` from the direction of `first` to the direction of `last`; the full circle if they are the same.
    fn new(at: DVec3, first: DVec3, last: DVec3, normal: DVec3) -> Self {
        let (first, last) = (first - at, last - at);
        Self {
            at,
            first,
            last,
            normal,
            reflex: first.cross(last).dot(normal) <= 0.0,
        }
    }

    fn contains(&self, p: DVec3) -> bool {
        let d = p - self.at;
        let left = |a: DVec3, b: DVec3| a.cross(b).dot(self.normal) > 0.0;
        if self.reflex {
            !(left(self.last, d) && left(d, self.first))
        } else {
            left(self.first, d) && left(d, self.last)
        }
    }

    fn angle(&self) -> f64 {
        let angle = angle_between(self.first, self.last);
        let angle = if angle.is_finite() { angle } else { 0.0 };
        if self.reflex { TAU - angle } else { angle }
    }
}

/// The closest pair of vertices of two outlines: their distance and indices. The distance is below `limit`. Pairs that see each
/// other across the gap take precedence; pairs at the same position do not count.
pub(super) fn nearest_pair(p: &Outline, q: &Outline, limit: f64) -> Option<(f64, usize, usize)> {
    let mut inside = (limit * limit, None);
    let mut any = (limit * limit, None);
    for (i, &a) in p.position.iter().enumerate() {
        for (j, &b) in q.position.iter().enumerate() {
            let d = a.distance_squared(b);
            if d < inside.0 && d > 0.0 {
                if d < any.0 {
                    any = (d, Some((i, j)));
                }
                if p.opens_towards(i, b) && q.opens_towards(j, a) {
                    inside = (d, Some((i, j)));
                }
            }
        }
    }
    let (d, pair) = if inside.1.is_some() { inside } else { any };
    pair.map(|(i, j)| (d.sqrt(), i, j))
}
