//! What a finished patch is held to: joined along the whole rim, manifold, and free of intersections.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::assemble::Assembled;
use super::intersect::intersecting;
use super::{StitchError, StitchInput};
use crate::spatial::Bounds;

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

/// Fails unless the patch uses each rim edge once and in the right direction, and no other edge of the mesh.
pub(super) fn check_joined(input: &StitchInput, faces: &[[u32; 3]]) -> Result<(), StitchError> {
    let mesh = input.mesh;
    let len = mesh.positions.len() as u32;
    let at = |v: u32| mesh.positions.get(v as usize).copied().unwrap_or_default();
    let sides = |f: &[u32; 3]| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])];
    let mut rim: HashMap<(u32, u32), bool> = HashMap::new();
    for lp in input.loops {
        (0..lp.len()).for_each(|i| {
            rim.insert((lp[i], lp[(i + 1) % lp.len()]), false);
        });
    }
    let on_rim: HashSet<u32> = input.loops.iter().flatten().copied().collect();
    let mut taken: HashSet<(u32, u32)> = HashSet::new();
    for (a, b) in mesh.faces.iter().flat_map(sides) {
        if on_rim.contains(&a) && on_rim.contains(&b) {
            taken.insert((a.min(b), a.max(b)));
        }
    }
    let mut edges = HashSet::with_capacity(3 * faces.len());
    for (a, b) in faces.iter().flat_map(sides) {
        let fresh = edges.insert((a, b));
        let allowed = match rim.get_mut(&(a, b)) {
            Some(used) => !std::mem::replace(used, true),
            None => a >= len || b >= len || !taken.contains(&(a.min(b), a.max(b))),
        };
        if a == b || !fresh || !allowed {
            return Err(StitchError::NotManifold {
                position: at(a.min(b)),
            });
        }
    }
    let open = faces
        .iter()
        .flat_map(sides)
        .find(|&(a, b)| !edges.contains(&(b, a)) && !rim.contains_key(&(a, b)));
    let unused = rim
        .iter()
        .filter(|(_, used)| !**used)
        .map(|(&e, _)| e)
        .min();
    match open.or(unused) {
        Some((a, b)) => Err(StitchError::NotManifold {
            position: at(a.min(b)),
        }),
        None => Ok(()),
    }
}
