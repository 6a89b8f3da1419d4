//! Hole selection: translates hole and crease numbers of the input to the present draft and back.

use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};

use super::edges;
use crate::fill::FillParams;
use crate::mend::{Control, CreaseEnd, FillError, Inspection};
use crate::mesh::HoleId;
use crate::tuning::{Tunable, tunable};

/// Faces. Components of at most this many faces have no inside.
pub(super) const SMALL_FACES: Tunable<usize> = tunable("repair.small_faces", 2);

/// Turns outer borders of open sheets into ordinary holes; returns those that may get flat caps. The level set cannot close them,
/// because their surface continues away from the centre of the border.
pub(super) fn take_borders(found: &mut Inspection) -> Vec<HoleId> {
    let mut sheets = Vec::new();
    for hole in found.holes.iter_mut().filter(|h| h.outer_boundary) {
        hole.outer_boundary = false;
        let faces = found.topology.component_faces[hole.component as usize];
        if faces > SMALL_FACES.get() {
            sheets.push(hole.id);
        }
    }
    sheets
}

/// The holes and crease ends of the input, for translating the caller's selection.
#[derive(Default)]
pub(super) struct Choice {
    /// The hole of each rim edge, between welded vertices of the input.
    hole_of: HashMap<(u32, u32), HoleId>,
    /// The welded vertex of each input vertex.
    weld: Vec<u32>,
    /// Pairs of welded input vertices to be connected by sharp edges.
    joined: Vec<[u32; 2]>,
}

impl Choice {
    /// # Errors
    /// If the selection names a hole that does not exist.
    pub(super) fn new(found: &Inspection, params: &FillParams) -> Result<Self, FillError> {
        // Fails for hole numbers that do not exist.
        drop(found.regions(params)?);
        let rims = found.holes.iter();
        let ends = match params.crease.is_empty() {
            true => Vec::new(),
            false => found.crease_ends(&Control::new())?,
        };
        let pairs = params.crease.iter();
        Ok(Self {
            joined: pairs
                .map(|pair| pair.map(|id| ends[id - 1].vertex))
                .collect(),
            hole_of: rims
                .flat_map(|h| edges(&h.rim).map(|e| (e, h.id)))
                .collect(),
            weld: found.weld.clone(),
        })
    }

    /// The largest number of a hole of the input; 0 if there is none.
    pub(super) fn last_hole(&self) -> usize {
        self.hole_of.values().map(|id| id.get()).max().unwrap_or(0)
    }

    /// The parameters with the present numbers of the chosen holes. `made` are the holes made by the repair, which are always
    /// filled. `origin` is the input vertex of each present vertex.
    pub(super) fn params(
        &self,
        now: &Inspection,
        origin: &[u32],
        made: &[HoleId],
        params: &FillParams,
    ) -> FillParams {
        let chooses = params.holes.is_some()
            || params.max_diameter.is_some()
            || !params.keep_open.is_empty()
            || !params.flat.is_empty()
            || !params.bridge.is_empty()
            || !params.crease.is_empty();
        if !chooses {
            return params.clone();
        }
        let was: Vec<Option<HoleId>> = now
            .holes
            .iter()
            .map(|h| self.before(&h.rim, origin))
            .collect();
        let renumbered = |ids: &[HoleId]| -> Vec<HoleId> {
            let is_one =
                |(_, was): &(usize, &Option<HoleId>)| was.is_some_and(|id| ids.contains(&id));
            let found = (1..).zip(&was).filter(is_one);
            found.map(|(id, _)| HoleId(id)).collect()
        };
        let made: HashSet<HoleId> = made.iter().copied().collect();
        let mut new = params.clone();
        new.keep_open = renumbered(&params.keep_open);
        new.keep_open.retain(|id| !made.contains(id));
        new.flat = renumbered(&params.flat);
        new.flat.retain(|id| !made.contains(id));
        new.bridge = params.bridge.iter().map(|ids| renumbered(ids)).collect();
        new.bridge.retain(|ids| ids.len() > 1);
        if let Some(ids) = &params.holes {
            let mut ids = renumbered(ids);
            ids.extend(&made);
            ids.sort_unstable();
            ids.dedup();
            new.holes = Some(ids);
        } else if let Some(most) = params.max_diameter {
            let wide = |h: &&crate::mesh::Hole| h.diameter > most && !made.contains(&h.id);
            new.keep_open
                .extend(now.holes.iter().filter(wide).map(|h| h.id));
            new.max_diameter = None;
        }
        new.crease = self.creases(now, origin);
        if !new.crease.is_empty()
            && let Err(why) = now.regions(&new)
        {
            log::warn!(
                "the chosen sharp edges are not continued, because the repair changed the mesh: {why}"
            );
            new.crease.clear();
        }
        new
    }

    /// Input numbers of the present holes. Holes without an input number, or whose number is taken already, are numbered after
    /// the input's holes.
    pub(super) fn numbers(&self, now: &Inspection, origin: &[u32]) -> HashMap<HoleId, HoleId> {
        let mut next = self.hole_of.values().map(|id| id.get()).max().unwrap_or(0);
        let mut taken: HashSet<HoleId> = HashSet::new();
        let number = |hole: &crate::mesh::Hole| {
            let before = self
                .before(&hole.rim, origin)
                .filter(|id| taken.insert(*id));
            let own = before.unwrap_or_else(|| {
                next += 1;
                HoleId(next)
            });
            (hole.id, own)
        };
        now.holes.iter().map(number).collect()
    }

    /// The present numbers of the chosen crease ends; pairs with an end that no longer exists are dropped.
    fn creases(&self, now: &Inspection, origin: &[u32]) -> Vec<[usize; 2]> {
        if self.joined.is_empty() {
            return Vec::new();
        }
        let ends = now.crease_ends(&Control::new()).unwrap_or_default();
        let number = |vertex: u32| {
            let before = |end: &&CreaseEnd| self.before_vertex(end.vertex, origin) == Some(vertex);
            ends.iter().find(before).map(|end| end.id)
        };
        let pair = |&[a, b]: &[u32; 2]| {
            let pair = number(a).zip(number(b)).map(|(a, b)| [a, b]);
            if pair.is_none() {
                log::warn!(
                    "a sharp edge is not continued, because the repair changed the mesh at its end"
                );
            }
            pair
        };
        self.joined.iter().filter_map(pair).collect()
    }

    /// The welded input vertex of a present vertex.
    fn before_vertex(&self, vertex: u32, origin: &[u32]) -> Option<u32> {
        self.weld.get(origin[vertex as usize] as usize).copied()
    }

    /// The input hole that shares the most edges with a rim.
    fn before(&self, rim: &[u32], origin: &[u32]) -> Option<HoleId> {
        let of = |v: u32| self.before_vertex(v, origin);
        let mut votes: HashMap<HoleId, usize> = HashMap::new();
        for (v, w) in edges(rim) {
            if let (Some(v), Some(w)) = (of(v), of(w))
                && let Some(hole) = self.hole_of.get(&(v.min(w), v.max(w)))
            {
                *votes.entry(*hole).or_default() += 1;
            }
        }
        let most = votes
            .into_iter()
            .max_by_key(|(hole, n)| (*n, Reverse(*hole)));
        most.map(|(hole, _)| hole)
    }
}
