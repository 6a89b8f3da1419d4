//! Intersection test of a patch with itself and with the mesh around it.

use glam::DVec3;

use super::StitchInput;
use super::assemble::Assembled;
use crate::spatial::{Bounds, intersecting};

/// Positions and faces for the test: the patch's faces with output indices, and the mesh's faces near it.
pub(super) struct Surroundings {
    /// Positions of the mesh, then of the new vertices.
    pub(super) positions: Vec<DVec3>,
    /// Faces of the mesh whose bounding box meets the patch's, grown by a tenth of its largest side.
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

    /// Pairs of intersecting faces. The first is a face of the patch; the second is a face of the patch or, from the patch's
    /// number of faces on, a face of the mesh.
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
