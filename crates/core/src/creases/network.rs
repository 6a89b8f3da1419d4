//! The network of creases across a hole: from the sides of the rim's edges to crease lines, corners, and the parts of the patch
//! between them.

use glam::DVec3;

use super::CreaseRefusal;
use super::collar::Collar;
use super::segment::Sides;
use super::sheet::{Sheet, onto};
use crate::tuning::{Tunable, tunable};

/// Maximum step towards a crease, in diameters of the hole.
pub(super) const LONGEST_STEP: Tunable<f64> = tunable("creases.network.longest_step", 0.3);
/// Maximum step towards a corner, in diameters of the hole.
const LONGEST_CORNER_STEP: Tunable<f64> = tunable("creases.network.longest_corner_step", 0.2);
/// Maximum distance of a crease's end from its rim vertex, in edges.
const FARTHEST_END: Tunable<f64> = tunable("creases.network.farthest_end", 1.5);
/// Maximum distance of points of a crease from both sheets, in edges; a tenth of it for a corner.
pub(super) const ON_BOTH: Tunable<f64> = tunable("creases.network.on_both", 1e-2);
/// Maximum distance of a corner from the middle of the rim, in diameters of the hole.
pub(super) const FARTHEST_CORNER: Tunable<f64> = tunable("creases.network.farthest_corner", 0.9);
/// A corner closer than this to an end on the rim, in edges, coincides with that rim vertex.
const SAME_POINT: Tunable<f64> = tunable("creases.network.same_point", 0.3);
/// A rim vertex closer than this to both sheets and to a crease, in edges, is on the crease.
const ON_CREASE: Tunable<f64> = tunable("creases.network.on_crease", 0.05);
/// Minimum of the smallest singular value of the three unit normals at a corner: sheets at grazing angles do not determine a
/// corner.
const DETERMINED: Tunable<f64> = tunable("creases.network.determined", 0.15);

/// A part of the patch between creases: its side and its outline. Points of the rim are numbered first, then points of creases.
pub(super) struct Part {
    pub(super) side: usize,
    pub(super) outline: Vec<usize>,
}

/// A continued crease.
#[derive(Clone, Debug)]
pub(super) struct CreaseLine {
    /// Point numbers from end to end.
    pub(super) points: Vec<usize>,
    /// The sides that it separates.
    pub(super) sides: [usize; 2],
}

/// The parts of a patch and the creases between them.
pub(super) struct Network<'a> {
    pub(super) collar: &'a Collar,
    sides: &'a Sides,
    /// Minimum distance of a crease's inner points from its ends on the rim, in edges.
    lead: f64,
    /// Positions of the rim's points, then of crease points.
    pub(super) points: Vec<DVec3>,
    pub(super) parts: Vec<Part>,
    pub(super) lines: Vec<CreaseLine>,
}

/// A run of points with the same side: on the rim, or on the outline of the region that no part covers yet, which also contains
/// creases.
struct Arc {
    side: usize,
    points: Vec<usize>,
}

impl Arc {
    /// First and last point.
    fn ends(&self) -> [usize; 2] {
        [self.points[0], self.points[self.points.len() - 1]]
    }
}

impl<'a> Network<'a> {
    /// The network for given sides of the rim's edges.
    pub(super) fn new(
        collar: &'a Collar,
        sides: &'a Sides,
        labels: &[usize],
        lead: f64,
    ) -> Result<Self, CreaseRefusal> {
        let count = labels.len();
        let mut network = Self {
            collar,
            sides,
            lead,
            points: (0..count).map(|i| collar.rim_point(i)).collect(),
            parts: Vec::new(),
            lines: Vec::new(),
        };
        let ends = ends(labels);
        if ends.is_empty() {
            network.parts.push(Part {
                side: labels[0],
                outline: (0..count).collect(),
            });
            return Ok(network);
        }
        let arc = |j: usize| {
            let (from, to) = (ends[j], ends[(j + 1) % ends.len()]);
            let to = if to > from { to } else { to + count };
            Arc {
                side: labels[from],
                points: (from..=to).map(|i| i % count).collect(),
            }
        };
        network.join((0..ends.len()).map(arc).collect())?;
        Ok(network)
    }

    /// Cuts parts off until two arcs remain, which one crease separates. An arc between two arcs of the same side is cut off by a
    /// crease between its ends, shortest first; this determines which ends are paired. If there is none, an arc is cut off at the
    /// corner where it and its neighbours meet.
    fn join(&mut self, mut arcs: Vec<Arc>) -> Result<(), CreaseRefusal> {
        loop {
            let count = arcs.len();
            match &arcs[..] {
                [last] => {
                    self.add_part(last.side, last.points.clone());
                    return Ok(());
                }
                [a, b] => return self.part_two(a, b),
                _ => {}
            }
            let chord = |j: &usize| {
                let [first, last] = arcs[*j].ends();
                self.points[first].distance(self.points[last])
            };
            let is_between =
                |j: &usize| arcs[(j + count - 1) % count].side == arcs[(j + 1) % count].side;
            let between = (0..count).filter(is_between);
            let shortest = between.min_by(|a, b| chord(a).total_cmp(&chord(b)));
            arcs = match shortest {
                Some(j) => self.cut_off(arcs, j)?,
                None => self.cut_corner(arcs)?,
            };
        }
    }

    fn add_part(&mut self, side: usize, outline: Vec<usize>) {
        self.parts.push(Part { side, outline });
    }

    /// Divides the remaining region between its last two arcs.
    fn part_two(&mut self, a: &Arc, b: &Arc) -> Result<(), CreaseRefusal> {
        let [to, from] = a.ends();
        let line = match from == to {
            true => Vec::new(),
            false => self.line([from, to], [a.side, b.side])?,
        };
        for (arc, line) in [(b, line.iter().rev().copied().collect()), (a, line)] {
            let mut outline = [&arc.points[..], &line].concat();
            // Both arcs start and end at the same corner.
            if from == to {
                outline.pop();
            }
            self.add_part(arc.side, outline);
        }
        Ok(())
    }

    /// Cuts an arc off by a crease, which then belongs to the arc that joins its neighbours.
    fn cut_off(&mut self, arcs: Vec<Arc>, j: usize) -> Result<Vec<Arc>, CreaseRefusal> {
        let count = arcs.len();
        let (before, own, after) = (
            &arcs[(j + count - 1) % count],
            &arcs[j],
            &arcs[(j + 1) % count],
        );
        let (first, last) = (own.points[0], own.points[own.points.len() - 1]);
        let line = self.line([last, first], [before.side, own.side])?;
        self.add_part(own.side, [&own.points[..], &line].concat());
        let mut points = before.points[..before.points.len() - 1].to_vec();
        points.push(first);
        points.extend(line.iter().rev());
        points.push(last);
        points.extend(&after.points[1..]);
        let mut rest = vec![Arc {
            side: before.side,
            points,
        }];
        let mut others: Vec<Option<Arc>> = arcs.into_iter().map(Some).collect();
        rest.extend(
            (0..count.saturating_sub(3)).filter_map(|k| others[(j + 2 + k) % count].take()),
        );
        Ok(rest)
    }

    /// Cuts an arc off by the creases to the corner where its side and the sides of its neighbours meet. Of all arcs it takes the
    /// one whose corner is closest to its ends.
    fn cut_corner(&mut self, arcs: Vec<Arc>) -> Result<Vec<Arc>, CreaseRefusal> {
        let count = arcs.len();
        let triple = |j: usize| [(j + count - 1) % count, j, (j + 1) % count];
        let corner = |j: usize| {
            // The candidate corner of each arc, with its distance from the arc's ends.
            let [before, own, after] = triple(j).map(|k| &arcs[k]);
            let [first, last] = own.ends();
            let mut ends = vec![first, last];
            if count == 3 {
                ends.push(before.ends()[0]);
            }
            let corner = self.corner([before.side, own.side, after.side], &ends)?;
            let away = [first, last].map(|e| corner.distance(self.points[e]));
            Ok((away[0] + away[1], j, corner))
        };
        let corners: Vec<Result<_, CreaseRefusal>> = (0..count).map(corner).collect();
        let found = corners.iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
        let Some(&(_, j, corner)) = found else {
            return Err(if count == 3 {
                CreaseRefusal::NoCorner
            } else {
                CreaseRefusal::Arcs(count)
            });
        };
        // A corner at an end on the rim is that rim vertex; otherwise it is a new point.
        let near = SAME_POINT.get() * self.collar.rim_edge;
        let ends = arcs.iter().map(|arc| arc.ends()[0]);
        let same = ends
            .into_iter()
            .find(|&e| self.points[e].distance(corner) < near);
        let at = same.unwrap_or_else(|| self.add(vec![corner])[0]);
        let mut arcs: Vec<Arc> = arcs;
        let [before, own, after] = triple(j);
        let [first, last] = arcs[own].ends();
        let to_first = self.line_to(at, first, [arcs[before].side, arcs[own].side])?;
        let to_last = self.line_to(at, last, [arcs[own].side, arcs[after].side])?;
        // The outline of the part: the arc, the crease from its end to the corner, and the crease from there to its start.
        let back = to_last.iter().rev();
        let outline = arcs[own]
            .points
            .iter()
            .chain(back.skip(1))
            .chain(to_first.iter().skip(1));
        let mut outline: Vec<usize> = outline.copied().collect();
        outline.pop_if(|v| *v == first);
        self.add_part(arcs[own].side, outline);
        arcs[before].points.extend(to_first.iter().rev().skip(1));
        let points = [&to_last[..to_last.len() - 1], &arcs[after].points].concat();
        arcs[after].points = points;
        arcs.remove(own);
        Ok(arcs)
    }

    /// The points of the crease from a corner to an end, inclusive; a single point if they are the same.
    fn line_to(
        &mut self,
        corner: usize,
        end: usize,
        sides: [usize; 2],
    ) -> Result<Vec<usize>, CreaseRefusal> {
        if corner == end {
            return Ok(vec![end]);
        }
        let line = self.line([corner, end], sides)?;
        Ok([&[corner][..], &line, &[end]].concat())
    }

    /// The common zero of three sheets, starting from the mean of some rim points.
    fn corner(&self, sides: [usize; 3], ends: &[usize]) -> Result<DVec3, CreaseRefusal> {
        let collar = self.collar;
        let middle = ends.iter().map(|&e| self.points[e]).sum::<DVec3>() / ends.len() as f64;
        let sheets = sides.map(|s| self.sheet(s));
        let corner = onto(
            &sheets,
            middle,
            40,
            LONGEST_CORNER_STEP.get() * collar.diameter,
        );
        let off = sheets
            .iter()
            .map(|s| s.distance(corner).abs())
            .fold(0.0, f64::max);
        let least = least_singular_value(sheets.map(|s| s.normal(corner)));
        let is_far = corner.length() > FARTHEST_CORNER.get() * collar.diameter;
        // The comparison is false for NaN.
        let is_on_all = off <= 0.1 * ON_BOTH.get() * collar.rim_edge;
        match is_on_all && !is_far && least >= DETERMINED.get() {
            true => Ok(corner),
            false => Err(CreaseRefusal::NoCorner),
        }
    }

    /// The inner points of the crease between two rim points.
    fn line(
        &mut self,
        [from, to]: [usize; 2],
        sides: [usize; 2],
    ) -> Result<Vec<usize>, CreaseRefusal> {
        let (p, q) = (self.lead_point(from, sides)?, self.lead_point(to, sides)?);
        let mut points = self.curve(p, q, sides)?;
        self.drop_near(&mut points, from);
        points.reverse();
        self.drop_near(&mut points, to);
        points.reverse();
        let touched = self.touched(&points, [from, to], sides);
        let line = self.add_between(points, touched);
        self.lines.push(CreaseLine {
            points: [&[from][..], &line, &[to]].concat(),
            sides,
        });
        Ok(line)
    }

    /// Rim vertices on a crease between two others, with their parameter along its points.
    fn touched(
        &self,
        points: &[DVec3],
        [from, to]: [usize; 2],
        sides: [usize; 2],
    ) -> Vec<(f64, usize)> {
        let near = ON_CREASE.get() * self.collar.rim_edge;
        let ends = [self.points[from], self.points[to]];
        let all = [&ends[..1], points, &ends[1..]].concat();
        let is_on = |i: &usize| {
            let off = sides.map(|s| self.sheet(s).distance(self.points[*i]).abs());
            *i != from && *i != to && off.iter().all(|d| *d < near)
        };
        let place = |i: usize| {
            let p = self.points[i];
            let segment = |(k, w): (usize, &[DVec3])| {
                let along = w[1] - w[0];
                let t = (p - w[0]).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
                let t = t.clamp(0.0, 1.0);
                (p.distance(w[0] + t * along), k as f64 + t, i)
            };
            let segments = all.windows(2).enumerate().map(segment);
            let nearest = segments.min_by(|a, b| a.0.total_cmp(&b.0))?;
            (nearest.0 < near).then_some((nearest.1, i))
        };
        let rim = 0..self.collar.rim.len();
        rim.filter(is_on).filter_map(place).collect()
    }

    /// Adds the points of a crease, merged with the rim vertices that it touches; points next to these vertices are left out.
    fn add_between(&mut self, points: Vec<DVec3>, touched: Vec<(f64, usize)>) -> Vec<usize> {
        let near = 0.5 * self.collar.rim_edge;
        let is_far = |p: &DVec3| touched.iter().all(|t| self.points[t.1].distance(*p) > near);
        let (places, kept): (Vec<f64>, Vec<DVec3>) = points
            .into_iter()
            .enumerate()
            .filter(|(_, p)| is_far(p))
            .map(|(k, p)| (k as f64 + 1.0, p))
            .unzip();
        let added = places.into_iter().zip(self.add(kept));
        let mut all: Vec<(f64, usize)> = added.chain(touched).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.into_iter().map(|(_, i)| i).collect()
    }

    fn add(&mut self, points: Vec<DVec3>) -> Vec<usize> {
        let first = self.points.len();
        self.points.extend(points);
        (first..self.points.len()).collect()
    }

    /// Drops the first point if it is too close to the end point `end`.
    fn drop_near(&self, points: &mut Vec<DVec3>, end: usize) {
        let near = self.lead * self.collar.rim_edge;
        if points
            .first()
            .is_some_and(|p| p.distance(self.points[end]) < near)
        {
            points.remove(0);
        }
    }

    pub(super) fn sheet(&self, side: usize) -> &'a Sheet {
        &self.sides.list[side].sheet
    }

    /// The point of the crease closest to a rim point; on meshes with bevelled edges the rim point itself is not on the crease.
    fn lead_point(&self, end: usize, sides: [usize; 2]) -> Result<DVec3, CreaseRefusal> {
        let sheets = sides.map(|s| self.sheet(s));
        let point = onto(&sheets, self.points[end], 15, f64::INFINITY);
        match point.distance(self.points[end]) <= FARTHEST_END.get() * self.collar.rim_edge {
            true => Ok(point),
            false => Err(CreaseRefusal::EndOffCrease),
        }
    }
}

/// The simple loops of an outline that may touch itself: each point occurs once per loop.
pub(super) fn simple_loops(outline: &[usize]) -> Vec<Vec<usize>> {
    let mut loops = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    for &point in outline {
        if let Some(at) = open.iter().position(|p| *p == point) {
            loops.push(open.split_off(at));
        }
        open.push(point);
    }
    loops.push(open);
    loops.retain(|points| points.len() >= 3);
    loops
}

/// The positions where labels change: the vertices before which a new side starts.
pub(super) fn ends(labels: &[usize]) -> Vec<usize> {
    let count = labels.len();
    let changes = |i: &usize| labels[*i] != labels[(i + count - 1) % count];
    (0..count).filter(changes).collect()
}

/// The smallest singular value of the matrix with three vectors as rows.
fn least_singular_value(rows: [DVec3; 3]) -> f64 {
    let gram = rows.map(|a| rows.map(|b| a.dot(b)));
    let (squares, _) = crate::linalg::symmetric_eigen(&gram);
    squares[0].max(0.0).sqrt()
}
