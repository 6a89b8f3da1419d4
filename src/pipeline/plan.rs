//! What a fill would do, without doing it.

use super::{
    FillError, Inspection, attempt, bridges, check_params, check_voxel, choose, groups, inspect,
};
use crate::mesh::Mesh;
use crate::params::{FillParams, SurfaceKind};
use crate::report::{HoleOutcome, Plan, PlannedHole, PlannedOutcome, PlannedRegion};
use crate::stitch::close_seam;

/// What [`super::fill`] would do with a mesh: which holes it would fill, together with which others, on which grid.
///
/// What comes out is not known before: a hole whose surroundings contradict each other may still end in triangles between
/// its own vertices, and some take several grids.
///
/// # Errors
/// As [`super::fill`].
pub fn plan(mesh: &Mesh, params: &FillParams) -> Result<Plan, FillError> {
    check_params(params)?;
    plan_found(&inspect(mesh)?, params)
}

/// What would be done with the holes that were found.
pub(super) fn plan_found(found: &Inspection, params: &FillParams) -> Result<Plan, FillError> {
    let (mut outcomes, chosen) = choose(found, params)?;
    let groups = groups(found, &chosen, &mut outcomes, &bridges(found, params)?);
    check_voxel(found, &groups, params, None)?;
    let mut planned: Vec<(PlannedOutcome, usize)> = outcomes
        .into_iter()
        .map(|outcome| match outcome {
            HoleOutcome::Left(why) => (PlannedOutcome::Left(why), 0),
            _ => (PlannedOutcome::WouldBeFilled, 0),
        })
        .collect();
    let mut regions = Vec::new();
    for (i, group) in groups.iter().enumerate() {
        let simple = triangulated(found, params, group);
        for &h in group {
            planned[h].1 = i + 1;
            if let Some(why) = simple {
                planned[h].0 = PlannedOutcome::WouldBeTriangulated(why.to_owned());
            }
        }
        regions.push(region(found, params, group, i + 1, simple.is_none()));
    }
    let holes = found.holes.iter().zip(planned);
    Ok(Plan {
        vertices: found.mesh.positions.len(),
        faces: found.mesh.faces.len(),
        pieces: found.topology.piece_faces.len(),
        defects: found.topology.defects,
        open_chains: found.open_chains.clone(),
        holes: holes
            .map(|(hole, (outcome, region))| PlannedHole {
                hole: hole.clone(),
                outcome,
                region,
            })
            .collect(),
        regions,
    })
}

/// Why a group would be closed without a grid, if it would.
fn triangulated(found: &Inspection, params: &FillParams, group: &[usize]) -> Option<&'static str> {
    if attempt::is_trivial(found, params, group) {
        return Some("it has no more than four edges");
    }
    let (&[a, b], SurfaceKind::Stitched) = (group, params.surface) else {
        return None;
    };
    let [a, b] = [a, b].map(|h| &found.holes[h].rim);
    close_seam(&found.mesh, a, b).map(|_| "it is one side of a seam")
}

fn region(
    found: &Inspection,
    params: &FillParams,
    group: &[usize],
    id: usize,
    solved: bool,
) -> PlannedRegion {
    let holes: Vec<usize> = group.iter().map(|&h| found.holes[h].id).collect();
    let grid = solved.then(|| attempt::first_region(found, params, group));
    let widest = group.iter().map(|&h| found.holes[h].diameter);
    PlannedRegion {
        id,
        bridge: params
            .bridge
            .iter()
            .any(|b| b.iter().any(|i| holes.contains(i))),
        diameter: widest.fold(0.0, f64::max),
        voxel: grid.as_ref().map(|g| g.voxel),
        dims: grid.as_ref().map(|g| {
            let finer = 1 << g.refinements.min(16);
            g.dims.map(|n| n as usize * finer)
        }),
        holes,
    }
}
