//! Constrained Delaunay triangulation of a plane polygon with inner points.

use glam::DVec2;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation, mitigate_underflow};

/// A triangulation of the plane with constraint edges.
type Triangles2 = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// The constrained Delaunay triangulation of the inside of an outline with inner points; all triangles are counter-clockwise.
/// Corners are indices into the outline, then inner points. `None` if the outline is not simple, or a point is on it or occurs
/// twice.
pub(crate) fn constrained_delaunay(outline: &[DVec2], inner: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let mut whole = Triangles2::new();
    let mut number = Vec::new();
    for (i, p) in outline.iter().chain(inner).enumerate() {
        // The triangulation refuses coordinates that are nearly zero, which symmetric parts may have.
        let at = mitigate_underflow(Point2::new(p.x, p.y));
        let handle = whole.insert(at).ok()?;
        if handle.index() != i {
            return None;
        }
        number.push(handle);
        // All constraint edges must exist before inner points are inserted.
        if i + 1 == outline.len() {
            for i in 0..outline.len() {
                let (a, b) = (number[i], number[(i + 1) % outline.len()]);
                if !whole.can_add_constraint(a, b) {
                    return None;
                }
                whole.add_constraint(a, b);
            }
        }
    }
    let is_out = outside(&whole);
    let inner = whole.inner_faces().filter(|f| !is_out[f.index()]);
    Some(
        inner
            .map(|f| f.vertices().map(|v| v.fix().index()))
            .collect(),
    )
}

/// The constrained Delaunay triangulation between simple loops, the first around the others; all triangles are counter-clockwise.
/// Corners are indices into all loops, one after the other. `None` if loops cross or touch.
pub(crate) fn constrained_between(loops: &[Vec<DVec2>]) -> Option<Vec<[usize; 3]>> {
    let mut whole = Triangles2::new();
    let mut number = Vec::new();
    for (i, p) in loops.iter().flatten().enumerate() {
        let at = mitigate_underflow(Point2::new(p.x, p.y));
        let handle = whole.insert(at).ok()?;
        if handle.index() != i {
            return None;
        }
        number.push(handle);
    }
    let mut first = 0;
    for own in loops {
        for i in 0..own.len() {
            let (a, b) = (number[first + i], number[first + (i + 1) % own.len()]);
            if !whole.can_add_constraint(a, b) {
                return None;
            }
            whole.add_constraint(a, b);
        }
        first += own.len();
    }
    // Inside is what lies in an odd number of loops.
    let is_inside = |p: DVec2| {
        let crosses = |a: DVec2, b: DVec2| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
        };
        let of_loop = |own: &Vec<DVec2>| {
            let next = own.iter().cycle().skip(1);
            own.iter()
                .zip(next)
                .filter(|(a, b)| crosses(**a, **b))
                .count()
        };
        loops.iter().map(of_loop).sum::<usize>() % 2 == 1
    };
    let points: Vec<DVec2> = loops.iter().flatten().copied().collect();
    let faces = whole.inner_faces();
    let faces = faces.map(|f| f.vertices().map(|v| v.fix().index()));
    let inside = faces.filter(|f| is_inside(f.iter().map(|i| points[*i]).sum::<DVec2>() / 3.0));
    Some(inside.collect())
}

/// For each face of a triangulation, whether it is connected to the outside through edges that are no constraints.
fn outside(whole: &Triangles2) -> Vec<bool> {
    let mut is_out = vec![false; whole.num_all_faces()];
    let mut front: Vec<_> = whole.convex_hull().map(|edge| edge.rev()).collect();
    front.retain(|edge| !edge.is_constraint_edge());
    while let Some(edge) = front.pop() {
        let face = edge.face();
        if face.is_outer() || std::mem::replace(&mut is_out[face.index()], true) {
            continue;
        }
        let sides = [edge.next(), edge.prev()];
        let open = sides.into_iter().filter(|side| !side.is_constraint_edge());
        front.extend(open.map(|side| side.rev()));
    }
    is_out
}
