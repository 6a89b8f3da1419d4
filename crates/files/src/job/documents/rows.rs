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
    /// Number, from 1.
    id: HoleId,
    /// Number of edges.
    edges: usize,
    /// Length of the rim.
    length: f64,
    /// Largest distance between two vertices.
    diameter: f64,
    /// Five areas over the length, at most the diameter.
    width: f64,
    /// Distance of the vertices from their plane, over the diameter. Root mean square.
    planarity: f64,
    /// Extent of the rim along its normal.
    height: f64,
    /// Mean of the vertices. Weighted by edge length.
    centre: DVec3,
    /// Unit normal, outwards. Zero if the rim encloses no area.
    normal: DVec3,
    /// Component that it bounds, from 0.
    component: u32,
    /// Whether it is the border of an open sheet.
    outer_boundary: bool,
    /// Object of a 3MF file.
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

/// A hole and its outcome, in a plan the planned one.
#[derive(Serialize)]
pub(super) struct OutcomeRow {
    #[serde(flatten)]
    hole: HoleRow,
    /// `closed`, `left` (as asked) or `open`. In a plan `would_be_closed` or `left`.
    outcome: &'static str,
    /// How it was closed.
    closed_by: Option<&'static str>,
    /// Why it was not closed as wished.
    #[serde(skip_serializing_if = "Option::is_none")]
    cause: Option<&'static str>,
    /// The cause as a sentence.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    /// Number of its region, or 0.
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
    /// `declined`, `intersects`, `predicted` (a smooth patch predicts the surrounding faces as well), `rough` or `rounded`.
    cause: &'static str,
    /// The cause as a sentence.
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

/// A region: holes that were filled together, and their patch.
#[derive(Serialize)]
pub(super) struct RegionRow<'a> {
    /// Number, from 1.
    id: usize,
    /// Numbers of its holes.
    holes: &'a [HoleId],
    /// Whether `--bridge` asked for it.
    bridge: bool,
    /// Whether it joins two sides of a wall unasked.
    joins_wall: bool,
    /// Diameter of its largest hole.
    diameter: f64,
    /// Voxel size of the finest grid, or 0.
    voxel: f64,
    /// The grids, coarsest first.
    levels: Vec<LevelRow<'a>>,
    /// Whether the flow converged.
    converged: bool,
    /// As of its holes. Null where a rim is open.
    closed_by: Option<&'static str>,
    /// Rise of the patch above its rim, in diameters. Above 0.3 it gets a remark. Null for patches of several holes.
    rise: Option<f64>,
    /// Mean angle between faces at the seam.
    seam_angle_mean: Option<f64>,
    /// Largest of these angles.
    seam_angle_max: Option<f64>,
    /// Number of new vertices.
    new_vertices: usize,
    /// Number of new faces.
    new_faces: usize,
    /// Mean quality of the new faces; 1 is equilateral.
    quality_mean: f64,
    /// Number of new faces that intersect others. As they are written.
    intersecting_faces: usize,
    /// Number of components of the patch.
    components: usize,
    /// Quality by which patches were compared. Null for offset shells.
    quality: Option<&'a Quality>,
    /// How the patch was finished on its triangles.
    finish: Option<&'a FinishReport>,
    /// Continued sharp edges.
    creases: &'a [CreaseReport],
    /// Number of sharp edges at the rim.
    crease_ends: usize,
    /// Why these were not continued.
    not_continued: Option<NotContinuedRow>,
    /// The counterpart of `--like`.
    counterpart: Option<CounterpartRow>,
    /// The roughness of `--grain`.
    grain: Option<GrainReport>,
    /// Why earlier attempts failed.
    failed_attempts: Vec<String>,
    /// Whether the Willmore energy replaced the requested one.
    other_energy: bool,
    /// Time of the region. Left out with `--unit` or `--tolerance`.
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
}

/// A level of the solve of a region.
#[derive(Serialize)]
struct LevelRow<'a> {
    /// Voxel size.
    voxel: f64,
    /// Number of stored nodes.
    nodes: usize,
    /// The flow.
    flow: FlowRow<'a>,
    /// Times of sampling and of solving.
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<[f64; 2]>,
}

/// The flow of a level.
#[derive(Serialize)]
struct FlowRow<'a> {
    /// The energy that was minimised.
    energy: Energy,
    /// Number of steps.
    steps: usize,
    /// The steps, with `--verbose`.
    #[serde(skip_serializing_if = "Option::is_none")]
    each_step: Option<&'a [StepRecord]>,
    /// Largest displacement of the last step, in voxels.
    update: f64,
    /// Whether it converged.
    converged: bool,
    /// Whether it ended because the energy hardly changed any more.
    energy_plateau: bool,
    /// Number of unknowns of the last band.
    unknowns: usize,
    /// Energy of the initial surface.
    energy_before: f64,
    /// Energy of the final surface.
    energy_after: f64,
    /// Final weight of the eikonal term.
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
