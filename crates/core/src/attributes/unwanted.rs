//! Colours that are not continued onto patches: the paint that marked the faces that were cut out.

use std::collections::BTreeMap;

use super::Transfer;
use super::field::{Field, FieldSource, Instead};
use crate::mesh::attributes::{Attribute, Role};
use crate::mesh::mask::is_near;

/// A colour that patches must not get from their rims.
#[derive(Clone, Copy, Debug)]
pub struct UnwantedColour {
    /// Red, green and blue, from 0 to 1.
    pub rgb: [f64; 3],
    /// Largest difference of each of the three.
    pub tolerance: f64,
}

/// For each slot at the rim with an unwanted colour, the colour to continue from there instead: the colour of the nearest vertices of
/// the input with another one. The rim itself keeps its colours.
pub(super) fn instead(
    transfer: &Transfer<'_>,
    source: &FieldSource<'_>,
    field: &Field,
) -> Vec<Instead> {
    let FieldSource::Vertex(colours) = source else {
        return Vec::new();
    };
    if colours.role != Role::Colour || colours.components < 3 || transfer.unwanted.is_empty() {
        return Vec::new();
    }
    let is_unwanted = |v: u32| {
        let mut all = transfer.unwanted.iter();
        all.any(|c| is_near(colours, v as usize, c.rgb, c.tolerance))
    };
    let slots = transfer.patches.slots.iter().enumerate();
    let at_rim = slots.filter(|(s, slot)| !slot.rim.is_empty() && field.get(*s).is_some());
    let marked = at_rim.filter(|(_, slot)| {
        let corners = slot.rim.iter();
        let mut vertices =
            corners.map(|&(f, k)| transfer.original.faces[f as usize][usize::from(k)]);
        vertices.any(is_unwanted)
    });
    let marked: Vec<(usize, u32)> = marked.map(|(s, slot)| (s, slot.vertex)).collect();
    if marked.is_empty() {
        return Vec::new();
    }
    let around = spread_inwards(transfer, colours, is_unwanted);
    let of = |(s, v): (usize, u32)| (s, around.get(&v).cloned().flatten());
    marked.into_iter().map(of).collect()
}

/// For each unwanted vertex of the input, as the first at its position, the mean colour of the nearest others along edges; none
/// if it is connected with none.
fn spread_inwards(
    transfer: &Transfer<'_>,
    colours: &Attribute,
    is_unwanted: impl Fn(u32) -> bool,
) -> BTreeMap<u32, Option<Vec<f64>>> {
    let weld = &transfer.patches.weld;
    let mut around: BTreeMap<u32, Option<Vec<f64>>> = BTreeMap::new();
    let mut neighbours: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for face in &transfer.original.faces {
        for k in (0..3).filter(|k| is_unwanted(face[*k])) {
            let own = neighbours.entry(weld[face[k] as usize]).or_default();
            own.extend([face[(k + 1) % 3], face[(k + 2) % 3]]);
            around.insert(weld[face[k] as usize], None);
        }
    }
    // One ring of vertices in each pass, from the ones next to other colours inwards.
    loop {
        let value = |w: u32| match around.get(&weld[w as usize]) {
            Some(found) => found.as_deref(),
            None => colours.get(w as usize),
        };
        let mean = |v: &u32| {
            let known: Vec<&[f64]> = neighbours[v].iter().filter_map(|w| value(*w)).collect();
            let sum = |c: usize| known.iter().map(|x| x[c]).sum::<f64>() / known.len() as f64;
            let mean: Vec<f64> = (0..colours.components).map(sum).collect();
            (!known.is_empty()).then_some((*v, mean))
        };
        let open = around.iter().filter(|(_, found)| found.is_none());
        let ring: Vec<(u32, Vec<f64>)> = open.filter_map(|(v, _)| mean(v)).collect();
        if ring.is_empty() {
            return around;
        }
        for (v, mean) in ring {
            around.insert(v, Some(mean));
        }
    }
}
