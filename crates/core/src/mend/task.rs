//! The task of a region as a value: it can be saved, sent and solved anywhere, and its patch sent back.

use std::slice;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::coarse_rims::CoarseRims;
use super::control::{Control, Watch};
use super::framed::Framed;
use super::reach::ReachQuery;
use super::solved_patches::{SolvedPatches, key};
use super::sources::places;
use super::{FillError, Inspection};
use crate::fill::{BasePlane, Closure, FillParams, PlacedPart, RegionPatch, RegionProblem};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{Hole, HoleId, Mesh, Part, Topology};
use crate::sdf::Sampler;

/// The task of one region of a fill: the part of the mesh that it needs, its holes, the parameters.
///
/// Its size depends on the region and its surroundings, not on the whole mesh. Numbers must be restored bit by bit when a task is
/// read: `serde_json` does so with its feature `float_roundtrip`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RegionTask {
    /// Number of the region, from 1.
    pub id: usize,
    /// The part of the welded mesh that the region needs, its faces oriented consistently.
    part: Part,
    /// Whether the region knows each of its faces. The others belong to components that pass through its box; patches must not
    /// intersect them. None if it knows all.
    known: Option<Vec<bool>>,
    /// Number of vertices of the whole mesh.
    count: usize,
    /// Points relative to which distances are computed: for the known faces, and for all faces of the mesh.
    centres: [DVec3; 2],
    /// Upper bound of the factor of its box's margin.
    growth: f64,
    /// Upper bound of the cost of its level-set retries, in unknowns times steps.
    budget: u64,
    /// The holes, in the part's vertex numbers.
    holes: Vec<Hole>,
    /// Pairs of vertices between which the caller wants sharp edges, in the part's vertex numbers.
    joined: Vec<[u32; 2]>,
    /// The plane of its flat base, if it gets one.
    #[serde(default)]
    base: Option<BasePlane>,
    /// The parts of the counterpart at its holes, if there is a counterpart.
    #[serde(default)]
    counterparts: Option<Vec<PlacedPart>>,
    /// The parameters of the fill.
    params: FillParams,
}

impl RegionTask {
    /// The task of region `id`, from 1, with these faces of the mesh, in ascending order. `centres` are the points relative to
    /// which distances are computed, for the known faces and for all.
    pub(super) fn new(
        id: usize,
        found: &Inspection,
        query: &ReachQuery,
        faces: &[u32],
        centres: [DVec3; 2],
        params: &FillParams,
    ) -> Self {
        let rims = query.holes.iter().flat_map(|h| h.rim.iter().copied());
        let part = Part::new(&found.mesh, faces, rims);
        let known = query.known.as_ref().map(|known| {
            let is_known = |&f: &u32| match found.topology.component[f as usize] {
                NONE => true,
                component => known[component as usize],
            };
            faces.iter().map(is_known).collect()
        });
        let mut holes: Vec<Hole> = query.holes.iter().copied().cloned().collect();
        for v in holes.iter_mut().flat_map(|h| &mut h.rim) {
            *v = part.local(*v);
        }
        let joined = query.joined.iter();
        let joined = joined.map(|pair| pair.map(|v| part.local(v))).collect();
        Self {
            id,
            part,
            joined,
            known,
            count: found.mesh.positions.len(),
            centres,
            base: query.base,
            counterparts: query.counterparts.clone(),
            growth: query.growth,
            budget: query.budget,
            holes,
            params: params.clone(),
        }
    }

    /// Computes the patch of the region; an empty one where [`RegionPatch::is_cramped`].
    ///
    /// # Errors
    /// [`FillError::Cancelled`], or [`FillError::Task`] if this is not a valid region task.
    pub fn solve(&self, control: &Control) -> Result<RegionPatch, FillError> {
        let watch = Watch::new(*control, vec![1.0]);
        control.install(|| {
            let patch = self.patch(&watch)?;
            watch.finish()?;
            Ok(patch)
        })
    }

    fn patch(&self, watch: &Watch) -> Result<RegionPatch, FillError> {
        self.check()?;
        let patch = self.placed_patch(0, watch, None)?;
        watch.finish()?;
        Ok(patch)
    }

    /// The patch of the region, which is at `place` in the watch's list; one of the patches `before`, where it was solved in this run.
    pub(super) fn placed_patch(
        &self,
        place: usize,
        watch: &Watch,
        before: Option<&SolvedPatches>,
    ) -> Result<RegionPatch, FillError> {
        let part = &self.part.mesh;
        let holes: Vec<&Hole> = self.holes.iter().collect();
        let decided = Closure::decided(part, &holes, &self.params);
        let decided = decided.as_ref();
        let ids: Vec<HoleId> = self.holes.iter().map(|h| h.id).collect();
        watch.begin(&ids);
        let run = (watch, before);
        let mut patch = match self.with_coarse_rims(decided, run)? {
            Some(patch) => patch,
            None => self.on_part(decided, part, &self.holes, self.known.as_deref(), run)?,
        };
        watch.end(place, &patch.report);
        for face in &mut patch.mesh.faces {
            *face = face.map(|v| self.part.original(v, self.count));
        }
        Ok(patch)
    }

    /// The patch of a region with a rim of thousands of edges, solved with fewer of them; none where that gives no sound patch.
    fn with_coarse_rims(
        &self,
        decided: Option<&Closure>,
        run: (&Watch, Option<&SolvedPatches>),
    ) -> Result<Option<RegionPatch>, FillError> {
        let part = &self.part.mesh;
        if !is_framed(decided) || self.params.edge_ratio.is_some() || self.counterparts.is_some() {
            return Ok(None);
        }
        let Some(coarse) = CoarseRims::new(part, &self.holes, &self.joined) else {
            return Ok(None);
        };
        let of_face = |known: &Vec<bool>| coarse.faces.iter().map(|&f| known[f as usize]).collect();
        let known: Option<Vec<bool>> = self.known.as_ref().map(of_face);
        let holes: Vec<&Hole> = coarse.holes.iter().collect();
        let decided = Closure::decided(&coarse.mesh, &holes, &self.params);
        let patch = self.on_part(
            decided.as_ref(),
            &coarse.mesh,
            &coarse.holes,
            known.as_deref(),
            run,
        )?;
        Ok(match patch.is_cramped() {
            true => Some(patch),
            false => coarse.fanned(part, patch),
        })
    }

    /// The patch on a part of the mesh, in its numbers; solved in the region's own frame where it has one.
    fn on_part(
        &self,
        decided: Option<&Closure>,
        part: &Mesh,
        holes: &[Hole],
        known: Option<&[bool]>,
        run: (&Watch, Option<&SolvedPatches>),
    ) -> Result<RegionPatch, FillError> {
        let in_frame = || Framed::new(part, holes, &self.params);
        let framed = is_framed(decided).then(in_frame).flatten();
        let Some(framed) = framed else {
            let topology = Topology::without_orienting(part);
            let mut holes = holes.to_vec();
            for hole in &mut holes {
                hole.component = component_at(part, &topology, hole).ok_or(FillError::Task)?;
            }
            let solved = Solved {
                mesh: part,
                topology: &topology,
                holes: &holes,
                joined: &self.joined,
                known,
                counterparts: self.counterparts.as_deref(),
                centres: self.centres,
                params: &self.params,
                decided,
            };
            return self.solved(&solved, run.0);
        };
        self.in_frame(&framed, known, run)
    }

    /// The patch on a part of the mesh, solved in the region's own frame, unless it was solved before.
    fn in_frame(
        &self,
        framed: &Framed,
        known: Option<&[bool]>,
        (watch, before): (&Watch, Option<&SolvedPatches>),
    ) -> Result<RegionPatch, FillError> {
        let joined = framed.pairs(&self.joined);
        let known = known.map(|known| framed.by_face(known));
        let counterparts = self.counterparts.as_ref();
        let counterparts = counterparts.map(|parts| framed.counterparts(parts));
        let before = before.filter(|_| counterparts.is_none());
        let limits = (self.growth, self.budget);
        let before = before.map(|kept| (kept, key(framed, known.as_deref(), &joined, limits)));
        if let Some(mut patch) = before.as_ref().and_then(|(kept, key)| kept.get(key)) {
            patch.report.id = self.id;
            patch.report.holes = framed.holes.iter().map(|h| h.id).collect();
            return Ok(framed.returned(patch));
        }
        let solved = Solved {
            mesh: &framed.mesh,
            topology: &framed.topology,
            holes: &framed.holes,
            joined: &joined,
            known: known.as_deref(),
            counterparts: counterparts.as_deref(),
            centres: [DVec3::ZERO; 2],
            params: &framed.params,
            decided: None,
        };
        let patch = self.solved(&solved, watch)?;
        if let Some((kept, key)) = before.filter(|_| watch.keep_going()) {
            kept.keep(key, &patch);
        }
        Ok(framed.returned(patch))
    }

    /// Computes the patch on some mesh, in its numbers and coordinates.
    fn solved(&self, on: &Solved, watch: &Watch) -> Result<RegionPatch, FillError> {
        let (mesh, topology) = (on.mesh, on.topology);
        let holes: Vec<&Hole> = on.holes.iter().collect();
        let [of_known, of_all] = on.centres;
        let groups = slice::from_ref(&holes);
        let place = places(mesh, topology, groups, on.params.voxel, usize::MAX);
        let place = place.and_then(|mut all| all.pop()).ok_or(FillError::Task)?;
        let all = Sampler::new(mesh, topology).about(of_all);
        let known = match on.known {
            None if of_known == of_all => None,
            None => Some(all.about(of_known)),
            Some(known) => {
                let mut components = vec![false; topology.component_faces.len()];
                for (&component, _) in topology.component.iter().zip(known).filter(|(_, k)| **k) {
                    if component != NONE {
                        components[component as usize] = true;
                    }
                }
                let known = all.restricted(&|component| components[component as usize]);
                Some(known.about(of_known))
            }
        };
        // Samplers of the same faces share their hierarchies.
        let all = all.at(place.clone());
        let known = known.map_or_else(|| all.clone(), |known| known.at(place));
        let work = RegionProblem {
            id: self.id,
            mesh,
            holes: &holes,
            decided: on.decided,
            known: &known,
            all: &all,
            joined: on.joined,
            base: self.base,
            counterparts: on.counterparts,
            most_growth: self.growth,
            budget: self.budget,
            params: on.params,
            own: None,
            reference: None,
            extent: None,
            keep_going: &|| watch.keep_going(),
            cancel: watch.token(),
        };
        Ok(work.fill())
    }

    /// Returns an error if this is not a valid region task: damaged, or of another version.
    fn check(&self) -> Result<(), FillError> {
        let mesh = &self.part.mesh;
        let in_range = |v: u32| (v as usize) < mesh.positions.len();
        let faces_fit = mesh.faces.iter().flatten().all(|&v| in_range(v));
        let rims = || self.holes.iter().flat_map(|h| &h.rim);
        let rims_fit = rims().all(|&v| in_range(v));
        let mut joined = self.joined.iter().flatten();
        let joined_fit = joined.all(|v| rims().any(|w| w == v));
        let known = self.known.as_ref().map(Vec::len);
        let lists_fit = known.is_none_or(|n| n == mesh.faces.len())
            && self.part.vertices().len() == mesh.positions.len();
        let mut parts = self.counterparts.iter().flatten();
        let parts_fit = parts.all(PlacedPart::is_valid);
        if !(parts_fit && faces_fit && rims_fit && joined_fit && lists_fit) || self.holes.is_empty()
        {
            return Err(FillError::Task);
        }
        Ok(mesh.validate()?)
    }
}

/// The mesh, holes and parameters with which a task is computed: its own, or the same in the region's frame.
struct Solved<'a> {
    mesh: &'a Mesh,
    topology: &'a Topology,
    holes: &'a [Hole],
    joined: &'a [[u32; 2]],
    known: Option<&'a [bool]>,
    counterparts: Option<&'a [PlacedPart]>,
    /// Points relative to which distances are computed: for the known faces, and for all.
    centres: [DVec3; 2],
    params: &'a FillParams,
    decided: Option<&'a Closure>,
}

/// Whether a region is solved in a frame of its own. Closures that are decided before are triangles between existing vertices, or flat
/// caps, whose planes are exact in the mesh's coordinates only.
pub(super) fn is_framed(decided: Option<&Closure>) -> bool {
    decided.is_none()
}

/// The component that a hole bounds.
fn component_at(mesh: &Mesh, topology: &Topology, hole: &Hole) -> Option<u32> {
    let (&from, &to) = (hole.rim.first()?, hole.rim.get(1)?);
    let boundary = (0..topology.boundary.len() as u32).filter(|&h| topology.boundary[h as usize]);
    let mut at_rim = boundary.filter(|&h| end(mesh, h) == from && start(mesh, h) == to);
    let component = topology.component[at_rim.next()? as usize / 3];
    (component != NONE).then_some(component)
}
