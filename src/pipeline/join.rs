//! Patches are joined to the part of the mesh round them: what a region costs does not depend on the rest of the model.

use glam::DVec3;

use super::attempt::{RegionPatch, Work};
use crate::mesh::triangulate::triangulate_loop_beside;
use crate::mesh::{Mesh, Part, bounds};
use crate::region::{LevelSurface, Region};
use crate::report::{ClosedBy, HoleOutcome, RegionReport};
use crate::stitch::{Patch, StitchError, StitchInput, StitchParams, count_intersecting, stitch};

/// How far round the extracted surface the mesh may be looked at, in parts of its size. More than the stitcher's own margin.
const MARGIN: f64 = 0.15;

impl Work<'_> {
    /// Stitches the extracted surface of a region to its rims.
    pub(super) fn stitch(
        &self,
        group: &[usize],
        region: &Region,
        surface: &LevelSurface,
        extracted: &Mesh,
    ) -> Result<Patch, StitchError> {
        let part = self.round(group, extracted, region.voxel);
        let loops: Vec<Vec<u32>> = group.iter().map(|&h| self.local_rim(&part, h)).collect();
        let count = self.found.mesh.positions.len();
        let mut patch = stitch(&StitchInput {
            mesh: &part.mesh,
            loops: &loops,
            surface,
            extracted,
            voxel: region.voxel,
            params: StitchParams {
                edge_factor: self.params.edge_ratio(),
                ..StitchParams::default()
            },
        })
        .map_err(|e| e.renumbered(|v| part.original(v, count)))?;
        renumber(&mut patch.faces, &part, count);
        Ok(patch)
    }

    /// The part of the mesh near an extracted surface and the rims of a group.
    fn round(&self, group: &[usize], extracted: &Mesh, voxel: f64) -> Part {
        let mesh = &self.found.mesh;
        let rim = || {
            group
                .iter()
                .flat_map(|&h| &self.found.holes[h].rim)
                .copied()
        };
        let points = rim()
            .map(|v| mesh.positions[v as usize])
            .chain(extracted.positions.iter().copied());
        let (low, high) = bounds(points);
        let margin = DVec3::splat(MARGIN * (high - low).max_element() + 2.0 * voxel);
        self.sources.all().part(low - margin, high + margin, rim())
    }

    fn local_rim(&self, part: &Part, hole: usize) -> Vec<u32> {
        let rim = self.found.holes[hole].rim.iter();
        rim.map(|&v| part.local(v)).collect()
    }

    /// Triangulates each loop on its own, with other diagonals than the loops before it.
    pub(super) fn triangulate(
        &self,
        group: &[usize],
        why: &str,
        mut report: RegionReport,
    ) -> RegionPatch {
        let rims: Vec<Vec<u32>> = group
            .iter()
            .map(|&h| self.found.holes[h].rim.clone())
            .collect();
        let part = self.sources.all().part_round(&rims);
        let mut faces = Vec::new();
        let mut outcomes = Vec::new();
        for &h in group {
            report.diameter = report.diameter.max(self.found.holes[h].diameter);
            let outcome =
                match triangulate_loop_beside(&part.mesh, &self.local_rim(&part, h), &faces) {
                    Ok(new) => {
                        faces.extend(new);
                        HoleOutcome::Triangulated(why.to_owned())
                    }
                    Err(e) => HoleOutcome::Failed(format!("{why}; {e}")),
                };
            outcomes.push((h, outcome));
        }
        report.new_faces = faces.len();
        report.intersecting_faces = count_intersecting(&part.mesh, &[], &faces);
        report.components = outcomes.len();
        report.closed_by = match outcomes
            .iter()
            .any(|o| matches!(o.1, HoleOutcome::Failed(_)))
        {
            true => ClosedBy::Nothing,
            false => ClosedBy::RimTriangles,
        };
        renumber(&mut faces, &part, self.found.mesh.positions.len());
        RegionPatch {
            patch: Mesh::new(Vec::new(), faces),
            report,
            outcomes,
        }
    }
}

/// Gives faces the vertex numbers of the whole mesh, which has `count` vertices.
fn renumber(faces: &mut [[u32; 3]], part: &Part, count: usize) {
    for f in faces {
        *f = f.map(|v| part.original(v, count));
    }
}
