//! Fills of a repair: of the holes with one obvious closure, of those that the caller chose, and of those that cuts made.

use std::collections::HashSet;

use super::choice::SMALL_FACES;
use super::rim_triangles::push;
use super::{Edge, RepairStep, Run, caps, chains, choice, edges, inner_sheets, report, sheets};
use crate::fill::{FEW_EDGES, FillParams};
use crate::mend::{FillError, FillReport, Inspection, Watch};
use crate::mesh::topology::NONE;
use crate::mesh::{Hole, HoleId};
use crate::tuning::{Tunable, tunable};

/// Edges. Longer rims are not closed while bodies are united.
const CAPPED_EDGES: Tunable<usize> = tunable("repair.capped_edges", 300);

/// The region of triangles that close holes while bodies are united.
pub(super) const CAP: u32 = NONE - 1;

/// Which holes a fill closes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filling {
    /// Of the chosen holes those with one obvious closure: few edges.
    Obvious,
    /// The input's holes that the caller chose, and those that the repair made.
    Chosen,
    /// Those that the repair made.
    Made,
}

impl Run<'_> {
    /// Fills holes. Those with an edge outside the `old` boundary were made by the repair.
    pub(super) fn fill(&mut self, old: &HashSet<Edge>, which: Filling) -> Result<(), FillError> {
        let first = which == Filling::Chosen;
        let (mesh, expected_error, report, caps) = {
            let mut found = self.draft.take_inspection()?;
            let takes_borders = self.params.borders && !self.params.fill.flat_base;
            let sheets = match takes_borders && which != Filling::Obvious {
                true => choice::take_borders(&mut found),
                false => Vec::new(),
            };
            let mut made: Vec<HoleId> = Vec::new();
            for hole in &mut found.holes {
                // An outer border at which faces were cut out moved in: it stays one.
                let is_border = hole.outer_boundary && {
                    let origin = &self.draft.origins.vertices;
                    let before: Vec<u32> = hole.rim.iter().map(|v| origin[*v as usize]).collect();
                    edges(&before).any(|e| self.outer.contains(&e))
                };
                if !is_border && edges(&hole.rim).any(|e| !old.contains(&e)) {
                    // A hole made by a cut is not the outer border of a sheet.
                    hole.outer_boundary = false;
                    made.push(hole.id);
                }
            }
            let mut params = self.filling(&found, made, which)?;
            let mut caps = caps::of_sheets(&found, sheets, &mut params)?;
            let mut regions = found.regions(&params)?.after(&self.solved);
            if self.compares || which == Filling::Made {
                regions = regions.without_retries();
            }
            let watch = Watch::new(*self.control, regions.expected_work());
            let mut filled = regions.fill(&watch)?;
            if first && self.params.borders {
                self.cap_mouths(&found, &params, &mut filled)?;
            }
            if which != Filling::Made {
                let numbers = self.choice.numbers(&found, &self.draft.origins.vertices);
                report::renumber(&mut filled.report, &numbers);
                caps.iter_mut()
                    .for_each(|id| *id = numbers.get(id).copied().unwrap_or(*id));
            }
            (filled.mesh, filled.expected_error, filled.report, caps)
        };
        let regions = self.report.fill.regions.len();
        let holes = match which {
            Filling::Made => report::last_number(&self.report.fill),
            _ => 0,
        };
        let caps: Vec<HoleId> = caps.iter().map(|id| HoleId(id.0 + holes)).collect();
        let known = self.draft.mesh.positions.len();
        self.draft
            .append_fill(mesh, expected_error, &report, regions);
        self.draft.round_from(known);
        self.append_report(report, regions, holes, which);
        self.drop_bad_caps(&caps, regions)
    }

    /// Closes the chosen holes and those that stay open, and outer borders inside other components, by triangles between their rims'
    /// vertices, as faces of the region [`CAP`].
    pub(super) fn cap(&mut self) -> Result<(), FillError> {
        let faces: Vec<[u32; 3]> = {
            let mut found = self.draft.take_inspection()?;
            if self.params.borders {
                choice::take_borders(&mut found);
            }
            let params = self.filling(&found, Vec::new(), Filling::Chosen)?;
            let regions = found.regions(&params)?;
            let chosen: HashSet<HoleId> = regions.hole_groups().flatten().map(|h| h.id).collect();
            let faces_of = &found.topology.component_faces;
            let is_kept = |hole: &Hole| {
                let is_small = faces_of[hole.component as usize] <= SMALL_FACES.get();
                self.keeps_holes() && !hole.outer_boundary && !is_small
            };
            (found.holes.iter())
                .filter(|hole| chosen.contains(&hole.id) || is_kept(hole))
                .filter(|hole| hole.edges <= CAPPED_EDGES.get())
                .flat_map(|hole| chains::triangulated(&found.mesh.positions, &hole.rim))
                .collect()
        };
        faces
            .into_iter()
            .for_each(|f| push(&mut self.draft, CAP, f));
        if !self.params.does(RepairStep::Holes) {
            return Ok(());
        }
        for rim in inner_sheets::inner_borders(&self.draft)? {
            for f in chains::triangulated(&self.draft.mesh.positions, &rim) {
                push(&mut self.draft, CAP, f);
            }
        }
        Ok(())
    }

    /// Separates surfaces that meet in edges or vertices.
    pub(super) fn separate_sheets(&mut self) -> Result<(), FillError> {
        let closes = !self.keeps_holes();
        sheets::separate(&mut self.draft, &mut self.report, closes)
    }

    /// Whether the caller keeps holes open.
    pub(super) fn keeps_holes(&self) -> bool {
        let fill = &self.params.fill;
        let chooses =
            fill.holes.is_some() || fill.max_diameter.is_some() || !fill.keep_open.is_empty();
        chooses || !self.params.does(RepairStep::Holes)
    }

    /// The parameters of a fill, with the present numbers of holes. `made` are the holes that the repair made.
    fn filling(
        &self,
        found: &Inspection,
        made: Vec<HoleId>,
        which: Filling,
    ) -> Result<FillParams, FillError> {
        let only = |holes: Vec<HoleId>| FillParams {
            apart: self.apart,
            ..self.params.fill.of_holes(Some(holes))
        };
        if which == Filling::Made || !self.params.does(RepairStep::Holes) {
            return Ok(only(made));
        }
        let origins = &self.draft.origins.vertices;
        let mut chosen = (self.choice).params(found, origins, &made, &self.params.fill);
        chosen.apart = self.apart;
        if which == Filling::Chosen {
            return Ok(chosen);
        }
        let few = FEW_EDGES.get();
        let regions = found.regions(&chosen)?;
        let groups = regions.hole_groups();
        let obvious = groups.filter(|group| matches!(group[..], [hole] if hole.edges <= few));
        Ok(only(obvious.flatten().map(|hole| hole.id).collect()))
    }

    /// Appends the report of a fill to the report of the fills before it.
    fn append_report(&mut self, mut new: FillReport, regions: usize, holes: usize, which: Filling) {
        let all = &mut self.report.fill;
        if which == Filling::Chosen {
            all.holes.clone_from(&self.early);
            all.all_holes = new.all_holes;
            all.input.open_chains = new.input.open_chains;
        }
        for mut hole in new.holes.drain(..) {
            if which != Filling::Chosen && hole.region == 0 {
                continue;
            }
            hole.hole.id.0 += holes;
            hole.region += if hole.region > 0 { regions } else { 0 };
            if which == Filling::Obvious {
                self.early.push(hole.clone());
            }
            all.holes.push(hole);
        }
        for mut region in new.regions.drain(..) {
            region.id += regions;
            region.holes.iter_mut().for_each(|id| id.0 += holes);
            all.regions.push(region);
        }
    }
}
