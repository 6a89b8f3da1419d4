//! Repair of self-intersections: local changes around intersecting faces.

use std::collections::BTreeSet;

use super::Remesher;
use crate::stitch::StitchInput;
use crate::stitch::assemble::Assembled;
use crate::stitch::check::Surroundings;
use crate::tuning::{Tunable, tunable};

/// Rounds of repair of a patch's faces.
const REPAIR_ROUNDS: Tunable<usize> = tunable("stitch.repair_rounds", 9);

/// Changes the patch around its intersecting faces until none is left or nothing helps; returns their remaining number.
pub(in crate::stitch) fn repair(
    input: &StitchInput,
    patch: &mut Assembled,
    surroundings: &mut Surroundings,
) -> usize {
    let mesh_len = input.mesh.positions.len();
    let mut hits = surroundings.intersections(patch, mesh_len);
    for round in 0..REPAIR_ROUNDS.get() {
        if hits.is_empty() || input.surface.is_cancelled() {
            break;
        }
        let before = patch.mesh.clone();
        let count = patch.mesh.faces.len() as u32;
        let faces: BTreeSet<u32> = hits
            .iter()
            .flat_map(|&(f, g)| [f, g])
            .filter(|&f| f < count)
            .collect();
        Remesher::new(input, patch).rework(&faces, round);
        patch.mesh.compact();
        let now = surroundings.intersections(patch, mesh_len);
        if now.len() <= hits.len() {
            hits = now;
        } else {
            patch.mesh = before;
        }
    }
    hits.len()
}

impl Remesher<'_> {
    /// Flips or collapses edges of the given faces (depending on the round), then untangles and smooths around them.
    fn rework(&mut self, faces: &BTreeSet<u32>, round: usize) {
        let corners: BTreeSet<u32> = faces
            .iter()
            .flat_map(|&f| self.mesh.faces[f as usize])
            .collect();
        match round % 3 {
            0 => {}
            1 => faces.iter().flat_map(|&f| 3 * f..3 * f + 3).for_each(|h| {
                if self.is_live(h) && self.can_flip(h, 0.3) {
                    self.mesh.flip(h);
                }
            }),
            _ => faces.iter().for_each(|&f| {
                let shortest = (3 * f..3 * f + 3)
                    .filter(|&h| self.is_live(h))
                    .min_by(|&a, &b| self.mesh.length(a).total_cmp(&self.mesh.length(b)));
                if let Some(h) = shortest {
                    self.collapse(h, f64::INFINITY);
                }
            }),
        }
        self.untangle();
        let near: BTreeSet<u32> = corners
            .iter()
            .filter(|&&v| self.mesh.is_used(v))
            .flat_map(|&v| self.mesh.neighbours(v))
            .collect();
        let free = |v: &u32| !self.mesh.is_rim(*v) && self.mesh.is_used(*v);
        let free: Vec<u32> = near.union(&corners).copied().filter(free).collect();
        for _ in 0..3 {
            self.smooth_at(&free, Self::shape_goal, 0.5);
        }
    }
}
