//! Rigid motions, reflections and scalings of space.

use glam::{DMat3, DQuat, DVec3};

use crate::mesh::Mesh;

/// `x ↦ A x + b`, `A` being an orthogonal matrix times a scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    pub(super) matrix: DMat3,
    pub(super) shift: DVec3,
}

impl Motion {
    pub(super) const IDENTITY: Self = Self {
        matrix: DMat3::IDENTITY,
        shift: DVec3::ZERO,
    };

    /// The reflection in the plane through a point with a unit normal.
    pub(super) fn reflection(point: DVec3, normal: DVec3) -> Self {
        let twice = 2.0 * normal;
        let matrix = DMat3::IDENTITY
            - DMat3::from_cols(twice * normal.x, twice * normal.y, twice * normal.z);
        Self {
            matrix,
            shift: twice * normal.dot(point),
        }
    }

    /// A matrix about a point that goes to another one.
    pub(super) fn about(matrix: DMat3, from: DVec3, to: DVec3) -> Self {
        Self {
            matrix,
            shift: to - matrix * from,
        }
    }

    pub(super) fn at(&self, p: DVec3) -> DVec3 {
        self.matrix * p + self.shift
    }

    /// Where a unit normal of a surface goes.
    pub(super) fn direction(&self, n: DVec3) -> DVec3 {
        (self.matrix * n).normalize_or_zero()
    }

    pub(super) fn inverse(&self) -> Self {
        let matrix = self.matrix.inverse();
        Self {
            matrix,
            shift: -(matrix * self.shift),
        }
    }

    /// This one, then another.
    pub(super) fn then(&self, next: &Self) -> Self {
        Self {
            matrix: next.matrix * self.matrix,
            shift: next.at(self.shift),
        }
    }

    /// Length after over length before.
    pub(super) fn scale(&self) -> f64 {
        self.matrix.determinant().abs().cbrt()
    }

    pub(super) fn is_reflection(&self) -> bool {
        self.matrix.determinant() < 0.0
    }

    /// Angle of its rotation, in radians, where it is a motion without reflection.
    pub(super) fn angle(&self) -> f64 {
        let quat = DQuat::from_mat3(&(self.matrix * (1.0 / self.scale())));
        2.0 * quat.w.abs().min(1.0).acos()
    }

    pub(super) fn is_finite(&self) -> bool {
        self.matrix.is_finite() && self.shift.is_finite()
    }

    /// A mesh after the motion; after a reflection its faces are turned, so that outside stays outside.
    pub(super) fn moved(&self, mesh: &Mesh) -> Mesh {
        let positions = mesh.positions.iter().map(|p| self.at(*p)).collect();
        let turned = |&[a, b, c]: &[u32; 3]| match self.is_reflection() {
            true => [a, c, b],
            false => [a, b, c],
        };
        Mesh::new(positions, mesh.faces.iter().map(turned).collect())
    }
}
