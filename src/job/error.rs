//! Why a job was not done. What lies beneath is the error's source.

use std::path::PathBuf;

use thiserror::Error;

use crate::compare::CompareError;
use crate::extract::VolumeSurfaceError;
use crate::io::{Format, IoError};
use crate::mend::{FairError, FillError, RestoreError};
use crate::mesh::mask::MaskError;
use crate::report::picture::PictureError;
use crate::volume::VolumeError;

/// Why a job was not done.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum JobError {
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] IoError),
    /// What was given as bytes could not be read.
    #[error("{name}")]
    Bytes {
        /// The name of the source.
        name: String,
        /// Why.
        #[source]
        error: IoError,
    },
    /// A source that is a folder.
    #[error("{} is a folder: name a mesh file in it", path.display())]
    IsFolder {
        /// The folder.
        path: PathBuf,
    },
    /// A mesh with more vertices than can be numbered.
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
    /// A mesh could not be looked at.
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
    #[error("{name} has no such surface")]
    NoSurface {
        /// The name of the source.
        name: String,
        /// Why.
        #[source]
        error: VolumeSurfaceError,
    },
    /// 64-bit coordinates in a format that has none.
    #[error("{format} has 32-bit coordinates only; ply, obj, vtk and vtp have others")]
    No64Bit {
        /// The format.
        format: Format,
    },
    /// There is no signed distance.
    #[error("cannot measure {name}")]
    Measure {
        /// The name of the source.
        name: String,
        /// Why.
        #[source]
        error: VolumeError,
    },
    /// A mask makes no sense for the mesh.
    #[error(transparent)]
    Mask(#[from] MaskError),
    /// A mask that marks nothing.
    #[error("the mask marks no face: {}", why.join("; "))]
    NothingMarked {
        /// What it missed by how much.
        why: Vec<String>,
    },
    /// A restoration without a mask.
    #[error("no region is marked")]
    NoMask,
    /// A mask that is grown or shrunk, but chooses nothing.
    #[error("a mask is grown or shrunk, but it chooses nothing")]
    EmptyMask,
    /// A mesh that is to be a mask is not closed.
    #[error("{} cannot be a mask: it is not closed; fill it first", path.display())]
    OpenMask {
        /// The file.
        path: PathBuf,
    },
    /// A mesh that is to be a mask cannot be used.
    #[error("cannot use {}", path.display())]
    MaskMesh {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        error: FillError,
    },
    /// A list of face numbers that cannot be read.
    #[error("{name}{}: {what}", line.map(|n| format!(", line {n}")).unwrap_or_default())]
    FaceList {
        /// The file.
        name: String,
        /// The line, from 1.
        line: Option<usize>,
        /// What is wrong.
        what: String,
    },
    /// A name that does not tell a format to write.
    #[error(
        "the name {} does not tell a format to write; name it otherwise; supported are {}",
        path.display(),
        Format::LIST
    )]
    NoFormat {
        /// The name.
        path: PathBuf,
    },
    /// Text in a format that has none.
    #[error("{name} is written as {format}, which has no text form; {other} has")]
    NoTextForm {
        /// The name of the output.
        name: String,
        /// The format.
        format: Format,
        /// One like it that has.
        other: &'static str,
    },
    /// An output that cannot be written.
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
    /// A page or a picture of a plan.
    #[error(
        "a plan makes no mesh that a page or a picture could show; inspect the mesh to draw its holes"
    )]
    PlanDrawn,
    /// A page or a picture of several meshes.
    #[error("a page or a picture shows one mesh, but there are several inputs; do them one by one")]
    SeveralDrawn,
    /// A document in the place of a mesh.
    #[error("{} would overwrite a mesh; name another file", path.display())]
    DocumentOverMesh {
        /// The file.
        path: PathBuf,
    },
    /// The observer of a batch failed, such as where standard output is closed.
    #[error(transparent)]
    Observer(std::io::Error),
    /// A page or picture that cannot go where it should.
    #[error("{what}")]
    Drawing {
        /// What is wrong, and what to do.
        what: String,
    },
    /// Something beside the mesh that cannot be handed on so.
    #[error("{what}")]
    Deliverable {
        /// What is wrong, and what to do.
        what: String,
    },
    /// Patches or a piece of several meshes.
    #[error(
        "the patches and the piece are those of one mesh, but there are several inputs; do them one by one"
    )]
    SeveralDelivered,
    /// A picture could not be made.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

impl JobError {
    /// Whether it is in what was asked for rather than in the files.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::NoTextForm { .. }
                | Self::No64Bit { .. }
                | Self::Places { .. }
                | Self::PlanDrawn
                | Self::SeveralDrawn
                | Self::Deliverable { .. }
                | Self::SeveralDelivered
                | Self::EmptyMask
        )
    }
}
