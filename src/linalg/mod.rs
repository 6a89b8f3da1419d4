//! Linear algebra that knows nothing of surfaces.

mod cg;
mod dense;

pub use cg::{CgOutcome, LinearOperator, conjugate_gradient};
pub use dense::solve_spd;
