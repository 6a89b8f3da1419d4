//! What a repair displaced before it cut anything out.

use std::collections::BTreeMap;

use glam::DVec3;

/// The vertices and faces that were moved because the surface is folded or noisy.
#[derive(Clone, Debug, Default)]
pub(super) struct Displaced {
    /// The first position of each moved vertex of the input.
    pub(super) vertices: BTreeMap<u32, DVec3>,
    /// The corners of each moved face before, and the largest displacement of one of them, in mesh units.
    pub(super) faces: Vec<([DVec3; 3], f64)>,
}
