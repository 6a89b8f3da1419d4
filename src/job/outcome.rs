//! What comes of a job.

use std::borrow::Cow;

use super::JobSpec;
use super::result::Extent;
use crate::io::Format;
use crate::mend::FillReport;
use crate::mesh::Mesh;

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
    /// Whether this is what would be done.
    pub planned: bool,
    /// What of the mesh was replaced.
    pub extent: Extent,
    /// What was found and done.
    pub report: FillReport,
    /// The mesh as it was written; none in a plan.
    pub mesh: Option<Mesh>,
    /// The bytes, where they are the caller's.
    pub bytes: Vec<u8>,
    /// Remarks of the reader and the writer.
    pub notes: Vec<String>,
    /// How many of them are the reader's.
    pub notes_read: usize,
}

impl JobResult<'_> {
    /// The remarks of the writer.
    pub fn notes_written(&self) -> &[String] {
        &self.notes[self.notes_read..]
    }

    /// Whether nothing that was to be filled is still open.
    pub fn complete(&self) -> bool {
        self.extent.is_complete(&self.report)
    }
}
