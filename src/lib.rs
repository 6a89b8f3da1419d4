//! isomend fills holes in triangle meshes by 3D level-set Willmore flow.
#![warn(missing_docs)]

pub mod extract;
pub mod io;
pub mod mesh;
pub mod spatial;
pub mod stitch;
