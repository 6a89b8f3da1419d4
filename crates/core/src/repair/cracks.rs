//! Cracks: boundary chains that run along each other are joined at the smallest distance that closes them.
//!
//! The distance is not known beforehand: it rises from the precision of the coordinates to a fraction of the mesh and of the edges
//! there. At each distance vertices are merged and edges are split at vertices, and this is kept if it closes boundary edges and no
//! further faces intersect others. Vertices at which it does not work out are left as they are.

use std::collections::HashSet;

use super::RepairReport;
use super::draft::Draft;
use super::seams::WELD_EDGE;
use super::seams::{Reach, merge, split};
use crate::check::JUNCTION_MOST;
use crate::mend::{FillError, Inspection};
use crate::mesh::topology::{NONE, end, start};
use crate::tuning::{Tunable, tunable};

/// Cosine. Faces at an edge whose angle is below this (60°) lie on each other.
pub(super) const FOLDED: Tunable<f64> = tunable("repair.folded", 0.5);

/// Factor from one width at which cracks are closed to the next.
const CRACK_GROWTH: Tunable<f64> = tunable("repair.crack_growth", 4.0);

/// Attempts at each width, at most: each leaves out the vertices at which the one before made faces intersect.
const CRACK_ATTEMPTS: Tunable<usize> = tunable("repair.crack_attempts", 4);

/// Rounds of merging vertices and splitting edges in an attempt, at most.
const CRACK_ROUNDS: Tunable<usize> = tunable("repair.crack_rounds", 6);

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
}

fn record(joined: Option<Joined>, report: &mut RepairReport) {
    let Some(joined) = joined else {
        return;
    };
    report.steps.welded_vertices += joined.merged;
    report.steps.stitched_junctions += joined.split;
    report.steps.degenerate_faces += joined.collapsed;
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
    for _ in 0..CRACK_ATTEMPTS.get() {
        let reach = Reach {
            unit,
            part,
            vertices: kind == Kind::Cracks,
            blocked: &blocked,
        };
        let mut new = draft.clone();
        let joined = join(&mut new, &reach, kind)?;
        if joined.merged + joined.split == 0 {
            return Ok(None);
        }
        let wrong = known.worse(&mut new)?;
        if wrong.is_empty() {
            let closes = boundary_edges(&*new.inspect()?) < known.open;
            let loses = new.faults()?.loses_more(&draft.faults()?);
            if closes && !loses {
                *draft = new;
                return Ok(Some(joined));
            }
            return Ok(None);
        }
        let before = blocked.len();
        blocked.extend(wrong);
        if blocked.len() == before {
            break;
        }
    }
    Ok(None)
}

/// Merges and splits in turn until neither finds anything.
fn join(draft: &mut Draft, reach: &Reach, kind: Kind) -> Result<Joined, FillError> {
    let mut all = Joined::default();
    for _ in 0..CRACK_ROUNDS.get() {
        let merged = match kind {
            Kind::Junctions => 0,
            _ => merge(draft, reach)?,
        };
        let collapsed = draft
            .mesh
            .faces
            .iter()
            .map(|[a, b, c]| a == b || b == c || c == a);
        let collapsed: Vec<bool> = collapsed.collect();
        if kind == Kind::Cracks {
            all.collapsed += draft.remove(&collapsed);
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
        let across = |h: u32| {
            let apex = mesh.faces[h as usize / 3][(h as usize % 3 + 2) % 3];
            let [a, b, c] =
                [start(mesh, h), end(mesh, h), apex].map(|v| mesh.positions[v as usize]);
            (c - a)
                .reject_from_normalized((b - a).normalize_or_zero())
                .normalize_or_zero()
        };
        let are_same = (start(mesh, *h) == start(mesh, *o)) != (turned(*h) != turned(*o));
        are_same && across(*h).dot(across(*o)) > FOLDED.get()
    });
    same.map(|(h, _)| {
        let (v, w) = (start(mesh, h), end(mesh, h));
        (v.min(w), v.max(w))
    })
}

fn boundary_edges(found: &Inspection) -> usize {
    found.topology.boundary.iter().filter(|b| **b).count()
}
