//! isomend fills holes in triangle meshes by 3D level-set Willmore flow.
#![warn(missing_docs)]

pub mod extract;
pub mod flow;
pub mod grid;
pub mod io;
pub mod linalg;
pub mod mesh;
pub mod params;
pub mod pipeline;
pub mod region;
pub mod report;
pub mod sdf;
pub mod spatial;
pub mod stitch;

pub use mesh::Mesh;
pub use params::{FillParams, SurfaceKind, VoxelSize};
pub use pipeline::{FillError, Filled, Inspection, fill, fill_with_progress, inspect};
