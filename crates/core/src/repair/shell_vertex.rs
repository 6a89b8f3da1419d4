//! Vertices of an offset shell: direction and depth below the surface.

use std::collections::HashSet;

use glam::DVec3;

use super::Edge;
use super::rounding::{Rounding, is_single};
use crate::mend::Inspection;
use crate::mesh::{VertexFaces, face_normal};
use crate::spatial::Bvh;
use crate::tuning::{Tunable, tunable};

/// Units in the last place of 32-bit floats. Separated vertices are moved apart by at least this.
pub(super) const LEAST_APART: Tunable<f64> = tunable("repair.least_apart", 16.0);

/// Shortest edges. Depth of an offset shell under the surface.
const SHELL_DEPTH: Tunable<f64> = tunable("repair.shell_depth", 0.1);

/// Fraction of the distance to the next surface below. Upper bound of the depth of a wall.
const ROOM: Tunable<f64> = tunable("repair.room", 0.8);

/// Fraction of the wanted depth. A wall that would have to be thinner anywhere is not made.
const WALL_LEAST: Tunable<f64> = tunable("repair.wall_least", 2e-4);

/// Steps of the search for a direction into the surface at a vertex, at most; twenty are rarely needed.
const SHELL_STEPS: Tunable<usize> = tunable("repair.shell_steps", 100);

/// A shell vertex below a point of the surface: `from + depth * direction`.
pub(super) struct ShellVertex {
    pub(super) from: DVec3,
    pub(super) direction: DVec3,
    pub(super) depth: f64,
    /// Smallest depth that differs from zero in the output's precision, and for walls a small fraction of the wanted depth.
    pub(super) min_depth: f64,
}

/// The surface below which an offset shell is made.
pub(super) struct ShellBase<'a> {
    pub(super) found: &'a Inspection<'a>,
    pub(super) around: &'a VertexFaces,
    /// The covered faces.
    pub(super) faces: &'a [u32],
    /// Edges of the rims to which the shell is attached.
    pub(super) rims: &'a HashSet<Edge>,
    pub(super) rounding: Rounding,
    pub(super) shape: Shape,
    /// The faces of the mesh, if they limit the depth.
    pub(super) bvh: Option<&'a Bvh>,
}

/// The depth of a shell, and how it is attached to the rims.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// At this depth (mesh units), with side walls at the rims.
    Walled(f64),
    /// At this depth; the outermost faces rise to the rims.
    Hanging(f64),
    /// At a small fraction of the local edge length; the outermost faces rise to the rims.
    Thin,
}

impl Shape {
    /// The wanted depth; none if it depends on the local edge length.
    pub(super) fn depth(self) -> Option<f64> {
        match self {
            Self::Walled(depth) | Self::Hanging(depth) => Some(depth),
            Self::Thin => None,
        }
    }

    pub(super) fn has_sides(self) -> bool {
        matches!(self, Self::Walled(_))
    }
}

/// The shell vertex below a mesh vertex.
pub(super) fn below(base: &ShellBase, v: u32) -> ShellVertex {
    let mesh = &base.found.mesh;
    let component = |f: u32| base.found.topology.component[f as usize];
    let at = |f: &u32| {
        base.faces
            .first()
            .is_some_and(|own| component(*own) == component(*f))
    };
    let faces: Vec<u32> = base.around.of(v).iter().copied().filter(at).collect();
    let from = mesh.positions[v as usize];
    let corners = faces.iter().flat_map(|f| mesh.corners(*f));
    let edges = corners.map(|q| q.distance(from)).filter(|d| *d > 0.0);
    let length = edges.fold(f64::INFINITY, f64::min);
    ShellVertex::new(base, from, &faces, length, base.around.of(v))
}

/// The shell vertex below a point of some faces, on the edge from `a` to `b` or near it.
pub(super) fn under(base: &ShellBase, from: DVec3, faces: &[u32], [a, b]: [u32; 2]) -> ShellVertex {
    let mesh = &base.found.mesh;
    let length = mesh.positions[a as usize].distance(mesh.positions[b as usize]);
    ShellVertex::new(base, from, faces, length, faces)
}

impl ShellBase<'_> {
    /// Upper bound of the depth below a point: a fraction of the distance to the next surface, and half of it if that surface
    /// shows its back, since another shell may lie there. Without a bound, shells that pass through each other entirely intersect
    /// in few places, which would not show that they are too deep.
    fn room(&self, from: DVec3, direction: DVec3, own: &[u32]) -> f64 {
        let Some(bvh) = self.bvh.filter(|_| direction != DVec3::ZERO) else {
            return f64::INFINITY;
        };
        let next = bvh.first_along(from, direction, |f| !own.contains(&f));
        next.map_or(f64::INFINITY, |(f, distance)| {
            let shows_back = face_normal(&self.found.mesh, f).dot(direction) > 0.0;
            let part = ROOM.get() * if shows_back { 0.5 } else { 1.0 };
            part * distance
        })
    }
}

impl ShellVertex {
    /// The shell vertex below a point of some faces. `length` is their shortest edge there; `own` are all faces at the point.
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
        let min_depth = LEAST_APART.get() * epsilon * from.abs().max_element();
        let direction = inward(&normals);
        let wanted = base.shape.depth();
        let depth = wanted.unwrap_or(SHELL_DEPTH.get() * length);
        let room = base.room(from, direction, own);
        // Below this depth a wall would be practically absent but still count as one.
        let min_depth = min_depth.max(wanted.map_or(0.0, |depth| WALL_LEAST.get() * depth));
        Self {
            from,
            direction,
            depth: depth.min(room).max(min_depth),
            min_depth,
        }
    }
}

/// A unit direction into the inside of all faces with these normals, if there is one (Rosenblatt's perceptron).
fn inward(normals: &[DVec3]) -> DVec3 {
    let mut direction = -normals.iter().sum::<DVec3>();
    for _ in 0..SHELL_STEPS.get() {
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
