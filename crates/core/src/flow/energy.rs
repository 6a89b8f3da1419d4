//! The interface between an energy and the flow, for energies assembled cell by cell. [`super::BendingEnergy`] is the simpler
//! public one.

use super::band::Band;
use super::cells::{eikonal, nodal};
use super::settings::{Energy, Variant};
use super::system::System;

/// Requirements of an energy on the solver that minimises it.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// Number of grid steps beyond the mask at which the energy needs the nodal curvature.
    pub dilations: usize,
    /// Energies whose steady states, one after another, initialise this energy on the coarsest grid.
    pub start: &'static [Energy],
    /// Factor on the default voxel size, and the largest number of voxels across a hole that the factor may lead to.
    pub voxel: (f64, f64),
    /// Default edge length of a patch, relative to the length of the edges around the hole.
    pub edge_ratio: f64,
    /// Factor on the default tolerance of the stopping test.
    pub tolerance: f64,
    /// The step metrics that the energy supports; any other is replaced by the first.
    pub metrics: &'static [Variant],
    /// The more robust energy to use if this one finds no surface.
    pub fallback: Option<Energy>,
}

/// An energy of a level set on a narrow band. Fields are values at the band's nodes; lengths are in voxels.
pub trait BandEnergy: Sized {
    /// What the energy requires of the solver.
    const NEEDS: Needs;

    /// The nodes and cells.
    fn band(&self) -> &Band;

    /// The energy of `phi`.
    fn evaluate(&self, phi: &[f64]) -> Evaluation;

    /// The gradient of the energy at `phi`, zero except at the unknowns; `at` is the evaluation at `phi`.
    fn gradient(&self, phi: &[f64], at: &Evaluation) -> Vec<f64>;

    /// The matrix of a step at `phi`; `time_step` is infinite for the steady state.
    fn system(&self, phi: &[f64], at: &Evaluation, variant: Variant, time_step: f64) -> System;
}

/// An energy and the nodal quantities from which it is computed.
pub struct Evaluation {
    /// The total energy, with the eikonal term.
    pub energy: f64,
    /// The energy of the surface, without the eikonal term.
    pub surface: f64,
    /// Weak mean curvature r_i.
    pub(super) r: Vec<f64>,
    /// Lumped mass M_i.
    pub(super) mass: Vec<f64>,
}

impl Evaluation {
    /// Evaluates φ on a band with eikonal weight κ; `surface` computes the energy of the surface from r and M.
    pub(super) fn new(
        band: &Band,
        phi: &[f64],
        kappa: f64,
        surface: impl FnOnce(&[f64], &[f64]) -> f64,
    ) -> Self {
        let (r, mass) = nodal(band, phi);
        let surface = surface(&r, &mass);
        Self {
            energy: surface + kappa * eikonal(band, phi),
            surface,
            r,
            mass,
        }
    }
}
