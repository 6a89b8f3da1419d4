//! Morph targets of glTF primitives: displacements of positions, applied with their default weights.

use gltf_json::mesh::Primitive;

use super::super::{IoError, Location};
use super::accessor;
use super::buffers::Buffers;

/// The accessors of displacements of a primitive's positions with their weights; displacements of weight zero are left out.
pub(super) fn displacements(primitive: &Primitive, weights: &[f32]) -> Vec<(usize, f32)> {
    let targets = primitive.targets.iter().flatten().zip(weights);
    let targets = targets.filter(|(_, weight)| **weight != 0.0);
    let positions = targets.filter_map(|(target, weight)| Some((target.positions?, *weight)));
    positions
        .map(|(index, weight)| (index.value(), weight))
        .collect()
}

/// Adds weighted displacements to the positions of a primitive of the mesh number `mesh`. The sums are rounded to 32-bit floats, as which
/// patches are written beside them.
pub(super) fn displace(
    buffers: &mut Buffers<'_>,
    mesh: usize,
    displacements: &[(usize, f32)],
    positions: &mut [[f64; 3]],
) -> Result<(), IoError> {
    for (accessor, weight) in displacements {
        let by = accessor::positions(buffers, *accessor)?;
        if by.len() != positions.len() {
            let (morphed, all) = (by.len(), positions.len());
            let what = format!("a morph target has {morphed} displacements for {all} vertices");
            let place = Location::Item("mesh", mesh);
            return Err(IoError::malformed(buffers.format, place, what));
        }
        for (point, by) in positions.iter_mut().zip(by) {
            for (x, by) in point.iter_mut().zip(by) {
                *x += f64::from(*weight) * by;
            }
        }
    }
    if !displacements.is_empty() {
        let rounded = |x: &mut f64| *x = f64::from(*x as f32);
        positions.iter_mut().flatten().for_each(rounded);
    }
    Ok(())
}
