//! Chooses the holes to fill, and groups the holes that are filled together.

use super::{FillError, Inspection};
use crate::fill::{FEW_EDGES, FillParams, HoleOutcome, LeftReason, OpenReason};
use crate::mesh::HoleId;
use crate::region::{group_holes, group_named};

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
    let wanted = |i: usize| asked.as_ref().is_some_and(|a| a.contains(&i)) || named.contains(&i);
    // The caller's reasons to leave a hole open.
    let left_by_caller = |i: usize| {
        if kept.contains(&i) {
            Some(LeftReason::KeptOpen)
        } else if wanted(i) {
            None
        } else if asked.is_some() {
            Some(LeftReason::NotChosen)
        } else if params
            .max_diameter
            .is_some_and(|d| found.holes[i].diameter > d)
        {
            Some(LeftReason::TooWide)
        } else {
            None
        }
    };
    let open: Vec<usize> = (0..found.holes.len())
        .filter(|&i| left_by_caller(i).is_none())
        .collect();
    let facing = match params.apart {
        true => vec![false; found.holes.len()],
        false => facing_borders(found, &open),
    };
    let (mut outcomes, mut chosen) = (Vec::new(), Vec::new());
    for (i, hole) in found.holes.iter().enumerate() {
        let small = || found.bounds_small_component(i);
        let reason = if let Some(reason) = left_by_caller(i) {
            Some(reason)
        } else if wanted(i) {
            None
        } else if hole.outer_boundary && !params.flat_base && !small() && !facing[i] {
            Some(LeftReason::OuterBoundary)
        } else {
            None
        };
        outcomes.push(match reason {
            Some(reason) => HoleOutcome::Left(reason),
            None => {
                chosen.push(i);
                HoleOutcome::Open(OpenReason::NotReached)
            }
        });
    }
    Ok((outcomes, chosen))
}

/// Groups the chosen holes into regions, with the holes `joined` that bridges name or that are ends of a bore. The rims of one flat cap
/// form a region, also if there are several. Holes of few edges that no bridge names and holes with flat caps or bases form regions of
/// their own. Rims of small components join the hole around them, or are left open.
pub(super) fn groups(
    found: &Inspection,
    params: &FillParams,
    (chosen, caps): (&[usize], &[Vec<usize>]),
    outcomes: &mut [HoleOutcome],
    joined: &[Vec<usize>],
) -> Vec<Vec<usize>> {
    let is_small = |h: usize| found.bounds_small_component(h);
    let is_alone = |h: usize| {
        let hole = &found.holes[h];
        hole.edges <= FEW_EDGES.get() && !is_small(h) && !params.bridges(&[hole.id])
            || params.is_flat(hole.id)
            || params.is_on_base(hole) && !is_small(h)
    };
    let several: Vec<&Vec<usize>> = caps.iter().filter(|cap| cap.len() > 1).collect();
    let free = chosen
        .iter()
        .filter(|h| !several.iter().any(|cap| cap.contains(h)));
    let (alone, others): (Vec<usize>, Vec<usize>) = free.partition(|&&h| is_alone(h));
    let mut groups = match params.apart {
        true => group_named(&found.holes, &others, joined),
        false => group_holes(&found.mesh, &found.holes, &others, joined, &is_small),
    };
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
    groups.extend(several.into_iter().cloned());
    groups
}

/// Marks the outer borders that face the rim of another component: islands in holes, the two sides of a gap. Only rims that are to be
/// filled count, as indices in `open`.
fn facing_borders(found: &Inspection, open: &[usize]) -> Vec<bool> {
    let mut facing = vec![false; found.holes.len()];
    if !found.holes.iter().any(|h| h.outer_boundary) {
        return facing;
    }
    let is_small = |h: usize| found.bounds_small_component(h);
    let groups = group_holes(&found.mesh, &found.holes, open, &[], &is_small);
    let component = |h: usize| found.holes[h].component;
    for group in &groups {
        for &h in group {
            facing[h] = group.iter().any(|&other| component(other) != component(h));
        }
    }
    facing
}
