//! What comes of a job: what it would do, and what it did.

use std::borrow::Cow;

use super::JobSpec;
use super::deliver::Delivered;
use super::result::Extent;
use crate::check::Verdict;
use crate::io::Format;
use crate::mend::{FairPlan, FillPlan, FillReport, RestorePlan};
use crate::mesh::Mesh;

/// What a job would do.
#[derive(Debug)]
#[non_exhaustive]
pub struct JobPlan<'s> {
    /// The job.
    pub spec: Cow<'s, JobSpec>,
    /// The format that was read.
    pub format: Format,
    /// Vertices and faces of the mesh that was read.
    pub size: [usize; 2],
    /// What would be done.
    pub plan: WorkPlan,
    /// Remarks of the reader.
    pub notes: Vec<String>,
}

/// What would be done with a mesh, by the kind of work.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum WorkPlan {
    /// Holes would be filled.
    Fill(FillPlan),
    /// A marked region would be replaced.
    Restore(RestorePlan),
    /// The surface, or a marked region, would be faired.
    Fair(FairPlan),
    /// What is wrong would be mended; which of its holes will be left then to be filled is not known before.
    Repair {
        /// What is wrong.
        before: Box<Verdict>,
        /// The fill of the holes that it has now.
        fill: FillPlan,
    },
    /// It would be written as it was read.
    Copy,
}

/// What came of a job.
#[derive(Debug)]
#[non_exhaustive]
pub struct JobResult<'s> {
    /// The job.
    pub spec: Cow<'s, JobSpec>,
    /// The format that was read.
    pub format: Format,
    /// Vertices and faces of the mesh that was read.
    pub size: [usize; 2],
    /// What of the mesh was replaced.
    pub extent: Extent,
    /// What was found and done.
    pub report: FillReport,
    /// The mesh as it was written.
    pub mesh: Mesh,
    /// The bytes, where they are the caller's.
    pub bytes: Vec<u8>,
    /// Remarks of the reader and the writer.
    pub notes: Vec<String>,
    /// How many of them are the reader's.
    pub notes_read: usize,
    /// SHA-256 of what was read and of what was written, where they are files or bytes.
    pub(super) sha256: [Option<String>; 2],
    /// What was handed on beside the mesh.
    pub(super) delivered: Delivered,
}

impl JobResult<'_> {
    /// The remarks of the writer.
    pub fn notes_written(&self) -> &[String] {
        &self.notes[self.notes_read..]
    }

    /// Whether all that was asked for beside the mesh was handed on, and expected errors are within the tolerance.
    pub fn delivered(&self) -> bool {
        self.delivered.is_complete()
    }

    /// How much is invented and how sure it is, in lines: in all, and in a report that is to be filed for each hole.
    pub fn delivery_lines(&self) -> Vec<String> {
        let wanted = &self.spec.deliverables;
        let mut lines = self.delivered.lines(wanted.unit, wanted.tolerance);
        if wanted.is_filed() {
            lines.extend(self.delivered.hole_lines(wanted.unit));
        }
        lines
    }

    /// What of [`JobResult::delivered`] does not hold, in lines.
    pub fn delivery_warnings(&self) -> Vec<String> {
        let wanted = &self.spec.deliverables;
        self.delivered.warnings(wanted.unit, wanted.tolerance)
    }

    /// Whether nothing that was to be filled is still open.
    pub fn complete(&self) -> bool {
        self.extent.is_complete(&self.report)
    }
}
