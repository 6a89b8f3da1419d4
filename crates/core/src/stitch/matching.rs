//! Matching of loops: which rim loops and boundary loops of the kept part bound the same gap.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::cut::Kept;
use super::rim::Rims;
use super::sector::{Outline, nearest_pair};
use super::{StitchError, StitchInput};
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Voxels. A boundary of the kept part whose mean distance from the rim is larger does not belong to the rim.
const FAR_BORDER: Tunable<f64> = tunable("stitch.far_border", 6.0);

/// Vertices of a boundary loop that have to be nearest to a rim loop for the two to bound the same gap.
const VOTES: Tunable<usize> = tunable("stitch.votes", 2);

/// A gap between the rim and the kept part, given by its boundary loops.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Gap {
    /// Rim loops.
    pub(super) rims: Vec<usize>,
    /// Boundary loops of the kept part.
    pub(super) inner: Vec<usize>,
}

/// The gaps, and the components of the kept part that are dropped.
pub(super) fn gaps(
    input: &StitchInput,
    rims: &Rims,
    kept: &Kept,
) -> Result<(Vec<Gap>, BTreeSet<usize>), StitchError> {
    let (votes, dropped) = vote(input, rims, kept)?;
    let count = rims.loops.len();
    let mut groups = Groups::new(count + kept.loops.len());
    let mut reached = vec![false; count];
    // A boundary loop joins the gap of each rim loop that has enough of its votes.
    for (l, votes) in votes
        .iter()
        .enumerate()
        .filter(|(l, _)| !dropped.contains(&kept.loop_component[*l]))
    {
        let most = votes.values().copied().max().unwrap_or(0);
        for (&rim, &n) in votes {
            if n >= VOTES.get().min(most) {
                groups.join(rim, count + l);
                reached[rim] = true;
            }
        }
    }
    join_islands(input, rims, kept, &dropped, &reached, &mut groups);
    let mut gaps: BTreeMap<usize, Gap> = BTreeMap::new();
    for rim in 0..count {
        gaps.entry(groups.root(rim)).or_default().rims.push(rim);
    }
    for l in (0..kept.loops.len()).filter(|&l| !dropped.contains(&kept.loop_component[l])) {
        gaps.entry(groups.root(count + l))
            .or_default()
            .inner
            .push(l);
    }
    Ok((gaps.into_values().collect(), dropped))
}

type Votes = Vec<BTreeMap<usize, usize>>;

/// For each boundary loop, the number of its vertices that are nearest to each rim loop. Components far from every rim are
/// dropped.
fn vote(
    input: &StitchInput,
    rims: &Rims,
    kept: &Kept,
) -> Result<(Votes, BTreeSet<usize>), StitchError> {
    let limit = FAR_BORDER.get() * input.voxel;
    let segments = segments(input, rims);
    let mut far = Vec::new();
    let mut near = vec![false; kept.component_len.len()];
    let mut votes = Vec::new();
    for (l, lp) in kept.loops.iter().enumerate() {
        // The boundary loop in reverse, with the gap on its left.
        let outline = Outline::new(
            lp.iter()
                .rev()
                .map(|&v| (kept.positions[v as usize], kept.normals[v as usize])),
        );
        // For each vertex, the distance (world units) and the loop of the nearest rim edge across the gap.
        let found: Vec<(f64, usize)> = (0..lp.len())
            .into_par_iter()
            .map(|i| nearest_rim(&outline, i, &segments))
            .collect_indexed();
        // A boundary loop as a whole is near a rim or not; a component is near if one of its boundary loops is.
        let mean = found.iter().map(|f| f.0).sum::<f64>() / found.len() as f64;
        if mean <= limit {
            near[kept.loop_component[l]] = true;
        } else {
            let worst = (0..lp.len())
                .max_by(|&a, &b| found[a].0.total_cmp(&found[b].0))
                .unwrap_or(0);
            far.push((l, outline.position[worst], mean));
        }
        // Vertices near a rim vote for it.
        let mut count = BTreeMap::new();
        found
            .iter()
            .filter(|f| f.0 <= limit)
            .for_each(|f| *count.entry(f.1).or_insert(0) += 1);
        votes.push(count);
    }
    // A far boundary loop of a near component means that the surface continues away from the hole.
    if let Some(&(_, position, distance)) = far.iter().find(|f| near[kept.loop_component[f.0]]) {
        return Err(StitchError::OpenBoundary { position, distance });
    }
    let dropped = (0..near.len()).filter(|&p| !near[p]).collect();
    Ok((votes, dropped))
}

/// A rim edge: its ends, the surface normal, and its rim loop.
struct Segment {
    ends: [DVec3; 2],
    normal: DVec3,
    rim: usize,
}

fn segments(input: &StitchInput, rims: &Rims) -> Vec<Segment> {
    let mut segments = Vec::new();
    for (rim, lp) in rims.loops.iter().enumerate() {
        for (i, a) in lp.iter().enumerate() {
            let b = &lp[(i + 1) % lp.len()];
            let ends = [a, b].map(|v| input.mesh.positions[*v as usize]);
            segments.push(Segment {
                ends,
                normal: rims.normal[a] + rims.normal[b],
                rim,
            });
        }
    }
    segments
}

/// Distance from vertex `i` to the nearest rim edge across the gap, and its rim loop. Vertex and edge must be on the gap side of
/// each other; if there is no such edge, the nearest edge counts.
fn nearest_rim(outline: &Outline, i: usize, segments: &[Segment]) -> (f64, usize) {
    let (p, normal) = (outline.position[i], outline.normal[i]);
    let mut across = (f64::INFINITY, 0);
    let mut any = across;
    for s in segments {
        let [a, b] = s.ends;
        let d = b - a;
        let t = ((p - a).dot(d) / d.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let q = a + t * d;
        let distance = p.distance_squared(q);
        if distance < across.0 {
            if distance < any.0 {
                any = (distance, s.rim);
            }
            let beyond = t > 0.0 && t < 1.0 && d.cross(p - a).dot(s.normal) < 0.0;
            if !beyond && s.normal.dot(normal) >= 0.0 && outline.opens_towards(i, q) {
                across = (distance, s.rim);
            }
        }
    }
    let best = if across.0.is_finite() { across } else { any };
    (best.0.sqrt(), best.1)
}

/// Joins rim loops that are nearest to no boundary loop to the gap of the nearest other loop, unless they bound a small hole of
/// their own.
fn join_islands(
    input: &StitchInput,
    rims: &Rims,
    kept: &Kept,
    dropped: &BTreeSet<usize>,
    reached: &[bool],
    groups: &mut Groups,
) {
    if reached.iter().all(|&r| r) {
        return;
    }
    // Outlines of the rim loops, then of the boundary loops of the kept part.
    let at = |v: &u32| (input.mesh.positions[*v as usize], rims.normal[v]);
    let mut outlines: Vec<Outline> = rims
        .loops
        .iter()
        .map(|lp| Outline::new(lp.iter().map(at)))
        .collect();
    // Rim loops that bound a small hole of their own.
    let alone: Vec<bool> = (outlines.iter().zip(reached))
        .map(|(o, &reached)| !reached && o.turning() > 0.0 && o.is_thin(input.voxel))
        .collect();
    for (l, lp) in kept.loops.iter().enumerate() {
        let used = !dropped.contains(&kept.loop_component[l]);
        let vertices = lp.iter().rev().filter(|_| used);
        outlines.push(Outline::new(
            vertices.map(|&v| (kept.positions[v as usize], kept.normals[v as usize])),
        ));
    }
    // The other unreached rim loops join the nearest loop.
    let is_alone = |o: usize| alone.get(o).copied().unwrap_or(false);
    for r in (0..reached.len()).filter(|&r| !reached[r] && !is_alone(r)) {
        let island = outlines[r].turning() < -PI;
        let mut best = (FAR_BORDER.get() * input.voxel, r);
        for o in (0..outlines.len()).filter(|&o| o != r && (island || !is_alone(o))) {
            if let Some((d, ..)) = nearest_pair(&outlines[r], &outlines[o], best.0) {
                best = (d, o);
            }
        }
        groups.join(r, best.1);
    }
}

/// Disjoint sets (union-find).
struct Groups(Vec<usize>);

impl Groups {
    fn new(len: usize) -> Self {
        Self((0..len).collect())
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn join(&mut self, i: usize, j: usize) {
        let (i, j) = (self.root(i), self.root(j));
        self.0[i.max(j)] = i.min(j);
    }
}
