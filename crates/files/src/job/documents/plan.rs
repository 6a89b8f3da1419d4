//! JSON documents of plans, as `--dry-run --json` writes them.

use serde::Serialize;

use super::rows::OutcomeRow;
use super::{Document, FileInfo, VerdictRow};
use crate::job::{JobPlan, WorkPlan};
use isomend_core::mend::{FairPlan, FillPlan, InputReport, PlannedRegion, RestoreReport};

impl JobPlan<'_> {
    /// The JSON document of the plan.
    pub fn document(&self) -> Document<impl Serialize> {
        let body = match &self.plan {
            WorkPlan::Fill(fill) => PlannedWork::Fill(PlannedFillRow::new(fill)),
            WorkPlan::Restore(restore) => PlannedWork::Restore {
                cut: &restore.cut,
                fill: PlannedFillRow::new(&restore.fill),
            },
            WorkPlan::Fair(fair) => PlannedWork::Fair(fair),
            WorkPlan::Repair { before, fill } => PlannedWork::Repair {
                before: Box::new(VerdictRow::new(before)),
                fill: PlannedFillRow::new(fill),
            },
            WorkPlan::Copy => PlannedWork::Copy {},
        };
        let plan = PlanBody {
            dry_run: true,
            input: FileInfo::of(&self.spec.source.place, self.format, self.size),
            notes: &self.notes,
            body,
        };
        Document::new(self.spec.work.name(), plan)
    }
}

/// The document of a plan.
#[derive(Serialize)]
struct PlanBody<'a> {
    /// True: nothing was done, and only what is known before the work is there.
    dry_run: bool,
    /// The input file.
    input: FileInfo,
    /// Remarks.
    notes: &'a [String],
    #[serde(flatten)]
    body: PlannedWork<'a>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum PlannedWork<'a> {
    Fill(PlannedFillRow<'a>),
    Restore {
        #[serde(flatten)]
        cut: &'a RestoreReport,
        #[serde(flatten)]
        fill: PlannedFillRow<'a>,
    },
    Fair(&'a FairPlan),
    Repair {
        /// The verdict on the input, as of `check`.
        before: Box<VerdictRow<'a>>,
        #[serde(flatten)]
        fill: PlannedFillRow<'a>,
    },
    Copy {},
}

/// The plan of a fill.
#[derive(Serialize)]
struct PlannedFillRow<'a> {
    #[serde(flatten)]
    input: &'a InputReport,
    /// The holes.
    holes: Vec<OutcomeRow>,
    /// Holes that would be filled together.
    regions: &'a [PlannedRegion],
}

impl<'a> PlannedFillRow<'a> {
    fn new(plan: &'a FillPlan) -> Self {
        Self {
            input: &plan.input,
            holes: plan.holes.iter().map(OutcomeRow::planned).collect(),
            regions: &plan.regions,
        }
    }
}
