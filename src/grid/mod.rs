//! Lattices, sparse node sets and interpolation.

mod interpolate;
mod sparse;

pub use interpolate::{Tricubic, linear, value_and_gradient};
pub use sparse::{BLOCK, Lattice, NodeIndex, SparseGrid};
pub(crate) use sparse::{add, as_point};
