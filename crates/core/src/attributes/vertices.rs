//! Attributes of the patches' vertices, and the vertex that each patch corner at the rim uses.

use super::Transfer;
use super::field::{Field, FieldSource};
use crate::mesh::Model;
use crate::mesh::attributes::{Attribute, NONE, same_value};

/// Sets the values of the new vertices and the vertices of the patches' corners.
pub(super) fn finish(transfer: &Transfer<'_>, out: &mut Model) {
    let before = &transfer.before.vertex;
    if before.is_empty() {
        return;
    }
    // One field per attribute, with a value at each slot of the patches.
    let fields: Vec<Field> = before
        .iter()
        .map(|a| transfer.field(&FieldSource::Vertex(a)))
        .collect();
    let kept = transfer.original.positions.len();
    let slots = &transfer.patches.slots;
    // The slot that each new vertex takes its values from, and the vertex that each slot uses.
    let mut slot_of = vec![NONE; out.mesh.positions.len() - kept];
    let mut vertex_of: Vec<u32> = slots.iter().map(|s| s.vertex).collect();
    let mut copies: Vec<(u32, usize)> = Vec::new();
    // A new vertex takes the values of its first slot. A rim slot uses the input vertex with its values. If there is
    // none, as between the two sides of a texture seam, it gets a copy of the vertex.
    for (s, slot) in slots.iter().enumerate() {
        match (slot.vertex as usize).checked_sub(kept) {
            Some(new) if slot_of[new] == NONE => slot_of[new] = s as u32,
            Some(_) => {}
            None => match same(transfer, &fields, before, s) {
                Some(vertex) => vertex_of[s] = vertex,
                None => {
                    vertex_of[s] = (out.mesh.positions.len() + copies.len()) as u32;
                    copies.push((slot.vertex, s));
                }
            },
        }
    }
    // Values in the order of the vertices: input (unchanged), new vertices, copies.
    for (a, (attribute, field)) in out.attributes.vertex.iter_mut().zip(&fields).enumerate() {
        attribute.values.truncate(kept * before[a].components);
        for &s in &slot_of {
            let value = if s == NONE {
                None
            } else {
                field.get(s as usize)
            };
            attribute.push(value);
        }
        for &(_, s) in &copies {
            attribute.push(field.get(s));
        }
    }
    // A copy has the position of its vertex.
    for (copy, _) in copies {
        let at = out.mesh.positions.len() as u32;
        out.attributes.copies.push((at, copy));
        out.mesh
            .positions
            .push(transfer.original.positions[copy as usize]);
    }
    // The new faces use the vertices of their slots.
    let new_faces = out.mesh.faces[transfer.original.faces.len()..].iter_mut();
    for (face, in_slots) in new_faces.zip(&transfer.patches.faces) {
        *face = in_slots.map(|s| vertex_of[s as usize]);
    }
}

/// The first input vertex at a rim slot that has the slot's values in all attributes.
fn same(transfer: &Transfer<'_>, fields: &[Field], before: &[Attribute], s: usize) -> Option<u32> {
    let slot = &transfer.patches.slots[s];
    if slot.rim.is_empty() {
        return Some(slot.vertex);
    }
    let mut candidates: Vec<u32> = slot
        .rim
        .iter()
        .map(|&(f, k)| transfer.original.faces[f as usize][usize::from(k)])
        .collect();
    candidates.sort_unstable();
    candidates.into_iter().find(|&v| {
        let mut all = before.iter().zip(fields);
        all.all(|(attribute, field)| same_value(attribute.get(v as usize), field.get(s)))
    })
}
