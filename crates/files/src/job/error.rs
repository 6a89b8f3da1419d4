//! Errors of jobs. The underlying error, if there is one, is the error's source.

use std::path::PathBuf;

use thiserror::Error;

use crate::io::{Format, IoError};
use crate::report::picture::PictureError;
use isomend_core::compare::CompareError;
use isomend_core::extract::VolumeSurfaceError;
use isomend_core::mend::{FairError, FillError, RestoreError};
use isomend_core::mesh::mask::MaskError;
use isomend_core::volume::VolumeError;

/// Why a job was not done.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JobError {
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] IoError),
    /// Bytes in memory could not be read as a mesh.
    #[error("{name}")]
    Bytes {
        /// The name of the source.
        name: String,
        /// Why.
        #[source]
        error: IoError,
    },
    /// The source is a folder.
    #[error("{} is a folder: name a mesh file in it", path.display())]
    IsFolder {
        /// The folder.
        path: PathBuf,
    },
    /// The mesh has more vertices than 32-bit indices can number.
    #[error("{name} has too many vertices")]
    TooManyVertices {
        /// The name of the source.
        name: String,
    },
    /// Nothing could be filled.
    #[error(transparent)]
    Fill(#[from] FillError),
    /// Nothing could be restored.
    #[error("cannot restore the marked region")]
    Restore(#[from] RestoreError),
    /// Nothing could be faired.
    #[error("cannot fair the mesh")]
    Fair(#[from] FairError),
    /// An object of a file with several could not be faired.
    #[error("cannot fair the object {name}")]
    FairObject {
        /// The name of the object.
        name: String,
        /// Why.
        #[source]
        error: FairError,
    },
    /// A mesh could not be inspected.
    #[error("cannot inspect {name}")]
    Inspect {
        /// The name of the source.
        name: String,
        /// Why.
        #[source]
        error: FillError,
    },
    /// Two meshes could not be compared.
    #[error("cannot compare {first} with {second}")]
    Compare {
        /// The name of the first.
        first: String,
        /// The name of the second.
        second: String,
        /// Why.
        #[source]
        error: CompareError,
    },
    /// A volume has no surface at a level.
    #[error("cannot extract the surface from {name}")]
    NoSurface {
        /// The name of the source.
        name: String,
        /// Why.
        #[source]
        error: VolumeSurfaceError,
    },
    /// 64-bit coordinates were requested of a format that has only 32-bit ones.
    #[error(
        "{format} has 32-bit coordinates only; for 64-bit coordinates write ply, obj, vtk or vtp"
    )]
    No64Bit {
        /// The format.
        format: Format,
    },
    /// The signed distance could not be measured.
    #[error("cannot measure {name}")]
    Measure {
        /// The name of the source.
        name: String,
        /// Why.
        #[source]
        error: VolumeError,
    },
    /// The mask does not fit the mesh.
    #[error(transparent)]
    Mask(#[from] MaskError),
    /// The mask marks no face.
    #[error("the mask marks no face: {}", why.join("; "))]
    NothingMarked {
        /// For each part of the mask, how far it is from the mesh.
        why: Vec<String>,
    },
    /// A restoration without a mask.
    #[error("no region is marked: a restoration needs a mask")]
    NoMask,
    /// The mask is grown or shrunk, but names no region.
    #[error("the mask is grown or shrunk, but it names no region to start from")]
    EmptyMask,
    /// A mesh given as a mask is not closed.
    #[error("{} cannot be used as a mask: its surface is not closed; fill its holes first", path.display())]
    OpenMask {
        /// The file.
        path: PathBuf,
    },
    /// A mesh given as a mask could not be used.
    #[error("cannot use {} as a mask", path.display())]
    MaskMesh {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        error: FillError,
    },
    /// A list of face numbers could not be read.
    #[error("{name}{}: {what}", line.map(|n| format!(", line {n}")).unwrap_or_default())]
    FaceList {
        /// The file.
        name: String,
        /// The line, from 1.
        line: Option<usize>,
        /// What is wrong.
        what: String,
    },
    /// The extension of an output names no format that can be written.
    #[error(
        "the file name {} has no extension of a known mesh format; supported are {}",
        path.display(),
        Format::LIST
    )]
    NoFormat {
        /// The name.
        path: PathBuf,
    },
    /// An output would have to be binary USD.
    #[error("{} would be binary USD, which is read, but not written: name it .usda or .usdz", path.display())]
    BinaryUsd {
        /// The name.
        path: PathBuf,
    },
    /// Text was requested of a format that has no text form.
    #[error("{name} is written as {format}, which has no text form; {other} has one")]
    NoTextForm {
        /// The name of the output.
        name: String,
        /// The format.
        format: Format,
        /// A similar format that has one.
        other: &'static str,
    },
    /// An output cannot be written.
    #[error("cannot write {}: {what}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why, and what to do.
        what: String,
    },
    /// Inputs and outputs that do not go together.
    #[error("{what}")]
    Places {
        /// What is wrong, and what to do.
        what: String,
    },
    /// A page or a picture was requested for a plan.
    #[error(
        "a plan makes no mesh that a page or a picture could show; inspect the mesh to draw its holes"
    )]
    PlanDrawn,
    /// A page or a picture was requested for several meshes.
    #[error(
        "a page or a picture shows one mesh, but there are several inputs; run them one by one"
    )]
    SeveralDrawn,
    /// The document would overwrite a mesh.
    #[error("the document {} would overwrite a mesh; name another file", path.display())]
    DocumentOverMesh {
        /// The file.
        path: PathBuf,
    },
    /// The observer of a batch failed, for example because standard output is closed.
    #[error(transparent)]
    Observer(std::io::Error),
    /// The file of a page or a picture cannot be used.
    #[error("{what}")]
    Drawing {
        /// What is wrong, and what to do.
        what: String,
    },
    /// A deliverable cannot be made or written.
    #[error("{what}")]
    Deliverable {
        /// What is wrong, and what to do.
        what: String,
    },
    /// A parameter given by its name does not exist, or its value is wrong.
    #[error("{what}")]
    Named {
        /// What is wrong, and what to do.
        what: String,
    },
    /// Patches or a piece were requested for several meshes.
    #[error(
        "a file of patches or of the piece holds the result of one mesh, but there are several inputs; run them one by one"
    )]
    SeveralDelivered,
    /// A picture could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

impl JobError {
    /// Whether the request is wrong, rather than a file.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::NoTextForm { .. }
                | Self::No64Bit { .. }
                | Self::Places { .. }
                | Self::PlanDrawn
                | Self::SeveralDrawn
                | Self::Deliverable { .. }
                | Self::Named { .. }
                | Self::SeveralDelivered
                | Self::EmptyMask
        )
    }
}

/// The message of an error, followed by the messages of its causes.
#[doc(hidden)]
pub fn with_causes(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += &format!(": {error}");
        cause = error.source();
    }
    text
}

/// The message where work ended in a panic.
#[doc(hidden)]
pub const PANICKED: &str = "the work ended in a panic; this is a bug of isomend, please report it";
