//! JSON rows for holes, their outcomes, regions and crease ends.

use glam::DVec3;
use serde::Serialize;

use super::counterpart::CounterpartRow;
use isomend_core::fill::{
    Closure, CreaseReport, FinishReport, GrainReport, HoleOutcome, NotContinued, Quality,
    RegionReport,
};
use isomend_core::flow::{Energy, FlowOutcome, StepRecord};
use isomend_core::mend::{HoleReport, PlannedHole};
use isomend_core::mesh::{Hole, HoleId};
use isomend_core::region::LevelReport;

/// A hole and its measures.
#[derive(Debug, Serialize)]
pub(in crate::job) struct HoleRow {
    id: HoleId,
    edges: usize,
    length: f64,
    diameter: f64,
    width: f64,
    planarity: f64,
    height: f64,
    centre: DVec3,
    normal: DVec3,
    component: u32,
    outer_boundary: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    object: Option<String>,
}

impl HoleRow {
    pub(in crate::job) fn new(hole: &Hole) -> Self {
        Self {
            id: hole.id,
            edges: hole.edges,
            length: hole.length,
            diameter: hole.diameter,
            width: hole.width,
            planarity: hole.planarity,
            height: hole.height,
            centre: hole.centre,
            normal: hole.normal,
            component: hole.component,
            outer_boundary: hole.outer_boundary,
            object: hole.object.clone(),
        }
    }
}

/// A hole and its outcome, or the outcome that is planned.
#[derive(Serialize)]
pub(super) struct OutcomeRow {
    #[serde(flatten)]
    hole: HoleRow,
    outcome: &'static str,
    /// How it was closed; null where it is open, and in a plan where the fill finds it.
    closed_by: Option<&'static str>,
    /// Why, as a fixed identifier.
    #[serde(skip_serializing_if = "Option::is_none")]
    cause: Option<&'static str>,
    /// Why, as a sentence.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    region: usize,
}

impl OutcomeRow {
    pub(super) fn new(report: &HoleReport) -> Self {
        let outcome = report.outcome.key();
        Self::of(&report.hole, outcome, Some(&report.outcome), report.region)
    }

    pub(super) fn planned(planned: &PlannedHole) -> Self {
        let outcome = match &planned.outcome {
            Some(open @ (HoleOutcome::Left(_) | HoleOutcome::Open(_))) => open.key(),
            Some(HoleOutcome::Closed(_)) | None => "would_be_closed",
        };
        Self::of(
            &planned.hole,
            outcome,
            planned.outcome.as_ref(),
            planned.region,
        )
    }

    fn of(hole: &Hole, outcome: &'static str, how: Option<&HoleOutcome>, region: usize) -> Self {
        Self {
            hole: HoleRow::new(hole),
            outcome,
            closed_by: how.and_then(HoleOutcome::closure).map(Closure::key),
            cause: how.and_then(HoleOutcome::cause),
            reason: how.and_then(HoleOutcome::reason),
            region,
        }
    }
}

/// Why sharp edges were not continued.
#[derive(Serialize)]
struct NotContinuedRow {
    /// A fixed identifier.
    cause: &'static str,
    /// A sentence.
    reason: String,
}

impl NotContinuedRow {
    fn new(why: &NotContinued) -> Self {
        Self {
            cause: why.key(),
            reason: why.to_string(),
        }
    }
}

/// A region that was filled. `voxel` is 0 if no grid was used.
#[derive(Serialize)]
pub(super) struct RegionRow<'a> {
    id: usize,
    holes: &'a [HoleId],
    bridge: bool,
    /// Whether it joins the two sides of a wall, without being asked.
    joins_wall: bool,
    diameter: f64,
    voxel: f64,
    levels: Vec<LevelRow<'a>>,
    converged: bool,
    /// How it was closed; null where a rim is open.
    closed_by: Option<&'static str>,
    rise: Option<f64>,
    seam_angle_mean: Option<f64>,
    seam_angle_max: Option<f64>,
    new_vertices: usize,
    new_faces: usize,
    quality_mean: f64,
    intersecting_faces: usize,
    components: usize,
    /// The quality by which candidate patches were compared; null for offset shells of a repair.
    quality: Option<&'a Quality>,
    /// How the patch was finished on the triangle mesh; null if it was not.
    finish: Option<&'a FinishReport>,
    /// Sharp edges that were continued over the patch.
    creases: &'a [CreaseReport],
    /// Number of sharp edges that end at the rim.
    crease_ends: usize,
    /// Why they were not continued; null if they were.
    not_continued: Option<NotContinuedRow>,
    /// The counterpart after which it was to be filled; null where there was none.
    counterpart: Option<CounterpartRow>,
    /// The roughness that was invented for the patch; null where it has none.
    grain: Option<GrainReport>,
    failed_attempts: Vec<String>,
    other_energy: bool,
    /// Left out where no run times are reported.
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
}

/// A level of the solve of a region.
#[derive(Serialize)]
struct LevelRow<'a> {
    voxel: f64,
    nodes: usize,
    flow: FlowRow<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<[f64; 2]>,
}

/// The flow of a level.
#[derive(Serialize)]
struct FlowRow<'a> {
    energy: Energy,
    steps: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    each_step: Option<&'a [StepRecord]>,
    update: f64,
    converged: bool,
    energy_plateau: bool,
    unknowns: usize,
    energy_before: f64,
    energy_after: f64,
    kappa: f64,
}

impl<'a> FlowRow<'a> {
    fn new(flow: &'a FlowOutcome, each_step: bool) -> Self {
        Self {
            energy: flow.energy,
            steps: flow.steps.len(),
            each_step: each_step.then_some(&flow.steps),
            update: flow.update,
            converged: flow.converged,
            energy_plateau: flow.energy_plateau,
            unknowns: flow.unknowns,
            energy_before: flow.energy_before,
            energy_after: flow.energy_after,
            kappa: flow.kappa,
        }
    }
}

impl<'a> LevelRow<'a> {
    fn new(level: &'a LevelReport, each_step: bool) -> Self {
        let LevelReport { voxel, nodes, .. } = *level;
        Self {
            voxel,
            nodes,
            flow: FlowRow::new(&level.flow, each_step),
            seconds: Some(level.seconds).filter(|seconds| *seconds != [0.0; 2]),
        }
    }
}

/// A run time; none if it was cleared, or not measured.
pub(super) fn some_time(seconds: f64) -> Option<f64> {
    Some(seconds).filter(|seconds| *seconds > 0.0)
}

impl<'a> RegionRow<'a> {
    pub(super) fn new(r: &'a RegionReport, walls: &[HoleId], each_step: bool) -> Self {
        let level = |level| LevelRow::new(level, each_step);
        Self {
            id: r.id,
            holes: &r.holes,
            bridge: r.bridge,
            joins_wall: r.holes.iter().any(|id| walls.contains(id)),
            diameter: r.diameter,
            voxel: r.voxel.unwrap_or(0.0),
            levels: r.levels.iter().map(level).collect(),
            converged: r.converged,
            closed_by: r.closure.as_ref().map(Closure::key),
            rise: r.rise,
            seam_angle_mean: r.seam_angle_mean,
            seam_angle_max: r.seam_angle_max,
            new_vertices: r.new_vertices,
            new_faces: r.new_faces,
            quality_mean: r.quality_mean,
            intersecting_faces: r.intersecting_faces,
            components: r.components,
            quality: r.quality.as_ref(),
            finish: r.finish.as_ref(),
            creases: &r.creases,
            crease_ends: r.crease_ends,
            not_continued: r.not_continued.as_ref().map(NotContinuedRow::new),
            grain: r.grain,
            counterpart: r.counterpart.as_ref().map(CounterpartRow::new),
            failed_attempts: r.failed_attempts.iter().map(ToString::to_string).collect(),
            other_energy: r.other_energy,
            seconds: some_time(r.seconds),
        }
    }
}
