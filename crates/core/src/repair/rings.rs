//! Regions of faces grown ring by ring from hole rims.

use std::collections::{BTreeSet, HashSet};

use crate::mend::Inspection;
use crate::mesh::topology::NONE;
use crate::mesh::{Hole, VertexFaces};

/// A region of faces round some rims, all in one component.
pub(super) struct Region {
    pub(super) component: u32,
    pub(super) faces: Vec<u32>,
    known: HashSet<u32>,
    border: BTreeSet<u32>,
    rings: usize,
}

impl Region {
    pub(super) fn new(holes: &[&Hole]) -> Self {
        Self {
            component: holes.first().map_or(NONE, |h| h.component),
            faces: Vec::new(),
            known: HashSet::new(),
            border: holes.iter().flat_map(|h| h.rim.iter().copied()).collect(),
            rings: 0,
        }
    }

    /// Grows the region to `rings` rings, or until it has more than `most` faces; returns whether it grew.
    pub(super) fn grow(
        &mut self,
        found: &Inspection,
        around: &VertexFaces,
        rings: usize,
        most: usize,
    ) -> bool {
        let before = self.faces.len();
        while self.rings < rings && self.faces.len() <= most && !self.border.is_empty() {
            let first = self.faces.len();
            for v in std::mem::take(&mut self.border) {
                for &f in around.of(v) {
                    if found.topology.component[f as usize] == self.component
                        && self.known.insert(f)
                    {
                        self.faces.push(f);
                    }
                }
            }
            let new = self.faces[first..].iter();
            self.border = new.flat_map(|f| found.mesh.faces[*f as usize]).collect();
            self.rings += 1;
        }
        self.faces.len() > before
    }
}
