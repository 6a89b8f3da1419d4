//! What a run would do.

use super::text::{chain_lines, joined, ranges};
use super::{defect_lines, length};
use crate::fill::{HoleOutcome, LeftReason};
use crate::mend::FillReport;
use crate::mesh::HoleId;

/// A plan in lines: defects, then the regions, then the holes that would stay open.
pub fn plan_lines(plan: &FillReport) -> Vec<String> {
    let mut lines = defect_lines(&plan.defects);
    lines.extend(chain_lines(&plan.open_chains));
    let simple = plan.regions.iter().filter(|r| r.voxel.is_none());
    let simple: Vec<HoleId> = simple.flat_map(|r| r.holes.iter().copied()).collect();
    for r in &plan.regions {
        if let (Some(voxel), Some([x, y, z])) = (r.voxel, r.dims) {
            lines.push(format!(
                "hole {}: would be filled; diameter {}, voxel {} ({:.0} across), in a box of {x} x {y} x {z} nodes",
                joined(&r.holes),
                length(r.diameter),
                length(voxel),
                r.diameter / voxel
            ));
        }
    }
    if !simple.is_empty() {
        lines.push(format!(
            "{} {}: would be closed with faces between their own vertices",
            if simple.len() == 1 { "hole" } else { "holes" },
            ranges(&simple)
        ));
    }
    let left = left_holes(plan);
    for (why, ids) in &left {
        let noun = if ids.len() == 1 { "hole" } else { "holes" };
        lines.push(format!("{noun} {}: would be left open: {why}", ranges(ids)));
    }
    let open: usize = left.iter().map(|(_, ids)| ids.len()).sum();
    let all = plan.holes.len();
    lines.push(format!("{} of {all} holes would be filled", all - open));
    lines
}

/// The numbers of the holes that stay open, those with the same reason together.
pub fn left_holes(report: &FillReport) -> Vec<(LeftReason, Vec<HoleId>)> {
    let mut left: Vec<(LeftReason, Vec<HoleId>)> = Vec::new();
    for h in &report.holes {
        if let HoleOutcome::Left(why) = h.outcome {
            match left.iter_mut().find(|(w, _)| *w == why) {
                Some((_, ids)) => ids.push(h.hole.id),
                None => left.push((why, vec![h.hole.id])),
            }
        }
    }
    left
}
