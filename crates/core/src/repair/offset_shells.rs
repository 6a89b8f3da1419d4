//! Offset shells for holes that nothing else closes: a copy of the surface round the hole, a little below it and reversed,
//! attached to the rim and closed at its other ends.
//!
//! A part that sticks through the hole is then enclosed in a recess. If the shell covers a whole open sheet, the result is a body
//! with walls.

use std::collections::HashMap;

use super::draft::Draft;
use super::intersection_cache::sorted;
use super::offset_shell::{WallFace, edges_of};
use super::rim_triangles::{not_smooth, push};
use super::shell_search::{Blocked, Budget, OffsetShells, Wanted, find};
use super::{Edge, edges};
use crate::fill::{Closure, HoleOutcome, RegionReport};
use crate::mend::{FillError, FillReport, HoleReport};
use crate::mesh::cut::settled;
use crate::mesh::topology::NONE;

/// Result of a search for offset shells.
pub(super) struct AddResult {
    /// Number of shells added.
    pub(super) count: usize,
    /// The faces that block shells of other holes: whole components first, then by the number of faces.
    pub(super) blocked: Vec<Blocked>,
    /// The walls of the added shells.
    pub(super) walls: Vec<ShellWall>,
}

/// The walls between a surface and its offset shell.
#[derive(Clone, Debug)]
pub(super) struct ShellWall {
    /// Index of its region in the report.
    pub(super) region: u32,
    /// Mean edge length of the surface above the shell, in mesh units.
    pub(super) edge: f64,
    pub(super) faces: Vec<WallFace>,
}

/// Closes the `chosen` open holes by offset shells that intersect nothing, so that no face is removed. Tries the smallest shell
/// for each hole, then one for the remaining holes of a component together, then one of the whole component. If `whole`, only the
/// last is tried.
pub(super) fn add(
    draft: &mut Draft,
    report: &mut FillReport,
    chosen: &dyn Fn(&HoleReport) -> bool,
    (whole, wanted): (bool, Wanted),
    budget: &mut Budget,
) -> Result<AddResult, FillError> {
    let rim_edges = open_rim_edges(report, chosen);
    if rim_edges.is_empty() {
        return Ok(AddResult {
            count: 0,
            blocked: Vec::new(),
            walls: Vec::new(),
        });
    }
    let mut shells = find(draft, &rim_edges, (whole, wanted), budget)?;
    let mut done = AddResult {
        count: shells.groups.len(),
        blocked: std::mem::take(&mut shells.blocked),
        walls: Vec::new(),
    };
    if done.count > 0 {
        done.walls = shells.take_over(draft, report);
    }
    Ok(done)
}

/// Cuts out faces that block an offset shell, unless more than `most` input faces or a whole component would be removed. Adds
/// their vertices to the rims. Returns the number of input faces removed; none if nothing was cut.
pub(super) fn cut(
    draft: &mut Draft,
    blocked: &mut Blocked,
    most: usize,
) -> Result<Option<usize>, FillError> {
    let removed = {
        let found = draft.inspect()?;
        let marks: Vec<bool> = (found.mesh.faces.iter())
            .map(|f| blocked.faces.contains(&sorted(*f)))
            .collect();
        let mut removed = settled(&found.mesh, &found.topology, &marks, true);
        draft.protect_components(&mut removed);
        let gone = found.mesh.faces.iter().zip(&removed).filter(|(_, r)| **r);
        blocked.rims.extend(gone.flat_map(|(f, _)| f));
        removed
    };
    let gone = removed.iter().zip(&draft.region);
    let own = gone.filter(|(r, region)| **r && **region == NONE).count();
    if own > most || !removed.contains(&true) {
        return Ok(None);
    }
    draft.remove(&removed);
    Ok(Some(own))
}

/// Records chosen holes whose rims were cut away as closed by the last shell, if they are no longer open.
pub(super) fn record_gone(
    draft: &Draft,
    report: &mut FillReport,
    chosen: &dyn Fn(&HoleReport) -> bool,
) -> Result<(), FillError> {
    let found = draft.inspect()?;
    let open = edges_of(found.holes.iter().map(|h| &h.rim[..]));
    let Some(last) = report.regions.last_mut() else {
        return Ok(());
    };
    for hole in &mut report.holes {
        if chosen(hole) && !edges(&hole.hole.rim).any(|e| open.contains(&e)) {
            let how = Closure::OffsetShell(not_smooth(&hole.outcome));
            hole.outcome = HoleOutcome::Closed(how);
            hole.region = last.id;
            last.holes.push(hole.hole.id);
        }
    }
    Ok(())
}

/// Maps the rim edges of the chosen holes to the holes' indices in the report.
fn open_rim_edges(
    report: &FillReport,
    chosen: &dyn Fn(&HoleReport) -> bool,
) -> HashMap<Edge, usize> {
    let holes = report.holes.iter().enumerate();
    let open = holes.filter(|(_, h)| chosen(h));
    open.flat_map(|(i, h)| edges(&h.hole.rim).map(move |e| (e, i)))
        .collect()
}

impl OffsetShells {
    /// Adds the shells to a draft and to the report; returns their walls.
    fn take_over(self, draft: &mut Draft, report: &mut FillReport) -> Vec<ShellWall> {
        let mut walls = Vec::new();
        for position in &self.vertices {
            draft.mesh.positions.push(*position);
            draft.origins.vertices.push(NONE);
            draft.expected_error.push(None);
        }
        for group in self.groups {
            let region = report.regions.len();
            walls.push(ShellWall {
                region: region as u32,
                edge: group.edge,
                faces: group.walls,
            });
            group
                .faces
                .iter()
                .for_each(|f| push(draft, region as u32, *f));
            let (mut holes, mut closure) = (Vec::new(), None);
            for index in &group.report_indices {
                let hole = &mut report.holes[*index];
                let own = match group.walled {
                    true => Closure::Walls,
                    false => Closure::OffsetShell(not_smooth(&hole.outcome)),
                };
                closure.get_or_insert_with(|| own.clone());
                hole.outcome = HoleOutcome::Closed(own);
                hole.region = region + 1;
                holes.push(hole.hole.id);
            }
            report.regions.push(RegionReport {
                id: region + 1,
                holes,
                diameter: group.diameter,
                closure,
                components: 1,
                ..RegionReport::default()
            });
        }
        walls
    }
}
