//! The part of a loop's surroundings that lies on one side of it.

use glam::DVec3;

/// An angle at a vertex, from one direction counter-clockwise to another.
pub(super) struct Sector {
    at: DVec3,
    first: DVec3,
    last: DVec3,
    normal: DVec3,
    reflex: bool,
}

impl Sector {
    /// At `at`, from the direction of `first` to that of `last`; the whole circle if they are the same.
    pub(super) fn new(at: DVec3, first: DVec3, last: DVec3, normal: DVec3) -> Self {
        let (first, last) = (first - at, last - at);
        Self {
            at,
            first,
            last,
            normal,
            reflex: first.cross(last).dot(normal) <= 0.0,
        }
    }

    /// Whether `p` lies in the direction of the sector.
    pub(super) fn contains(&self, p: DVec3) -> bool {
        let d = p - self.at;
        let left = |a: DVec3, b: DVec3| a.cross(b).dot(self.normal) > 0.0;
        if self.reflex {
            !(left(self.last, d) && left(d, self.first))
        } else {
            left(self.first, d) && left(d, self.last)
        }
    }
}

/// The pair of loop positions at the least distance below `limit` for which `allowed` holds and, if there is such a pair,
/// whose connection lies in the sector of both.
pub(super) fn nearest_pair(
    [p, q]: [&[DVec3]; 2],
    [s, t]: [&[Sector]; 2],
    limit: f64,
    allowed: impl Fn(usize, usize) -> bool,
) -> Option<(f64, usize, usize)> {
    let mut inside = (limit * limit, None);
    let mut any = (limit * limit, None);
    for (i, &a) in p.iter().enumerate() {
        for (j, &b) in q.iter().enumerate() {
            let d = a.distance_squared(b);
            if d < inside.0 && allowed(i, j) {
                if d < any.0 {
                    any = (d, Some((i, j)));
                }
                if s[i].contains(b) && t[j].contains(a) {
                    inside = (d, Some((i, j)));
                }
            }
        }
    }
    let (d, pair) = if inside.1.is_some() { inside } else { any };
    pair.map(|(i, j)| (d.sqrt(), i, j))
}
