//! The interface of an energy to the flow.

use super::band::Band;
use super::settings::Variant;
use super::system::System;

/// An energy of a level set on a narrow band. Fields are values at the band's nodes, lengths are in voxels.
pub trait BandEnergy: Sized {
    /// How many steps beyond the mask its nodal curvature is needed.
    const DILATIONS: usize;

    /// The energy on a band, with the weight κ of the eikonal term.
    fn new(band: Band, kappa: f64) -> Self;

    /// The nodes and cells.
    fn band(&self) -> &Band;

    /// The energy of `phi`.
    fn evaluate(&self, phi: &[f64]) -> Evaluation;

    /// The gradient of the energy at `phi`, which `at` is the evaluation of: zero off the unknowns.
    fn gradient(&self, phi: &[f64], at: &Evaluation) -> Vec<f64>;

    /// The matrix of a step there; `time_step` is infinite for the steady state.
    fn system(&self, phi: &[f64], at: &Evaluation, variant: Variant, time_step: f64) -> System;
}

/// Energy and the nodal quantities it is made of.
pub struct Evaluation {
    /// The whole energy.
    pub energy: f64,
    /// That of the surface: without the eikonal term.
    pub surface: f64,
    /// Weak mean curvature r_i.
    pub(super) r: Vec<f64>,
    /// Lumped mass M_i.
    pub(super) mass: Vec<f64>,
}
