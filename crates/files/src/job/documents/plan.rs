//! JSON documents of plans, as `--dry-run --json` writes them.

use serde::Serialize;

use super::rows::OutcomeRow;
use super::{Document, FileInfo, VerdictRow};
use crate::job::{JobPlan, WorkPlan};
use isomend_core::mend::{FairPlan, FillPlan, PlannedRegion, RestorePlan};
use isomend_core::mesh::{Defects, OpenChain};

impl JobPlan<'_> {
    /// The JSON document of the plan.
    pub fn document(&self) -> Document<impl Serialize> {
        let body = match &self.plan {
            WorkPlan::Fill(fill) => Body::Fill(FillRow::new(fill)),
            WorkPlan::Restore(restore) => Body::Restore(RestoreRow::new(restore)),
            WorkPlan::Fair(fair) => Body::Fair(fair),
            WorkPlan::Repair { before, fill } => Body::Repair {
                before: Box::new(VerdictRow::new(before)),
                fill: FillRow::new(fill),
            },
            WorkPlan::Copy => Body::Copy {},
        };
        let plan = PlanRow {
            dry_run: true,
            input: FileInfo::of(&self.spec.source.place, self.format, self.size),
            notes: &self.notes,
            body,
        };
        Document::new(self.spec.work.name(), plan)
    }
}

#[derive(Serialize)]
struct PlanRow<'a> {
    dry_run: bool,
    input: FileInfo,
    notes: &'a [String],
    #[serde(flatten)]
    body: Body<'a>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Body<'a> {
    Fill(FillRow<'a>),
    Restore(RestoreRow<'a>),
    Fair(&'a FairPlan),
    Repair {
        before: Box<VerdictRow<'a>>,
        #[serde(flatten)]
        fill: FillRow<'a>,
    },
    Copy {},
}

#[derive(Serialize)]
struct FillRow<'a> {
    vertices: usize,
    faces: usize,
    components: usize,
    defects: Defects,
    open_chains: &'a [OpenChain],
    holes: Vec<OutcomeRow>,
    regions: &'a [PlannedRegion],
}

impl<'a> FillRow<'a> {
    fn new(plan: &'a FillPlan) -> Self {
        Self {
            vertices: plan.vertices,
            faces: plan.faces,
            components: plan.components,
            defects: plan.defects,
            open_chains: &plan.open_chains,
            holes: plan.holes.iter().map(OutcomeRow::planned).collect(),
            regions: &plan.regions,
        }
    }
}

#[derive(Serialize)]
struct RestoreRow<'a> {
    marked_faces: usize,
    removed_faces: usize,
    removed_vertices: usize,
    keep_shape: f64,
    #[serde(flatten)]
    fill: FillRow<'a>,
}

impl<'a> RestoreRow<'a> {
    fn new(plan: &'a RestorePlan) -> Self {
        Self {
            marked_faces: plan.marked_faces,
            removed_faces: plan.removed_faces,
            removed_vertices: plan.removed_vertices,
            keep_shape: plan.keep_shape,
            fill: FillRow::new(&plan.fill),
        }
    }
}
