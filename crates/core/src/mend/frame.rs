//! The frame of a region: origin, axes and unit of length from its rims alone. A region is solved in its frame, so that its patch does
//! not depend on the position, orientation, handedness and scale of the mesh, nor on the order of its vertices and faces.

use glam::{DMat3, DVec3};

use crate::mesh::{Hole, Mesh};

/// Steps of the grid to which coordinates are rounded, per unit of length. The step, 1e-9 of a hole's diameter, is finer than 32-bit
/// floats resolve it, and 10⁶ times coarser than the rounding errors of a rotation: rotated and scaled meshes get equal coordinates.
const STEPS: f64 = (1u64 << 30) as f64;
/// Lower bound of the rims' vector area, over the sum of the areas of the triangles from the origin to their edges. Rims that
/// enclose less, such as the two ends of a missing length of tube, have no normal of their own.
const LEAST_AREA: f64 = 0.1;
/// Lower bound of the mean sine of the angle between the surface at the rims and their plane. A smaller one does not tell the sides of
/// the plane apart.
const LEVEL: f64 = 0.01;
/// Lower bound of the distance of the rims from a line, and of a vertex from their plane, in their radii.
const COLLINEAR: f64 = 1e-6;

/// Fraction of their length by which vectors that are as long differ at most.
const EQUAL: f64 = 1e-9;
/// A direction along which no two vertices of common shapes are equally far.
const TIES: DVec3 = DVec3::new(0.619, 0.267, 0.739);

/// The frame of a region.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    origin: DVec3,
    /// Unit vectors along the axes, as columns. The third is the normal of the rims, if they have one.
    axes: DMat3,
    /// The length of a unit: twice the largest distance of a rim's vertex from the origin.
    unit: f64,
    /// Whether it turns faces over, so that the rims' normal is along the third axis: a mesh, its mirror image and its inside-out copy
    /// become the same mesh.
    turns: bool,
}

impl Frame {
    /// The frame of some holes; none where their rims are nearly on a line.
    ///
    /// Every direction is to a vertex that is extreme in some way, or a sum over the rims: rounding errors do not grow.
    pub(super) fn new(mesh: &Mesh, holes: &[&Hole]) -> Option<Self> {
        let at = |v: u32| mesh.positions[v as usize];
        let edges = || {
            holes.iter().flat_map(|hole| {
                let next = hole.rim.iter().cycle().skip(1);
                hole.rim.iter().zip(next).map(|(&v, &w)| (at(v), at(w)))
            })
        };
        let length: f64 = edges().map(|(a, b)| a.distance(b)).sum();
        // Sums relative to one of the vertices keep their digits far from the origin of coordinates.
        let start = edges().next()?.0;
        let weighted = edges().map(|(a, b)| a.distance(b) * (0.5 * (a + b) - start));
        let origin = start + weighted.sum::<DVec3>() / length;
        let points = || edges().map(|(a, _)| a - origin);
        let radius = points().map(DVec3::length).fold(0.0, f64::max);
        let parts = || edges().map(|(a, b)| (a - origin).cross(b - origin) / radius.powi(2));
        let area: DVec3 = parts().sum();
        let has_normal = area.length() > LEAST_AREA * parts().map(DVec3::length).sum::<f64>();
        let normal = has_normal.then(|| area.normalize_or_zero());

        let across = |p: DVec3| normal.map_or(p, |n| p - p.dot(n) * n);
        let first = farthest(points().map(across))?.normalize_or_zero();
        let beside = |p: DVec3| across(p) - p.dot(first) * first;
        let second = farthest(points().map(beside))?;
        if !(radius.is_finite() && second.length() > COLLINEAR * radius) {
            return None;
        }
        let second = (second - second.dot(first) * first).normalize_or_zero();
        let upright = normal.unwrap_or_else(|| first.cross(second));
        let third = upright * side(upright, radius, holes, points());
        // The direction to the farthest vertex is a diagonal of the voxels.
        let [first, second] = [first + second, second - first].map(DVec3::normalize_or_zero);
        let axes = DMat3::from_cols(first, second, third);
        // The normal of the rims in the frame, before faces are turned, is along `axes.determinant() · axesᵀ normal`.
        let upwards = normal.map_or(1.0, |normal| normal.dot(third));
        let turns = axes.determinant() * upwards < 0.0;
        let new = Self {
            origin,
            axes,
            unit: 2.0 * radius,
            turns,
        };
        (new.axes.is_finite() && origin.is_finite()).then_some(new)
    }

    /// Whether it turns the orientation of faces over.
    pub(super) fn turns_faces(&self) -> bool {
        self.turns
    }

    /// A point of the mesh in the frame, rounded.
    pub(super) fn of_world(&self, p: DVec3) -> DVec3 {
        let p = self.axes.transpose() * ((p - self.origin) / self.unit);
        // The sum turns -0 into 0.
        (STEPS * p).round() / STEPS + 0.0
    }

    /// A point of the frame in the mesh's coordinates.
    pub(super) fn to_world(self, p: DVec3) -> DVec3 {
        self.origin + self.unit * (self.axes * p)
    }
}

/// 1 or -1: the side of the rims' plane to which their surroundings continue, or else on which a rim's vertex is farthest from it. It
/// does not depend on the orientation of the faces.
fn side(upright: DVec3, radius: f64, holes: &[&Hole], points: impl Iterator<Item = DVec3>) -> f64 {
    let conormals = || holes.iter().flat_map(|hole| &hole.conormals);
    let tilt: f64 = conormals().map(|c| c.dot(upright)).sum();
    if tilt.abs() > LEVEL * conormals().count() as f64 {
        return 1f64.copysign(tilt);
    }
    let heights = points.map(|p| p.dot(upright) * upright);
    let highest = farthest(heights).unwrap_or(DVec3::ZERO);
    match highest.length() > COLLINEAR * radius {
        true => 1f64.copysign(highest.dot(upright)),
        false => 1.0,
    }
}

/// The longest of some vectors. Of vectors that are as long, as symmetric rims have them, the one that is farthest along a direction:
/// then the frame does not depend on the order of vertices, only on the position of the rims.
fn farthest(vectors: impl Iterator<Item = DVec3>) -> Option<DVec3> {
    let all: Vec<DVec3> = vectors.collect();
    let longest = all.iter().map(|v| v.length()).fold(0.0, f64::max);
    let is_long = |v: &&DVec3| v.length() >= (1.0 - EQUAL) * longest;
    let along = |v: &DVec3| v.dot(TIES);
    let last = |a: &&DVec3, b: &&DVec3| along(a).total_cmp(&along(b));
    all.iter().filter(is_long).max_by(last).copied()
}
