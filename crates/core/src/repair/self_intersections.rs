//! Cuts self-intersections: removes intersecting faces with the faces round them, then parts that lie inside or under others.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::choice::SMALL_FACES;
use super::dangling;
use super::draft::Draft;
use super::inner_sheets::sampled;
use super::steps::SelfIntersectionPass;
use super::witness::BEFORE;
use crate::mend::{FillError, Inspection};
use crate::mesh::cut::settled;
use crate::mesh::topology::NONE;
use crate::mesh::{DisjointSets, Mesh, Topology, area_vector, face_normal};
use crate::spatial::meets;
use crate::spatial::{Bvh, WindingTree};
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Winding number of the other component. A sample point in front of a face lies inside the other component above this;
/// half of the points decide.
const INSIDE: Tunable<f64> = tunable("repair.inside", 0.5);

/// Mean edges. A sheet covers another one that is at most this far below it.
const COVER: Tunable<f64> = tunable("repair.cover", 4.0);

/// Least cosine between the faces of two such sheets: 60°.
const SAME_WAY: Tunable<f64> = tunable("repair.same_way", 0.5);

/// Fraction of a component inside others. Above this the component is kept as an inner one, and its visible part is
/// removed.
const SUBMERGED: Tunable<f64> = tunable("repair.submerged", 0.9);

/// Result of a pass of cuts.
pub(super) struct CutResult {
    pub(super) pass: SelfIntersectionPass,
    /// Faces removed because they lay inside another surface or were covered by one.
    pub(super) covered: usize,
    /// Input faces removed.
    pub(super) own: usize,
}

/// Cuts out patch faces that intersect others, with `rings` rings of patch faces round them, and the faces that intersect these.
/// Other faces are kept, since patches are to give way. None if there is nothing to cut or more than `most` input faces would be
/// removed.
pub(super) fn cut_patches(
    draft: &mut Draft,
    rings: usize,
    most: usize,
) -> Result<Option<CutResult>, FillError> {
    let pairs = draft.self_intersection_pairs()?;
    let (removed, cut) = {
        let found = draft.inspect()?;
        let (mesh, topology) = (&found.mesh, &found.topology);
        let is_new = |f: u32| draft.region[f as usize] != NONE;
        let mut marks = vec![false; mesh.faces.len()];
        for &(f, _) in pairs.iter().filter(|(f, _)| is_new(*f)) {
            marks[f as usize] = true;
        }
        let count = marks.iter().filter(|m| **m).count();
        if count == 0 {
            return Ok(None);
        }
        let mut near = marks.clone();
        let all = vec![Some(rings); topology.component_faces.len()];
        grow(mesh, topology, &mut near, &all);
        for f in (0..marks.len()).filter(|f| near[*f]) {
            marks[f] |= is_new(f as u32);
        }
        for &(f, _) in pairs.iter().filter(|(f, _)| near[*f as usize]) {
            marks[f as usize] = true;
        }
        let removed = settled(mesh, topology, &marks, true);
        let pass = SelfIntersectionPass {
            intersecting_faces: count,
            cut_faces: removed.iter().filter(|r| **r).count(),
            rings,
        };
        (removed, CutResult::plain(pass))
    };
    Ok(apply(draft, removed, cut, most))
}

/// Cuts out the faces that intersect others with `rings` rings of faces round them, then the parts that lie inside others. None
/// if nothing can be cut.
pub(super) fn cut(draft: &mut Draft, rings: usize) -> Result<Option<CutResult>, FillError> {
    let pairs = draft.self_intersection_pairs()?;
    let (removed, cut) = {
        let found = draft.inspect()?;
        let dangling = dangling::components(draft, &found.topology);
        let Some(removed) = cuts(&found, rings, &dangling, &pairs) else {
            return Ok(None);
        };
        let marked = removed.iter().filter(|r| **r).count();
        let inner = Parts::new(&found, &removed, &pairs).covered();
        let mut all = removed;
        inner.iter().for_each(|f| all[*f as usize] = true);
        let all = if inner.is_empty() {
            all
        } else {
            settled(&found.mesh, &found.topology, &all, true)
        };
        let pass = SelfIntersectionPass {
            intersecting_faces: pairs.len(),
            cut_faces: marked,
            rings,
        };
        let covered = all.iter().filter(|r| **r).count() - marked;
        let cut = CutResult {
            covered,
            ..CutResult::plain(pass)
        };
        (all, cut)
    };
    Ok(apply(draft, removed, cut, usize::MAX))
}

/// Removes the faces, unless more than `most` come from the input or none remain to be removed. No input component is removed
/// entirely.
fn apply(
    draft: &mut Draft,
    mut removed: Vec<bool>,
    cut: CutResult,
    most: usize,
) -> Option<CutResult> {
    draft.protect_components(&mut removed);
    let gone = removed.iter().zip(&draft.region);
    let own = gone.filter(|(r, region)| **r && **region == NONE).count();
    if own > most || !removed.contains(&true) {
        return None;
    }
    draft.remove(&removed);
    Some(CutResult { own, ..cut })
}

impl CutResult {
    fn plain(pass: SelfIntersectionPass) -> Self {
        Self {
            pass,
            covered: 0,
            own: 0,
        }
    }
}

/// The faces to cut out for these intersecting pairs, including dangling sheets of which little would be left.
fn cuts(
    found: &Inspection,
    rings: usize,
    dangling: &[bool],
    pairs: &[(u32, u32)],
) -> Option<Vec<bool>> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let mut rings_of = vec![Some(rings); topology.component_faces.len()];
    let component = |f: u32| topology.component[f as usize] as usize;
    loop {
        // Components whose number of rings is `None` are not cut; the others get holes round them.
        let mut marks = vec![false; mesh.faces.len()];
        for &(f, _) in pairs
            .iter()
            .filter(|(f, _)| rings_of[component(*f)].is_some())
        {
            marks[f as usize] = true;
        }
        if !marks.contains(&true) {
            return None;
        }
        // Cut with the present numbers of rings and count what is left of each component.
        grow(mesh, topology, &mut marks, &rings_of);
        let mut removed = settled(mesh, topology, &marks, true);
        let mut left = topology.component_faces.clone();
        for f in topology.faces().filter(|f| removed[*f as usize]) {
            left[component(f)] -= 1;
        }
        // One or two faces left of a larger component enclose nothing: retry with 0 rings, where such a remainder is accepted.
        let little = |p: usize| {
            let wide = rings_of[p].is_some_and(|rings| rings > 0);
            left[p] == 0
                || (wide
                    && left[p] <= SMALL_FACES.get()
                    && topology.component_faces[p] > SMALL_FACES.get())
        };
        let gone: Vec<usize> = (0..left.len())
            .filter(|&p| little(p) && !dangling[p])
            .collect();
        if gone.is_empty() {
            for f in topology.faces() {
                removed[f as usize] |= dangling[component(f)] && little(component(f));
            }
            return Some(removed);
        }
        // Components that would vanish are tried with fewer rings, at last uncut.
        for p in gone {
            rings_of[p] = match rings_of[p] {
                Some(0) | None => None,
                Some(_) => Some(0),
            };
        }
    }
}

/// Adds rings of faces round the marked ones, as many as `rings_of` gives for their component.
fn grow(mesh: &Mesh, topology: &Topology, marks: &mut [bool], rings_of: &[Option<usize>]) {
    let most = rings_of.iter().flatten().copied().max().unwrap_or(0);
    for ring in 0..most {
        let mut near = vec![false; mesh.positions.len()];
        let marked = mesh.faces.iter().zip(&*marks).filter(|(_, m)| **m);
        marked
            .flat_map(|(f, _)| f)
            .for_each(|&v| near[v as usize] = true);
        for f in topology.faces() {
            let wanted =
                rings_of[topology.component[f as usize] as usize].is_some_and(|n| ring < n);
            if wanted && mesh.faces[f as usize].iter().any(|v| near[*v as usize]) {
                marks[f as usize] = true;
            }
        }
    }
}

/// The parts into which the cuts divide intersecting components.
struct Parts<'a> {
    found: &'a Inspection<'a>,
    /// For each component the group of components that intersect each other; `u32::MAX` for components that intersect none.
    group: Vec<u32>,
    /// The faces of each part.
    faces: Vec<Vec<u32>>,
    /// Distance within which one surface covers another, in mesh units.
    reach: f64,
}

impl<'a> Parts<'a> {
    fn new(found: &'a Inspection<'a>, removed: &[bool], pairs: &[(u32, u32)]) -> Self {
        let topology = &found.topology;
        let component = |f: u32| topology.component[f as usize];
        // Group components that intersect each other.
        let mut sets = DisjointSets::new(topology.component_faces.len());
        let mut crosses = vec![false; topology.component_faces.len()];
        for &(f, g) in pairs {
            sets.join(component(f), component(g));
            crosses[component(f) as usize] = true;
            crosses[component(g) as usize] = true;
        }
        let group: Vec<u32> = (0..crosses.len() as u32)
            .map(|p| {
                if crosses[p as usize] {
                    sets.find(p)
                } else {
                    NONE
                }
            })
            .collect();
        // Flood the remaining faces of these components into parts.
        let mut seen = removed.to_vec();
        let mut faces = Vec::new();
        for seed in topology.faces() {
            let own = group[component(seed) as usize];
            if own == NONE || std::mem::replace(&mut seen[seed as usize], true) {
                continue;
            }
            let mut part = vec![seed];
            let mut next = 0;
            while let Some(&f) = part.get(next) {
                next += 1;
                for h in 3 * f..3 * f + 3 {
                    let o = topology.opposite[h as usize];
                    if o != NONE && !std::mem::replace(&mut seen[o as usize / 3], true) {
                        part.push(o / 3);
                    }
                }
            }
            faces.push(part);
        }
        // The mean edge of the intersecting faces sets the reach.
        let (mut length, mut count) = (0.0, 0.0);
        for &(f, _) in pairs {
            let [a, b, c] = found.mesh.corners(f);
            length += a.distance(b) + b.distance(c) + c.distance(a);
            count += 3.0;
        }
        Self {
            found,
            group,
            faces,
            reach: COVER.get() * length / f64::max(count, 1.0),
        }
    }

    fn component(&self, part: usize) -> usize {
        self.found.topology.component[self.faces[part][0] as usize] as usize
    }

    /// The faces of parts that lie inside the surface they intersect, or are covered by another layer of it.
    fn covered(&self) -> Vec<u32> {
        let mut of_group: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for part in 0..self.faces.len() {
            of_group
                .entry(self.group[self.component(part)])
                .or_default()
                .push(part);
        }
        let mut covered = Vec::new();
        for (group, parts) in of_group.into_iter().filter(|(_, parts)| parts.len() > 1) {
            let topology = &self.found.topology;
            let of_group = |f: &u32| self.group[topology.component[*f as usize] as usize] == group;
            let bvh = Bvh::new(&self.found.mesh, topology.faces().filter(of_group));
            let tree = WindingTree::new(&bvh);
            let under: Vec<[bool; 2]> = parts
                .par_iter()
                .map(|&part| self.is_covered(part, &bvh, &tree))
                .collect_indexed();
            covered.extend(self.to_go(&parts, &under));
        }
        covered
            .into_iter()
            .flat_map(|part| self.faces[part].iter().copied())
            .collect()
    }

    /// Whether a part lies inside the surface it intersects, and whether another surface layer covers it: by majority of sampled
    /// faces.
    fn is_covered(&self, part: usize, bvh: &Bvh, tree: &WindingTree) -> [bool; 2] {
        let mesh = &self.found.mesh;
        let faces = &self.faces[part];
        let (mut inside, mut layered, mut all) = (0, 0, 0);
        for &f in sampled(faces) {
            let corners = mesh.corners(f);
            let normal = face_normal(mesh, f);
            if normal == DVec3::ZERO {
                continue;
            }
            let centre = corners.iter().sum::<DVec3>() / 3.0;
            let before = BEFORE.get() * (0.5 * area_vector(corners).length()).sqrt();
            let winding = tree.winding_number(bvh, centre + before * normal);
            all += 1;
            inside += usize::from(winding > INSIDE.get());
            layered += usize::from(self.is_under_other(f, centre, normal, bvh));
        }
        [2 * inside > all, 2 * layered > all]
    }

    /// Whether the first face in front of a face, within reach, has a similar normal.
    fn is_under_other(&self, face: u32, centre: DVec3, normal: DVec3, bvh: &Bvh) -> bool {
        let mesh = &self.found.mesh;
        let end = centre + self.reach * normal;
        let mut first: Option<(f64, u32)> = None;
        bvh.for_each_in_box(centre.min(end), centre.max(end), |g| {
            if g == face {
                return;
            }
            let along = meets(centre, normal, mesh.corners(g));
            if let Some(t) = along.filter(|t| *t < self.reach)
                && first.is_none_or(|best| (t, g) < best)
            {
                first = Some((t, g));
            }
        });
        first.is_some_and(|(_, g)| face_normal(mesh, g).dot(normal) > SAME_WAY.get())
    }

    /// The parts of a group to remove.
    fn to_go(&self, parts: &[usize], under: &[[bool; 2]]) -> Vec<usize> {
        let area = |part: usize| {
            let corners = self.faces[part].iter().map(|f| self.found.mesh.corners(*f));
            corners.map(|c| 0.5 * area_vector(c).length()).sum::<f64>()
        };
        let mut of_component: BTreeMap<usize, Vec<(usize, f64, [bool; 2])>> = BTreeMap::new();
        for (&part, &under) in parts.iter().zip(under) {
            let entry = of_component.entry(self.component(part)).or_default();
            entry.push((part, area(part), under));
        }
        let mut go = Vec::new();
        for own in of_component.values() {
            let all: f64 = own.iter().map(|(_, area, _)| area).sum();
            let inside: f64 = own.iter().filter(|p| p.2[0]).map(|p| p.1).sum();
            let submerged = inside > SUBMERGED.get() * all;
            let some = own.iter().filter(|(_, _, [inside, layered])| {
                if submerged {
                    !inside
                } else {
                    *inside || *layered
                }
            });
            go.extend(some.map(|p| p.0));
        }
        // If all parts seem covered, removing them all would lose the surface: keep them.
        if go.len() == parts.len() {
            Vec::new()
        } else {
            go
        }
    }
}
