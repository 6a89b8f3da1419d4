//! Similarity transforms: rotations, translations, reflections and uniform scalings.

use glam::{DMat3, DQuat, DVec3};

use crate::elementary::{acos, cbrt};
use crate::mesh::Mesh;

/// `x ↦ A x + b`, where `A` is an orthogonal matrix times a scale.
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

    /// The motion with the given matrix that maps `from` to `to`.
    pub(super) fn about(matrix: DMat3, from: DVec3, to: DVec3) -> Self {
        Self {
            matrix,
            shift: to - matrix * from,
        }
    }

    pub(super) fn at(&self, p: DVec3) -> DVec3 {
        self.matrix * p + self.shift
    }

    /// The image of a unit normal, of unit length.
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

    /// This motion followed by another.
    pub(super) fn then(&self, next: &Self) -> Self {
        Self {
            matrix: next.matrix * self.matrix,
            shift: next.at(self.shift),
        }
    }

    /// Ratio of lengths after the motion to lengths before.
    pub(super) fn scale(&self) -> f64 {
        cbrt(self.matrix.determinant().abs())
    }

    pub(super) fn is_reflection(&self) -> bool {
        self.matrix.determinant() < 0.0
    }

    /// Angle of rotation in radians; meaningless for a reflection.
    pub(super) fn angle(&self) -> f64 {
        let quat = DQuat::from_mat3(&(self.matrix * (1.0 / self.scale())));
        2.0 * acos(quat.w.abs().min(1.0))
    }

    pub(super) fn is_finite(&self) -> bool {
        self.matrix.is_finite() && self.shift.is_finite()
    }

    /// The moved mesh. A reflection reverses the order of the corners, so that outside stays outside.
    pub(super) fn moved(&self, mesh: &Mesh) -> Mesh {
        let positions = mesh.positions.iter().map(|p| self.at(*p)).collect();
        let turned = |&[a, b, c]: &[u32; 3]| match self.is_reflection() {
            true => [a, c, b],
            false => [a, b, c],
        };
        Mesh::new(positions, mesh.faces.iter().map(turned).collect())
    }
}
