//! Linear algebra, independent of geometry: sparse and dense matrices, iterative and direct solvers, multigrid.

mod bicgstab;
mod cg;
mod csr;
mod dense;
mod dissection;
mod ldl;
mod multigrid;
mod real;
mod rows;
mod symmetric;
#[cfg(test)]
mod tests;
mod tridiagonal;

pub use bicgstab::bicgstab;
pub use cg::{CgOutcome, Jacobi, LinearOperator, Preconditioner, conjugate_gradient};
pub use csr::{Accumulator, Csr, SparseMatrix};
pub use dense::{Cholesky, second_moments, solve_spd, symmetric_eigen};
pub use ldl::{Ldl, LdlPattern};
pub use multigrid::{Multigrid, MultigridCycle};
pub use real::Real;
pub use symmetric::{Symmetric, Triangle};
pub use tridiagonal::{Shifted, Tridiagonal};
