//! Errors of fills and restorations.

use thiserror::Error;

use crate::mesh::{HoleId, Mesh, MeshError, at_least, length};
use crate::parameters::OutOfBounds;

/// Upper bound of the number of threads of a run.
pub(super) const MOST_THREADS: usize = 1024;

/// Why a fill was refused or stopped.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FillError {
    /// The mesh is invalid.
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
    /// A component number that does not exist.
    #[error("there is no component {id}; the mesh has {count}")]
    NoSuchComponent {
        /// The number asked for.
        id: usize,
        /// Number of components.
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
        /// The cause, and what to do.
        why: String,
    },
    /// Parameters contradict each other.
    #[error("{what}")]
    Parameter {
        /// The cause, and what to do.
        what: &'static str,
    },
    /// A parameter is out of its bounds.
    #[error(transparent)]
    Bounds(#[from] OutOfBounds),
    /// The voxel needs too large a grid.
    #[error(
        "a voxel of {} needs too large a grid for the widest hole to fill; the smallest that fits is about {}",
        length(*voxel),
        at_least(*fits)
    )]
    TooFine {
        /// The voxel asked for.
        voxel: f64,
        /// A voxel that fits.
        fits: f64,
    },
    /// The voxel exceeds the widest hole: no grid of it holds a surface across a hole.
    #[error(
        "a voxel of {} is larger than the widest hole, whose diameter is {}; leave the voxel out, or take a fraction of \
         that diameter",
        length(*voxel),
        length(*widest)
    )]
    TooCoarse {
        /// The voxel asked for.
        voxel: f64,
        /// The diameter of the widest hole that needs a grid.
        widest: f64,
    },
    /// The threads could not be started.
    #[error(
        "{threads} threads could not be started; take fewer, {} at most",
        MOST_THREADS
    )]
    Threads {
        /// The requested number of threads.
        threads: usize,
    },
    /// Patches of another number of regions, or of other regions.
    #[error(
        "there are {regions} regions, but patches of {patches} regions were given; one for each is needed, in order"
    )]
    Patches {
        /// Number of regions.
        regions: usize,
        /// Number of patches, or the id of the first patch that belongs to another region.
        patches: usize,
    },
    /// Not a valid region task: damaged, or of another version.
    #[error(
        "this is not a valid region task: it is damaged, or was written by another version; write it again"
    )]
    Task,
    /// The caller asked to stop.
    #[error("stopped before it was done")]
    Cancelled,
}

/// Why a restoration was refused or stopped.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RestoreError {
    /// The mesh or the parameters of the fill are invalid, or the fill was stopped.
    #[error(transparent)]
    Fill(#[from] FillError),
    /// The number of marks differs from the number of faces.
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
    /// At most two faces of a component remain, which is nothing to be continued.
    #[error(
        "the mask covers a whole component of {faces} faces, or all but one or two of them, so that nothing is left to continue; \
         mark fewer faces, or remove the component"
    )]
    WholeComponent {
        /// Its number of faces.
        faces: usize,
    },
    /// The marked region reaches the outer border of an open sheet.
    #[error(
        "the mask reaches the outer border of an open sheet near {x:.6}, {y:.6}, {z:.6}, where there is nothing to continue; \
         leave a strip of faces along the border"
    )]
    Border {
        /// x coordinate of the place.
        x: f64,
        /// y coordinate of the place.
        y: f64,
        /// z coordinate of the place.
        z: f64,
    },
    /// The rim of the cut meets edges with more than two faces, or a one-sided surface, and does not close.
    #[error(
        "the marked faces cannot be cut out near {x:.6}, {y:.6}, {z:.6}: an edge there has more than two faces, or the surface is \
         one-sided, so that the rim would not close; repair the mesh first, or mark other faces"
    )]
    OpenRim {
        /// x coordinate of the place.
        x: f64,
        /// y coordinate of the place.
        y: f64,
        /// z coordinate of the place.
        z: f64,
    },
}

impl RestoreError {
    /// Checks that there is one mark for each face, and that a face is marked.
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
