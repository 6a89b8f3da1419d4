//! The working mesh of a repair, with the origin of its vertices and faces.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use rayon::prelude::*;

use super::displaced::Displaced;
use super::faults::Faults;
use super::intersection_cache::IntersectionCache;
use super::rounding::Rounding;
use crate::check::self_intersections_among;
use crate::mend::{FillError, FillReport, Inspection};
use crate::mesh::cut::settled;
use crate::mesh::topology::NONE;
use crate::mesh::{FaceOrigin, Mesh, Origins, VertexFaces, has_several_fans};
use crate::tuning::{Tunable, tunable};

/// Rounds in which edges of a draft are flipped or collapsed: faces without area may be adjacent.
pub(super) const CLEAN_ROUNDS: Tunable<usize> = tunable("repair.clean_rounds", 20);

/// The working mesh of a repair. Vertices keep their numbers until the end; unused ones are dropped then.
#[derive(Clone)]
pub(super) struct Draft {
    pub(super) mesh: Mesh,
    /// Input vertex and face of each vertex and face; `u32::MAX` and [`FaceOrigin::NEW`] for new ones in patches.
    pub(super) origins: Origins,
    /// The expected error of each patch vertex.
    pub(super) expected_error: Vec<Option<f64>>,
    /// For each face the index of the region whose patch it belongs to; `u32::MAX` for input faces.
    pub(super) region: Vec<u32>,
    /// The input component of each input face; `u32::MAX` for degenerate faces.
    component: Vec<u32>,
    /// Input faces that belong to dangling sheets; see [`super::dangling`].
    dangling: HashSet<u32>,
    cache: Arc<IntersectionCache>,
    inspected: Inspected,
    /// The faults, with the inspection that they were computed from.
    judged: Option<(Weak<Inspection<'static>>, Faults)>,
    /// What was moved before cuts; see [`super::relax`].
    pub(super) displaced: Displaced,
    /// How positions are rounded in the output.
    pub(super) rounding: Rounding,
    /// The welding tolerance of boundary vertices, in mesh units.
    pub(super) unit: f64,
}

/// Cache of the last inspection of a draft. It holds a copy of the inspected mesh, to detect when it is out of date.
#[derive(Default)]
struct Inspected(Mutex<Option<Arc<Inspection<'static>>>>);

impl Inspected {
    fn of(&self, mesh: &Mesh) -> Result<Arc<Inspection<'static>>, FillError> {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = last.as_ref().filter(|found| *found.input == *mesh) {
            return Ok(found.clone());
        }
        *last = None;
        let found = Arc::new(Inspection::new(mesh.clone())?);
        *last = Some(found.clone());
        Ok(found)
    }
}

impl Clone for Inspected {
    fn clone(&self) -> Self {
        let last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        Self(Mutex::new(last.clone()))
    }
}

/// The final mesh of a draft.
pub(super) struct Finished {
    pub(super) mesh: Mesh,
    pub(super) origins: Origins,
    pub(super) expected_error: Vec<Option<f64>>,
    /// New number of each draft vertex; `u32::MAX` if it was dropped.
    pub(super) number: Vec<u32>,
}

impl Draft {
    /// A draft of a mesh with the given component of each face.
    pub(super) fn new(mesh: &Mesh, component: Vec<u32>) -> Self {
        Self {
            component,
            dangling: HashSet::new(),
            cache: Arc::default(),
            inspected: Inspected::default(),
            judged: None,
            displaced: Displaced::default(),
            rounding: Rounding::default(),
            unit: 0.0,
            origins: Origins::of(mesh),
            expected_error: vec![None; mesh.positions.len()],
            region: vec![NONE; mesh.faces.len()],
            mesh: mesh.clone(),
        }
    }

    /// The inspection of the mesh; the cached one if the mesh has not changed.
    pub(super) fn inspect(&self) -> Result<Arc<Inspection<'static>>, FillError> {
        self.inspected.of(&self.mesh)
    }

    /// The inspection as an owned value; clears the cache.
    pub(super) fn take_inspection(&mut self) -> Result<Inspection<'static>, FillError> {
        let found = self.inspect()?;
        self.forget_inspection();
        Ok(Arc::unwrap_or_clone(found))
    }

    /// Clears the cached inspection.
    pub(super) fn forget_inspection(&mut self) {
        self.inspected = Inspected::default();
    }

    /// Clears everything that depends on vertex positions.
    pub(super) fn forget_positions(&mut self) {
        self.forget_inspection();
        self.cache = Arc::default();
        self.judged = None;
    }

    /// Reverses a face.
    pub(super) fn reverse_face(&mut self, face: usize) {
        self.mesh.faces[face].swap(1, 2);
        self.origins.faces[face].corners.swap(1, 2);
    }

    /// Adds a copy of a vertex at another position.
    pub(super) fn copy_vertex(&mut self, vertex: u32, position: glam::DVec3) -> u32 {
        self.mesh.positions.push(position);
        self.origins
            .vertices
            .push(self.origins.vertices[vertex as usize]);
        self.expected_error
            .push(self.expected_error[vertex as usize]);
        self.mesh.positions.len() as u32 - 1
    }

    /// Removes the marked faces; returns how many.
    pub(super) fn remove(&mut self, removed: &[bool]) -> usize {
        let before = self.mesh.faces.len();
        retain(&mut self.mesh.faces, removed);
        retain(&mut self.origins.faces, removed);
        retain(&mut self.region, removed);
        before - self.mesh.faces.len()
    }

    /// The input component of a face; `u32::MAX` if the face is new or was degenerate.
    pub(super) fn component(&self, face: usize) -> u32 {
        match self.origins.faces[face].face {
            NONE => NONE,
            old => self.component[old as usize],
        }
    }

    /// The input components that have a face left.
    pub(super) fn components_left(&self) -> HashSet<u32> {
        let there = (0..self.mesh.faces.len()).map(|f| self.component(f));
        there.filter(|c| *c != NONE).collect()
    }

    /// The input components that have a face left, and more than this many faces in the input.
    pub(super) fn components_above(&self, faces: usize) -> HashSet<u32> {
        let mut counts: HashMap<u32, usize> = HashMap::new();
        for c in &self.component {
            *counts.entry(*c).or_default() += 1;
        }
        let mut left = self.components_left();
        left.retain(|c| counts[c] > faces);
        left
    }

    /// Assigns the components of some faces to the component of the `host` face and marks the faces as dangling sheets.
    pub(super) fn join(&mut self, faces: &[usize], host: usize) {
        let host = self.component(host);
        if host == NONE {
            return;
        }
        self.judged = None;
        let own: HashSet<u32> = faces.iter().map(|f| self.component(*f)).collect();
        for component in &mut self.component {
            if *component != NONE && own.contains(component) {
                *component = host;
            }
        }
        let old = faces.iter().map(|f| self.origins.faces[*f].face);
        self.dangling.extend(old.filter(|f| *f != NONE));
    }

    /// Merges the components of each cluster; each face is given with its cluster.
    pub(super) fn merge_components(&mut self, faces: &[(u32, u32)]) {
        self.judged = None;
        let mut first: HashMap<u32, u32> = HashMap::new();
        let mut to: HashMap<u32, u32> = HashMap::new();
        for &(f, cluster) in faces {
            let own = self.component(f as usize);
            if own != NONE {
                to.insert(own, *first.entry(cluster).or_insert(own));
            }
        }
        for component in &mut self.component {
            *component = to.get(component).copied().unwrap_or(*component);
        }
    }

    /// Whether an input face belongs to a dangling sheet; none for patch faces.
    pub(super) fn is_dangling(&self, face: usize) -> Option<bool> {
        let old = self.origins.faces[face].face;
        (old != NONE).then(|| self.dangling.contains(&old))
    }

    pub(super) fn has_dangling(&self) -> bool {
        !self.dangling.is_empty()
    }

    /// Unmarks all faces of input components that would be removed entirely; returns the number of these components.
    pub(super) fn protect_components(&self, removed: &mut [bool]) -> usize {
        let (mut stays, mut goes) = (HashSet::new(), HashSet::new());
        for (f, removed) in removed.iter().enumerate() {
            let set = if *removed { &mut goes } else { &mut stays };
            set.insert(self.component(f));
        }
        goes.retain(|c| *c != NONE && !stays.contains(c));
        for (f, removed) in removed.iter_mut().enumerate() {
            *removed &= !goes.contains(&self.component(f));
        }
        goes.len()
    }

    /// The faces that intersect others, ascending.
    pub(super) fn self_intersections(&mut self) -> Result<Vec<u32>, FillError> {
        let found = self.inspect()?;
        Ok(self.self_intersections_in(&found))
    }

    /// The faces that intersect others, ascending, each with the partner that a search through all faces finds first.
    pub(super) fn self_intersection_pairs(&mut self) -> Result<Vec<(u32, u32)>, FillError> {
        let found = self.inspect()?;
        let crossing = self.self_intersections_in(&found);
        Ok(self_intersections_among(
            &found.mesh,
            &found.topology,
            &crossing,
        ))
    }

    fn self_intersections_in(&mut self, found: &Inspection) -> Vec<u32> {
        let (crossing, cache) = self.cache.search(found);
        if let Some(cache) = cache {
            self.cache = Arc::new(cache);
        }
        crossing
    }

    /// Takes over an inspection and its intersecting faces, if the vertex positions equal the draft's.
    pub(super) fn adopt(&mut self, found: Inspection, crossing: &[u32]) {
        if self.mesh.positions != found.input.positions {
            return;
        }
        self.cache = Arc::new(IntersectionCache::of(&found, crossing));
        self.inspected = Inspected(Mutex::new(Some(Arc::new(found.into_owned()))));
    }

    /// The faults of the draft, cached with the inspection.
    pub(super) fn faults(&mut self) -> Result<Faults, FillError> {
        let found = self.inspect()?;
        let of = Arc::downgrade(&found);
        if let Some((known, faults)) = &self.judged
            && known.ptr_eq(&of)
        {
            return Ok(*faults);
        }
        let there = self.components_left();
        let all: HashSet<u32> = self.component.iter().copied().collect();
        let lost = |c: &&u32| **c != NONE && !there.contains(c);
        let (mesh, topology) = (&found.mesh, &found.topology);
        let around = VertexFaces::new(mesh);
        let vertices = (0..mesh.positions.len() as u32).into_par_iter();
        let pinched = vertices.filter(|v| has_several_fans(mesh, topology, &around, *v));
        let pinched = pinched.count();
        let crossing = self.self_intersections_in(&found);
        let faults = Faults {
            lost_components: all.iter().filter(lost).count(),
            crossing: crossing.len(),
            non_manifold: topology.non_manifold_edges(mesh).len() + pinched,
            open: found.holes.len() + found.open_chains.len(),
        };
        self.judged = Some((of, faults));
        Ok(faults)
    }

    /// Removes marked faces, and further faces so that the rims are simple; returns how many.
    pub(super) fn cut(&mut self, marked: &[bool]) -> Result<usize, FillError> {
        if !marked.contains(&true) {
            return Ok(0);
        }
        let removed = {
            let found = self.inspect()?;
            settled(&found.mesh, &found.topology, marked, true)
        };
        Ok(self.remove(&removed))
    }

    /// Takes over the result of a fill, which appended to the mesh. The regions of the report get indices from `first` on.
    pub(super) fn append_fill(
        &mut self,
        mesh: Mesh,
        expected_error: Vec<Option<f64>>,
        report: &FillReport,
        first: usize,
    ) {
        let faces = mesh.faces.len();
        self.mesh = mesh;
        self.expected_error.extend(expected_error);
        let vertices = self.mesh.positions.len();
        self.expected_error.resize(vertices, None);
        self.origins.vertices.resize(vertices, NONE);
        self.origins.faces.resize(faces, FaceOrigin::NEW);
        for (region, r) in report.regions.iter().enumerate() {
            let ends = self.region.len() + r.new_faces;
            self.region.resize(ends.min(faces), (first + region) as u32);
        }
        self.region.resize(faces, NONE);
    }

    /// Rounds the positions from vertex `first` on to the output's precision, and removes new faces with two corners that
    /// coincide then.
    pub(super) fn round_from(&mut self, first: usize) {
        if !self.rounding.is_single() {
            return;
        }
        for p in &mut self.mesh.positions[first..] {
            *p = self.rounding.of(*p);
        }
        let collapsed = |(face, region): (&[u32; 3], &u32)| {
            let [a, b, c] = face.map(|v| self.mesh.positions[v as usize]);
            *region != NONE && (a == b || b == c || c == a)
        };
        let faces = self.mesh.faces.iter().zip(&self.region);
        let removed: Vec<bool> = faces.map(collapsed).collect();
        if removed.contains(&true) {
            self.remove(&removed);
        }
    }

    /// Orders the result: vertices and faces from the input first, then new ones. `keep` decides which unused vertices stay. With
    /// `altered_last` changed input faces come after unchanged ones.
    pub(super) fn finish(self, input: &Mesh, keep: &KeepVertices, altered_last: bool) -> Finished {
        let count = self.mesh.positions.len();
        let mut used = vec![false; count];
        let corners = self.mesh.faces.iter().flatten();
        corners.for_each(|&v| used[v as usize] = true);
        let mut was_used = vec![false; input.positions.len()];
        let corners = input.faces.iter().flatten();
        corners.for_each(|&v| was_used[v as usize] = true);
        // Decide which vertices stay, and number those from the input first.
        let stays = |v: usize| {
            used[v]
                || (v < was_used.len()
                    && match keep {
                        KeepVertices::Used => false,
                        KeepVertices::UsedAndUnused => !was_used[v],
                        KeepVertices::All => true,
                    })
        };
        let is_new = |v: &usize| self.origins.vertices[*v] == NONE;
        let kept: Vec<usize> = (0..count).filter(|&v| stays(v)).collect();
        let (new, old): (Vec<usize>, Vec<usize>) = kept.into_iter().partition(is_new);
        let mut number = vec![NONE; count];
        let order: Vec<usize> = old.iter().chain(&new).copied().collect();
        for (i, &v) in order.iter().enumerate() {
            number[v] = i as u32;
        }
        // Order the faces: unchanged, changed, new. Steps may have moved unchanged ones behind others.
        let unchanged = self.unchanged(input);
        let class = |f: usize| match self.origins.faces[f] {
            FaceOrigin { face: NONE, .. } => 2,
            _ if altered_last && !unchanged[f] => 1,
            _ => 0,
        };
        let mut faces: Vec<usize> = (0..self.mesh.faces.len()).collect();
        let origin = |f: &usize| self.origins.faces[*f].face;
        match (faces.iter().filter(|f| unchanged[**f])).is_sorted_by_key(origin) {
            true => faces.sort_by_key(|f| class(*f)),
            false => faces.sort_by_key(|f| (class(*f), origin(f))),
        }
        let known = faces.iter().filter(|f| class(**f) < 2);
        Finished {
            mesh: Mesh::new(
                order.iter().map(|&v| self.mesh.positions[v]).collect(),
                faces
                    .iter()
                    .map(|&f| self.mesh.faces[f].map(|v| number[v as usize]))
                    .collect(),
            ),
            origins: Origins {
                vertices: old.iter().map(|&v| self.origins.vertices[v]).collect(),
                faces: known.map(|&f| self.origins.faces[f]).collect(),
            },
            expected_error: new.iter().map(|&v| self.expected_error[v]).collect(),
            number,
        }
    }

    /// For each face whether it is a face of the input as it was, the only one that comes from it.
    fn unchanged(&self, input: &Mesh) -> Vec<bool> {
        let mut is_taken = vec![false; input.faces.len()];
        let faces = self.mesh.faces.iter().zip(&self.origins.faces);
        let is_unchanged = |(face, origin): (&[u32; 3], &FaceOrigin)| {
            *origin != FaceOrigin::NEW && *origin == FaceOrigin::same(origin.face) && {
                let old = origin.face as usize;
                *face == input.faces[old] && !std::mem::replace(&mut is_taken[old], true)
            }
        };
        faces.map(is_unchanged).collect()
    }
}

/// Which vertices without faces are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum KeepVertices {
    /// None.
    Used,
    /// Those that no input face used either.
    UsedAndUnused,
    /// All input vertices.
    All,
}

fn retain<T>(items: &mut Vec<T>, removed: &[bool]) {
    let mut marks = removed.iter();
    items.retain(|_| marks.next() == Some(&false));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::self_intersections;
    use crate::mesh::shapes::icosphere;

    #[test]
    fn faces_known_to_cross_nothing_are_asked_again_where_that_may_have_changed() {
        let ball = icosphere(2);
        let mut draft = Draft::new(&ball, vec![0; ball.faces.len()]);
        let all = |draft: &Draft| -> Vec<u32> {
            let found = draft.inspect().unwrap();
            let pairs = self_intersections(&found.mesh, &found.topology);
            pairs.iter().map(|(f, _)| *f).collect()
        };
        assert!(draft.self_intersections().unwrap().is_empty());
        assert_eq!(draft.cache.clear.len(), ball.faces.len());
        // A face that pierces the ball, then a duplicate face.
        let first = draft.mesh.positions.len() as u32;
        let spike = [0.5, 1.0, 2.0].map(|s| s * glam::DVec3::new(0.3, 0.1 * s, 1.0));
        draft.mesh.positions.extend(spike);
        draft.mesh.faces.push([first, first + 1, first + 2]);
        let spike = draft.self_intersections().unwrap();
        assert!(spike.len() > 1);
        assert_eq!(spike, all(&draft));
        assert_eq!(draft.cache.crossing.len(), spike.len());
        assert_eq!(
            draft.cache.clear.len() + spike.len(),
            draft.mesh.faces.len()
        );
        let [a, b, c] = ball.faces[7];
        draft.mesh.faces.push([b, c, a]);
        let double = draft.self_intersections().unwrap();
        assert!(double.contains(&7));
        assert_eq!(double, all(&draft));
        draft.mesh.faces.truncate(ball.faces.len() + 1);
        assert_eq!(draft.self_intersections().unwrap(), spike);
        // Its partners intersect nothing once it is removed.
        draft.mesh.faces.truncate(ball.faces.len());
        assert!(draft.self_intersections().unwrap().is_empty());
    }
}
