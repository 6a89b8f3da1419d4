//! The precision of the output: positions that a repair makes are rounded to it before self-intersections are looked for.

use glam::{DMat4, DVec3};

/// Whether 32-bit floats hold a position.
pub(super) fn is_single(p: DVec3) -> bool {
    p.as_vec3().as_dvec3() == p
}

/// How positions are rounded when they are written.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rounding {
    /// The transform from the coordinates that the file holds as 32-bit floats to those of the mesh, and its inverse; none where
    /// the file holds 64-bit floats.
    stored: Option<[DMat4; 2]>,
}

impl Rounding {
    /// The rounding of a file whose 32-bit floats a transform takes to the coordinates of the mesh; none for 64-bit floats, and for
    /// transforms that cannot be inverted.
    pub(super) fn new(stored: Option<DMat4>) -> Self {
        let finite = |to: &DMat4| to.determinant() != 0.0 && to.inverse().is_finite();
        let stored = stored.filter(finite).map(|to| [to, to.inverse()]);
        Self { stored }
    }

    /// Whether positions are rounded at all.
    pub(super) fn is_single(&self) -> bool {
        self.stored.is_some()
    }

    /// A position as it is read from the file. What 32-bit floats cannot hold stays as it is: writing refuses it.
    pub(super) fn of(&self, p: DVec3) -> DVec3 {
        let single = |p: DVec3| p.as_vec3().as_dvec3();
        let rounded = match &self.stored {
            None => return p,
            Some([to, _]) if *to == DMat4::IDENTITY => single(p),
            Some([to, back]) => to.transform_point3(single(back.transform_point3(p))),
        };
        if rounded.is_finite() { rounded } else { p }
    }

    /// A vertex that moves. One in single precision stays so, since formats may hold no more.
    pub(super) fn moved(&self, p: DVec3, shift: DVec3) -> DVec3 {
        self.beside(is_single(p), p + shift)
    }

    /// The position of a new vertex: in single precision where those beside it are.
    pub(super) fn beside(&self, are_single: bool, p: DVec3) -> DVec3 {
        match are_single && !self.is_single() {
            true => p.as_vec3().as_dvec3(),
            false => self.of(p),
        }
    }
}
