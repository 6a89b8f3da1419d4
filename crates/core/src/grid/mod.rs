//! Regular lattices, sparse sets of lattice nodes, interpolation, and volumes.

mod interpolate;
mod marks;
mod quadrature;
mod sparse;
mod volume;

pub use interpolate::{Tricubic, linear, value_and_gradient};
pub use marks::dilate;
pub use quadrature::gauss_points;
pub use sparse::{ABSENT, BLOCK_NODES, add, as_point, offset};
pub use sparse::{BLOCK, Lattice, NodeIndex, SparseGrid};
pub use volume::Volume;
