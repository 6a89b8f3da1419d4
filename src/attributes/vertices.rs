//! Attributes of vertices: values for the new ones, and the vertex of each corner of the patches at the rim.

use super::Transfer;
use super::field::{Field, Source};
use crate::mesh::Model;
use crate::mesh::attributes::{Attribute, NONE};

/// Gives the new vertices their values and the corners of the patches their vertices.
pub(super) fn finish(transfer: &Transfer<'_>, out: &mut Model) {
    let before = &transfer.before.vertex;
    if before.is_empty() {
        return;
    }
    // One field for each attribute, with a value at each slot of the patches.
    let fields: Vec<Field> = before
        .iter()
        .map(|a| transfer.field(&Source::Vertex(a)))
        .collect();
    let kept = transfer.original.positions.len();
    let slots = &transfer.patches.slots;
    // The slot that a new vertex takes its values from; a rim slot is given a vertex.
    let mut slot_of = vec![NONE; out.mesh.positions.len() - kept];
    let mut vertex_of: Vec<u32> = slots.iter().map(|s| s.vertex).collect();
    let mut copies: Vec<(u32, usize)> = Vec::new();
    // A new vertex takes the values of its first slot. A slot on the rim uses the vertex of the mesh that has its values;
    // where none has, as between the two sides of a texture seam, it gets a copy of the vertex.
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
    // Values in the order of the vertices: those of the mesh unchanged, then the new ones, then the copies.
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
    // A copy has the position of the vertex that it stands for.
    for (copy, _) in copies {
        let at = out.mesh.positions.len() as u32;
        out.attributes.copies.push((at, copy));
        out.mesh
            .positions
            .push(transfer.original.positions[copy as usize]);
    }
    // New faces use the vertices chosen for their slots.
    let new_faces = out.mesh.faces[transfer.original.faces.len()..].iter_mut();
    for (face, in_slots) in new_faces.zip(&transfer.patches.faces) {
        *face = in_slots.map(|s| vertex_of[s as usize]);
    }
}

/// The first vertex at a slot on the rim that has, in all attributes, the values of the slot.
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
        all.all(|(attribute, field)| attribute.get(v as usize) == field.get(s))
    })
}
