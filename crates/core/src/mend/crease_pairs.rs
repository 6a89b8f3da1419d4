//! Finds and checks the pairs of crease ends between which the caller wants sharp edges, before anything is filled.

use super::hole_group::HoleGroup;
use super::{Control, CreaseEnd, FillError, Inspection};
use crate::fill::{Closure, FillParams};
use crate::mesh::HoleId;

/// Gives each group the pairs of its rim vertices between which the caller wants sharp edges.
pub(super) fn join_creases(
    found: &Inspection,
    params: &FillParams,
    groups: &mut [HoleGroup],
) -> Result<(), FillError> {
    if params.crease.is_empty() {
        return Ok(());
    }
    let all = found.crease_ends(&Control::new())?;
    for &ends in &params.crease {
        let [a, b] = [end(&all, ends[0])?, end(&all, ends[1])?];
        let wrong = |why: String| FillError::Crease { ends, why };
        if a.id == b.id {
            return Err(wrong("it is the same end; name another one".to_owned()));
        }
        if a.hole != b.hole {
            let why = format!(
                "the first is at hole {}, the second at hole {}; name two ends of one hole",
                a.hole, b.hole
            );
            return Err(wrong(why));
        }
        let group = group_of(found, a.hole, groups).map_err(wrong)?;
        let pair = [a.vertex.min(b.vertex), a.vertex.max(b.vertex)];
        if !groups[group].joined.contains(&pair) {
            groups[group].joined.push(pair);
        }
    }
    Ok(())
}

fn end(all: &[CreaseEnd], id: usize) -> Result<&CreaseEnd, FillError> {
    let end = id.checked_sub(1).and_then(|at| all.get(at));
    end.ok_or(FillError::NoSuchCreaseEnd {
        end: id,
        count: all.len(),
    })
}

/// The group of a hole, or why no sharp edge can be continued in it.
fn group_of(found: &Inspection, hole: HoleId, groups: &[HoleGroup]) -> Result<usize, String> {
    let has = |group: &HoleGroup| group.holes.iter().any(|&h| found.holes[h].id == hole);
    let Some(at) = groups.iter().position(has) else {
        return Err(format!("hole {hole} is not to be filled; fill it"));
    };
    match (&groups[at].decided, groups[at].holes.len()) {
        (None, 1) => Ok(at),
        (Some(Closure::Flat), _) => Err(format!("hole {hole} gets a flat cap; leave that out")),
        _ => Err(format!(
            "hole {hole} is filled together with others, and sharp edges are continued in single holes only; fill it by itself"
        )),
    }
}
