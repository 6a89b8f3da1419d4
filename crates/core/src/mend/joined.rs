//! Finds and checks the pairs of crease ends between which the caller wants sharp edges, before anything is filled.

use super::{Control, CreaseEnd, FillError, Inspection};
use crate::fill::{Closure, FillParams};
use crate::mesh::HoleId;

/// For each region the pairs of rim vertices between which a sharp edge is to be continued. A region is given by the indices of
/// its holes and the closure that is decided for it.
pub(super) fn joined(
    found: &Inspection,
    params: &FillParams,
    groups: &[Vec<usize>],
    decided: &[Option<Closure>],
) -> Result<Vec<Vec<[u32; 2]>>, FillError> {
    let mut joined = vec![Vec::new(); groups.len()];
    if params.crease.is_empty() {
        return Ok(joined);
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
        let region = region_of(found, a.hole, groups, decided).map_err(wrong)?;
        let pair = [a.vertex.min(b.vertex), a.vertex.max(b.vertex)];
        if !joined[region].contains(&pair) {
            joined[region].push(pair);
        }
    }
    Ok(joined)
}

fn end(all: &[CreaseEnd], id: usize) -> Result<&CreaseEnd, FillError> {
    let end = id.checked_sub(1).and_then(|at| all.get(at));
    end.ok_or(FillError::NoSuchCreaseEnd {
        end: id,
        count: all.len(),
    })
}

/// The region of a hole, or why no sharp edge can be continued in it.
fn region_of(
    found: &Inspection,
    hole: HoleId,
    groups: &[Vec<usize>],
    decided: &[Option<Closure>],
) -> Result<usize, String> {
    let has = |group: &Vec<usize>| group.iter().any(|&h| found.holes[h].id == hole);
    let Some(region) = groups.iter().position(has) else {
        return Err(format!("hole {hole} is not to be filled; fill it"));
    };
    match (&decided[region], groups[region].len()) {
        (None, 1) => Ok(region),
        (Some(Closure::Flat), _) => Err(format!("hole {hole} gets a flat cap; leave that out")),
        _ => Err(format!(
            "hole {hole} is filled together with others, and sharp edges are continued in single holes only; fill it by itself"
        )),
    }
}
