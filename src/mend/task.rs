//! The work on a region as a value: it can be written, sent, worked on anywhere and its patch sent back.

use std::slice;

use serde::{Deserialize, Serialize};

use super::control::{Control, Watch};
use super::sources::{Looked, places};
use super::{FillError, Inspection};
use crate::fill::{FillParams, RegionPatch, RegionPlan, RegionProblem};
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{Hole, Mesh, Part, Topology};
use crate::sdf::Sampler;

/// The work on one region of a fill: the part of the mesh that it may look at, its holes, the parameters.
///
/// Numbers in a written form must come back bit for bit: JSON by `serde_json` does so with its feature `float_roundtrip`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RegionTask {
    /// Number of the region, from 1.
    pub id: usize,
    /// The pieces of the welded mesh that are looked at, with faces turned to agree.
    mesh: Mesh,
    /// Which of its faces the region knows; others, of pieces that pass through its box, are not to be crossed. None for all.
    known: Option<Vec<bool>>,
    /// For each vertex of the part its number in the whole mesh; none where the part is the whole.
    vertices: Option<Vec<u32>>,
    /// Number of vertices of the whole mesh.
    count: usize,
    /// Whether the region has a hierarchy of its own over the faces near it.
    near: bool,
    /// The holes, with the part's numbers of vertices.
    holes: Vec<Hole>,
    /// The parameters of the fill.
    params: FillParams,
}

impl RegionTask {
    /// The work on a region, from 1, of a mesh; `looked` says which pieces it looks at, if not all, and `near` whether the region
    /// has a hierarchy of its own.
    pub(super) fn new(
        id: usize,
        found: &Inspection,
        holes: &[&Hole],
        looked: Option<Looked>,
        near: bool,
        params: &FillParams,
    ) -> Self {
        let task = Self {
            id,
            mesh: Mesh::default(),
            known: None,
            vertices: None,
            count: found.mesh.positions.len(),
            near,
            holes: holes.iter().copied().cloned().collect(),
            params: params.clone(),
        };
        let Some(Looked {
            near: near_pieces,
            known,
        }) = looked
        else {
            let mesh = found.mesh.clone();
            return Self { mesh, ..task };
        };
        let faces = found.topology.piece.iter().zip(0u32..);
        let is_near = |piece: u32| piece == NONE || near_pieces[piece as usize];
        let faces: Vec<u32> = faces
            .filter(|(p, _)| is_near(**p))
            .map(|(_, f)| f)
            .collect();
        let rims = task.holes.iter().flat_map(|h| h.rim.iter().copied());
        let part = Part::new(&found.mesh, &faces, rims);
        let known_face = |&f: &u32| {
            let piece = found.topology.piece[f as usize];
            piece == NONE || known[piece as usize]
        };
        let mut holes = task.holes;
        for v in holes.iter_mut().flat_map(|h| &mut h.rim) {
            *v = part.local(*v);
        }
        Self {
            known: Some(faces.iter().map(known_face).collect()),
            vertices: Some(part.vertices().to_vec()),
            mesh: part.mesh,
            holes,
            ..task
        }
    }

    /// Computes the patch.
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
        let mut mesh = self.mesh.clone();
        let in_range = |v: u32| (v as usize) < mesh.positions.len();
        let faces_fit = mesh.faces.iter().flatten().all(|&v| in_range(v));
        let rims_fit = self.holes.iter().flat_map(|h| &h.rim).all(|&v| in_range(v));
        let fits = |length: Option<usize>, wanted: usize| length.is_none_or(|n| n == wanted);
        let maps_fit = fits(self.known.as_ref().map(Vec::len), mesh.faces.len())
            && fits(self.vertices.as_ref().map(Vec::len), mesh.positions.len());
        if !(faces_fit && rims_fit && maps_fit) || self.holes.is_empty() {
            return Err(FillError::Task);
        }
        mesh.validate()?;
        let topology = Topology::new(&mut mesh);
        let mut holes = self.holes.clone();
        for hole in &mut holes {
            hole.piece = piece_at(&mesh, &topology, hole).ok_or(FillError::Task)?;
        }
        let all = Sampler::new(&mesh, &topology);
        let restricted = self.known.as_ref().map(|known| {
            let mut pieces = vec![false; topology.piece_faces.len()];
            for (&piece, _) in topology.piece.iter().zip(known).filter(|(_, k)| **k) {
                if piece != NONE {
                    pieces[piece as usize] = true;
                }
            }
            all.restricted(&|piece| pieces[piece as usize])
        });
        let holes: Vec<&Hole> = holes.iter().collect();
        let voxel = self.params.voxel;
        let place = || places(&mesh, &topology, slice::from_ref(&holes), voxel, usize::MAX)?.pop();
        let place = self.near.then(place).flatten();
        let [restricted, all] = [restricted, Some(all)].map(|sampler| match &place {
            Some(place) => sampler.map(|s| s.at(place.clone())),
            None => sampler,
        });
        let all = all.ok_or(FillError::Task)?;
        let ids: Vec<usize> = holes.iter().map(|h| h.id).collect();
        watch.begin(&ids);
        let work = RegionProblem {
            id: self.id,
            mesh: &mesh,
            holes: &holes,
            plan: RegionPlan::new(&mesh, &holes, &self.params),
            known: restricted.as_ref().unwrap_or(&all),
            all: &all,
            params: &self.params,
            reference: None,
            extent: None,
            keep_going: &|| watch.keep_going(),
            cancel: watch.token(),
        };
        let mut patch = work.fill();
        watch.end(0, &patch.report);
        watch.finish()?;
        self.renumber(&mut patch.mesh);
        Ok(patch)
    }

    /// Gives a patch the whole mesh's numbers of vertices.
    fn renumber(&self, patch: &mut Mesh) {
        let Some(vertices) = &self.vertices else {
            return;
        };
        let whole = |v: u32| match vertices.get(v as usize) {
            Some(&w) => w,
            None => v - vertices.len() as u32 + self.count as u32,
        };
        for face in &mut patch.faces {
            *face = face.map(whole);
        }
    }
}

/// The piece that a hole bounds.
fn piece_at(mesh: &Mesh, topology: &Topology, hole: &Hole) -> Option<u32> {
    let (&from, &to) = (hole.rim.first()?, hole.rim.get(1)?);
    let boundary = (0..topology.boundary.len() as u32).filter(|&h| topology.boundary[h as usize]);
    let mut at_rim = boundary.filter(|&h| end(mesh, h) == from && start(mesh, h) == to);
    let piece = topology.piece[at_rim.next()? as usize / 3];
    (piece != NONE).then_some(piece)
}
