//! The arrangement of intersecting faces: each face is divided along the segments in which it intersects others.
//!
//! Overlapping coplanar faces are divided together, so that their common part consists of the same triangles in each.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::exact::{Plane, Point, Points, Unit};
use super::pairs::{End, Face, Meeting, meeting};
use super::planar::{ArrangementError, Planar};
use crate::mesh::DisjointSets;
use crate::mesh::topology::NONE;
use crate::spatial::{Bounds, BoxTree};
use crate::threads::CollectIndexed;

/// A triangle of the arrangement.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Its corners: input vertices, or points, numbered after them.
    pub(super) nodes: [u32; 3],
    pub(super) faces: Owners,
}

/// The faces that a triangle is a part of, and whether each has its orientation.
type Owners = Vec<(u32, bool)>;

/// The triangles into which intersecting faces are divided.
pub(super) struct Arrangement {
    pub(super) points: Points,
    pub(super) pieces: Vec<Piece>,
}

/// The origin of a segment.
#[derive(Clone, Copy)]
enum Line {
    /// The intersection with this face.
    Face(u32),
    /// An edge of this face, which lies in the same plane.
    Edge(u32, usize),
}

/// The points and segments that divide a face.
#[derive(Clone, Default)]
struct Cuts {
    points: Vec<u32>,
    /// Segments, each with the face whose intersection it is.
    segments: Vec<([u32; 2], u32)>,
}

/// Divides faces, given by their vertices, along their intersections. `pairs` are the pairs of faces that intersect, `on_edges`
/// pairs of a face and a vertex that divides one of its edges.
pub(super) fn arrange(
    unit: Unit,
    positions: &[DVec3],
    faces: &[[u32; 3]],
    (pairs, on_edges): (&[[u32; 2]], &[(u32, u32)]),
) -> Result<Arrangement, ArrangementError> {
    let corners = |f: &[u32; 3]| f.map(|v| positions[v as usize]);
    let all: Option<Vec<Face>> = (faces.par_iter())
        .map(|f| Face::new(unit, *f, corners(f)))
        .collect();
    let all = all.ok_or(ArrangementError)?;
    // Exact end points of the intersection of each pair.
    let meetings: Vec<Meeting> = pairs
        .par_iter()
        .map(|&[f, g]| meeting(unit, &all[f as usize], &all[g as usize]))
        .collect_indexed();
    let mut points = Points::new(unit);
    for (face, v) in all.iter().flat_map(|f| f.vertices.iter().zip(f.corners)) {
        points.add_vertex(*face, v);
    }
    // Collect the segments of each face; coplanar faces form groups.
    let mut cuts = vec![Cuts::default(); all.len()];
    for &(f, v) in on_edges {
        let point = points.add_vertex(v, positions[v as usize]);
        cuts[f as usize].points.push(point);
    }
    let mut sets = DisjointSets::new(all.len());
    for (&[f, g], meeting) in pairs.iter().zip(meetings) {
        match meeting {
            Meeting::Coplanar => _ = sets.join(f, g),
            Meeting::Ends(ends) => {
                let ends = numbered(&mut points, positions, ends)?;
                for (own, other) in [(f, g), (g, f)] {
                    let cuts = &mut cuts[own as usize];
                    cuts.points.extend(&ends);
                    if let [a, b] = ends[..] {
                        cuts.segments.push(([a, b], other));
                    }
                }
            }
        }
    }
    let mut groups: Vec<Vec<u32>> = vec![Vec::new(); all.len()];
    for f in 0..all.len() as u32 {
        groups[sets.find(f) as usize].push(f);
    }
    groups.retain(|g| !g.is_empty());
    // Triangulate each group independently.
    let divided: Result<Vec<Divided>, ArrangementError> = groups
        .par_iter()
        .map(|members| Group::new(&all, &cuts, &points, members)?.divide())
        .collect();
    let mut pieces = Vec::new();
    for group in divided? {
        group.add_to(&mut points, &mut pieces, positions.len() as u32);
    }
    Ok(Arrangement { points, pieces })
}

/// The distinct point numbers of the ends of a segment.
fn numbered(
    points: &mut Points,
    positions: &[DVec3],
    ends: Vec<End>,
) -> Result<Vec<u32>, ArrangementError> {
    let mut numbers: Vec<u32> = Vec::new();
    for end in ends {
        numbers.push(match end {
            End::Vertex(v) => points.add_vertex(v, positions[v as usize]),
            End::New(point) => points.add(point),
        });
    }
    numbers.sort_unstable();
    numbers.dedup();
    if numbers.len() > 2 {
        return Err(ArrangementError);
    }
    Ok(numbers)
}

/// Coplanar faces that are divided together.
struct Group<'a> {
    all: &'a [Face],
    members: &'a [u32],
    unit: Unit,
    axis: usize,
    /// Global number of each local point; `u32::MAX` for the corners of the frame.
    number: Vec<u32>,
    points: Vec<Point>,
    segments: Vec<([u32; 2], Line)>,
}

/// The triangulation of a group.
struct Divided {
    number: Vec<u32>,
    new: Vec<Point>,
    triangles: Vec<([u32; 3], Owners)>,
}

impl<'a> Group<'a> {
    fn new(
        all: &'a [Face],
        cuts: &[Cuts],
        points: &Points,
        members: &'a [u32],
    ) -> Result<Self, ArrangementError> {
        let first = &all[members[0] as usize];
        let mut group = Self {
            all,
            members,
            unit: points.unit,
            axis: first.axis,
            number: Vec::new(),
            points: Vec::new(),
            segments: Vec::new(),
        };
        let mut local: HashMap<u32, u32> = HashMap::new();
        if members.len() > 1 {
            group.frame()?;
        }
        let mut of = |point: u32| {
            *local.entry(point).or_insert_with(|| {
                group.number.push(point);
                group.points.push(points.all[point as usize].clone());
                group.number.len() as u32 - 1
            })
        };
        let mut segments = Vec::new();
        for &f in members {
            let corners = all[f as usize].vertices.map(|v| of(points.of(v)));
            if members.len() > 1 {
                let edge = |k: usize| ([corners[k], corners[(k + 1) % 3]], Line::Edge(f, k));
                segments.extend([0, 1, 2].map(edge));
            }
        }
        for &f in members {
            let own = &cuts[f as usize];
            own.points.iter().for_each(|p| _ = of(*p));
            let line = |(ends, other): &([u32; 2], u32)| (ends.map(&mut of), Line::Face(*other));
            segments.extend(own.segments.iter().map(line));
        }
        group.segments = segments;
        Ok(group)
    }

    /// Adds a triangle that encloses all members, as the first three points.
    fn frame(&mut self) -> Result<(), ArrangementError> {
        let corners = self.members.iter().map(|f| self.all[*f as usize].corners);
        let (low, high) = crate::mesh::bounds(corners.flatten());
        let (i, j) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        let size = 2.0 * (high - low).max_element();
        for (x, y) in [(-3.0, -1.0), (3.0, -1.0), (0.0, 3.0)] {
            let mut p = DVec3::ZERO;
            p[i] = 0.5 * (low[i] + high[i]) + x * size;
            p[j] = 0.5 * (low[j] + high[j]) + y * size;
            self.points
                .push(Point::near(self.unit, p).ok_or(ArrangementError)?);
            self.number.push(NONE);
        }
        Ok(())
    }

    fn plane(&self, line: Line) -> Plane {
        match line {
            Line::Face(f) => self.all[f as usize].plane.clone(),
            Line::Edge(f, k) => {
                let t = self.all[f as usize].corners;
                Plane::along(self.unit, [t[k], t[(k + 1) % 3]], self.axis)
            }
        }
    }

    fn divide(mut self) -> Result<Divided, ArrangementError> {
        let count = self.points.len();
        let mut planar = Planar::new(self.axis, std::mem::take(&mut self.points));
        for v in 3..count as u32 {
            planar.insert(v)?;
        }
        let own = &self.all[self.members[0] as usize].plane;
        let line = |l: u32| self.plane(self.segments[l as usize].1);
        let mut meet = |l, m| Point::of_planes(self.unit, [own, &line(l), &line(m)]);
        for (l, (ends, _)) in (0..).zip(&self.segments) {
            planar.enforce(*ends, l, &mut meet)?;
        }
        planar.relax();
        let triangles = match self.members {
            [f] => planar.triangles().map(|t| (t, vec![(*f, true)])).collect(),
            _ => self.owned(&planar),
        };
        Ok(Divided {
            number: self.number,
            new: planar.points.split_off(count),
            triangles,
        })
    }

    /// The triangles that are parts of members, each with these members.
    fn owned(&self, planar: &Planar) -> Vec<([u32; 3], Owners)> {
        let boxes = self.members.iter();
        let boxes: Vec<Bounds> = boxes
            .map(|f| Bounds::of(self.all[*f as usize].corners))
            .collect();
        let tree = BoxTree::new(&boxes);
        let mut corners: Vec<[u32; 3]> = Vec::new();
        for ends in self.segments.chunks_exact(3).take(self.members.len()) {
            corners.push([0, 1, 2].map(|k: usize| ends[k].0[0]));
        }
        let way = |t: &[u32; 3]| planar.turn(t[0], t[1], t[2]);
        let ways: Vec<i8> = corners.iter().map(way).collect();
        let mut owned = Vec::new();
        for t in planar.triangles() {
            let place = Bounds::of(t.map(|v| planar.points[v as usize].nearest));
            let mut faces = Vec::new();
            tree.for_each(&place, |m| {
                let (own, way) = (corners[m as usize], ways[m as usize]);
                let holds =
                    |v: u32| (0..3).all(|k| way * planar.turn(own[k], own[(k + 1) % 3], v) >= 0);
                if boxes[m as usize].contains(&place) && t.into_iter().all(holds) {
                    faces.push((self.members[m as usize], way > 0));
                }
            });
            if !faces.is_empty() {
                faces.sort_unstable();
                owned.push((t, faces));
            }
        }
        owned
    }
}

impl Divided {
    fn add_to(self, points: &mut Points, pieces: &mut Vec<Piece>, base: u32) {
        let mut number = self.number;
        number.extend(self.new.into_iter().map(|p| points.add(p)));
        let node = |v: u32| {
            let point = number[v as usize];
            match points.vertex[point as usize] {
                NONE => base + point,
                vertex => vertex,
            }
        };
        for (corners, faces) in self.triangles {
            let nodes = corners.map(node);
            pieces.push(Piece { nodes, faces });
        }
    }
}
