//! The plane on which an open sheet is put.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::mesh::Hole;

/// The plane of a base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct BasePlane {
    /// The unit vector to which walls are parallel: along an axis, from the sheet to the base.
    down: DVec3,
    /// Component along it of the plane's points.
    level: f64,
}

impl BasePlane {
    /// The plane under the outer border of a sheet within these bounds: perpendicular to the axis that is nearest to the normal of the border,
    /// `offset` below the lowest vertex; without an offset by the mean edge of the border, so that the lowest place has a thickness.
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

    /// The point of the plane below a point.
    pub(super) fn below(&self, p: DVec3) -> DVec3 {
        // Exactly in the plane, with the other coordinates bit for bit.
        DVec3::select(
            self.down.abs().cmpgt(DVec3::ZERO),
            self.level * self.down,
            p,
        )
    }

    /// Coordinates within the plane, seen such that a base that faces down turns to the left.
    pub(super) fn flat(&self, p: DVec3) -> DVec2 {
        let x = self.down.any_orthonormal_vector();
        DVec2::new(p.dot(x), p.dot(self.down.cross(x)))
    }
}
