//! Rounding of positions to the precision of the output, applied before self-intersections are searched.

use glam::{DMat4, DVec3};

/// Whether 32-bit floats represent a position exactly.
pub(super) fn is_single(p: DVec3) -> bool {
    p.as_vec3().as_dvec3() == p
}

/// How positions are rounded when they are written.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rounding {
    /// The transform from the stored 32-bit coordinates to mesh coordinates, and its inverse; none if the file stores 64-bit
    /// floats.
    stored: Option<[DMat4; 2]>,
}

impl Rounding {
    /// Rounding for a file with 32-bit floats and this transform to mesh coordinates. No rounding for 64-bit floats or a singular
    /// transform.
    pub(super) fn new(stored: Option<DMat4>) -> Self {
        let finite = |to: &DMat4| to.determinant() != 0.0 && to.inverse().is_finite();
        let stored = stored.filter(finite).map(|to| [to, to.inverse()]);
        Self { stored }
    }

    /// Whether positions are rounded at all.
    pub(super) fn is_single(&self) -> bool {
        self.stored.is_some()
    }

    /// A position as it will be read from the file. Positions outside the range of 32-bit floats are returned unchanged; writing
    /// refuses them.
    pub(super) fn of(&self, p: DVec3) -> DVec3 {
        let single = |p: DVec3| p.as_vec3().as_dvec3();
        let rounded = match &self.stored {
            None => return p,
            Some([to, _]) if *to == DMat4::IDENTITY => single(p),
            Some([to, back]) => to.transform_point3(single(back.transform_point3(p))),
        };
        if rounded.is_finite() { rounded } else { p }
    }

    /// A displaced vertex. A single-precision position stays single precision, since the format may hold no more.
    pub(super) fn moved(&self, p: DVec3, shift: DVec3) -> DVec3 {
        self.beside(is_single(p), p + shift)
    }

    /// The position of a new vertex, rounded to single precision if its neighbours are.
    pub(super) fn beside(&self, are_single: bool, p: DVec3) -> DVec3 {
        match are_single && !self.is_single() {
            true => p.as_vec3().as_dvec3(),
            false => self.of(p),
        }
    }
}
