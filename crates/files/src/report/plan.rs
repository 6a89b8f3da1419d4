//! The plan of a fill as text: which holes would be filled, how, and which would stay open.

use std::collections::HashSet;

use super::text::{chain_lines, every_hole, joined, named_holes, with_article};
use super::{counted, defect_lines};
use isomend_core::fill::{Closure, HoleOutcome, LeftReason};
use isomend_core::mend::{FillPlan, FillReport};
use isomend_core::mesh::{HoleId, Unit};

/// A plan in lines: defects, then the regions, then the holes that would stay open.
#[doc(hidden)]
pub fn plan_lines(plan: &FillPlan, unit: Option<Unit>) -> Vec<String> {
    let notes = defect_lines(&plan.input.defects).into_iter();
    let notes = notes.chain(chain_lines(&plan.input.open_chains));
    let mut lines: Vec<String> = notes.map(|line| format!("note: {line}")).collect();
    for r in &plan.regions {
        if let (Some(voxel), Some([x, y, z])) = (r.voxel, r.dims) {
            lines.push(format!(
                "hole {}: would be filled; diameter {}, voxel {} ({:.0} across), in a box of {x} x {y} x {z} nodes",
                joined(&r.holes),
                Unit::text(unit, r.diameter),
                Unit::text(unit, voxel),
                r.diameter / voxel
            ));
        }
    }
    for (how, ids) in ways(plan) {
        lines.push(format!("{}: would be closed by {how}", named_holes(&ids)));
    }
    let left = plan.holes.iter().filter_map(|h| match h.outcome {
        Some(HoleOutcome::Left(why)) => Some((h.hole.id, why)),
        _ => None,
    });
    let left = by_reason(left);
    for (why, ids) in &left {
        lines.push(format!("{}: would be left open: {why}", named_holes(ids)));
    }
    let open: usize = left.iter().map(|(_, ids)| ids.len()).sum();
    let all = plan.holes.len();
    lines.push(match (all, open) {
        (0, _) => "no holes".to_owned(),
        (_, 0) => every_hole(all, ["would"; 2], "be filled"),
        _ => format!("{} of {} would be filled", all - open, counted(all, "hole")),
    });
    lines
}

/// The holes that would be closed without a grid, grouped by how; rims of few edges get smoothed triangles.
fn ways(plan: &FillPlan) -> Vec<(String, Vec<HoleId>)> {
    let without_grid = plan.regions.iter().filter(|r| r.voxel.is_none());
    let own: HashSet<HoleId> = without_grid.flat_map(|r| r.holes.iter().copied()).collect();
    let mut ways: Vec<(String, Vec<HoleId>)> = Vec::new();
    for planned in plan.holes.iter().filter(|h| own.contains(&h.hole.id)) {
        let smoothed = Closure::Faired(None);
        let how = planned
            .outcome
            .as_ref()
            .map_or(Some(&smoothed), HoleOutcome::closure);
        let Some(how) = how.map(with_article) else {
            continue;
        };
        match ways.iter_mut().find(|(known, _)| *known == how) {
            Some((_, ids)) => ids.push(planned.hole.id),
            None => ways.push((how, vec![planned.hole.id])),
        }
    }
    ways
}

/// The holes that stay open, grouped by reason.
#[doc(hidden)]
pub fn left_holes(report: &FillReport) -> Vec<(LeftReason, Vec<HoleId>)> {
    by_reason(report.holes.iter().filter_map(|h| match h.outcome {
        HoleOutcome::Left(why) => Some((h.hole.id, why)),
        _ => None,
    }))
}

/// Groups holes by reason, in the order of their first holes.
fn by_reason(holes: impl Iterator<Item = (HoleId, LeftReason)>) -> Vec<(LeftReason, Vec<HoleId>)> {
    let mut left: Vec<(LeftReason, Vec<HoleId>)> = Vec::new();
    for (id, why) in holes {
        match left.iter_mut().find(|(w, _)| *w == why) {
            Some((_, ids)) => ids.push(id),
            None => left.push((why, vec![id])),
        }
    }
    left
}
