//! The description of a job: source, work with its parameters, output, drawings and deliverables.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::deliver::Deliverables;
use super::draw::Drawings;
use super::places::refuse_over;
use super::{JobError, MaskSpec, Output, Place, Source};
use isomend_core::check::CheckParams;
use isomend_core::fill::{FillParams, Like};
use isomend_core::mend::{FairParams, FillError, RestoreParams};
use isomend_core::repair::RepairParams;

/// The work to do with a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
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
    /// List the holes and properties of the mesh, and the faces that a mask marks. Writes no mesh.
    Inspect(Option<MaskSpec>),
    /// List the defects of the mesh. Writes no mesh.
    Check(CheckParams),
}

impl Work {
    /// The files that it reads besides the mesh, each with what it is.
    pub(super) fn files_read(&self) -> Vec<(&'static str, PathBuf)> {
        let masks = self
            .mask()
            .into_iter()
            .flat_map(|m| m.inside.iter().chain(&m.face_files));
        let masks = masks.map(|path| ("a mask", path.clone()));
        let template = self
            .template()
            .map(|path| ("the template", path.to_path_buf()));
        masks.chain(template).collect()
    }

    /// Its mask, if it has one.
    pub(super) fn mask(&self) -> Option<&MaskSpec> {
        match self {
            Self::Restore(mask, _) => Some(mask),
            Self::Fair(mask, _) | Self::Inspect(mask) => mask.as_ref(),
            Self::Fill(_) | Self::Repair(_) | Self::Copy | Self::Check(_) => None,
        }
    }

    /// The name of the command that does it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Fill(_) => "fill",
            Self::Restore(..) => "restore",
            Self::Fair(..) => "fair",
            Self::Repair(_) => "repair",
            Self::Copy => "convert",
            Self::Inspect(_) => "inspect",
            Self::Check(_) => "check",
        }
    }

    /// The file of the template after which holes are filled, where one is named.
    pub fn template(&self) -> Option<&Path> {
        let fill = match self {
            Self::Fill(fill) => fill,
            Self::Restore(_, params) => &params.fill,
            Self::Repair(params) => &params.fill,
            Self::Fair(..) | Self::Copy | Self::Inspect(_) | Self::Check(_) => return None,
        };
        Some(fill.like.as_ref()?.unread()?)
    }

    /// The same work with another file for its template.
    #[must_use]
    pub fn with_template(mut self, file: PathBuf) -> Self {
        let fill = match &mut self {
            Self::Fill(fill) => fill,
            Self::Restore(_, params) => &mut params.fill,
            Self::Repair(params) => &mut params.fill,
            Self::Fair(..) | Self::Copy | Self::Inspect(_) | Self::Check(_) => return self,
        };
        fill.like = Some(Like::Template { file, mesh: None });
        self
    }

    /// Whether its command makes patches, and has the options for them.
    pub fn makes_patches(&self) -> bool {
        matches!(self, Self::Fill(_) | Self::Restore(..) | Self::Repair(_))
    }

    /// Whether it only looks at the mesh and writes none.
    pub fn only_looks(&self) -> bool {
        matches!(self, Self::Inspect(_) | Self::Check(_))
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
            Self::Inspect(mask) => mask.as_ref().map_or(Ok(()), MaskSpec::check),
            Self::Check(params) => Ok(params.check().map_err(FillError::from)?),
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
    /// Whether JSON documents list each step of the flows.
    #[serde(default)]
    pub each_step: bool,
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
            each_step: false,
        }
    }

    /// Refuses outputs that are files which the job reads besides its mesh.
    ///
    /// # Errors
    /// [`JobError::Places`].
    pub(super) fn refuse_over_read(&self) -> Result<(), JobError> {
        let read = self.work.files_read();
        let drawn = [&self.drawings.page, &self.drawings.picture];
        let drawn = drawn.into_iter().flatten().cloned().map(Place::from);
        let delivered = [&self.deliverables.patches, &self.deliverables.piece];
        let meshes = self.output.iter().chain(delivered.into_iter().flatten());
        for place in drawn.chain(meshes.map(|output| output.place.clone())) {
            refuse_over(&place, &self.source.place, &read)?;
        }
        Ok(())
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
        self.refuse_over_read()?;
        self.drawings.check(&self.source.place, mesh)?;
        self.deliverables.check(self)?;
        self.work.check()
    }
}
