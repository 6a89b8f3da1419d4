//! The plane of the flat base under an open sheet.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::mesh::Hole;

/// The plane of a base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct BasePlane {
    /// Unit vector along a coordinate axis, from the sheet to the base; walls are parallel to it.
    down: DVec3,
    /// Signed distance of the plane from the origin along `down`.
    level: f64,
}

impl BasePlane {
    /// The plane under the outer border of a sheet with these bounds: perpendicular to the coordinate axis nearest to the
    /// border's normal, `offset` below the lowest vertex. Without an offset, the mean edge length of the border, so that the
    /// sheet has a thickness at its lowest point.
    pub(crate) fn new(hole: &Hole, (low, high): (DVec3, DVec3), offset: Option<f64>) -> Self {
        let normal = hole.normal.to_array();
        let largest = (0..3).max_by(|&i, &j| normal[i].abs().total_cmp(&normal[j].abs()));
        let axis = largest.unwrap_or(2);
        let mut down = DVec3::ZERO;
        down[axis] = normal[axis].signum();
        let lowest = f64::max(low.dot(down), high.dot(down));
        let offset = offset.unwrap_or(hole.length / hole.edges.max(1) as f64);
        Self {
            down,
            level: lowest + offset,
        }
    }

    /// The projection of a point to the plane.
    pub(super) fn below(&self, p: DVec3) -> DVec3 {
        // Exactly in the plane; the other coordinates keep their bits.
        DVec3::select(
            self.down.abs().cmpgt(DVec3::ZERO),
            self.level * self.down,
            p,
        )
    }

    /// Coordinates within the plane, oriented so that a base that faces down is counterclockwise.
    pub(super) fn flat(&self, p: DVec3) -> DVec2 {
        let x = self.down.any_orthonormal_vector();
        DVec2::new(p.dot(x), p.dot(self.down.cross(x)))
    }
}
