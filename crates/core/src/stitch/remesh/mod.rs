//! Isotropic remeshing of the patch with a fixed rim (Botsch and Kobbelt 2004, section 4).

mod compensate;
mod edges;
mod relax;
mod repair;
mod size;
mod smooth;
mod untangle;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::assemble::Assembled;
use super::half_edge::{NONE, PatchMesh};
use super::rim::Rims;
use super::{StitchError, StitchInput};
use crate::mesh::area_vector;
use crate::sdf::Surface;
use crate::tuning::{Tunable, tunable};

pub(super) use repair::repair;

/// Least cosine between a face and the surface normals at its corners: a change must keep above it, or not lower the
/// cosine.
const LEAST_COSINE: Tunable<f64> = tunable("stitch.least_cosine", 0.5);

/// Faces. A patch of at least this many faces is refused if more than `MOST_TILTED` of them are tilted after
/// untangling.
const LARGE_PATCH: Tunable<usize> = tunable("stitch.large_patch", 3000);

/// Fraction of the faces of a large patch that may be tilted. On patches of scans it is below a hundredth.
const MOST_TILTED: Tunable<f64> = tunable("stitch.most_tilted", 0.25);

/// The same before untangling, which costs hundreds of times as much for a tilted face as all else for another.
const MOST_TANGLED: Tunable<f64> = tunable("stitch.most_tangled", 0.4);

/// Rounds of flips and smoothing at the end.
const POLISH: Tunable<usize> = tunable("stitch.polish", 8);

/// Target lengths, root mean square. The rounds of a large patch end when smoothing moves its vertices by less. Together
/// with `SETTLED_POLISH` this saves a third of the time on a patch of 14,500 vertices; the mean quality falls
/// from 0.976 to 0.973.
const SETTLED: Tunable<f64> = tunable("stitch.settled", 0.06);

/// The same for the rounds at the end.
const SETTLED_POLISH: Tunable<f64> = tunable("stitch.settled_polish", 0.01);

/// Remeshes the patch in place.
///
/// # Errors
/// If splitting long edges does not end: between edges whose lengths differ by orders of magnitude, or in spikes, new short edges
/// appear faster than they can be collapsed; [`StitchError::Cancelled`].
pub(super) fn remesh(input: &StitchInput, patch: &mut Assembled) -> Result<(), StitchError> {
    let mut work = Remesher::new(input, patch);
    work.set_sizes(&input.params, input.voxel);
    let most = work.most_faces(&input.params);
    // Split, collapse, flip and smooth by area; a large patch stops early once vertices hardly move.
    for _ in 0..input.params.iterations {
        input.go_on()?;
        work.split_long();
        if work.mesh.faces.len() as f64 > most {
            return Err(StitchError::TooManyFaces {
                faces: work.mesh.faces.len(),
                edges: input.loops.iter().map(Vec::len).sum(),
            });
        }
        work.collapse_short();
        work.flip_by_valence();
        work.refuse_folded(MOST_TANGLED.get())?;
        work.untangle();
        work.refuse_folded(MOST_TILTED.get())?;
        if work.smooth_by_area() < SETTLED.get() && work.is_large() {
            break;
        }
    }
    // Flip and smooth by shape.
    for _ in 0..POLISH.get() {
        input.go_on()?;
        work.flip_by_shape();
        work.untangle();
        if work.smooth_by_shape() < SETTLED_POLISH.get() && work.is_large() {
            break;
        }
    }
    if input.params.facet_compensation != 0.0 {
        work.compensate(input.params.facet_compensation);
    }
    input.go_on()?;
    work.relax_seam();
    input.go_on()?;
    patch.mesh.compact();
    Ok(())
}

/// The patch and the constraints on its changes.
pub(super) struct Remesher<'a> {
    mesh: &'a mut PatchMesh,
    rims: &'a Rims,
    surface: &'a dyn Surface,
    centre: DVec3,
    /// The corners of mesh vertices that have several.
    copies: FxHashMap<u32, Vec<u32>>,
}

impl<'a> Remesher<'a> {
    pub(super) fn new(input: &'a StitchInput, patch: &'a mut Assembled) -> Self {
        let mut copies: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        for (corner, &v) in patch.mesh.origin.iter().enumerate() {
            copies.entry(v).or_default().push(corner as u32);
        }
        copies.retain(|_, corners| corners.len() > 1);
        Self {
            mesh: &mut patch.mesh,
            rims: &patch.rims,
            surface: input.surface,
            centre: patch.centre,
            copies,
        }
    }

    /// Whether the work should stop.
    fn is_cancelled(&self) -> bool {
        self.surface.is_cancelled()
    }

    /// Whether the patch has many faces, not counting removed ones.
    fn is_large(&self) -> bool {
        self.living() >= LARGE_PATCH.get()
    }

    /// The number of faces, without removed ones.
    fn living(&self) -> usize {
        let is_there = |f: &&[u32; 3]| f[0] != NONE;
        self.mesh.faces.iter().filter(is_there).count()
    }

    /// Fails if more than a part of a large patch is folded: each tilted face costs as much time as a hundred others.
    fn refuse_folded(&self, most: f64) -> Result<(), StitchError> {
        if !self.is_large() {
            return Ok(());
        }
        let (tilted, faces) = (self.tilted().len(), self.living());
        if tilted as f64 > most * faces as f64 {
            return Err(StitchError::Folded { tilted, faces });
        }
        Ok(())
    }

    /// The nearest point of the surface and its normal, unless it is farther than `limit`.
    fn project(&self, p: DVec3, limit: f64) -> Option<(DVec3, DVec3)> {
        let (q, n) = self.surface.project(p + self.centre)?;
        let q = q - self.centre;
        (q.is_finite() && n.is_finite() && q.distance_squared(p) <= limit * limit).then_some((q, n))
    }

    /// Whether a new edge between two vertices would be the only one between their output vertices.
    fn may_join(&self, a: u32, b: u32) -> bool {
        let mesh = &*self.mesh;
        match (mesh.is_rim(a), mesh.is_rim(b)) {
            (false, false) => true,
            (true, true) => {
                let (u, v) = (mesh.origin[a as usize], mesh.origin[b as usize]);
                let apart = |x: &u32, y: &u32| !mesh.has_edge(*x, *y);
                u != v
                    && !self.rims.has_edge(u, v)
                    && self
                        .corners(u, &a)
                        .iter()
                        .all(|x| self.corners(v, &b).iter().all(|y| apart(x, y)))
            }
            (true, false) => self.alone(a, b),
            (false, true) => self.alone(b, a),
        }
    }

    /// Whether no other corner of `rim`'s mesh vertex has an edge to `free`.
    fn alone(&self, rim: u32, free: u32) -> bool {
        let corners = self.corners(self.mesh.origin[rim as usize], &rim);
        corners
            .iter()
            .all(|&c| c == rim || !self.mesh.has_edge(c, free))
    }

    /// All corners of a mesh vertex; `only` if it has a single one.
    fn corners<'b>(&'b self, origin: u32, only: &'b u32) -> &'b [u32] {
        self.copies
            .get(&origin)
            .map_or(std::slice::from_ref(only), Vec::as_slice)
    }

    /// Cosine between the normal of a face and the mean surface normal at its corners; -1 for a degenerate face.
    fn cosine(&self, face: [u32; 3]) -> f64 {
        self.cosine_at(face, face.map(|v| self.mesh.position[v as usize]))
    }

    fn cosine_at(&self, face: [u32; 3], corners: [DVec3; 3]) -> f64 {
        let normal: DVec3 = face.iter().map(|&v| self.mesh.normal[v as usize]).sum();
        let cross = area_vector(corners);
        let length = cross.length() * normal.length();
        if length > 0.0 {
            cross.dot(normal) / length
        } else {
            -1.0
        }
    }

    /// The smallest cosine and the smallest quality of the faces around `v` if it were at `p`.
    fn around(&self, v: u32, p: DVec3) -> (f64, f64) {
        let mut least = (1.0f64, 1.0f64);
        for h in self.mesh.outgoing(v) {
            let face = self.mesh.faces[h as usize / 3];
            let at = face.map(|w| {
                if w == v {
                    p
                } else {
                    self.mesh.position[w as usize]
                }
            });
            least = (
                least.0.min(self.cosine_at(face, at)),
                least.1.min(super::assemble::quality(at)),
            );
        }
        least
    }

    fn free_vertices(&self) -> impl Iterator<Item = u32> + use<> {
        let used: Vec<u32> = (self.mesh.rim_len() as u32..self.mesh.position.len() as u32)
            .filter(|&v| self.mesh.is_used(v))
            .collect();
        debug_assert!(!used.contains(&NONE));
        used.into_iter()
    }
}
