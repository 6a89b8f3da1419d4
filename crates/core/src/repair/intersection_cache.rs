//! Cache of intersecting faces, reused from one search of a draft to the next.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::check::self_intersections;
use crate::mend::Inspection;
use crate::spatial::{intersecting_pairs, partners};

/// If more than one in this many faces is unknown, those that intersect any others are found first, which is quicker for many long
/// and thin faces.
const LARGE_PART: usize = 16;

/// The corners of a face, ascending.
pub(super) fn sorted([a, b, c]: [u32; 3]) -> [u32; 3] {
    let (a, b) = (a.min(b), a.max(b));
    let (b, c) = (b.min(c), b.max(c));
    [a.min(b), a.max(b), c]
}

/// Which faces intersect others, by sorted welded corners, from the last search. Vertices do not move, so only added or removed
/// faces can change it.
#[derive(Default)]
pub(super) struct IntersectionCache {
    /// Faces that intersect no other face of this set.
    pub(super) clear: FxHashSet<[u32; 3]>,
    /// Intersecting faces, each with one partner: the face intersects as long as the partner exists.
    pub(super) crossing: FxHashMap<[u32; 3], [u32; 3]>,
}

impl IntersectionCache {
    /// The cache for a mesh with these intersecting faces (ascending).
    pub(super) fn of(found: &Inspection, crossing: &[u32]) -> Self {
        let faces = found.topology.faces();
        let is_clear = |f: &u32| crossing.binary_search(f).is_err();
        let key = |f: u32| sorted(found.mesh.faces[f as usize]);
        Self {
            clear: faces.filter(is_clear).map(key).collect(),
            crossing: FxHashMap::default(),
        }
    }

    /// The faces that intersect others, ascending, and the updated cache; none if nothing changed. Only faces of unknown state
    /// are tested.
    pub(super) fn search(&self, found: &Inspection) -> (Vec<u32>, Option<Self>) {
        let (mesh, topology) = (&found.mesh, &found.topology);
        let all: Vec<u32> = topology.faces().collect();
        let keys = all.iter().map(|f| sorted(mesh.faces[*f as usize]));
        let keys: Vec<[u32; 3]> = keys.collect();
        let mut times: FxHashMap<[u32; 3], u32> = FxHashMap::default();
        times.reserve(keys.len());
        let mut are_unlike = true;
        for key in &keys {
            let count = times.entry(*key).or_insert(0);
            *count += 1;
            are_unlike &= *count == 1;
        }
        // Take over what is known; collect the faces to test.
        let mut with: Vec<Option<[u32; 3]>> = vec![None; all.len()];
        let mut asked: Vec<u32> = Vec::new();
        for (i, face) in (0..).zip(&keys) {
            let partner = self.crossing.get(face);
            if !are_unlike && times[face] > 1 {
                // A duplicate face intersects its double, so the cached state is not valid.
                asked.push(i);
            } else if let Some(partner) = partner.filter(|p| *p != face && times.contains_key(*p)) {
                with[i as usize] = Some(*partner);
            } else if !self.clear.contains(face) {
                asked.push(i);
            }
        }
        let is_same = asked.is_empty();
        let mut pair = |i: u32, j: u32| {
            with[i as usize] = with[i as usize].or(Some(keys[j as usize]));
        };
        // Test all faces, or only the unknown ones against all.
        if asked.len() == all.len() {
            let place = |f: u32| all.partition_point(|g| *g < f) as u32;
            for (f, g) in self_intersections(mesh, topology) {
                pair(place(f), place(g));
            }
        } else if !is_same {
            let faces: Vec<[u32; 3]> = all.iter().map(|f| mesh.faces[*f as usize]).collect();
            if LARGE_PART * asked.len() > all.len() {
                let hit = partners(&mesh.positions, &faces, &asked);
                asked = hit.into_iter().map(|(i, _)| i).collect();
            }
            for [i, j] in intersecting_pairs(&mesh.positions, &faces, &asked) {
                pair(i, j);
                pair(j, i);
            }
        }
        let is_crossing = all.iter().zip(&with).filter(|(_, with)| with.is_some());
        let crossing = is_crossing.map(|(f, _)| *f).collect();
        if is_same {
            return (crossing, None);
        }
        let own = || keys.iter().zip(&with);
        let known = Self {
            clear: own().filter(|k| k.1.is_none()).map(|k| *k.0).collect(),
            crossing: own().filter_map(|k| Some((*k.0, (*k.1)?))).collect(),
        };
        (crossing, Some(known))
    }
}
