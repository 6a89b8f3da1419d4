//! Discrete Willmore energy of a level set, its gradient and metrics, and the flow to its steady state.
//!
//! After Droske and Rumpf, "A level set formulation for Willmore flow", Interfaces and Free Boundaries 6 (2004), localised to a
//! narrow band with a weight that depends on the level. Lengths are in voxels.

mod band;
mod bending;
mod cells;
mod coarse;
mod element;
mod energies;
mod energy;
mod evolve;
mod layout;
mod outcome;
mod pull;
mod settings;
mod start;
mod state;
mod steady;
mod stencil;
mod stopping;
mod system;
#[cfg(test)]
mod tests;
mod variation;
mod willmore;

pub use band::Band;
pub(crate) use band::{MARGIN as BAND_MARGIN, WIDTH as HALF_WIDTH};
pub use bending::{BendingBand, BendingEnergy, Density, UserEnergy};
pub use energies::relax;
pub use energy::{BandEnergy, Evaluation, Needs};
pub use evolve::{Evolution, EvolutionStep, Pace, Pause};
pub use outcome::{FlowOutcome, StepRecord};
pub use pull::Pull;
pub use settings::{Energy, FlowSettings, Variant};
pub use start::biharmonic_fill;
pub use system::System;
pub use variation::VariationBand;
pub use willmore::WillmoreBand;
