//! What a job is to do.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::deliver::Deliverables;
use super::draw::Drawings;
use super::{JobError, MaskSpec, Output, Place, Source};
use crate::fill::FillParams;
use crate::mend::{FairParams, RestoreParams};
use crate::repair::RepairParams;

/// What is done with a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Work {
    /// Holes are filled.
    Fill(FillParams),
    /// What a mask marks is replaced.
    Restore(MaskSpec, RestoreParams),
    /// The surface, or what a mask marks, is faired.
    Fair(Option<MaskSpec>, FairParams),
    /// What is wrong is mended, and holes are filled.
    Repair(RepairParams),
    /// Nothing: the mesh is written as it was read, as far as the format of the output can hold it.
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

    /// Whether its parameters make sense and the files of its mask can be read.
    ///
    /// # Errors
    /// The first thing that does not.
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

/// One mesh from a file to a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct JobSpec {
    /// The mesh to read.
    pub source: Source,
    /// Where the result goes; none where it is only said what would be done.
    pub output: Option<Output>,
    /// What is done.
    pub work: Work,
    /// What is drawn of it.
    pub drawings: Drawings,
    /// What is handed on beside the mesh, and how it is reported.
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

    /// A job that only says what would be done.
    pub fn plan(source: impl Into<Source>, work: Work) -> Self {
        Self {
            source: source.into(),
            output: None,
            work,
            drawings: Drawings::default(),
            deliverables: Deliverables::default(),
        }
    }

    /// Checks what can be known before anything is read.
    ///
    /// # Errors
    /// When the parameters make no sense, or a file cannot be written or would go over another one.
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
