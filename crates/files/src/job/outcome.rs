//! Outcomes of jobs: the plan of a dry run, and the result of a run.

use std::borrow::Cow;

use super::JobSpec;
use super::deliver::Delivered;
use super::result::OperationReport;
use crate::io::Format;
use isomend_core::check::Verdict;
use isomend_core::mend::{FairPlan, FillPlan, FillReport, RestorePlan};
use isomend_core::mesh::Mesh;

/// The plan of a job: what it would do.
#[derive(Debug)]
#[non_exhaustive]
pub struct JobPlan<'s> {
    /// The job.
    pub spec: Cow<'s, JobSpec>,
    /// The format that was read.
    pub format: Format,
    /// Numbers of vertices and faces of the mesh that was read.
    pub size: [usize; 2],
    /// The plan of the work.
    pub plan: WorkPlan,
    /// Remarks of the reader.
    pub notes: Vec<String>,
}

/// The plan for a mesh, by the kind of work.
#[derive(Clone, Debug)]
pub enum WorkPlan {
    /// Holes would be filled.
    Fill(FillPlan),
    /// A marked region would be replaced.
    Restore(RestorePlan),
    /// The surface, or a marked region, would be faired.
    Fair(FairPlan),
    /// Defects would be repaired and holes filled. The repair may close or open holes, so the holes to fill are not known in advance.
    Repair {
        /// The defects.
        before: Box<Verdict>,
        /// The plan for the holes of the input.
        fill: FillPlan,
    },
    /// The mesh would be written as it was read.
    Copy,
}

/// The result of a job.
#[derive(Debug)]
#[non_exhaustive]
pub struct JobResult<'s> {
    /// The job.
    pub spec: Cow<'s, JobSpec>,
    /// The format that was read.
    pub format: Format,
    /// Numbers of vertices and faces of the mesh that was read.
    pub size: [usize; 2],
    /// The kind of work, with its report without the fill.
    pub extent: OperationReport,
    /// The report of the fill.
    pub report: FillReport,
    /// The mesh as it was written.
    pub mesh: Mesh,
    /// The bytes of the file, if the output is the caller's memory; else empty.
    pub bytes: Vec<u8>,
    /// Remarks, first of the reader, then of the writer.
    pub notes: Vec<String>,
    /// Number of remarks of the reader.
    pub notes_read: usize,
    /// SHA-256 of the input and of the output; `None` for an input that was a mesh in memory.
    pub(super) sha256: [Option<String>; 2],
    /// The deliverables besides the mesh.
    pub(super) delivered: Delivered,
}

impl JobResult<'_> {
    /// The remarks of the writer.
    pub fn notes_written(&self) -> &[String] {
        &self.notes[self.notes_read..]
    }

    /// Whether the missing piece was written if it was requested, and all patches are within the tolerance.
    pub fn delivered(&self) -> bool {
        self.delivered.is_complete()
    }

    /// Area and expected error of the invented surface, in lines: totals, and for an archived report one line per patch.
    pub fn delivery_lines(&self) -> Vec<String> {
        let wanted = &self.spec.deliverables;
        let mut lines = self.delivered.lines(wanted.unit, wanted.tolerance);
        if wanted.is_filed() {
            lines.extend(self.delivered.hole_lines(wanted.unit));
        }
        lines
    }

    /// Why [`JobResult::delivered`] is false, in lines.
    pub fn delivery_warnings(&self) -> Vec<String> {
        let wanted = &self.spec.deliverables;
        self.delivered.warnings(wanted.unit, wanted.tolerance)
    }

    /// Whether the work is complete: no hole that was to be filled is still open, and after a repair the mesh is sound.
    pub fn complete(&self) -> bool {
        self.extent.is_complete(&self.report)
    }
}
