//! Chooses the holes to fill, and groups the holes that are filled together.

use super::{FillError, Inspection};
use crate::fill::{FailedReason, FillParams, HoleOutcome, LeftReason};
use crate::mesh::HoleId;
use crate::region::group_holes;
use crate::tuning::tuning;

fn lookup(found: &Inspection, ids: &[HoleId]) -> Result<Vec<usize>, FillError> {
    let count = found.holes.len();
    let index = |&id: &HoleId| match id.get() {
        number @ 1.. if number <= count => Ok(number - 1),
        _ => Err(FillError::NoSuchHole { id, count }),
    };
    ids.iter().map(index).collect()
}

pub(super) fn bridges(
    found: &Inspection,
    params: &FillParams,
) -> Result<Vec<Vec<usize>>, FillError> {
    params.bridge.iter().map(|ids| lookup(found, ids)).collect()
}

/// The outcome of each hole before the fill, and the indices of the holes to fill.
pub(super) fn choose(
    found: &Inspection,
    params: &FillParams,
    bridges: &[Vec<usize>],
) -> Result<(Vec<HoleOutcome>, Vec<usize>), FillError> {
    let asked = params.holes.as_deref();
    let asked = asked.map(|ids| lookup(found, ids)).transpose()?;
    let kept = lookup(found, &params.keep_open)?;
    let named = [bridges.concat(), lookup(found, &params.flat)?].concat();
    let facing = facing_borders(found);
    let (mut outcomes, mut chosen) = (Vec::new(), Vec::new());
    for (i, hole) in found.holes.iter().enumerate() {
        let wanted = asked.as_ref().is_some_and(|a| a.contains(&i)) || named.contains(&i);
        let small = || found.bounds_small_component(i);
        let reason = if kept.contains(&i) {
            Some(LeftReason::KeptOpen)
        } else if wanted {
            None
        } else if asked.is_some() {
            Some(LeftReason::NotChosen)
        } else if params.max_diameter.is_some_and(|d| hole.diameter > d) {
            Some(LeftReason::TooWide)
        } else if hole.outer_boundary && !params.flat_base && !small() && !facing[i] {
            Some(LeftReason::OuterBoundary)
        } else {
            None
        };
        outcomes.push(match reason {
            Some(reason) => HoleOutcome::Left(reason),
            None => {
                chosen.push(i);
                HoleOutcome::Failed(FailedReason::NotReached)
            }
        });
    }
    Ok((outcomes, chosen))
}

/// Groups the chosen holes into regions. Holes of few edges and holes with flat caps or bases form regions of their own. Rims of
/// small components join the hole around them, or are left open.
pub(super) fn groups(
    found: &Inspection,
    params: &FillParams,
    chosen: &[usize],
    outcomes: &mut [HoleOutcome],
    bridges: &[Vec<usize>],
) -> Vec<Vec<usize>> {
    let is_small = |h: usize| found.bounds_small_component(h);
    let is_alone = |h: usize| {
        let hole = &found.holes[h];
        hole.edges <= tuning().fill.few_edges && !is_small(h)
            || params.is_flat(hole.id)
            || params.is_on_base(hole) && !is_small(h)
    };
    let (alone, others): (Vec<usize>, Vec<usize>) = chosen.iter().partition(|&&h| is_alone(h));
    let mut groups = group_holes(&found.mesh, &found.holes, &others, bridges, &is_small);
    groups.retain(|group| {
        let only_small = group.iter().all(|&h| is_small(h));
        if only_small {
            for &h in group {
                outcomes[h] = HoleOutcome::Left(LeftReason::SmallComponent);
            }
        }
        !only_small
    });
    groups.extend(alone.into_iter().map(|h| vec![h]));
    groups
}

/// Marks the outer borders that face another rim: islands in holes, the two sides of a gap.
fn facing_borders(found: &Inspection) -> Vec<bool> {
    let mut facing = vec![false; found.holes.len()];
    if !found.holes.iter().any(|h| h.outer_boundary) {
        return facing;
    }
    let all: Vec<usize> = (0..found.holes.len()).collect();
    let is_small = |h: usize| found.bounds_small_component(h);
    let groups = group_holes(&found.mesh, &found.holes, &all, &[], &is_small);
    for group in groups.iter().filter(|group| group.len() > 1) {
        group.iter().for_each(|&h| facing[h] = true);
    }
    facing
}
