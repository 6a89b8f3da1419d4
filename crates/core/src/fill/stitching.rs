//! Joins extracted surfaces to the part of the mesh around a region, so that the cost does not depend on the rest of the model.

use glam::DVec3;

use super::problem::RegionProblem;
use crate::mesh::{Hole, Mesh, Part, bounds};
use crate::region::{LevelSurface, Region};
use crate::sdf::Surface;
use crate::stitch::{Patch, StitchError, StitchInput, StitchParams, stitch};
use crate::tuning::{Tunable, tunable};

/// Sizes of the extracted surface. The mesh is given to the stitcher this far around it: farther than the stitcher's own
/// margin.
const STITCH_MARGIN: Tunable<f64> = tunable("fill.stitch_margin", 0.15);

impl RegionProblem<'_> {
    /// Joins the extracted surface of a region to its rims.
    pub(super) fn stitch(
        &self,
        region: &Region,
        surface: &LevelSurface,
        extracted: &Mesh,
    ) -> Result<Patch, StitchError> {
        let params = StitchParams::default();
        self.stitch_by(params, region.voxel, surface, extracted)
    }

    /// Stitches a mesh of about this length of edges to the rims, its vertices kept on a surface that has no smaller features.
    pub(super) fn stitch_exact(
        &self,
        edge: f64,
        surface: &dyn Surface,
        extracted: &Mesh,
    ) -> Result<Patch, StitchError> {
        let params = StitchParams {
            // Edges are never made shorter for a chord.
            chord_error: f64::MAX,
            facet_compensation: 0.0,
            ..StitchParams::default()
        };
        self.stitch_by(params, edge, surface, extracted)
    }

    fn stitch_by(
        &self,
        params: StitchParams,
        voxel: f64,
        surface: &dyn Surface,
        extracted: &Mesh,
    ) -> Result<Patch, StitchError> {
        let part = self.round(extracted, voxel);
        let loops: Vec<Vec<u32>> = self.holes.iter().map(|h| local_rim(&part, h)).collect();
        let count = self.mesh.positions.len();
        let mut patch = stitch(&StitchInput {
            mesh: &part.mesh,
            loops: &loops,
            surface,
            extracted,
            voxel,
            params: StitchParams {
                edge_factor: self.params.edge_ratio(),
                may_coarsen: self.params.edge_ratio.is_none() && self.reference.is_none(),
                ..params
            },
        })
        .map_err(|e| e.renumbered(|v| part.original(v, count)))?;
        renumber(&mut patch.faces, &part, count);
        Ok(patch)
    }

    /// The part of the mesh near an extracted surface and the rims.
    fn round(&self, extracted: &Mesh, voxel: f64) -> Part {
        let rim = || self.holes.iter().flat_map(|h| &h.rim).copied();
        let points = rim()
            .map(|v| self.mesh.positions[v as usize])
            .chain(extracted.positions.iter().copied());
        let (low, high) = bounds(points);
        let margin = DVec3::splat(STITCH_MARGIN.get() * (high - low).max_element() + 2.0 * voxel);
        self.all.part(low - margin, high + margin, rim())
    }
}

pub(super) fn local_rim(part: &Part, hole: &Hole) -> Vec<u32> {
    hole.rim.iter().map(|&v| part.local(v)).collect()
}

/// Converts faces to the vertex numbers of the whole mesh, which has `count` vertices.
pub(super) fn renumber(faces: &mut [[u32; 3]], part: &Part, count: usize) {
    for f in faces {
        *f = f.map(|v| part.original(v, count));
    }
}
