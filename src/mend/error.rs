//! Why nothing could be filled or restored.

use thiserror::Error;

use crate::mesh::{HoleId, Mesh, MeshError, length};
use crate::parameters::OutOfBounds;

/// Most threads of a run.
pub(super) const MOST_THREADS: usize = 1024;

/// Why nothing could be filled.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FillError {
    /// The mesh cannot be worked on.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A hole number that does not exist.
    #[error("there is no hole {id}; the mesh has {count}")]
    NoSuchHole {
        /// The number asked for.
        id: HoleId,
        /// Number of holes.
        count: usize,
    },
    /// A crease end that does not exist.
    #[error(
        "there is no crease end {end}; {count} sharp edges end at the rims of the mesh's holes"
    )]
    NoSuchCreaseEnd {
        /// The number asked for.
        end: usize,
        /// Number of crease ends.
        count: usize,
    },
    /// Two crease ends between which no sharp edge can be continued.
    #[error("no sharp edge can be continued from crease end {} to {}: {why}", ends[0], ends[1])]
    Crease {
        /// Their numbers.
        ends: [usize; 2],
        /// What is wrong, and what would be right.
        why: String,
    },
    /// Parameters do not go together.
    #[error("{what}")]
    Parameter {
        /// What is wrong and what would be right.
        what: &'static str,
    },
    /// A number that a parameter cannot have.
    #[error(transparent)]
    Bounds(#[from] OutOfBounds),
    /// The voxel would need too large a grid.
    #[error(
        "a voxel of {} makes too large a grid for the widest hole that is to be filled; the smallest that fits is about \
         {fits:.4e}",
        length(*voxel)
    )]
    TooFine {
        /// The voxel asked for.
        voxel: f64,
        /// One that fits.
        fits: f64,
    },
    /// The threads could not be started.
    #[error(
        "{threads} threads could not be started; take fewer, {} at most",
        MOST_THREADS
    )]
    Threads {
        /// So many were asked for.
        threads: usize,
    },
    /// The patches of another number of regions than there are, or of other regions.
    #[error(
        "there are {regions} regions, but patches of {patches} regions were given; one for each is needed, in order"
    )]
    Patches {
        /// Number of regions.
        regions: usize,
        /// Number of patches, or of the first that is not its region's.
        patches: usize,
    },
    /// A task that was read is none that was written.
    #[error("the task holds numbers that do not fit each other; write it again")]
    Task,
    /// The caller asked to stop.
    #[error("stopped before it was done")]
    Cancelled,
}

/// Why nothing could be restored.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RestoreError {
    /// The mesh or the parameters of the fill make no sense.
    #[error(transparent)]
    Fill(#[from] FillError),
    /// There are not as many marks as faces.
    #[error("there are {marks} marks for {faces} faces; one for each is needed")]
    Marks {
        /// Number of marks.
        marks: usize,
        /// Number of faces.
        faces: usize,
    },
    /// No face is marked.
    #[error("the mask marks no face")]
    NothingMarked,
    /// Nothing of a piece is left to continue.
    #[error(
        "the mask covers the whole of a piece of {faces} faces, so that nothing is left to continue; mark less, or take the \
         piece away"
    )]
    WholePiece {
        /// Its faces.
        faces: usize,
    },
    /// The region is open to one side.
    #[error(
        "the mask reaches the outer border of an open sheet near {x:.6}, {y:.6}, {z:.6}, where there is nothing to continue; \
         leave a strip of faces along the border"
    )]
    Border {
        /// Where.
        x: f64,
        /// Where.
        y: f64,
        /// Where.
        z: f64,
    },
}

impl RestoreError {
    /// There must be a mark for each face, and some face must be marked.
    pub(super) fn check_marks(mesh: &Mesh, marked: &[bool]) -> Result<(), Self> {
        if marked.len() != mesh.faces.len() {
            return Err(Self::Marks {
                marks: marked.len(),
                faces: mesh.faces.len(),
            });
        }
        if !marked.contains(&true) {
            return Err(Self::NothingMarked);
        }
        Ok(())
    }
}
