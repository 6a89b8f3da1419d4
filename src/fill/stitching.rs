//! Patches are joined to the part of the mesh round them: what a region costs does not depend on the rest of the model.

use glam::DVec3;

use super::outcome::{ClosedBy, FailedReason, HoleOutcome, TriangulatedReason};
use super::problem::RegionProblem;
use super::region_patch::RegionPatch;
use super::report::RegionReport;
use crate::mesh::triangulate::triangulate_loop_beside;
use crate::mesh::{Hole, Mesh, Part, bounds};
use crate::region::{LevelSurface, Region};
use crate::stitch::{Patch, StitchError, StitchInput, StitchParams, count_intersecting, stitch};

/// How far round the extracted surface the mesh may be looked at, in parts of its size. More than the stitcher's own margin.
const MARGIN: f64 = 0.15;

impl RegionProblem<'_> {
    /// Stitches the extracted surface of a region to its rims.
    pub(super) fn stitch(
        &self,
        region: &Region,
        surface: &LevelSurface,
        extracted: &Mesh,
    ) -> Result<Patch, StitchError> {
        let part = self.round(extracted, region.voxel);
        let loops: Vec<Vec<u32>> = self.holes.iter().map(|h| local_rim(&part, h)).collect();
        let count = self.mesh.positions.len();
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

    /// The part of the mesh near an extracted surface and the rims.
    fn round(&self, extracted: &Mesh, voxel: f64) -> Part {
        let rim = || self.holes.iter().flat_map(|h| &h.rim).copied();
        let points = rim()
            .map(|v| self.mesh.positions[v as usize])
            .chain(extracted.positions.iter().copied());
        let (low, high) = bounds(points);
        let margin = DVec3::splat(MARGIN * (high - low).max_element() + 2.0 * voxel);
        self.all.part(low - margin, high + margin, rim())
    }

    /// Triangulates each loop on its own, with other diagonals than the loops before it.
    pub(super) fn triangulate(
        &self,
        why: TriangulatedReason,
        mut report: RegionReport,
    ) -> RegionPatch {
        let rims: Vec<Vec<u32>> = self.holes.iter().map(|h| h.rim.clone()).collect();
        let part = self.all.part_round(&rims);
        let mut faces = Vec::new();
        let mut outcomes = Vec::new();
        for hole in self.holes {
            report.diameter = report.diameter.max(hole.diameter);
            let made = triangulate_loop_beside(&part.mesh, &local_rim(&part, hole), &faces);
            outcomes.push(match made {
                Ok(new) => {
                    faces.extend(new);
                    HoleOutcome::Triangulated(why.clone())
                }
                Err(error) => HoleOutcome::Failed(FailedReason::NoTriangulation {
                    after: why.clone(),
                    error,
                }),
            });
        }
        let is_open = |o: &HoleOutcome| matches!(o, HoleOutcome::Failed(_));
        report.new_faces = faces.len();
        report.intersecting_faces = count_intersecting(&part.mesh, &[], &faces);
        report.components = outcomes.len();
        report.closed_by = Some(match outcomes.iter().any(is_open) {
            true => ClosedBy::Nothing,
            false => ClosedBy::RimTriangles,
        });
        renumber(&mut faces, &part, self.mesh.positions.len());
        RegionPatch {
            mesh: Mesh::new(Vec::new(), faces),
            sigma: Vec::new(),
            report,
            outcomes,
        }
    }
}

fn local_rim(part: &Part, hole: &Hole) -> Vec<u32> {
    hole.rim.iter().map(|&v| part.local(v)).collect()
}

/// Gives faces the vertex numbers of the whole mesh, which has `count` vertices.
fn renumber(faces: &mut [[u32; 3]], part: &Part, count: usize) {
    for f in faces {
        *f = f.map(|v| part.original(v, count));
    }
}
