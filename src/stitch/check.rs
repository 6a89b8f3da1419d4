//! What a finished patch is held to: joined along the whole rim, manifold, and free of intersections.

use glam::DVec3;

use super::StitchInput;
use super::assemble::Assembled;
use crate::spatial::{Bounds, intersecting};

/// The patch's faces in output indices, followed by the mesh's faces near it.
pub(super) struct Surroundings {
    /// Positions of the mesh, then of the new vertices.
    pub(super) positions: Vec<DVec3>,
    /// Faces of the mesh whose box meets the patch's box, grown by half its size.
    pub(super) near: Vec<[u32; 3]>,
}

impl Surroundings {
    pub(super) fn new(input: &StitchInput, patch: &Assembled) -> Self {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &p in &patch.mesh.position {
            low = low.min(p + patch.centre);
            high = high.max(p + patch.centre);
        }
        let margin = DVec3::splat(0.1 * (high - low).max_element());
        let bounds = Bounds {
            low: low - margin,
            high: high + margin,
        };
        let at = |f: &[u32; 3]| f.map(|v| input.mesh.positions[v as usize]);
        let near = input
            .mesh
            .faces
            .iter()
            .filter(|f| Bounds::of(at(f)).meets(&bounds));
        Self {
            positions: input.mesh.positions.clone(),
            near: near.copied().collect(),
        }
    }

    /// The faces of the patch, by their number there, that intersect another face, and that face's number: of the patch, or
    /// of the mesh from the patch's number of faces on.
    pub(super) fn intersections(&mut self, patch: &Assembled, mesh_len: usize) -> Vec<(u32, u32)> {
        self.positions.truncate(mesh_len);
        let free = &patch.mesh.position[patch.mesh.rim_len()..];
        self.positions
            .extend(free.iter().map(|&p| p + patch.centre));
        let mut faces = patch.output_faces(mesh_len as u32);
        let count = faces.len();
        faces.extend_from_slice(&self.near);
        intersecting(&self.positions, &faces, count)
    }
}
