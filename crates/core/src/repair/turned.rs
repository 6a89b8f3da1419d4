//! Recognises faces that were added to close bodies as faces of the input that were taken away, turned or as they were.

use std::collections::HashMap;

use glam::DVec3;

use super::draft::Draft;
use super::steps::RepairSteps;
use crate::mesh::topology::NONE;
use crate::mesh::{FaceOrigin, Mesh, corner_key};

/// Gives added faces that belong to no patch the origin of the input face with the same corners that is not in the draft any more.
///
/// Along each edge of a face that is turned the wrong way one more face runs one way than the other, twice: two faces are added, of which
/// the union takes away one with the turned face (see [`super::chains`]).
pub(super) fn recognise(draft: &mut Draft, input: &Mesh, steps: &mut RepairSteps) {
    let origins = draft.origins.faces.iter().zip(&draft.region);
    let faces = (0..).zip(origins);
    let added = faces.filter(|(_, (origin, region))| origin.face == NONE && **region == NONE);
    let added: Vec<u32> = added.map(|(f, _)| f).collect();
    if added.is_empty() {
        return;
    }
    // The lost faces of the input by the positions of their corners; of several the first comes last.
    let mut lost: HashMap<[[u64; 3]; 3], Vec<u32>> = HashMap::new();
    let living = draft.origins.living(input.faces.len());
    for f in (0..input.faces.len() as u32)
        .rev()
        .filter(|f| !living[*f as usize])
    {
        lost.entry(corner_key(input.corners(f)))
            .or_default()
            .push(f);
    }
    for f in added {
        let face = lost
            .get_mut(&corner_key(draft.mesh.corners(f)))
            .and_then(Vec::pop);
        let origin = face.and_then(|face| origin(draft.mesh.corners(f), (input, face)));
        let Some(origin) = origin else {
            continue;
        };
        draft.origins.faces[f as usize] = origin;
        let is_turned = !matches!(origin.corners, [0, 1, 2] | [1, 2, 0] | [2, 0, 1]);
        steps.reoriented_faces += usize::from(is_turned);
        let faces = if is_turned { 2 } else { 1 };
        steps.closing_faces = steps.closing_faces.saturating_sub(faces);
    }
}

/// The origin of a face with the same corners as an input face; none if two of its corners coincide.
fn origin(own: [DVec3; 3], (input, face): (&Mesh, u32)) -> Option<FaceOrigin> {
    let old = input.corners(face);
    let places = own.map(|p| old.iter().position(|q| *q == p));
    let mut corners = [0; 3];
    for (corner, place) in corners.iter_mut().zip(places) {
        *corner = place? as u8;
    }
    let is_whole = (0..3).all(|k| corners.contains(&k));
    is_whole.then_some(FaceOrigin { face, corners })
}
