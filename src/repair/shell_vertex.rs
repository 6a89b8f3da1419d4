//! The vertices of a layer: where they lie under the surface, and how deep.

use std::collections::HashSet;

use glam::DVec3;

use super::Edge;
use super::rounding::{Rounding, is_single};
use crate::mend::Inspection;
use crate::mesh::{VertexFaces, face_normal};
use crate::spatial::Bvh;
use crate::tuning::tuning;

/// A vertex under the surface.
pub(super) struct ShellVertex {
    pub(super) from: DVec3,
    pub(super) direction: DVec3,
    pub(super) depth: f64,
    /// The least depth that can be told from none.
    pub(super) min_depth: f64,
}

/// What a layer is to be made under.
pub(super) struct ShellBase<'a> {
    pub(super) found: &'a Inspection<'a>,
    pub(super) around: &'a VertexFaces,
    /// The faces.
    pub(super) faces: &'a [u32],
    /// Edges of the rims on which the layer hangs.
    pub(super) rims: &'a HashSet<Edge>,
    pub(super) rounding: Rounding,
    pub(super) shape: Shape,
    /// The faces of the mesh, where the depth is limited by what lies there.
    pub(super) bvh: Option<&'a Bvh>,
}

/// How deep a layer lies, and how it hangs on the rims.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// At this depth, in the mesh's units, with side walls at the rims.
    Walled(f64),
    /// At this depth; its outermost faces go up to the rims.
    Hanging(f64),
    /// A hair under the surface, by the edges there; its outermost faces go up to the rims.
    Hair,
}

impl Shape {
    /// The depth that is wanted; none where it goes by the edges.
    pub(super) fn depth(self) -> Option<f64> {
        match self {
            Self::Walled(depth) | Self::Hanging(depth) => Some(depth),
            Self::Hair => None,
        }
    }

    pub(super) fn has_sides(self) -> bool {
        matches!(self, Self::Walled(_))
    }
}

/// A vertex under one of the surface.
pub(super) fn below(base: &ShellBase, v: u32) -> ShellVertex {
    let mesh = &base.found.mesh;
    let piece = |f: u32| base.found.topology.component[f as usize];
    let at = |f: &u32| {
        base.faces
            .first()
            .is_some_and(|own| piece(*own) == piece(*f))
    };
    let faces: Vec<u32> = base.around.of(v).iter().copied().filter(at).collect();
    let from = mesh.positions[v as usize];
    let corners = faces.iter().flat_map(|f| mesh.corners(*f));
    let edges = corners.map(|q| q.distance(from)).filter(|d| *d > 0.0);
    let length = edges.fold(f64::INFINITY, f64::min);
    ShellVertex::new(base, from, &faces, length, base.around.of(v))
}

/// A vertex under a point of some faces, which lies on an edge or beside one.
pub(super) fn under(base: &ShellBase, from: DVec3, faces: &[u32], [a, b]: [u32; 2]) -> ShellVertex {
    let mesh = &base.found.mesh;
    let length = mesh.positions[a as usize].distance(mesh.positions[b as usize]);
    ShellVertex::new(base, from, faces, length, faces)
}

impl ShellBase<'_> {
    /// How deep a layer may lie under a point before it meets the next surface; half as deep where the surface there shows its back, under
    /// which another layer may lie. Layers that go through each other as a whole cross in few places: they could not be told to be too deep.
    fn room(&self, from: DVec3, direction: DVec3, own: &[u32]) -> f64 {
        let Some(bvh) = self.bvh.filter(|_| direction != DVec3::ZERO) else {
            return f64::INFINITY;
        };
        let next = bvh.first_along(from, direction, |f| !own.contains(&f));
        next.map_or(f64::INFINITY, |(f, distance)| {
            let shows_back = face_normal(&self.found.mesh, f).dot(direction) > 0.0;
            let part = tuning().repair.room * if shows_back { 0.5 } else { 1.0 };
            part * distance
        })
    }
}

impl ShellVertex {
    /// A vertex under a point of some faces, of whose edges the shortest has this `length`; all faces there are its `own`.
    fn new(base: &ShellBase, from: DVec3, faces: &[u32], length: f64, own: &[u32]) -> Self {
        let (mesh, rounding) = (&base.found.mesh, base.rounding);
        let normals: Vec<DVec3> = faces.iter().map(|f| face_normal(mesh, *f)).collect();
        let corners = faces.iter().flat_map(|f| mesh.corners(*f));
        let mut points = corners.chain([from]);
        let single = rounding.is_single() || points.all(is_single);
        let epsilon = match single {
            true => f64::from(f32::EPSILON),
            false => f64::EPSILON,
        };
        let min_depth = tuning().repair.least_apart * epsilon * from.abs().max_element();
        let direction = inward(&normals);
        let wanted = base.shape.depth();
        let depth = wanted.unwrap_or(tuning().repair.shell_depth * length);
        let room = base.room(from, direction, own);
        // A wall that is hardly there anywhere would be taken for one.
        let min_depth =
            min_depth.max(wanted.map_or(0.0, |depth| tuning().repair.wall_least * depth));
        Self {
            from,
            direction,
            depth: depth.min(room).max(min_depth),
            min_depth,
        }
    }
}

/// A direction that leads to the inside of all faces with these normals, where there is one (Rosenblatt's perceptron).
fn inward(normals: &[DVec3]) -> DVec3 {
    let mut direction = -normals.iter().sum::<DVec3>();
    for _ in 0..tuning().repair.shell_steps {
        let worst = normals.iter().max_by(|m, n| {
            let [m, n] = [m.dot(direction), n.dot(direction)];
            m.total_cmp(&n)
        });
        let Some(worst) = worst.filter(|n| n.dot(direction) > -0.1 * direction.length()) else {
            break;
        };
        direction -= *worst;
    }
    direction.normalize_or_zero()
}
