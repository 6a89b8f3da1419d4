//! Lattices, sparse node sets and interpolation.

mod interpolate;
mod sparse;
mod volume;

pub use interpolate::{Tricubic, linear, value_and_gradient};
pub use sparse::{BLOCK, Lattice, NodeIndex, SparseGrid};
pub(crate) use sparse::{add, as_point};
pub use volume::Volume;
