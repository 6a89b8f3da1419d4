//! Patches of regions that were solved before in the same run. The plans of a repair close many of the same holes, and a region's patch
//! depends only on its part of the mesh in its frame, on its parameters and its budget.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Mutex, PoisonError};

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::framed::Framed;
use crate::fill::RegionPatch;
use crate::tuning::{Tunable, tunable};

/// Vertices. Patches are kept until they have as many.
const MOST_VERTICES: usize = 2_000_000;

/// Nodes of level sets that take as long as what else is done at a region, on average over the plans of eight parts.
const REGION_NODES: Tunable<usize> = tunable("repair.region_nodes", 15_000);

/// What decides the patch of a region, as a hash of 128 bits.
pub(super) type RegionKey = [u64; 2];

/// Patches of regions in their frames.
#[derive(Default)]
pub(crate) struct SolvedPatches(Mutex<Kept>);

#[derive(Default)]
struct Kept {
    /// None where there are too many.
    patches: FxHashMap<RegionKey, Option<RegionPatch>>,
    vertices: usize,
    nodes: usize,
}

impl SolvedPatches {
    /// What was spent on unlike regions, in nodes of level sets.
    pub(crate) fn nodes(&self) -> usize {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.nodes + REGION_NODES.get() * kept.patches.len()
    }

    /// The patch of a region that was solved before.
    pub(super) fn get(&self, key: &RegionKey) -> Option<RegionPatch> {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.patches.get(key).cloned().flatten()
    }

    /// Keeps the patch of a region.
    pub(super) fn keep(&self, key: RegionKey, patch: &RegionPatch) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Equal regions of one fill may be solved at the same time.
        if kept.patches.contains_key(&key) {
            return;
        }
        kept.vertices += patch.mesh.positions.len();
        kept.nodes += patch.report.levels.iter().map(|l| l.nodes).sum::<usize>();
        let is_kept = kept.vertices <= MOST_VERTICES;
        kept.patches.insert(key, is_kept.then(|| patch.clone()));
    }
}

/// The key of a region in its frame. `known` and `joined` are in the order of the frame, `limits` are the bounds of its task.
pub(super) fn key(
    framed: &Framed,
    known: Option<&[bool]>,
    joined: &[[u32; 2]],
    limits: (f64, u64),
) -> RegionKey {
    // Numbers of holes change as others are closed.
    let params = framed.params.of_holes(None);
    let ids: Vec<_> = framed.holes.iter().map(|h| h.id).collect();
    let params = (format!("{params:?}"), framed.params.bridges(&ids));
    [0u8, 1].map(|start| {
        let mut hasher = DefaultHasher::new();
        start.hash(&mut hasher);
        hash_points(&framed.mesh.positions, &mut hasher);
        (&framed.mesh.faces, known, joined).hash(&mut hasher);
        for hole in &framed.holes {
            let is_flat = framed.params.is_flat(hole.id);
            (&hole.rim, hole.outer_boundary, is_flat).hash(&mut hasher);
        }
        (limits.0.to_bits(), limits.1, &params).hash(&mut hasher);
        hasher.finish()
    })
}

fn hash_points(points: &[DVec3], hasher: &mut impl Hasher) {
    for p in points {
        p.to_array().map(f64::to_bits).hash(hasher);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::FillParams;
    use crate::mend::{Control, Inspection, Watch};
    use crate::mesh::HoleId;
    use crate::mesh::shapes::{grid, punch};

    #[test]
    fn a_region_that_was_solved_gets_the_same_patch_whatever_its_number() {
        let sheet = grid(30, 30, [false, false], |u, v| DVec3::new(u, v, 0.2 * u * u));
        let near = |p: DVec3, x: f64, radius: f64| (p - DVec3::new(x, 0.5, p.z)).length() < radius;
        let one = punch(&sheet, |p| near(p, 0.3, 0.12));
        let two = punch(&sheet, |p| near(p, 0.3, 0.12) || near(p, 0.8, 0.15));
        let solved = SolvedPatches::default();
        let filled = |mesh| {
            let found = Inspection::new(mesh).unwrap();
            let regions = found.regions(&FillParams::default()).unwrap();
            let regions = regions.after(&solved);
            regions.fill(&Watch::new(Control::new(), regions.expected_work()))
        };
        let first = filled(&one).unwrap();
        let spent = solved.nodes();
        assert!(spent > 0);
        let again = filled(&one).unwrap();
        assert_eq!(first.mesh, again.mesh);
        assert_eq!(first.expected_error, again.expected_error);
        assert_eq!(solved.nodes(), spent);

        let both = filled(&two).unwrap();
        assert!(solved.nodes() > spent);
        let alone = crate::mend::fill(&two, &FillParams::default()).unwrap();
        assert_eq!(both.mesh, alone.mesh);
        let ids = |report: &crate::mend::FillReport| -> Vec<(usize, Vec<HoleId>)> {
            let regions = report.regions.iter();
            regions.map(|r| (r.id, r.holes.clone())).collect()
        };
        assert_eq!(ids(&both.report), ids(&alone.report));
    }
}
