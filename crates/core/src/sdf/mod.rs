//! Signed distance of a mesh at lattice nodes, closest-point queries, and redistancing of level sets.

mod jets;
mod near;
mod redistance;
mod sampler;
mod side;
mod surface;
#[cfg(test)]
mod tests;

pub use jets::{JET_RINGS, Jet, fit_jet};
pub use near::{SearchArea, faces_at};
pub use redistance::{project_on_zero_set, redistance};
pub use sampler::{DistanceSample, RimSet, Sampler};
pub use side::{Feature, feature, side};
pub use surface::Surface;
