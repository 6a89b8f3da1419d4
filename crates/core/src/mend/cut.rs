//! Cuts the marked faces out of a mesh, and finds the holes that the cut makes.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::plan::FillPlan;
use super::report::FillReport;
use super::{Inspection, RestoreError};
use crate::fill::{FillParams, HoleOutcome, LeftReason};
use crate::mesh::cut::{Remainder, settled, without_spikes};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{HoleId, VertexFaces};

/// Marked components of at most this many faces are removed without a replacement; their holes are not filled.
const SMALL_FACES: usize = 2;

/// Cuts that are tried, each wider than the one before by the faces around the ends of its rim. A face given twice, or a fin, needs
/// two or three; along a seam where three surfaces meet no number is enough.
const WIDENINGS: usize = 6;

/// An edge between vertices of the welded input, the smaller vertex number first.
type Edge = (u32, u32);

/// The result of a cut: the removed faces, the remaining mesh and its holes.
pub(super) struct CutResult<'a> {
    /// The mesh before the cut.
    pub(super) before: &'a Inspection<'a>,
    /// Whether each face is removed: the marked faces, and those without which there would be no clean rim.
    pub(super) removed: Vec<bool>,
    /// Whether each vertex remains.
    vertices: Vec<bool>,
    /// The mesh after the cut, and its holes.
    pub(super) found: Inspection<'static>,
    /// The numbers of the holes that the cut made or changed.
    made: Vec<HoleId>,
    /// The holes of the mesh before the cut whose rims are not rims any more.
    pub(super) joined_holes: Vec<HoleId>,
    /// For each hole the component of the removed faces that it bounds, as an index into `bounds`.
    part: Vec<Option<usize>>,
    /// The bounding boxes of the connected components of the removed faces.
    bounds: Vec<(DVec3, DVec3)>,
}

impl<'a> CutResult<'a> {
    /// Cuts the marked faces out of an inspected mesh, and, if `small_parts` is set, also small components that would remain
    /// inside. A cut whose rim does not close, because it meets an edge of more than two faces, is widened.
    ///
    /// # Errors
    /// If nothing of a component would remain, or one or two faces, if the cut reaches an outer border, or if its rim does not close after
    /// [`WIDENINGS`] cuts.
    pub(super) fn new(
        before: &'a Inspection<'a>,
        marked: &[bool],
        keep_vertices: bool,
        small_parts: bool,
    ) -> Result<Self, RestoreError> {
        let mut marked = without_spikes(&before.topology, marked);
        // A vertex where the rim of the first cut ends, and how many faces a wider one may remove.
        let mut first = None;
        for _ in 0..WIDENINGS {
            let removed = settled(&before.mesh, &before.topology, &marked, small_parts);
            refuse_whole_components(before, &removed)?;
            let kept = Remainder::new(&before.input, &removed, keep_vertices);
            let found = Inspection::new(kept.mesh)?;
            let origin = before.weld.iter().zip(&kept.vertices);
            let origin: Vec<u32> = origin.filter(|(_, kept)| **kept).map(|(w, _)| *w).collect();
            let number = |v: u32| origin[v as usize];
            let rims: Vec<Vec<Edge>> = found.holes.iter().map(|h| edges(&h.rim, number)).collect();
            let scraps = scraps(before, &found, &rims, &removed);
            if !scraps.is_empty() {
                marked = removed;
                scraps.into_iter().for_each(|f| marked[f] = true);
                continue;
            }
            let ends = open_ends(before, &found, &rims, &origin);
            if ends.is_empty() {
                return Self::with_rims(before, removed, kept.vertices, found, &rims);
            }
            let (_, most) = *first.get_or_insert((ends[0], most_removed(&removed)));
            if count(&removed) > most {
                break;
            }
            marked = widened(before, removed, &ends);
        }
        let place = first.map_or(0, |(v, _)| v);
        let p = before.mesh.positions[place as usize];
        Err(RestoreError::OpenRim {
            x: p.x,
            y: p.y,
            z: p.z,
        })
    }

    /// The result of a cut whose rims close.
    fn with_rims(
        before: &'a Inspection<'a>,
        removed: Vec<bool>,
        vertices: Vec<bool>,
        found: Inspection<'static>,
        rims: &[Vec<Edge>],
    ) -> Result<Self, RestoreError> {
        let made = made(before, &found, rims)?;
        let joined_holes = joined_holes(before, &found, rims, &made);
        let (of_edge, bounds) = parts(before, &removed);
        let part = rims
            .iter()
            .map(|rim| rim.iter().find_map(|e| of_edge.get(e).copied()))
            .collect();
        Ok(Self {
            before,
            removed,
            vertices,
            found,
            made,
            joined_holes,
            part,
            bounds,
        })
    }

    /// The parameters of the fill of the holes that the cut made.
    pub(super) fn params(&self, fill: &FillParams) -> FillParams {
        FillParams {
            flat: fill.flat.clone(),
            bridge: match fill.apart {
                true => Vec::new(),
                false => self.bridges(),
            },
            flat_base: false,
            base_offset: None,
            ..fill.of_holes(Some(self.made.clone()))
        }
    }

    /// Converts the plan of a fill after the cut to one that describes the mesh before it.
    pub(super) fn adapt_plan(&self, plan: &mut FillPlan) {
        plan.input.describe(self.before);
        for hole in &mut plan.holes {
            if let Some(HoleOutcome::Left(why)) = &mut hole.outcome {
                *why = LeftReason::NotMarked;
            }
        }
        for region in &mut plan.regions {
            region.bridge = false;
        }
    }

    /// Converts the report of a fill after the cut to one that describes the mesh before it.
    pub(super) fn adapt_report(&self, report: &mut FillReport) {
        report.input.describe(self.before);
        for hole in &mut report.holes {
            if let HoleOutcome::Left(why) = &mut hole.outcome {
                *why = LeftReason::NotMarked;
            }
        }
        for region in &mut report.regions {
            region.bridge = false;
        }
    }

    /// Number of removed faces and vertices.
    pub(super) fn removed_counts(&self) -> [usize; 2] {
        let gone = self.vertices.iter().filter(|kept| !**kept).count();
        [count(&self.removed), gone]
    }

    /// The remaining mesh.
    pub(super) fn into_kept(self) -> Remainder {
        Remainder {
            mesh: self.found.input.into_owned(),
            faces: self.removed.iter().map(|r| !r).collect(),
            vertices: self.vertices,
        }
    }

    /// Groups of holes that bound the same component of the removed faces: they are filled together.
    fn bridges(&self) -> Vec<Vec<HoleId>> {
        let mut of_part: BTreeMap<usize, Vec<HoleId>> = BTreeMap::new();
        for &id in &self.made {
            if let Some(part) = self.part[id.get() - 1] {
                of_part.entry(part).or_default().push(id);
            }
        }
        of_part.into_values().filter(|ids| ids.len() > 1).collect()
    }

    /// For each hole the bounding box of the faces removed there.
    pub(super) fn extents(&self) -> Vec<Option<(DVec3, DVec3)>> {
        let bounds = |part: &Option<usize>| part.map(|p| self.bounds[p]);
        self.part.iter().map(bounds).collect()
    }
}

/// Number of marks that are set.
pub(super) fn count(marks: &[bool]) -> usize {
    marks.iter().filter(|m| **m).count()
}

fn key(v: u32, w: u32) -> Edge {
    (v.min(w), v.max(w))
}

/// The edges of a rim, in vertex numbers of the welded input: those that `number` has for its vertices.
fn edges(rim: &[u32], number: impl Fn(u32) -> u32) -> Vec<Edge> {
    let next = rim.iter().cycle().skip(1);
    rim.iter()
        .zip(next)
        .map(|(&v, &w)| key(number(v), number(w)))
        .collect()
}

/// Refuses a cut that removes a whole component of more than two faces.
fn refuse_whole_components(before: &Inspection, removed: &[bool]) -> Result<(), RestoreError> {
    let mut left = before.topology.component_faces.clone();
    for (&component, _) in before
        .topology
        .component
        .iter()
        .zip(removed)
        .filter(|(_, r)| **r)
    {
        if component != NONE {
            left[component as usize] -= 1;
        }
    }
    let sizes = before.topology.component_faces.iter().zip(&left);
    let whole = sizes.filter(|(all, left)| **left == 0 && **all > SMALL_FACES);
    match whole.map(|(all, _)| *all).max() {
        Some(faces) => Err(RestoreError::WholeComponent { faces }),
        None if left.iter().all(|l| *l == 0) => Err(RestoreError::WholeComponent {
            faces: removed.len(),
        }),
        None => Ok(()),
    }
}

/// The remaining faces of components that the cut leaves with so few faces that no hole of them is filled.
fn scraps(
    before: &Inspection,
    found: &Inspection,
    rims: &[Vec<Edge>],
    removed: &[bool],
) -> Vec<usize> {
    let size = |component: u32| found.topology.component_faces[component as usize];
    let small = found.holes.iter().zip(rims);
    let small: Vec<_> = small
        .filter(|(hole, _)| size(hole.component) <= SMALL_FACES)
        .collect();
    if small.is_empty() {
        return Vec::new();
    }
    let old = boundary_edges(before);
    let is_cut = |rim: &[Edge]| rim.iter().any(|edge| !old.contains(edge));
    let cut = small.into_iter().filter(|(_, rim)| is_cut(rim));
    let components: BTreeSet<u32> = cut.map(|(hole, _)| hole.component).collect();
    let kept = (0..removed.len()).filter(|&f| !removed[f]);
    let kept = kept.zip(&found.topology.component);
    kept.filter(|(_, component)| components.contains(component))
        .map(|(f, _)| f)
        .collect()
}

/// The vertices at which parts of a cut's rim end that do not close, as vertices of the mesh before the cut. A closed rim enters
/// each of its vertices as often as it leaves it.
fn open_ends(
    before: &Inspection,
    found: &Inspection,
    rims: &[Vec<Edge>],
    origin: &[u32],
) -> Vec<u32> {
    if found.open_chains.is_empty() {
        return Vec::new();
    }
    let old = boundary_edges(before);
    let closed: BTreeSet<&Edge> = rims.iter().flatten().collect();
    let at = |v: u32| origin[v as usize];
    let mut balance: BTreeMap<u32, isize> = BTreeMap::new();
    let mut on_cut = BTreeSet::new();
    for h in
        (0..found.topology.boundary.len() as u32).filter(|h| found.topology.boundary[*h as usize])
    {
        let (from, to) = (at(start(&found.mesh, h)), at(end(&found.mesh, h)));
        let edge = key(from, to);
        if closed.contains(&edge) {
            continue;
        }
        *balance.entry(from).or_default() += 1;
        *balance.entry(to).or_default() -= 1;
        if !old.contains(&edge) {
            on_cut.extend([from, to]);
        }
    }
    // Chains of the input that the cut does not touch stay as they are.
    let ends: Vec<u32> = on_cut.iter().copied().filter(|v| balance[v] != 0).collect();
    match ends.is_empty() {
        true => on_cut.into_iter().collect(),
        false => ends,
    }
}

/// The largest number of faces that a widened cut may remove: beyond it the cut follows a seam.
fn most_removed(first: &[bool]) -> usize {
    2 * count(first) + 16
}

/// The removed faces, and those around some vertices.
fn widened(before: &Inspection, removed: Vec<bool>, vertices: &[u32]) -> Vec<bool> {
    let around = VertexFaces::new(&before.mesh);
    let mut marked = removed;
    for f in vertices.iter().flat_map(|&v| around.of(v)) {
        marked[*f as usize] = true;
    }
    marked
}

/// The boundary edges of a mesh.
fn boundary_edges(found: &Inspection) -> BTreeSet<Edge> {
    (0..found.topology.boundary.len() as u32)
        .filter(|&h| found.topology.boundary[h as usize])
        .map(|h| key(start(&found.mesh, h), end(&found.mesh, h)))
        .collect()
}

/// The numbers of the holes that the cut made or changed.
fn made(
    before: &Inspection,
    found: &Inspection,
    rims: &[Vec<Edge>],
) -> Result<Vec<HoleId>, RestoreError> {
    let old = boundary_edges(before);
    let outer: BTreeSet<Edge> = before
        .holes
        .iter()
        .filter(|h| h.outer_boundary)
        .flat_map(|h| edges(&h.rim, |v| v))
        .collect();
    let mut ids = Vec::new();
    for (hole, rim) in found.holes.iter().zip(rims) {
        if rim.iter().all(|e| old.contains(e)) {
            continue;
        }
        if let Some(edge) = rim.iter().find(|e| outer.contains(e)) {
            let p = before.input.positions[edge.0 as usize];
            return Err(RestoreError::Border {
                x: p.x,
                y: p.y,
                z: p.z,
            });
        }
        ids.push(hole.id);
    }
    Ok(ids)
}

/// The holes of the mesh before the cut whose rims are not rims any more; `made` are those that the cut made or changed.
fn joined_holes(
    before: &Inspection,
    found: &Inspection,
    rims: &[Vec<Edge>],
    made: &[HoleId],
) -> Vec<HoleId> {
    let same = found.holes.iter().zip(rims);
    let same = same.filter(|(hole, _)| !made.contains(&hole.id));
    let same: BTreeSet<&Edge> = same.flat_map(|(_, rim)| rim).collect();
    let is_joined = |rim: &[u32]| edges(rim, |v| v).iter().any(|e| !same.contains(e));
    let joined = before.holes.iter().filter(|h| is_joined(&h.rim));
    joined.map(|h| h.id).collect()
}

/// The connected components of the removed faces: the component at each edge along the cut, and their bounding boxes.
fn parts(before: &Inspection, removed: &[bool]) -> (BTreeMap<Edge, usize>, Vec<(DVec3, DVec3)>) {
    let (mesh, topology) = (&before.mesh, &before.topology);
    let (mut of_edge, mut bounds) = (BTreeMap::new(), Vec::new());
    let mut seen = vec![false; removed.len()];
    for seed in 0..removed.len() {
        if !removed[seed] || std::mem::replace(&mut seen[seed], true) {
            continue;
        }
        let mut stack = vec![seed];
        let mut around = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        while let Some(f) = stack.pop() {
            for k in 0..3 {
                let h = (3 * f + k) as u32;
                let p = mesh.positions[start(mesh, h) as usize];
                around = (around.0.min(p), around.1.max(p));
                match topology.opposite[h as usize] {
                    NONE => {}
                    other if removed[other as usize / 3] => {
                        if !std::mem::replace(&mut seen[other as usize / 3], true) {
                            stack.push(other as usize / 3);
                        }
                    }
                    _ => {
                        of_edge.insert(key(start(mesh, h), end(mesh, h)), bounds.len());
                    }
                }
            }
        }
        bounds.push(around);
    }
    (of_edge, bounds)
}
