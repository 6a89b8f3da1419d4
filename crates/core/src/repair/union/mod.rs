//! Exact union of closed bodies that touch or intersect.
//!
//! Intersecting faces are divided along their exact intersection curves; then the faces with the inside on exactly one side are
//! kept, as in Zhou, Grinspun, Zorin, Jacobson, "Mesh arrangements for solid geometry", 2016. A point is inside if the winding
//! number of the bodies is positive. A body that intersects itself is therefore united with itself, and a cavity stays a cavity.
//! Steps:
//!
//! 1. `clusters`: components that touch or intersect, directly or through others. Only closed ones take part: along each edge as
//!    many faces run in one direction as in the other.
//! 2. `pairs`: the intersections of pairs of faces. Signs are computed by the adaptive predicates of the crate `robust`.
//! 3. `exact`: the intersection points, as quotients of integers (`dashu-int`).
//! 4. `planar`, `arrange`: each face is triangulated with its intersection segments; overlapping coplanar faces are triangulated
//!    together.
//! 5. `classify`: winding numbers of the patches between the curves, by exact rays.
//! 6. `assemble`: writes the kept faces into the draft. Only here new vertices are rounded.
//!
//! All steps but the last are exact, hence the result is closed. Rounding moves new vertices by half a unit in the last place,
//! which may let triangles of about this size intersect or lose their area; these are united again, in a few rounds. Vertices
//! that coincide after rounding are merged, and so are the ends of edges far shorter than the rounding errors of the input
//! (`tidy`).
//!
//! Limits: the union is skipped, and the case left to the other steps of a repair, for coordinates whose magnitudes differ by
//! more than 2 to the power of 512, open components, and more pairs of faces than `union_pairs`.

mod arrange;
mod assemble;
mod classify;
mod clusters;
mod collinear;
mod contact;
mod exact;
mod pairs;
mod planar;
mod tidy;

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::RepairReport;
use super::draft::Draft;
use super::union::contact::UNION_PAIRS;
use crate::mend::{FillError, Inspection};
use crate::mesh::topology::NONE;
use crate::spatial::{Bounds, BoxTree, intersecting_pairs};
use crate::tuning::{Tunable, tunable};
use arrange::arrange;
use assemble::Union;
use classify::{ClosedSurface, multiplicity};
use clusters::{Bodies, Clusters, clusters};
use collinear::Proper;
use exact::Unit;
use planar::ArrangementError;

pub(super) use clusters::{are_closed, paired_components, walls};
pub(super) use contact::{grow, touch_at_edges};

/// Rounds of unions, at most: rounded vertices may make faces intersect again.
const UNION_ROUNDS: Tunable<usize> = tunable("repair.union_rounds", 6);

/// Rounds of a union after the best one.
const VAIN_ROUNDS: Tunable<usize> = tunable("repair.vain_rounds", 2);

/// Factor. If a round of a union leaves more than this many times as many intersecting faces as before, the next one would leave
/// more still: a torus thicker than its ring went from 144 to 1,500 and 18,000 in a minute.
const UNION_GROWTH: Tunable<usize> = tunable("repair.union_growth", 2);

/// Faces. With fewer intersecting faces than this a union goes on, even if they multiply.
const UNION_GROWTH_FACES: Tunable<usize> = tunable("repair.union_growth_faces", 100);

/// Counts of what a union did.
#[derive(Clone, Copy, Debug, Default)]
struct United {
    bodies: usize,
    split: usize,
    removed: usize,
}

/// Unites closed components that touch or intersect; `crossing` are the intersecting faces. New edges shorter than `reach` are
/// collapsed. Parts that are inside out stay only if `turns`. Returns the number of faces that still intersect others; none if nothing was
/// united.
pub(super) fn unite(
    draft: &mut Draft,
    report: &mut RepairReport,
    mut crossing: Vec<u32>,
    (reach, turns): (f64, bool),
) -> Result<Option<usize>, FillError> {
    let mut first: Option<United> = None;
    let known = draft.mesh.positions.len();
    // Keep the best round, since rounding may let more faces intersect than before.
    let mut best: Option<(Draft, usize)> = None;
    let mut vain = 0;
    for _ in 0..UNION_ROUNDS.get() {
        let union = united(draft, &*draft.inspect()?, &crossing, turns);
        let Some(union) = union else {
            break;
        };
        draft.forget_inspection();
        draft.merge_components(&union.clusters);
        let done = union.apply(draft);
        let before = crossing.len();
        crossing = draft.self_intersections()?;
        if !crossing.is_empty() {
            tidy::collapse(draft, known, reach)?;
            crossing = draft.self_intersections()?;
        }
        log::debug!(
            "union of {} bodies: {before} faces intersected others, {} do afterwards",
            done.bodies,
            crossing.len()
        );
        first.get_or_insert(done);
        if crossing.is_empty() {
            best = None;
            break;
        }
        let least = best.as_ref().map_or(usize::MAX, |(_, count)| *count);
        if crossing.len() < least {
            best = Some((draft.clone(), crossing.len()));
            vain = 0;
        } else {
            vain += 1;
        }
        let is_many = crossing.len() > UNION_GROWTH_FACES.get();
        let multiplies = is_many && crossing.len() > UNION_GROWTH.get() * before;
        if vain == VAIN_ROUNDS.get() || multiplies {
            break;
        }
    }
    let Some(done) = first else {
        return Ok(None);
    };
    if let Some((best, count)) = best
        && count < crossing.len()
    {
        *draft = best;
    }
    tidy::collapse(draft, known, reach)?;
    report.steps.inner_faces += tidy::drop_gaps(draft)?;
    report.steps.united_bodies += done.bodies;
    report.steps.split_faces += done.split;
    report.steps.inner_faces += done.removed;
    Ok(Some(draft.self_intersections()?.len()))
}

/// Computes the union of the clusters with intersecting faces; none if there are none, or the arrangement fails.
fn united(draft: &Draft, found: &Inspection, crossing: &[u32], turns: bool) -> Option<Union> {
    let mut bodies = Bodies::new(found);
    if !bodies.any_closed(&found.topology, crossing) {
        log::debug!("union: no intersecting faces belong to closed bodies");
        return None;
    }
    let place = |v: u32| found.weld[v as usize];
    let faces: Vec<[u32; 3]> = (draft.mesh.faces.iter()).map(|f| f.map(place)).collect();
    let own: Vec<[u32; 3]> = crossing.iter().map(|f| faces[*f as usize]).collect();
    if too_many(&draft.mesh.positions, &own) {
        return None;
    }
    let all: Vec<u32> = (0..own.len() as u32).collect();
    let mut pairs = intersecting_pairs(&draft.mesh.positions, &own, &all);
    pairs.retain(|[f, g]| f < g);
    pairs.par_sort_unstable();
    let clusters = clusters(found, bodies, crossing, &pairs);
    if clusters.faces.is_empty() {
        log::debug!("union: no cluster is closed");
        return None;
    }
    let is_own = |f: &u32| clusters.of_face[*f as usize] != NONE;
    let list = crossing.iter().copied().filter(is_own).collect();
    let proper = Proper::of(&draft.mesh.positions, &faces, &clusters.faces, list);
    let place: HashMap<u32, u32> = (0..).zip(&proper.divided).map(|(i, f)| (*f, i)).collect();
    let number = |i: u32| place.get(&crossing[i as usize]).copied();
    let pairs: Vec<[u32; 2]> = (pairs.into_iter())
        .filter_map(|[f, g]| Some([number(f)?, number(g)?]))
        .collect();
    let task = Task {
        draft,
        faces,
        proper,
        pairs,
        clusters,
        turns,
    };
    let solved = task.solve();
    let failed = |_: &ArrangementError| log::debug!("union: the arrangement failed");
    let mut union = solved.inspect_err(failed).ok()?;
    // Sheets without thickness enclose nothing; a mesh of nothing else stays.
    if !union.keeps_any() && union.clusters.len() == found.topology.faces().count() {
        return None;
    }
    union.weld.clone_from(&found.weld);
    Some(union)
}

/// Whether more pairs of boxes intersect than a union is attempted for.
fn too_many(positions: &[DVec3], faces: &[[u32; 3]]) -> bool {
    let boxes: Vec<Bounds> = (faces.iter())
        .map(|f| Bounds::of(f.map(|v| positions[v as usize])))
        .collect();
    let tree = BoxTree::new(&boxes);
    let mut left = UNION_PAIRS.get();
    boxes.iter().any(|own| {
        tree.find(own, |_| {
            left = left.saturating_sub(1);
            left == 0
        });
        left == 0
    })
}

/// Input of a union.
struct Task<'a> {
    draft: &'a Draft,
    /// The faces of the draft on welded vertices.
    faces: Vec<[u32; 3]>,
    /// The intersecting faces, and their pairs as indices into the list of divided ones.
    proper: Proper,
    pairs: Vec<[u32; 2]>,
    clusters: Clusters,
    /// Whether parts that are inside out may stay.
    turns: bool,
}

impl Task<'_> {
    fn solve(self) -> Result<Union, ArrangementError> {
        let positions = &self.draft.mesh.positions;
        let corners = |f: &u32| self.faces[*f as usize].map(|v| positions[v as usize]);
        let own = &self.clusters.faces;
        let unit = Unit::of(own.iter().flat_map(corners)).ok_or(ArrangementError)?;
        let Proper {
            divided,
            collinear,
            cuts,
        } = self.proper;
        let corners_of = |f: &u32| self.faces[*f as usize];
        let own_faces: Vec<[u32; 3]> = divided.iter().map(corners_of).collect();
        let arrangement = arrange(unit, positions, &own_faces, (&self.pairs, &cuts))?;
        let mut is_divided = vec![false; self.faces.len()];
        (divided.iter().chain(&collinear)).for_each(|f| is_divided[*f as usize] = true);
        let whole = || own.iter().filter(|f| !is_divided[**f as usize]);
        let cluster = |f: u32| self.clusters.of_face[f as usize];
        let pieces = arrangement.pieces.iter();
        let surface = ClosedSurface {
            turns: self.turns,
            points: &arrangement.points,
            positions,
            triangles: (whole().map(|f| (self.faces[*f as usize], 1)))
                .chain(pieces.clone().map(|p| (p.nodes, multiplicity(p))))
                .collect(),
            faces: &(own.iter().map(|f| (corners(f), cluster(*f)))).collect::<Vec<_>>(),
            cluster: (whole().map(|f| cluster(*f)))
                .chain(pieces.map(|p| cluster(divided[p.faces[0].0 as usize])))
                .collect(),
        };
        let mut fates = surface.fates()?;
        let of_pieces = fates.split_off(fates.len() - arrangement.pieces.len());
        Ok(Union {
            bodies: self.clusters.bodies,
            clusters: own.iter().map(|f| (*f, cluster(*f))).collect(),
            whole: whole().copied().zip(fates).collect(),
            fates: of_pieces,
            arrangement,
            weld: Vec::new(),
            divided,
            collinear,
        })
    }
}
