//! Check that a patch is joined to its rims as a manifold.

use rustc_hash::{FxBuildHasher, FxHashMap, FxHashSet};

use super::{StitchError, StitchInput};

/// Fails unless the patch uses each rim edge once and in the right direction, and no other edge of the mesh.
pub(super) fn check_joined(input: &StitchInput, faces: &[[u32; 3]]) -> Result<(), StitchError> {
    let mesh = input.mesh;
    let len = mesh.positions.len() as u32;
    let at = |v: u32| mesh.positions.get(v as usize).copied().unwrap_or_default();
    let sides = |f: &[u32; 3]| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])];
    // Rim edges in the patch's direction, and whether a face uses them.
    let mut rim: FxHashMap<(u32, u32), bool> = FxHashMap::default();
    for lp in input.loops {
        (0..lp.len()).for_each(|i| {
            rim.insert((lp[i], lp[(i + 1) % lp.len()]), false);
        });
    }
    // Edges of the mesh between rim vertices, which the patch must not use.
    let on_rim: FxHashSet<u32> = input.loops.iter().flatten().copied().collect();
    let mut taken: FxHashSet<(u32, u32)> = FxHashSet::default();
    for (a, b) in mesh.faces.iter().flat_map(sides) {
        if on_rim.contains(&a) && on_rim.contains(&b) {
            taken.insert((a.min(b), a.max(b)));
        }
    }
    // Each directed edge occurs at most once in the patch and is a rim edge or new.
    let mut edges = FxHashSet::with_capacity_and_hasher(3 * faces.len(), FxBuildHasher);
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
    // Patch edges without an opposite face must be rim edges, and all rim edges must be used.
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
