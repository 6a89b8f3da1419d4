//! Intersections of pairs of triangles: a point or a segment with exact end points, or coplanar.

use glam::DVec3;
use robust::{Coord, Coord3D, orient2d, orient3d};

use super::exact::{Plane, Point, Unit};

/// A face with its plane and projection axis.
pub(super) struct Face {
    /// Its vertices.
    pub(super) vertices: [u32; 3],
    pub(super) corners: [DVec3; 3],
    pub(super) plane: Plane,
    /// The axis along which its projection has the largest area.
    pub(super) axis: usize,
}

impl Face {
    /// None if the corners are collinear.
    pub(super) fn new(unit: Unit, vertices: [u32; 3], corners: [DVec3; 3]) -> Option<Self> {
        let plane = Plane::of(unit, corners);
        let [a, b, c] = corners;
        let size = (b - a).cross(c - a).abs();
        let seen = (0..3).filter(|k| !plane.normal[*k].is_zero());
        let axis = seen.max_by(|i, j| size[*i].total_cmp(&size[*j]))?;
        Some(Self {
            vertices,
            corners,
            plane,
            axis,
        })
    }
}

/// An end point of the segment in which two faces intersect.
pub(super) enum End {
    /// A vertex of the input.
    Vertex(u32),
    New(Point),
}

/// How two faces meet.
pub(super) enum Meeting {
    /// They are coplanar.
    Coplanar,
    /// The end points: none, one (a single point), or the two of a segment.
    Ends(Vec<End>),
}

/// How two faces meet.
pub(super) fn meeting(unit: Unit, f: &Face, g: &Face) -> Meeting {
    let sides = |of: &Face, at: &Face| at.corners.map(|p| side(of.corners, p));
    let (s, t) = (sides(g, f), sides(f, g));
    if s == [0; 3] || t == [0; 3] {
        return Meeting::Coplanar;
    }
    let mut ends = Vec::new();
    collect(unit, f, g, s, &mut ends);
    collect(unit, g, f, t, &mut ends);
    Meeting::Ends(ends)
}

/// Collects the corners of `f` that lie on `g`, and the points where edges of `f` pass through `g`. If two edges intersect, the
/// calls in both directions find the point.
fn collect(unit: Unit, f: &Face, g: &Face, sides: [i8; 3], ends: &mut Vec<End>) {
    for k in 0..3 {
        let next = (k + 1) % 3;
        if sides[k] == 0 && contains(g, f.corners[k]) {
            ends.push(End::Vertex(f.vertices[k]));
        }
        if sides[k] * sides[next] < 0 {
            let edge = [f.corners[k], f.corners[next]];
            if passes(edge, g.corners)
                && let Some(point) = Point::on_segment(unit, edge, &g.plane)
            {
                ends.push(End::New(point));
            }
        }
    }
}

/// Whether an edge that intersects a triangle's plane passes through the closed triangle.
fn passes([a, b]: [DVec3; 2], t: [DVec3; 3]) -> bool {
    let s = [0, 1, 2].map(|k: usize| side([a, b, t[k]], t[(k + 1) % 3]));
    s.iter().all(|s| *s >= 0) || s.iter().all(|s| *s <= 0)
}

/// Whether a point in the plane of a face lies in the closed face.
fn contains(face: &Face, p: DVec3) -> bool {
    let (i, j) = ((face.axis + 1) % 3, (face.axis + 2) % 3);
    let at = |p: DVec3| Coord { x: p[i], y: p[j] };
    let t = face.corners;
    let s = [0, 1, 2].map(|k: usize| orient2d(at(t[k]), at(t[(k + 1) % 3]), at(p)));
    s.iter().all(|s| *s >= 0.0) || s.iter().all(|s| *s <= 0.0)
}

/// The side of a triangle's plane on which a point lies, exactly.
fn side(t: [DVec3; 3], p: DVec3) -> i8 {
    let [a, b, c, d] = [t[0], t[1], t[2], p].map(|p| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    });
    let s = orient3d(a, b, c, d);
    i8::from(s > 0.0) - i8::from(s < 0.0)
}
