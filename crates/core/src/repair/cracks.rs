//! Cracks: boundary chains that run along each other are joined at the smallest distance that closes them.
//!
//! The distance is not known beforehand: it rises from the precision of the coordinates to a fraction of the mesh and of the edges
//! there. At each distance vertices are merged and edges are split at vertices, and this is kept if it closes boundary edges and no
//! further faces intersect others. Vertices at which it does not work out are left as they are.

use std::collections::HashSet;

use glam::DVec3;

use super::RepairReport;
use super::draft::Draft;
use super::flakes;
use super::seams::WELD_EDGE;
use super::seams::{Reach, merge, split};
use crate::check::{JUNCTION_MOST, duplicates};
use crate::mend::{FillError, Inspection};
use crate::mesh::Mesh;
use crate::mesh::topology::{LOOSE_FACES, NONE, apex, end, start};
use crate::tuning::{Tunable, tunable};

/// Cosine. Faces at an edge whose angle is below this (60°) lie on each other.
pub(super) const FOLDED: Tunable<f64> = tunable("repair.folded", 0.5);

/// Factor from one width at which cracks are closed to the next.
const CRACK_GROWTH: Tunable<f64> = tunable("repair.crack_growth", 4.0);

/// Attempts at each width, at most: each leaves out the vertices at which the one before made faces intersect.
const CRACK_ATTEMPTS: Tunable<usize> = tunable("repair.crack_attempts", 4);

/// Rounds of merging vertices and splitting edges in an attempt, at most.
const CRACK_ROUNDS: Tunable<usize> = tunable("repair.crack_rounds", 6);

/// Boundary edges closed for each vertex of a new fault. Above it an attempt is kept with its faults if none is without: in a heap
/// of loose triangles, vertices that are left out lie on the edges of those beside them. 8593 edges in a plate of 17,186 triangles,
/// 312 in a solid with overlapping faces too.
const CRACK_GAIN: Tunable<f64> = tunable("repair.crack_gain", 100.0);

/// Boundary edges. A vertex of a new fault is as bad as this many that stay open.
const CRACK_FAULT: Tunable<usize> = tunable("repair.crack_fault", 3);

/// Merges boundary edges that coincide within the precision of the coordinates; returns the number of merged vertices.
pub(super) fn weld(draft: &mut Draft) -> Result<usize, FillError> {
    let reach = (draft.unit, JUNCTION_MOST.get());
    let joined = attempt(draft, reach, Kind::Edges)?;
    Ok(joined.map_or(0, |joined| joined.merged))
}

/// Splits edges at T-junctions within the precision of the coordinates, then closes cracks at rising distances up to `most`
/// (mesh units).
pub(super) fn close(
    draft: &mut Draft,
    most: f64,
    report: &mut RepairReport,
) -> Result<(), FillError> {
    let first = (draft.unit, JUNCTION_MOST.get());
    record(attempt(draft, first, Kind::Junctions)?, report);
    let mut unit = draft.unit;
    while unit < most && is_open(draft)? {
        unit = (CRACK_GROWTH.get() * unit).min(most);
        let reach = (unit, WELD_EDGE.get());
        let joined = attempt(draft, reach, Kind::Cracks)?;
        if let Some(joined) = &joined {
            report.steps.crack_width = unit;
            log::debug!("cracks of {unit:e}: {joined:?}");
        }
        record(joined, report);
    }
    let width = draft.unit.max(report.steps.crack_width);
    report.steps.duplicate_faces += flakes::drop(draft, width)?;
    Ok(())
}

fn is_open(draft: &Draft) -> Result<bool, FillError> {
    Ok(draft.inspect()?.topology.boundary.contains(&true))
}

/// What is joined at a distance.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Edges whose ends coincide.
    Edges,
    /// Edges with vertices on them.
    Junctions,
    /// Both, and vertices that nearly coincide.
    Cracks,
}

/// What was joined.
#[derive(Debug, Default)]
struct Joined {
    merged: usize,
    split: usize,
    /// Faces that shrank to an edge or a point.
    collapsed: usize,
    /// Faces that coincided with another one.
    doubled: usize,
}

fn record(joined: Option<Joined>, report: &mut RepairReport) {
    let Some(joined) = joined else {
        return;
    };
    report.steps.welded_vertices += joined.merged;
    report.steps.stitched_junctions += joined.split;
    report.steps.degenerate_faces += joined.collapsed;
    report.steps.duplicate_faces += joined.doubled;
}

/// Joins what is within `unit` (mesh units) and `part` of the edge lengths there, except where this makes faces intersect or edges
/// non-manifold. None if it closes no boundary edge; the draft is unchanged then.
fn attempt(
    draft: &mut Draft,
    (unit, part): (f64, f64),
    kind: Kind,
) -> Result<Option<Joined>, FillError> {
    if !is_open(draft)? {
        return Ok(None);
    }
    let known = Known::new(draft, kind)?;
    let mut blocked: HashSet<u32> = HashSet::new();
    // The first attempt that closes much more than it spoils, and the number of edges that one without faults must close to be better.
    let mut kept = None;
    let mut wanted = 0;
    for _ in 0..CRACK_ATTEMPTS.get() {
        let reach = Reach {
            unit,
            part,
            vertices: kind == Kind::Cracks,
            blocked: &blocked,
        };
        let mut new = draft.clone();
        let joined = join(&mut new, &reach, (kind, &known.larger))?;
        if joined.merged + joined.split == 0 {
            break;
        }
        let wrong = known.worse(&mut new)?;
        let open = boundary_edges(&*new.inspect()?);
        let closed = known.open.saturating_sub(open);
        let much = CRACK_GAIN.get() * wrong.len() as f64;
        let closes = closed > wanted && closed as f64 > much;
        if closes && known.larger.is_subset(&new.components_left()) {
            wanted = closed.saturating_sub(CRACK_FAULT.get() * wrong.len());
            kept = Some((new, joined));
        }
        if wrong.is_empty() {
            break;
        }
        let before = blocked.len();
        blocked.extend(wrong);
        if blocked.len() == before {
            break;
        }
    }
    Ok(kept.map(|(new, joined)| {
        *draft = new;
        joined
    }))
}

/// Merges and splits in turn until neither finds anything. Faces of other components than the `larger` ones go if they get the vertices
/// of another face.
fn join(
    draft: &mut Draft,
    reach: &Reach,
    (kind, larger): (Kind, &HashSet<u32>),
) -> Result<Joined, FillError> {
    let mut all = Joined::default();
    for _ in 0..CRACK_ROUNDS.get() {
        let merged = match kind {
            Kind::Junctions => 0,
            _ => merge(draft, reach)?,
        };
        if kind == Kind::Cracks {
            let collapsed: Vec<bool> = (draft.mesh.faces.iter())
                .map(|[a, b, c]| a == b || b == c || c == a)
                .collect();
            all.collapsed += draft.remove(&collapsed);
            all.doubled += drop_doubled(draft, larger)?;
        }
        let split = match kind {
            Kind::Edges => 0,
            _ => split(draft, reach)?,
        };
        all.merged += merged;
        all.split += split;
        if merged + split == 0 {
            break;
        }
    }
    Ok(all)
}

/// Removes faces of other components than the `larger` ones that have the vertices of an earlier face; returns how many.
fn drop_doubled(draft: &mut Draft, larger: &HashSet<u32>) -> Result<usize, FillError> {
    let found = draft.inspect()?;
    let mut removed = vec![false; draft.mesh.faces.len()];
    for f in duplicates(&found.mesh, &found.topology) {
        removed[f as usize] = !larger.contains(&draft.component(f as usize));
    }
    Ok(draft.remove(&removed))
}

/// The faults of a draft before an attempt.
struct Known {
    /// Input faces that intersect others.
    crossing: HashSet<u32>,
    /// Non-manifold edges between welded vertices, the smaller number first.
    crowded: HashSet<(u32, u32)>,
    /// Edges at which two faces lie on each other and run in the same direction; none where these are joined too. So do the borders of
    /// two sheets beside each other, and no sides of a crack.
    folded: Option<HashSet<(u32, u32)>>,
    /// Number of boundary edges.
    open: usize,
    /// The input components that are more than loose triangles and have a face left. The others may be slivers, which shrink to
    /// nothing where they are merged with their neighbours.
    larger: HashSet<u32>,
}

impl Known {
    fn new(draft: &mut Draft, kind: Kind) -> Result<Self, FillError> {
        let crossing = draft.self_intersections()?;
        let found = draft.inspect()?;
        Ok(Self {
            crossing: (crossing.iter())
                .map(|f| draft.origins.faces[*f as usize].face)
                .collect(),
            crowded: crowded(&found).collect(),
            folded: (kind == Kind::Cracks).then(|| folded(&found).collect()),
            open: boundary_edges(&found),
            larger: draft.components_above(LOOSE_FACES),
        })
    }

    /// The welded vertices of faces that intersect others and of non-manifold edges, both only if they are new.
    fn worse(&self, new: &mut Draft) -> Result<Vec<u32>, FillError> {
        let crossing = new.self_intersections()?;
        let found = new.inspect()?;
        let mut wrong: Vec<u32> = Vec::new();
        for f in crossing {
            let origin = new.origins.faces[f as usize].face;
            if origin == NONE || !self.crossing.contains(&origin) {
                wrong.extend(found.mesh.faces[f as usize]);
            }
        }
        let edges = crowded(&found).filter(|e| !self.crowded.contains(e));
        wrong.extend(edges.flat_map(|(v, w)| [v, w]));
        if let Some(known) = &self.folded {
            let edges = folded(&found).filter(|e| !known.contains(e));
            wrong.extend(edges.flat_map(|(v, w)| [v, w]));
        }
        Ok(wrong)
    }
}

fn crowded(found: &Inspection) -> impl Iterator<Item = (u32, u32)> {
    let edges = found.topology.non_manifold_edges(&found.mesh).into_iter();
    edges.map(|edge| {
        let (v, w) = (start(&found.mesh, edge[0]), end(&found.mesh, edge[0]));
        (v.min(w), v.max(w))
    })
}

/// The edges along which two faces run in the same direction, in the orientation of the draft, and lie on the same side.
fn folded(found: &Inspection) -> impl Iterator<Item = (u32, u32)> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let half_edges = 0..topology.opposite.len() as u32;
    let pairs = half_edges.map(|h| (h, topology.opposite[h as usize]));
    let pairs = pairs.filter(|(h, o)| *o != NONE && h < o);
    let same = pairs.filter(|(h, o)| {
        let turned = |h: u32| topology.turned[h as usize / 3];
        let are_same = (start(mesh, *h) == start(mesh, *o)) != (turned(*h) != turned(*o));
        are_same && across(mesh, *h).dot(across(mesh, *o)) > FOLDED.get()
    });
    same.map(|(h, _)| {
        let (v, w) = (start(mesh, h), end(mesh, h));
        (v.min(w), v.max(w))
    })
}

/// The unit vector in a face that points away from one of its edges, at right angles.
pub(super) fn across(mesh: &Mesh, half_edge: u32) -> DVec3 {
    let corners = [start, end, apex].map(|of| mesh.positions[of(mesh, half_edge) as usize]);
    let [a, b, c] = corners;
    (c - a)
        .reject_from_normalized((b - a).normalize_or_zero())
        .normalize_or_zero()
}

fn boundary_edges(found: &Inspection) -> usize {
    found.topology.boundary.iter().filter(|b| **b).count()
}
