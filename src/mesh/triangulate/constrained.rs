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
