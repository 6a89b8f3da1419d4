//! Inside/outside classification of the triangles of an arrangement by exact winding numbers.
//!
//! Triangles are joined across edges with two of them; the winding number on either side is constant over such a patch. It is
//! computed exactly once per patch, along a ray from a point of it. A point is inside if the winding number is positive; in a cluster
//! with much volume of negative winding numbers, parts of whose bodies are inside out, if it is not 0. A triangle is kept if exactly
//! one of its sides is inside, so the result is closed for any arrangement.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use rayon::prelude::*;

use super::arrange::Piece;
use super::exact::{Point, Points, Unit, rounded_turn, side, turn};
use super::planar::ArrangementError;
use crate::mesh::DisjointSets;
use crate::repair::witness::DOUBTFUL_DIFFERENCE;
use crate::spatial::{Bounds, BoxTree};
use crate::threads::{CollectFiltered, CollectIndexed};

/// Barycentric weights of a ray's origin in a triangle; the next ones are used if the ray passes through an edge.
const WEIGHTS: [[u32; 3]; 8] = [
    [37, 31, 29],
    [29, 41, 17],
    [13, 23, 59],
    [61, 19, 11],
    [101, 7, 43],
    [3, 97, 71],
    [127, 113, 5],
    [251, 83, 191],
];

/// What to do with a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    Goes,
    Stays,
    /// It stays, reversed.
    Turned,
}

/// The triangles of a closed surface, whole and divided, and the faces it was made of.
pub(super) struct ClosedSurface<'a> {
    /// Whether parts that are inside out may stay.
    pub(super) turns: bool,
    pub(super) points: &'a Points,
    pub(super) positions: &'a [DVec3],
    /// The corners of all triangles, and the multiplicity of each: occurrences minus reversed occurrences.
    pub(super) triangles: Vec<([u32; 3], i32)>,
    /// The undivided faces with their clusters; a ray counts the faces of its triangle's cluster.
    pub(super) faces: &'a [([DVec3; 3], u32)],
    /// The cluster of each triangle.
    pub(super) cluster: Vec<u32>,
}

/// The multiplicity of a triangle: the number of faces with its orientation minus the number of reversed ones.
pub(super) fn multiplicity(piece: &Piece) -> i32 {
    let one = |(_, same): &(u32, bool)| if *same { 1 } else { -1 };
    piece.faces.iter().map(one).sum()
}

impl ClosedSurface<'_> {
    /// The fate of each triangle.
    pub(super) fn fates(&self) -> Result<Vec<Fate>, ArrangementError> {
        let windings = self.windings()?;
        let reversed = match self.turns {
            true => self.reversed(&windings),
            false => HashSet::new(),
        };
        let fate = |t: usize| {
            let Some([front, back]) = windings[t] else {
                return Fate::Goes;
            };
            let counts_negative = reversed.contains(&self.cluster[t]);
            let is_inside = |winding: i32| winding > 0 || counts_negative && winding < 0;
            match (is_inside(front), is_inside(back)) {
                (false, true) => Fate::Stays,
                (true, false) => Fate::Turned,
                _ => Fate::Goes,
            }
        };
        Ok((0..windings.len())
            .into_par_iter()
            .map(fate)
            .collect_indexed())
    }

    /// The clusters in which the volume with negative winding numbers is too large for the pockets of a surface that intersects
    /// itself.
    fn reversed(&self, windings: &[Option<[i32; 2]>]) -> HashSet<u32> {
        let origin = self.positions.first().copied().unwrap_or_default();
        let mut volumes: HashMap<u32, [f64; 2]> = HashMap::new();
        for (t, sides) in windings.iter().enumerate() {
            let Some(sides) = sides else { continue };
            let [a, b, c] = self.triangles[t].0.map(|v| self.nearest(v) - origin);
            let cone = a.dot(b.cross(c)) / 6.0;
            let own = volumes.entry(self.cluster[t]).or_default();
            for (volume, sign) in own.iter_mut().zip([-1, 1]) {
                let [front, back] = sides.map(|w| f64::from(u8::from(w.signum() == sign)));
                *volume += (back - front) * cone;
            }
        }
        let least = DOUBTFUL_DIFFERENCE.get();
        let large = volumes.into_iter().filter(|(_, [n, p])| *n > least * p);
        large.map(|(cluster, _)| cluster).collect()
    }

    /// The winding numbers in front of each triangle and behind it; none for triangles that cancel out.
    fn windings(&self) -> Result<Vec<Option<[i32; 2]>>, ArrangementError> {
        let (mut patches, turned) = self.patches()?;
        let label: Vec<u32> = (0..self.triangles.len() as u32)
            .map(|t| patches.find(t))
            .collect();
        // The largest triangle of each patch is its sample.
        let mut sample: Vec<Option<(f64, u32)>> = vec![None; label.len()];
        for (t, &patch) in (0..).zip(&label) {
            if self.triangles[t as usize].1 == 0 {
                continue;
            }
            let own = (self.size(t), t);
            let best = &mut sample[patch as usize];
            if best.is_none_or(|(size, _)| size < own.0) {
                *best = Some(own);
            }
        }
        let boxes: Vec<Bounds> = self
            .faces
            .par_iter()
            .map(|f| Bounds::of(f.0))
            .collect_indexed();
        let tree = BoxTree::new(&boxes);
        // The winding number in front of each sample, by ray casting.
        let fronts: Result<Vec<Option<i32>>, ArrangementError> = sample
            .par_iter()
            .map(|sample| {
                let front =
                    |(_, t): &(f64, u32)| self.winding_in_front(*t, &tree).ok_or(ArrangementError);
                sample.as_ref().map(front).transpose()
            })
            .collect();
        let fronts = fronts?;
        let of = |t: usize| {
            let patch = label[t] as usize;
            let (front, (_, sample)) = fronts[patch].zip(sample[patch])?;
            let own = self.triangles[t].1;
            // If the triangle is reversed relative to the sample, its front is the sample's back.
            let front = match turned[t] == turned[sample as usize] {
                true => front,
                false => front + self.triangles[sample as usize].1,
            };
            Some([front, front + own])
        };
        Ok((0..label.len()).into_par_iter().map(of).collect_indexed())
    }

    /// Twice the area of a triangle, in floating-point arithmetic.
    fn size(&self, t: u32) -> f64 {
        let [a, b, c] = self.triangles[t as usize].0.map(|v| self.nearest(v));
        (b - a).cross(c - a).length()
    }

    fn nearest(&self, node: u32) -> DVec3 {
        match node.checked_sub(self.positions.len() as u32) {
            Some(point) => self.points.all[point as usize].nearest,
            None => self.positions[node as usize],
        }
    }

    /// Joins triangles across edges with exactly two of them, and returns for each whether it is reversed relative to its patch.
    /// Fails if the surface is not closed: along each edge as many triangles must run in one direction as in the other.
    fn patches(&self) -> Result<(DisjointSets, Vec<bool>), ArrangementError> {
        let count = self.triangles.len();
        let there = |t: &u32| self.triangles[*t as usize].1 != 0;
        let mut edges: Vec<(u64, u32, bool)> = (0..count as u32)
            .into_par_iter()
            .filter(there)
            .flat_map_iter(|t| {
                let corners = self.triangles[t as usize].0;
                (0..3).map(move |k| {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    let key = (u64::from(a.min(b)) << 32) | u64::from(a.max(b));
                    (key, t, a < b)
                })
            })
            .collect_filtered();
        edges.par_sort_unstable();
        // Check each edge's balance; edges with two triangles link them.
        let mut links: Vec<(u32, u32, bool)> = Vec::new();
        for edge in edges.chunk_by(|a, b| a.0 == b.0) {
            let run = |(_, t, along): &(u64, u32, bool)| {
                let times = self.triangles[*t as usize].1;
                if *along { times } else { -times }
            };
            if edge.iter().map(run).sum::<i32>() != 0 {
                return Err(ArrangementError);
            }
            if let [(_, s, a), (_, t, b)] = *edge {
                links.push((s, t, a == b));
            }
        }
        drop(edges);
        let mut sets = DisjointSets::new(count);
        links.iter().for_each(|(s, t, _)| _ = sets.join(*s, *t));
        Ok((sets, turned(count, &links)))
    }

    /// The winding number in front of a triangle, on the side of its normal.
    fn winding_in_front(&self, t: u32, tree: &BoxTree) -> Option<i32> {
        let (nodes, times) = self.triangles[t as usize];
        let base = self.positions.len() as u32;
        let points = nodes.map(|v| self.points.node(v, base, self.positions));
        let corners = [&points[0], &points[1], &points[2]];
        let [a, b, c] = nodes.map(|v| self.nearest(v));
        let size = (b - a).cross(c - a).abs();
        let mut axes = [0, 1, 2];
        axes.sort_by(|i, j| size[*j].total_cmp(&size[*i]));
        let mut ways = axes.into_iter().map(|k| (k, turn(k, corners)));
        let (axis, way) = ways.find(|(_, way)| *way != 0)?;
        for weights in WEIGHTS {
            let from = Point::inside(self.points.unit, corners, weights)?;
            let ray = Ray {
                unit: self.points.unit,
                axis,
                from,
            };
            if let Some(beyond) = self.winding_at(&ray, self.cluster[t as usize], tree) {
                // The ray leaves from the front or from the back of the triangle.
                return Some(if way > 0 { beyond } else { beyond - times });
            }
        }
        None
    }

    /// The winding number at the origin of a ray, just beyond the faces that contain the origin; none if the ray passes through
    /// an edge.
    fn winding_at(&self, ray: &Ray, cluster: u32, tree: &BoxTree) -> Option<i32> {
        let p = ray.from.nearest;
        let mut query = Bounds { low: p, high: p };
        for k in 0..3 {
            query.low[k] = p[k].next_down();
            query.high[k] = match k == ray.axis {
                true => f64::INFINITY,
                false => p[k].next_up(),
            };
        }
        let mut sum = Some(0);
        tree.find(&query, |f| {
            let (corners, own) = self.faces[f as usize];
            if own == cluster {
                match ray.crosses(corners) {
                    Some(way) => sum = sum.map(|s: i32| s + i32::from(way)),
                    None => sum = None,
                }
            }
            sum.is_none()
        });
        sum
    }
}

/// For each triangle whether it is reversed relative to the first triangle of its patch.
fn turned(count: usize, links: &[(u32, u32, bool)]) -> Vec<bool> {
    let mut turned = vec![false; count];
    if links.iter().all(|(_, _, against)| !against) {
        return turned;
    }
    let mut near: Vec<Vec<(u32, bool)>> = vec![Vec::new(); count];
    for &(s, t, against) in links {
        near[s as usize].push((t, against));
        near[t as usize].push((s, against));
    }
    let mut seen = vec![false; count];
    for first in 0..count as u32 {
        let mut stack = vec![first];
        while let Some(s) = stack.pop() {
            seen[s as usize] = true;
            for &(t, against) in &near[s as usize] {
                if !std::mem::replace(&mut seen[t as usize], true) {
                    turned[t as usize] = turned[s as usize] != against;
                    stack.push(t);
                }
            }
        }
    }
    turned
}

/// A ray in the positive direction of an axis.
struct Ray {
    unit: Unit,
    axis: usize,
    from: Point,
}

impl Ray {
    /// Whether the ray passes through a triangle from its back (1), from its front (-1) or not at all (0); none if it passes
    /// through an edge. A triangle that contains the origin does not count.
    fn crosses(&self, corners: [DVec3; 3]) -> Option<i8> {
        let p = &self.from;
        let mut sides = [0; 3];
        for k in 0..3 {
            let [a, b] = [corners[k], corners[(k + 1) % 3]];
            let known = rounded_turn(self.axis, [a, b, p.nearest]);
            sides[k] = known.unwrap_or_else(|| {
                let [a, b] = [a, b].map(|q| Point::vertex(self.unit, q));
                turn(self.axis, [&a, &b, p])
            });
            if sides[0] * sides[k] < 0 {
                return Some(0);
            }
        }
        if sides.contains(&1) && sides.contains(&-1) {
            return Some(0);
        }
        let height = side(self.unit, corners, p);
        match sides {
            // The triangle is seen edge-on.
            [0, 0, 0] => None,
            _ if sides.contains(&0) => {
                let way = sides[0] + sides[1] + sides[2];
                // Through an edge, but behind the origin.
                (height * way > 0).then_some(0)
            }
            [way, ..] => Some(match height * way {
                -1 => way,
                _ => 0,
            }),
        }
    }
}
