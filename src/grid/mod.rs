//! Lattices, sparse node sets and interpolation.

mod interpolate;
mod marks;
mod sparse;
mod volume;

pub use interpolate::{Tricubic, linear, value_and_gradient};
pub use marks::dilate;
pub(crate) use sparse::{ABSENT, BLOCK_NODES, add, as_point, offset};
pub use sparse::{BLOCK, Lattice, NodeIndex, SparseGrid};
pub use volume::Volume;
