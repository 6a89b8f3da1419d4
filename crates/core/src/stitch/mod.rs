//! Stitching: joins an extracted surface to the rim of the hole that it fills.
//!
//! The part of the extracted surface that belongs to the hole is cut out, the gap between its boundary and the rim is zipped with
//! triangles, and the patch is remeshed with a fixed rim. The input mesh is never changed: the patch refers to its vertices by
//! index and only adds vertices and faces.
//!
//! [`stitch`] guarantees that the patch uses every rim edge exactly once and in the right direction, that it creates no edge with
//! more than two faces, and that the same input gives the same bytes. It reports, but cannot always avoid, faces that intersect.
//!
//! Sources: Botsch and Kobbelt, "A remeshing approach to multiresolution modeling", 2004 (remeshing); Liepa, "Filling
//! holes in meshes", 2003 (triangulation of single loops).

mod assemble;
mod band;
mod check;
mod cut;
mod error;
mod gap;
mod half_edge;
mod manifold_joint;
mod matching;
mod measure;
mod refined;
mod remesh;
mod rim;
mod seam;
mod sector;
mod written;
mod zip;

#[cfg(test)]
mod tests;

use glam::DVec3;

use crate::mesh::Mesh;
use crate::sdf::Surface;
use crate::spatial::intersecting;

pub use band::{OpeningRim, band};
pub use error::StitchError;
pub use refined::{flipped, refined_triangulation};
pub use seam::close_seam;
pub use written::count_intersecting_faces;

/// Input of [`stitch`].
#[derive(Clone, Copy)]
pub struct StitchInput<'a> {
    /// The mesh with the hole.
    pub mesh: &'a Mesh,
    /// Rim loops of the region as vertex indices of `mesh`, in the direction of the patch's faces: the patch uses the directed
    /// edges `loop[i] → loop[i + 1]`, opposite to the mesh's own. Loops may share vertices.
    pub loops: &'a [Vec<u32>],
    /// The smooth surface.
    pub surface: &'a dyn Surface,
    /// The extracted surface of the region, in the coordinates of `mesh`, close to `surface`.
    pub extracted: &'a Mesh,
    /// Spacing of the lattice from which `extracted` was made, in the units of `mesh`.
    pub voxel: f64,
    /// Settings.
    pub params: StitchParams,
}

/// Settings of [`stitch`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StitchParams {
    /// Extracted triangles closer to the rim than this are cut away, in voxels.
    pub cut_depth: f64,
    /// Edge length of the patch relative to the edge length of the mesh at the rim.
    pub edge_factor: f64,
    /// Largest distance of an edge's midpoint from the smooth surface, in voxels; edges are shortened to meet it.
    pub chord_error: f64,
    /// Rounds of split, collapse, flip and smoothing.
    pub iterations: usize,
    /// 0 leaves the vertices on the smooth surface; 1 moves them along its normal until the faces around each vertex are on
    /// average neither above nor below it. Fades in over two rings from the rim.
    pub facet_compensation: f64,
    /// Whether edges may get longer with the distance from the rim, where a patch with edges as short as the rim's would have too many
    /// faces.
    pub may_coarsen: bool,
}

impl StitchInput<'_> {
    /// Returns an error once the surface is cancelled.
    fn go_on(&self) -> Result<(), StitchError> {
        match self.surface.is_cancelled() {
            true => Err(StitchError::Cancelled),
            false => Ok(()),
        }
    }
}

impl Default for StitchParams {
    fn default() -> Self {
        Self {
            cut_depth: 0.7,
            edge_factor: 0.8,
            chord_error: 0.1,
            iterations: 10,
            facet_compensation: 0.5,
            may_coarsen: false,
        }
    }
}

/// A patch for a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patch {
    /// New vertices; their indices follow the mesh's.
    pub positions: Vec<DVec3>,
    /// Faces; indices below the mesh's number of vertices are vertices of the mesh.
    pub faces: Vec<[u32; 3]>,
    /// Quality measures and actions.
    pub report: StitchReport,
}

/// Quality measures and actions of [`stitch`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StitchReport {
    /// Mean angle between the faces on both sides of a rim edge, in degrees.
    pub seam_angle_mean: f64,
    /// Largest of these angles, in degrees.
    pub seam_angle_max: f64,
    /// Mean over the patch's faces of twice the inradius over the circumradius (1 for equilateral faces).
    pub quality_mean: f64,
    /// Patch faces that intersect another face, after repair.
    pub intersecting_faces: usize,
    /// Connected components of the patch.
    pub components: usize,
    /// Euler characteristic of the patch, with rim vertices counted once for each sector of the patch.
    pub euler: i64,
    /// Rim loops that the extracted surface did not reach and that were triangulated separately.
    pub filled_directly: usize,
    /// Edges added to join several loops that bound one gap, because the lattice does not resolve them.
    pub bridged: usize,
    /// Edges that were split because the mesh or the patch already had an edge between the same vertices.
    pub split_duplicates: usize,
}

/// Joins the extracted surface to the rim.
///
/// # Errors
/// If it cannot be joined; [`StitchError::Cancelled`] once the surface is cancelled.
pub fn stitch(input: &StitchInput) -> Result<Patch, StitchError> {
    input.go_on()?;
    let mut patch = assemble::assemble(input)?;
    remesh::remesh(input, &mut patch)?;
    let mut surroundings = check::Surroundings::new(input, &patch);
    input.go_on()?;
    patch.report.intersecting_faces = remesh::repair(input, &mut patch, &mut surroundings);
    input.go_on()?;
    patch.into_patch(input)
}

/// Remeshes a closed surface isotropically, with edges of about `edge`, shorter where a chord would be too far from the smooth
/// surface. `extracted` must be manifold and close to `surface`; `voxel` is the spacing of the lattice it comes from.
///
/// # Errors
/// [`StitchError::NotManifold`] if `extracted` is not manifold or not closed; [`StitchError::Cancelled`] once `surface` is cancelled.
pub fn remesh_closed(
    extracted: &Mesh,
    surface: &dyn Surface,
    voxel: f64,
    edge: f64,
) -> Result<Patch, StitchError> {
    let input = StitchInput {
        mesh: &Mesh::default(),
        loops: &[],
        surface,
        extracted,
        voxel,
        params: StitchParams {
            edge_factor: 1.0,
            ..StitchParams::default()
        },
    };
    let mut patch = assemble::closed(&input, edge)?;
    remesh::remesh(&input, &mut patch)?;
    let mut surroundings = check::Surroundings::new(&input, &patch);
    input.go_on()?;
    patch.report.intersecting_faces = remesh::repair(&input, &mut patch, &mut surroundings);
    input.go_on()?;
    patch.into_patch(&input)
}

/// The number of `faces` (a patch for `mesh` with the new vertices `new`) that intersect another face of the patch or the mesh.
///
/// Decided exactly. Faces that share a vertex or an edge intersect if they have further common points; touching counts.
pub fn count_intersecting(mesh: &Mesh, new: &[DVec3], faces: &[[u32; 3]]) -> usize {
    let positions: Vec<DVec3> = mesh.positions.iter().chain(new).copied().collect();
    let all: Vec<[u32; 3]> = faces.iter().chain(&mesh.faces).copied().collect();
    intersecting(&positions, &all, faces.len()).len()
}
