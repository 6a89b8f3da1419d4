//! Linear algebra that knows nothing of surfaces.

mod bicgstab;
mod cg;
mod csr;
mod dense;
mod multigrid;
mod real;
#[cfg(test)]
mod tests;

pub use bicgstab::bicgstab;
pub use cg::{CgOutcome, Jacobi, LinearOperator, Preconditioner, conjugate_gradient};
pub use csr::{Accumulator, Csr, SparseMatrix};
pub use dense::{Cholesky, solve_spd};
pub use multigrid::{Multigrid, MultigridCycle};
pub use real::Real;
