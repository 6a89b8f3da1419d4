//! End of a repair: orders the mesh and completes the report.

use std::collections::HashSet;

use super::draft::KeepVertices;
use super::{Carried, Repaired, Run, report, shell_walls, turned};
use crate::mend::FillError;
use crate::mesh::topology::NONE;

impl Run<'_> {
    pub(super) fn finish(mut self, carried: &Carried) -> Result<Repaired, FillError> {
        let keep = match (carried.in_place, self.params.drop_unused) {
            (true, _) => KeepVertices::All,
            (_, true) => KeepVertices::Used,
            _ => KeepVertices::UsedAndUnused,
        };
        for region in &mut self.report.fill.regions {
            region.new_faces = 0;
        }
        for &region in self.draft.region.iter().filter(|r| **r != NONE) {
            self.report.fill.regions[region as usize].new_faces += 1;
        }
        turned::recognise(&mut self.draft, self.input, &mut self.report.steps);
        let mut places = shell_walls::places(&self.draft, &self.report.walls);
        let done = self.draft.finish(self.input, &keep, carried.in_place);
        let mut report = self.report;
        places
            .values_mut()
            .for_each(|v| *v = done.number[*v as usize]);
        shell_walls::record(&done.mesh, &places, self.params, &mut report)?;
        let living = done.origins.living(self.input.faces.len());
        report.lost_faces = living.iter().filter(|l| !**l).count();
        report.lost_components = report::lost_components(&self.components, &living);
        let known: HashSet<u32> = done.origins.vertices.iter().copied().collect();
        report.lost_vertices = self.input.positions.len() - known.len();
        // Renumber the rims for the result; rims with dropped vertices are cleared, so that they are not drawn.
        let own = done.origins.vertices.len() as u32;
        for hole in &mut report.fill.holes {
            let number = |v: &u32| done.number[*v as usize];
            hole.hole.rim = hole.hole.rim.iter().map(number).collect();
            if hole.hole.rim.iter().any(|v| *v >= own) {
                hole.hole.rim.clear();
            }
        }
        Ok(Repaired {
            mesh: done.mesh,
            origins: done.origins,
            expected_error: done.expected_error,
            fill: std::mem::take(&mut report.fill),
            report,
        })
    }
}
