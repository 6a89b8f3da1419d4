//! The search for intersecting pairs of faces.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use glam::DVec3;
use rayon::prelude::*;

use super::predicates::{at, faces_intersect};
use super::slender::have_partners;
use super::{Bounds, BoxTree};
use crate::threads::CollectIndexed;

/// With at most this many query faces all boxes are compared one by one, without a tree. With a tree, making the offset shells of
/// 8000 sheets of two triangles took a tenth longer.
const MAX_WITHOUT_TREE: usize = 8;
/// Pairs of intersecting boxes per face up to which all pairs of faces are tested. A closed surface of regular triangles has 10.
/// With many more most faces intersect others, and searching only the first partner of each face is faster; or most faces are long
/// and thin, and oriented boxes are.
const MAX_PAIRS_PER_FACE: usize = 64;
/// Number of faces that are tested first if there are more than [`LEAST_SAMPLED`].
const SAMPLE: usize = 128;
/// Least number of faces of which some are tested first.
const LEAST_SAMPLED: usize = 4096;
/// Lower bound of the pairs that are tested before oriented boxes are made.
const MIN_PAIRS: usize = 10_000;

/// The faces among the first `count` that intersect any other face, in order, each with one partner.
///
/// Faces that share a vertex intersect if they have another point in common, faces that share an edge if they are folded onto
/// each other, faces with the same vertices always. Decided exactly for the given coordinates.
pub fn intersecting(positions: &[DVec3], faces: &[[u32; 3]], count: usize) -> Vec<(u32, u32)> {
    let boxes: Vec<Bounds> = faces
        .par_iter()
        .map(|f| Bounds::of(at(positions, *f)))
        .collect_indexed();
    let hit =
        |i: u32, j: u32| j != i && faces_intersect(positions, faces[i as usize], faces[j as usize]);
    if count <= MAX_WITHOUT_TREE {
        let meets = |i: u32, j: u32| boxes[i as usize].meets(&boxes[j as usize]);
        let partner = |i: u32| (0..faces.len() as u32).find(|&j| meets(i, j) && hit(i, j));
        return (0..count as u32)
            .filter_map(|i| Some((i, partner(i)?)))
            .collect();
    }
    let tree = BoxTree::new(&boxes);
    // If all faces are queried, each pair is tested once; the partners are searched afterwards for the few faces that have one.
    let hits = (count == faces.len()).then(|| tree.hits(MAX_PAIRS_PER_FACE, hit));
    let hits = hits.flatten();
    let may_hit = |i: &u32| hits.as_ref().is_none_or(|hits| hits[*i as usize]);
    let asked: Vec<u32> = (0..count as u32).filter(may_hit).collect();
    let soup = Soup {
        positions,
        faces,
        boxes: &boxes,
        tree: &tree,
    };
    soup.partners(&asked, hits.is_some())
}

/// The faces among `asked` (ascending) that intersect any other face, each with the partner that [`intersecting`] finds.
pub(crate) fn partners(positions: &[DVec3], faces: &[[u32; 3]], asked: &[u32]) -> Vec<(u32, u32)> {
    if faces.len() <= MAX_WITHOUT_TREE {
        let mut all = intersecting(positions, faces, faces.len());
        all.retain(|(f, _)| asked.contains(f));
        return all;
    }
    let boxes: Vec<Bounds> = faces
        .par_iter()
        .map(|f| Bounds::of(at(positions, *f)))
        .collect_indexed();
    let soup = Soup {
        positions,
        faces,
        boxes: &boxes,
        tree: &BoxTree::new(&boxes),
    };
    soup.partners(asked, false)
}

/// Faces with a tree over their boxes.
struct Soup<'a> {
    positions: &'a [DVec3],
    faces: &'a [[u32; 3]],
    boxes: &'a [Bounds],
    tree: &'a BoxTree,
}

impl Soup<'_> {
    /// The faces among `asked` with a partner, each with its first one in the order of the tree. If it is not known that all of
    /// them have one, and the search takes many pairs, the faces without one are sorted out by oriented boxes first.
    fn partners(&self, asked: &[u32], all_have_one: bool) -> Vec<(u32, u32)> {
        let most = MAX_PAIRS_PER_FACE
            .saturating_mul(asked.len())
            .max(MIN_PAIRS);
        let most = match all_have_one {
            true => usize::MAX,
            false => most,
        };
        let found = match !all_have_one && self.takes_many_pairs(asked) {
            true => None,
            false => self.first_partners(asked, most),
        };
        if let Some(found) = found {
            return found;
        }
        let has = have_partners(self.positions, self.faces, asked);
        let has = |i: &usize| has.as_ref().is_none_or(|has| has[*i]);
        let left: Vec<u32> = (0..asked.len()).filter(has).map(|i| asked[i]).collect();
        self.first_partners(&left, usize::MAX).unwrap_or_default()
    }

    /// Whether a few of many faces show that the search takes many pairs.
    fn takes_many_pairs(&self, asked: &[u32]) -> bool {
        if asked.len() <= LEAST_SAMPLED {
            return false;
        }
        let sample = asked.iter().copied().step_by(asked.len() / SAMPLE);
        let sample: Vec<u32> = sample.collect();
        let most = MAX_PAIRS_PER_FACE * SAMPLE;
        self.first_partners(&sample, most).is_none()
    }

    /// The faces among `asked` with a partner, as [`Self::partners`] finds them, or none if more than `most` pairs of faces had to be tested.
    fn first_partners(&self, asked: &[u32], most: usize) -> Option<Vec<(u32, u32)>> {
        let left = AtomicUsize::new(most);
        let is_over = || left.load(Relaxed) == 0;
        let partner = |&i: &u32| {
            let own = self.faces[i as usize];
            let mut tested = 0;
            let hit = |j: u32| {
                tested += 1;
                // Other threads are asked only now and then.
                let is_over = usize::is_multiple_of(tested, 1024) && (tested > most || is_over());
                is_over || (j != i && faces_intersect(self.positions, own, self.faces[j as usize]))
            };
            let found = self.tree.find(&self.boxes[i as usize], hit);
            let take = |left: usize| Some(left.saturating_sub(tested));
            if most != usize::MAX {
                // The closure always returns a value, so this cannot fail.
                let _ = left.fetch_update(Relaxed, Relaxed, take);
            }
            Some((i, found?))
        };
        let found = asked.par_iter().filter(|_| !is_over()).filter_map(partner);
        let found = found.collect();
        (!is_over()).then_some(found)
    }
}

/// All pairs (asked face, other face) of intersecting faces; see [`intersecting`].
pub(crate) fn intersecting_pairs(
    positions: &[DVec3],
    faces: &[[u32; 3]],
    asked: &[u32],
) -> Vec<[u32; 2]> {
    let boxes: Vec<Bounds> = faces
        .par_iter()
        .map(|f| Bounds::of(at(positions, *f)))
        .collect_indexed();
    // The tree is built over the few asked faces and queried with all faces.
    let own: Vec<Bounds> = asked.iter().map(|i| boxes[*i as usize]).collect();
    let tree = BoxTree::new(&own);
    let pairs = (0..faces.len() as u32).into_par_iter().flat_map_iter(|j| {
        let mut found = Vec::new();
        tree.for_each(&boxes[j as usize], |i| {
            let i = asked[i as usize];
            if i != j && faces_intersect(positions, faces[i as usize], faces[j as usize]) {
                found.push([i, j]);
            }
        });
        found
    });
    pairs.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::noise;

    fn p(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }

    #[test]
    fn the_search_finds_what_all_pairs_find() {
        let mut noise = noise(3);
        let mut noise = || 2.0 * noise() - 1.0;
        let positions: Vec<DVec3> = (0..300).map(|_| p(noise(), noise(), noise())).collect();
        let faces: Vec<[u32; 3]> = (0..100).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let small: Vec<DVec3> = (0..300)
            .map(|i| positions[i / 3 * 3] + 0.2 * positions[i])
            .collect();
        let found = intersecting(&small, &faces, 60);
        let all: Vec<u32> = (0..60u32)
            .filter(|&i| {
                (0..100u32).any(|j| {
                    i != j && faces_intersect(&small, faces[i as usize], faces[j as usize])
                })
            })
            .collect();
        assert!(!all.is_empty());
        assert_eq!(found.iter().map(|f| f.0).collect::<Vec<_>>(), all);
        // All pairs of one of the first sixty faces with any other.
        let asked: Vec<u32> = (0..60).collect();
        let mut pairs = intersecting_pairs(&small, &faces, &asked);
        let both = |i: u32| (0..100u32).filter_map(move |j| (i != j).then_some([i, j]));
        let hit =
            |&[i, j]: &[u32; 2]| faces_intersect(&small, faces[i as usize], faces[j as usize]);
        let all: Vec<[u32; 2]> = asked.iter().flat_map(|i| both(*i)).filter(hit).collect();
        assert!(!all.is_empty());
        pairs.sort_unstable();
        assert_eq!(pairs, all);
    }
}
