//! What a run would do.

use serde::Serialize;

use super::text::{chain_lines, joined, ranges};
use super::{defect_lines, length};
use crate::mesh::{Defects, Hole, OpenChain};

/// What would happen to a hole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "outcome", content = "reason")]
pub enum PlannedOutcome {
    /// It would be filled by the level set.
    WouldBeFilled,
    /// It would be triangulated on its own, without new vertices; says why.
    WouldBeTriangulated(String),
    /// It would be left as it is; says why.
    Left(String),
}

/// A hole and what would happen to it.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedHole {
    /// The hole.
    #[serde(flatten)]
    pub hole: Hole,
    /// What would happen.
    #[serde(flatten)]
    pub outcome: PlannedOutcome,
    /// Number of its region, from 1; 0 where there is none.
    pub region: usize,
}

/// Holes that would be filled together.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedRegion {
    /// Number, from 1.
    pub id: usize,
    /// Numbers of its holes.
    pub holes: Vec<usize>,
    /// Whether its holes are put together because the caller asked for a bridge.
    pub bridge: bool,
    /// Diameter of the widest one in the mesh's units.
    pub diameter: f64,
    /// Voxel size of the first try in the mesh's units; none where no grid is needed.
    pub voxel: Option<f64>,
    /// Nodes of the box of its grid along the axes. Memory and time go with those near the surface only.
    pub dims: Option<[usize; 3]>,
}

/// Everything a fill would do.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Plan {
    /// Vertices of the input.
    pub vertices: usize,
    /// Faces of the input.
    pub faces: usize,
    /// Connected pieces of the input.
    pub pieces: usize,
    /// What is wrong with the input.
    pub defects: Defects,
    /// Boundary chains that do not close.
    pub open_chains: Vec<OpenChain>,
    /// The holes.
    pub holes: Vec<PlannedHole>,
    /// The regions.
    pub regions: Vec<PlannedRegion>,
}

/// A plan in lines: defects, then the regions, then the holes that would stay open.
pub fn plan_lines(plan: &Plan) -> Vec<String> {
    let mut lines = defect_lines(&plan.defects);
    lines.extend(chain_lines(&plan.open_chains));
    let simple = plan.regions.iter().filter(|r| r.voxel.is_none());
    let simple: Vec<usize> = simple.flat_map(|r| r.holes.iter().copied()).collect();
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
    let mut left: Vec<(&str, Vec<usize>)> = Vec::new();
    for h in &plan.holes {
        if let PlannedOutcome::Left(why) = &h.outcome {
            match left.iter_mut().find(|(w, _)| w == why) {
                Some((_, ids)) => ids.push(h.hole.id),
                None => left.push((why, vec![h.hole.id])),
            }
        }
    }
    for (why, ids) in &left {
        let noun = if ids.len() == 1 { "hole" } else { "holes" };
        lines.push(format!("{noun} {}: would be left open: {why}", ranges(ids)));
    }
    let open: usize = left.iter().map(|(_, ids)| ids.len()).sum();
    let all = plan.holes.len();
    lines.push(format!("{} of {all} holes would be filled", all - open));
    lines
}
