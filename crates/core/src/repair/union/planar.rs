//! Constrained triangulation of points in a plane, with exact predicates.
//!
//! Points are inserted one by one; then each constrained edge is enforced by flips (Sloan, "A fast algorithm for generating
//! constrained Delaunay triangulations", 1993). Where two constrained edges intersect, the exact intersection point becomes a
//! vertex of both. Finally flips in floating-point arithmetic bring the triangulation near the Delaunay one, as long as all
//! triangles keep their exact orientation.

#[cfg(test)]
mod tests;

use std::cmp::Ordering;
use std::collections::VecDeque;

use super::exact::{Point, turn};
use crate::elementary::hypot;
use crate::mesh::topology::NONE;

/// A triangulation; half-edge `3 t + k` runs from corner `k` of triangle `t` to the next one.
pub(super) struct Planar {
    /// The projection axis, and whether orientations are reversed so that all triangles count as counter-clockwise.
    axis: usize,
    mirrored: bool,
    pub(super) points: Vec<Point>,
    /// The start point of each half-edge.
    from: Vec<u32>,
    /// The opposite half-edge; `u32::MAX` at the rim.
    twin: Vec<u32>,
    /// The constraint line of each half-edge; `u32::MAX` if it is not constrained.
    line: Vec<u32>,
    /// A half-edge that starts at each point; `u32::MAX` for points not inserted yet.
    leaving: Vec<u32>,
    last: u32,
}

/// The triangulation failed: a point is outside it, or the limit of steps was exceeded.
#[derive(Debug)]
pub(super) struct ArrangementError;

/// The location of a point.
enum Place {
    Corner,
    Edge(u32),
    Face(u32),
}

/// How a segment continues from a vertex.
enum Way {
    /// Along this half-edge.
    Along(u32),
    /// Through the next triangle, across this half-edge; its start is on the right.
    Across(u32),
}

fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

fn previous(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl Planar {
    /// The triangle of the first three points.
    pub(super) fn new(axis: usize, points: Vec<Point>) -> Self {
        let [a, b, c] = [0, 1, 2].map(|i: usize| &points[i]);
        Self {
            axis,
            mirrored: turn(axis, [a, b, c]) < 0,
            leaving: (0..points.len() as u32)
                .map(|i| if i < 3 { i } else { NONE })
                .collect(),
            points,
            from: vec![0, 1, 2],
            twin: vec![NONE; 3],
            line: vec![NONE; 3],
            last: 0,
        }
    }

    /// The triangles.
    pub(super) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.from.chunks_exact(3).map(|t| [t[0], t[1], t[2]])
    }

    /// The orientation of three points: 1 if counter-clockwise.
    pub(super) fn turn(&self, a: u32, b: u32, c: u32) -> i8 {
        let seen = turn(self.axis, [a, b, c].map(|i: u32| &self.points[i as usize]));
        if self.mirrored { -seen } else { seen }
    }

    fn to(&self, h: u32) -> u32 {
        self.from[next(h) as usize]
    }

    fn start(&self, h: u32) -> u32 {
        self.from[h as usize]
    }

    fn other(&self, h: u32) -> u32 {
        self.twin[h as usize]
    }

    /// Connects two half-edges as the sides of an edge.
    fn join(&mut self, h: u32, twin: u32, line: u32) {
        for (h, twin) in [(h, twin), (twin, h)] {
            if h != NONE {
                self.twin[h as usize] = twin;
                self.line[h as usize] = line;
            }
        }
    }

    /// Inserts a point.
    pub(super) fn insert(&mut self, point: u32) -> Result<(), ArrangementError> {
        if self.leaving[point as usize] != NONE {
            return Ok(());
        }
        match self.locate(point)? {
            Place::Corner => Err(ArrangementError),
            Place::Edge(h) => {
                self.split_edge(h, point);
                Ok(())
            }
            Place::Face(t) => {
                self.split_face(t, point);
                Ok(())
            }
        }
    }

    /// The location of a point in a triangle, or a half-edge that has the point on its outer side.
    fn place_in(&self, t: u32, point: u32, first: u32) -> Result<Place, u32> {
        let mut on = [NONE; 2];
        let mut count = 0;
        for k in 0..3 {
            let h = 3 * t + (first + k) % 3;
            match self.turn(self.start(h), self.to(h), point) {
                0 if count < 2 => {
                    on[count] = h;
                    count += 1;
                }
                1 => {}
                _ => return Err(h),
            }
        }
        Ok(match on {
            [NONE, _] => Place::Face(t),
            [h, NONE] => Place::Edge(h),
            _ => Place::Corner,
        })
    }

    /// Walks towards a point. The order in which edges are tested varies pseudo-randomly, since the walk could otherwise cycle.
    fn locate(&mut self, point: u32) -> Result<Place, ArrangementError> {
        let count = self.from.len() as u32 / 3;
        let mut t = self.last.min(count - 1);
        let mut seed = point;
        for _ in 0..64 + 4 * count {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            match self.place_in(t, point, (seed >> 16) % 3) {
                Ok(place) => {
                    self.last = t;
                    return Ok(place);
                }
                Err(h) if self.other(h) != NONE => t = self.other(h) / 3,
                Err(_) => return Err(ArrangementError),
            }
        }
        let found = (0..count).find_map(|t| self.place_in(t, point, 0).ok());
        found.ok_or(ArrangementError)
    }

    /// Adds a triangle; its edges are not connected yet.
    fn add(&mut self, corners: [u32; 3]) -> u32 {
        let h = self.from.len() as u32;
        self.from.extend(corners);
        self.twin.extend([NONE; 3]);
        self.line.extend([NONE; 3]);
        h
    }

    /// Replaces the corners of a triangle; its edges must be connected afterwards.
    fn set(&mut self, t: u32, corners: [u32; 3]) {
        for (h, corner) in (3 * t..).zip(corners) {
            self.from[h as usize] = corner;
            self.leaving[corner as usize] = h;
        }
    }

    fn split_face(&mut self, t: u32, point: u32) {
        let h = [3 * t, 3 * t + 1, 3 * t + 2];
        let corner = h.map(|h| self.start(h));
        let outer = h.map(|h| (self.other(h), self.line[h as usize]));
        let new = [
            3 * t,
            self.add([corner[1], corner[2], point]),
            self.add([corner[2], corner[0], point]),
        ];
        self.set(t, [corner[0], corner[1], point]);
        self.leaving[corner[2] as usize] = new[2];
        for k in 0..3 {
            self.join(new[k], outer[k].0, outer[k].1);
            self.join(next(new[k]), previous(new[(k + 1) % 3]), NONE);
        }
    }

    /// Inserts a point on an edge and splits each adjacent triangle in two.
    fn split_edge(&mut self, h: u32, point: u32) {
        let (o, line) = (self.other(h), self.line[h as usize]);
        let mut halves = [[NONE; 2]; 2];
        for (side, h) in [h, o].into_iter().enumerate() {
            if h == NONE {
                continue;
            }
            let (a, b, apex) = (self.start(h), self.to(h), self.start(previous(h)));
            let (far, near) = (next(h), previous(h));
            let far = (self.other(far), self.line[far as usize]);
            let near = (self.other(near), self.line[near as usize]);
            let t = h / 3;
            let new = self.add([point, b, apex]);
            self.set(t, [a, point, apex]);
            self.leaving[b as usize] = new + 1;
            self.join(new + 1, far.0, far.1);
            self.join(3 * t + 2, near.0, near.1);
            self.join(3 * t + 1, new + 2, NONE);
            halves[side] = [3 * t, new];
        }
        let [[a, b], [c, d]] = halves;
        self.join(a, d, line);
        self.join(b, c, line);
    }

    /// The half-edges that start at a point.
    fn around(&self, point: u32) -> Vec<u32> {
        let first = self.leaving[point as usize];
        let mut all = vec![first];
        let mut h = first;
        // Go counter-clockwise, then clockwise if the rim was reached.
        loop {
            h = self.other(previous(h));
            if h == NONE {
                break;
            }
            if h == first {
                return all;
            }
            all.push(h);
        }
        h = first;
        loop {
            let o = self.other(h);
            if o == NONE {
                return all;
            }
            h = next(o);
            all.push(h);
        }
    }

    /// The half-edge between two points.
    fn edge(&self, a: u32, b: u32) -> Option<u32> {
        self.around(a).into_iter().find_map(|h| {
            if self.to(h) == b {
                Some(h)
            } else {
                (self.start(previous(h)) == b).then_some(previous(h))
            }
        })
    }

    /// Whether `point`, on the line through `a` and `b`, is on the same side of `a` as `b`.
    fn is_ahead(&self, a: u32, b: u32, point: u32) -> bool {
        let [p, q, x] = [a, b, point].map(|i| &self.points[i as usize]);
        let axes = [(self.axis + 1) % 3, (self.axis + 2) % 3];
        let ways = axes.map(|k| (q.compare(p, k), x.compare(p, k)));
        let way = ways.iter().find(|(way, _)| *way != Ordering::Equal);
        way.is_some_and(|(b, x)| b == x)
    }

    fn way(&self, a: u32, b: u32) -> Option<Way> {
        for h in self.around(a) {
            let (right, left) = (self.to(h), self.start(previous(h)));
            let (r, l) = (self.turn(a, b, right), self.turn(a, b, left));
            if right == b || (r == 0 && self.is_ahead(a, b, right)) {
                return Some(Way::Along(h));
            }
            if left == b || (l == 0 && self.is_ahead(a, b, left)) {
                return Some(Way::Along(previous(h)));
            }
            if r < 0 && l > 0 {
                return Some(Way::Across(next(h)));
            }
        }
        None
    }

    /// Makes the segment between two points a chain of edges on `line`. `meet` returns the intersection point of two lines.
    pub(super) fn enforce(
        &mut self,
        [mut a, b]: [u32; 2],
        line: u32,
        meet: &mut dyn FnMut(u32, u32) -> Option<Point>,
    ) -> Result<(), ArrangementError> {
        while a != b {
            match self.way(a, b).ok_or(ArrangementError)? {
                Way::Along(h) => {
                    let end = if self.start(h) == a {
                        self.to(h)
                    } else {
                        self.start(h)
                    };
                    if self.line[h as usize] == NONE {
                        let o = self.other(h);
                        self.join(h, o, line);
                    }
                    a = end;
                }
                Way::Across(h) => {
                    let (crossed, end) = self.crossed([a, b], h, line, meet)?;
                    self.clear([a, end], crossed)?;
                    let h = self.edge(a, end).ok_or(ArrangementError)?;
                    let o = self.other(h);
                    self.join(h, o, line);
                    a = end;
                }
            }
        }
        Ok(())
    }

    /// The edges that a segment crosses up to the next vertex on it, and this vertex. A constrained edge is split at the
    /// intersection point.
    fn crossed(
        &mut self,
        [a, b]: [u32; 2],
        mut h: u32,
        line: u32,
        meet: &mut dyn FnMut(u32, u32) -> Option<Point>,
    ) -> Result<(VecDeque<[u32; 2]>, u32), ArrangementError> {
        let mut crossed = VecDeque::new();
        loop {
            if self.line[h as usize] != NONE {
                let point = meet(line, self.line[h as usize]).ok_or(ArrangementError)?;
                let new = self.points.len() as u32;
                self.points.push(point);
                self.leaving.push(NONE);
                self.split_edge(h, new);
                return Ok((crossed, new));
            }
            crossed.push_back([self.start(h), self.to(h)]);
            let o = self.other(h);
            if o == NONE {
                return Err(ArrangementError);
            }
            let apex = self.start(previous(o));
            let side = if apex == b { 0 } else { self.turn(a, b, apex) };
            h = match side {
                0 => return Ok((crossed, apex)),
                1 => next(o),
                _ => previous(o),
            };
        }
    }

    /// Flips edges until none crosses a segment (Sloan 1993).
    fn clear(
        &mut self,
        [a, b]: [u32; 2],
        mut crossed: VecDeque<[u32; 2]>,
    ) -> Result<(), ArrangementError> {
        let most = 64 + 8 * crossed.len() * crossed.len();
        for _ in 0..most {
            let Some([p, q]) = crossed.pop_front() else {
                return Ok(());
            };
            let h = self.edge(p, q).ok_or(ArrangementError)?;
            let Some([l, r]) = self.flip(h) else {
                crossed.push_back([p, q]);
                continue;
            };
            let ends = [l, r].iter().any(|v| *v == a || *v == b);
            if !ends && self.turn(a, b, l) * self.turn(a, b, r) < 0 {
                crossed.push_back([l, r]);
            }
        }
        Err(ArrangementError)
    }

    /// Flips an edge between two triangles that form a strictly convex quadrilateral; returns the ends of the new edge.
    fn flip(&mut self, h: u32) -> Option<[u32; 2]> {
        let o = self.other(h);
        if o == NONE || self.line[h as usize] != NONE {
            return None;
        }
        let (p, q) = (self.start(h), self.to(h));
        let (l, r) = (self.start(previous(h)), self.start(previous(o)));
        if self.turn(r, q, l) <= 0 || self.turn(l, p, r) <= 0 {
            return None;
        }
        let outer = [next(h), previous(h), next(o), previous(o)]
            .map(|h| (self.other(h), self.line[h as usize]));
        let (t, u) = (h / 3, o / 3);
        self.set(t, [q, l, r]);
        self.set(u, [p, r, l]);
        let new = [3 * t, 3 * u + 2, 3 * u, 3 * t + 2];
        for (h, (twin, line)) in new.into_iter().zip(outer) {
            self.join(h, twin, line);
        }
        self.join(3 * t + 1, 3 * u + 1, NONE);
        Some([l, r])
    }

    /// Flips unconstrained edges that violate the Delaunay condition, in floating-point arithmetic.
    pub(super) fn relax(&mut self) {
        let mut queue: VecDeque<u32> = (0..self.from.len() as u32).collect();
        let most = 16 * queue.len();
        for _ in 0..most {
            let Some(h) = queue.pop_front() else {
                return;
            };
            let o = self.other(h);
            if o == NONE || self.line[h as usize] != NONE || !self.is_bad(h, o) {
                continue;
            }
            if self.flip(h).is_some() {
                let around = [h / 3, o / 3].map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
                queue.extend(around.into_iter().flatten());
            }
        }
    }

    /// Whether the angles opposite an edge sum to clearly more than 180 degrees.
    fn is_bad(&self, h: u32, o: u32) -> bool {
        let at = |i: u32| self.points[i as usize].nearest;
        let (p, q) = (at(self.start(h)), at(self.to(h)));
        let [(c, s), (d, t)] = [h, o].map(|h| {
            let apex = at(self.start(previous(h)));
            let (u, v) = (p - apex, q - apex);
            (u.dot(v), u.cross(v).length())
        });
        // The sine of the sum times the lengths of the four edges, compared relative to them.
        s * d + t * c < -1e-9 * (hypot(c, s) * hypot(d, t))
    }
}
