//! The work on a region as a value: it can be written, sent, worked on anywhere and its patch sent back.

use std::slice;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::control::{Control, Watch};
use super::reach::Looking;
use super::sources::places;
use super::{FillError, Inspection};
use crate::fill::{BasePlane, FillParams, PlacedPart, RegionPatch, RegionPlan, RegionProblem};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{Hole, HoleId, Mesh, Part, Topology};
use crate::sdf::Sampler;

/// The work on one region of a fill: the part of the mesh that it may look at, its holes, the parameters.
///
/// How large it is depends on the region and what is near it, not on the mesh. Numbers in a written form must come back bit for bit:
/// JSON by `serde_json` does so with its feature `float_roundtrip`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RegionTask {
    /// Number of the region, from 1.
    pub id: usize,
    /// The part of the welded mesh that is looked at, with faces turned to agree.
    part: Part,
    /// Which of its faces the region knows; others, of pieces that pass through its box, are not to be crossed. None for all.
    known: Option<Vec<bool>>,
    /// Number of vertices of the whole mesh.
    count: usize,
    /// What distances are computed relative to: in what the region knows, and in all of the mesh.
    centres: [DVec3; 2],
    /// What the region's box may grow by.
    growth: f64,
    /// The holes, with the part's numbers of vertices.
    holes: Vec<Hole>,
    /// Pairs of vertices between which sharp edges are asked for, with the part's numbers.
    joined: Vec<[u32; 2]>,
    /// The plane of its base, if it gets one.
    #[serde(default)]
    base: Option<BasePlane>,
    /// The parts of a counterpart that lie at it, if it is filled after one.
    #[serde(default)]
    counterparts: Option<Vec<PlacedPart>>,
    /// The parameters of the fill.
    params: FillParams,
}

impl RegionTask {
    /// The work on a region, from 1, of a mesh: with these faces, rising, and with what distances are computed relative to, in what the
    /// region knows and in all of the mesh.
    pub(super) fn new(
        id: usize,
        found: &Inspection,
        looking: &Looking,
        faces: &[u32],
        centres: [DVec3; 2],
        params: &FillParams,
    ) -> Self {
        let rims = looking.holes.iter().flat_map(|h| h.rim.iter().copied());
        let part = Part::new(&found.mesh, faces, rims);
        let known = looking.known.as_ref().map(|known| {
            let is_known = |&f: &u32| match found.topology.component[f as usize] {
                NONE => true,
                piece => known[piece as usize],
            };
            faces.iter().map(is_known).collect()
        });
        let mut holes: Vec<Hole> = looking.holes.iter().copied().cloned().collect();
        for v in holes.iter_mut().flat_map(|h| &mut h.rim) {
            *v = part.local(*v);
        }
        let joined = looking.joined.iter();
        let joined = joined.map(|pair| pair.map(|v| part.local(v))).collect();
        Self {
            id,
            part,
            joined,
            known,
            count: found.mesh.positions.len(),
            centres,
            base: looking.base,
            counterparts: looking.counterparts.clone(),
            growth: looking.growth,
            holes,
            params: params.clone(),
        }
    }

    /// Computes the patch; without one where [`RegionPatch::is_cramped`].
    ///
    /// # Errors
    /// [`FillError::Cancelled`], or [`FillError::Task`] when what was read is no task that was written.
    pub fn solve(&self, control: &Control) -> Result<RegionPatch, FillError> {
        let watch = Watch::new(*control, vec![1.0]);
        control.install(|| {
            let patch = self.patch(&watch)?;
            watch.finish()?;
            Ok(patch)
        })
    }

    fn patch(&self, watch: &Watch) -> Result<RegionPatch, FillError> {
        let mesh = &self.part.mesh;
        self.check()?;
        let topology = Topology::as_it_is(mesh);
        let mut holes = self.holes.clone();
        for hole in &mut holes {
            hole.component = piece_at(mesh, &topology, hole).ok_or(FillError::Task)?;
        }
        let holes: Vec<&Hole> = holes.iter().collect();
        let [of_known, of_all] = self.centres;
        let all = Sampler::new(mesh, &topology).about(of_all);
        let known = match &self.known {
            None => all.about(of_known),
            Some(known) => {
                let mut pieces = vec![false; topology.component_faces.len()];
                for (&piece, _) in topology.component.iter().zip(known).filter(|(_, k)| **k) {
                    if piece != NONE {
                        pieces[piece as usize] = true;
                    }
                }
                let known = all.restricted(&|piece| pieces[piece as usize]);
                known.about(of_known)
            }
        };
        let groups = slice::from_ref(&holes);
        let place = places(mesh, &topology, groups, self.params.voxel, usize::MAX);
        let place = place.and_then(|mut all| all.pop()).ok_or(FillError::Task)?;
        let [known, all] = [known, all].map(|sampler| sampler.at(place.clone()));
        let ids: Vec<HoleId> = holes.iter().map(|h| h.id).collect();
        watch.begin(&ids);
        let work = RegionProblem {
            id: self.id,
            mesh,
            holes: &holes,
            plan: RegionPlan::new(mesh, &holes, &self.params),
            known: &known,
            all: &all,
            joined: &self.joined,
            base: self.base,
            counterparts: self.counterparts.as_deref(),
            most_growth: self.growth,
            params: &self.params,
            own: None,
            reference: None,
            extent: None,
            keep_going: &|| watch.keep_going(),
            cancel: watch.token(),
        };
        let mut patch = work.fill();
        watch.end(0, &patch.report);
        watch.finish()?;
        for face in &mut patch.mesh.faces {
            *face = face.map(|v| self.part.original(v, self.count));
        }
        Ok(patch)
    }

    /// An error where what was read is no task that was written.
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

/// The piece that a hole bounds.
fn piece_at(mesh: &Mesh, topology: &Topology, hole: &Hole) -> Option<u32> {
    let (&from, &to) = (hole.rim.first()?, hole.rim.get(1)?);
    let boundary = (0..topology.boundary.len() as u32).filter(|&h| topology.boundary[h as usize]);
    let mut at_rim = boundary.filter(|&h| end(mesh, h) == from && start(mesh, h) == to);
    let piece = topology.component[at_rim.next()? as usize / 3];
    (piece != NONE).then_some(piece)
}
