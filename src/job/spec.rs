//! The description of a job: source, work with its parameters, output, drawings and deliverables.

use std::path::Path;
#[cfg(feature = "view")]
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::deliver::Deliverables;
use super::draw::Drawings;
use super::{JobError, MaskSpec, Output, Place, Source};
use crate::fill::FillParams;
#[cfg(feature = "view")]
use crate::fill::Like;
use crate::mend::{FairParams, RestoreParams};
use crate::repair::RepairParams;

/// The work to do with a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Work {
    /// Fill holes.
    Fill(FillParams),
    /// Replace the faces that a mask marks.
    Restore(MaskSpec, RestoreParams),
    /// Fair (smooth) the surface, or the faces that a mask marks.
    Fair(Option<MaskSpec>, FairParams),
    /// Repair defects and fill holes.
    Repair(RepairParams),
    /// Write the mesh as it was read, as far as the format of the output can hold it.
    Copy,
}

impl Work {
    /// The name of the command that does it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Fill(_) => "fill",
            Self::Restore(..) => "restore",
            Self::Fair(..) => "fair",
            Self::Repair(_) => "repair",
            Self::Copy => "convert",
        }
    }

    /// The file of the template after which holes are filled, where one is named.
    #[cfg_attr(not(feature = "view"), allow(dead_code))]
    pub(crate) fn template(&self) -> Option<&Path> {
        let fill = match self {
            Self::Fill(fill) => fill,
            Self::Restore(_, params) => &params.fill,
            Self::Repair(params) => &params.fill,
            Self::Fair(..) | Self::Copy => return None,
        };
        Some(fill.like.as_ref()?.unread()?)
    }

    /// The same work with another file for its template.
    #[cfg(feature = "view")]
    #[must_use]
    pub(crate) fn with_template(mut self, file: PathBuf) -> Self {
        let fill = match &mut self {
            Self::Fill(fill) => fill,
            Self::Restore(_, params) => &mut params.fill,
            Self::Repair(params) => &mut params.fill,
            Self::Fair(..) | Self::Copy => return self,
        };
        fill.like = Some(Like::Template { file, mesh: None });
        self
    }

    /// Whether its command makes patches, and has the options for them.
    #[cfg_attr(not(feature = "view"), allow(dead_code))]
    pub(crate) fn makes_patches(&self) -> bool {
        matches!(self, Self::Fill(_) | Self::Restore(..) | Self::Repair(_))
    }

    /// Checks its parameters, and that the files of its mask can be read.
    ///
    /// # Errors
    /// The first problem.
    pub fn check(&self) -> Result<(), JobError> {
        match self {
            Self::Fill(params) => Ok(params.check()?),
            Self::Restore(mask, params) => {
                mask.check()?;
                match mask.is_empty() {
                    true => Err(JobError::NoMask),
                    false => Ok(params.check()?),
                }
            }
            Self::Repair(params) => Ok(params.check()?),
            Self::Fair(mask, params) => {
                mask.as_ref().map_or(Ok(()), MaskSpec::check)?;
                Ok(params.check()?)
            }
            Self::Copy => Ok(()),
        }
    }
}

/// A job: one mesh from its source to an output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct JobSpec {
    /// The mesh to read.
    pub source: Source,
    /// The output; `None` for a plan.
    pub output: Option<Output>,
    /// The work to do.
    pub work: Work,
    /// The page and the picture to draw.
    pub drawings: Drawings,
    /// Further files besides the mesh, and how patches are marked and reported.
    #[serde(default)]
    pub deliverables: Deliverables,
}

impl JobSpec {
    /// A job that writes in the format of the output's extension.
    ///
    /// # Errors
    /// [`JobError::NoFormat`].
    pub fn new(
        source: impl Into<Source>,
        output: impl Into<Place>,
        work: Work,
    ) -> Result<Self, JobError> {
        let output = Output::new(output, None)?;
        Ok(Self {
            output: Some(output),
            ..Self::plan(source, work)
        })
    }

    /// A job without an output, for a plan.
    pub fn plan(source: impl Into<Source>, work: Work) -> Self {
        Self {
            source: source.into(),
            output: None,
            work,
            drawings: Drawings::default(),
            deliverables: Deliverables::default(),
        }
    }

    /// Checks parameters and files without reading the mesh.
    ///
    /// # Errors
    /// If a parameter is invalid, or if a file cannot be written or would overwrite another file of the job.
    pub fn check(&self) -> Result<(), JobError> {
        if let Some(output) = &self.output {
            output.check()?;
        }
        let mesh = self.output.as_ref().map(|o| &o.place);
        self.drawings.check(&self.source.place, mesh)?;
        self.deliverables.check(self)?;
        self.work.check()
    }
}
