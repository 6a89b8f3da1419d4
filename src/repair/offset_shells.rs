//! Holes that nothing else closes are closed by lining the surface round them: a second layer a hair under it, which hangs on the rim
//! and ends where it can be closed.
//!
//! What sticks through a hole stands in a pocket then. A sheet all of which is lined is a shell with walls.

use std::collections::HashMap;

use super::draft::Draft;
use super::known::sorted;
use super::offset_shell::{WallFace, edges_of};
use super::rim_triangles::{closed_after, push};
use super::shell_search::{Blocked, Budget, OffsetShells, Wanted, find};
use super::{Edge, edges};
use crate::fill::{ClosedBy, HoleOutcome, RegionReport};
use crate::mend::{FillError, FillReport, HoleReport};
use crate::mesh::cut::settled;
use crate::mesh::topology::NONE;

/// What came of a search for linings.
pub(super) struct Done {
    /// Linings that were added.
    pub(super) count: usize,
    /// What keeps other holes from being lined: all of a component first, then the fewest faces first.
    pub(super) blocked: Vec<Blocked>,
    /// The walls of the linings.
    pub(super) walls: Vec<ShellWall>,
}

/// The walls that a lining makes.
#[derive(Clone, Debug)]
pub(super) struct ShellWall {
    /// The place of its region in the report.
    pub(super) region: u32,
    /// The mean edge of the surface that is lined.
    pub(super) edge: f64,
    pub(super) faces: Vec<WallFace>,
}

/// Closes the `chosen` open holes by linings that cross nothing, so that no face goes: each by one as small as may be, those of a
/// component that are left together, the last by one of all the component. Only the last is tried where it is to be the `whole`.
pub(super) fn add(
    draft: &mut Draft,
    report: &mut FillReport,
    chosen: &dyn Fn(&HoleReport) -> bool,
    (whole, wanted): (bool, Wanted),
    budget: &mut Budget,
) -> Result<Done, FillError> {
    let rim_edges = open_rim_edges(report, chosen);
    if rim_edges.is_empty() {
        return Ok(Done {
            count: 0,
            blocked: Vec::new(),
            walls: Vec::new(),
        });
    }
    let mut shells = find(draft, &rim_edges, (whole, wanted), budget)?;
    let mut done = Done {
        count: shells.groups.len(),
        blocked: std::mem::take(&mut shells.blocked),
        walls: Vec::new(),
    };
    if done.count > 0 {
        done.walls = shells.take_over(draft, report);
    }
    Ok(done)
}

/// Cuts faces out that are in the way of a layer, unless more than `most` faces of the input or all of a component would go; adds what
/// they leave to the rims. Returns how many faces of the input went; none where nothing was cut.
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
        draft.spare(&mut removed);
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

/// Tells of chosen holes whose rims went with what was cut out as closed by the last lining, if they are open no more.
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
            hole.outcome = closed_after(&hole.outcome);
            hole.region = last.id;
            last.holes.push(hole.hole.id);
        }
    }
    Ok(())
}

/// The places in the report of the holes to close, by the edges of their rims.
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
    /// Adds the linings to a draft and tells of them; returns their walls.
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
            let mut holes = Vec::new();
            for index in &group.report_indices {
                let hole = &mut report.holes[*index];
                hole.outcome = match group.walled {
                    true => HoleOutcome::Walls,
                    false => closed_after(&hole.outcome),
                };
                hole.region = region + 1;
                holes.push(hole.hole.id);
            }
            report.regions.push(RegionReport {
                id: region + 1,
                holes,
                diameter: group.diameter,
                closed_by: Some(ClosedBy::OffsetShell),
                components: 1,
                ..RegionReport::default()
            });
        }
        walls
    }
}
