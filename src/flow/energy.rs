//! The interface of an energy to the flow, for energies whose terms are computed cell by cell; see [`super::BendingEnergy`] for the simpler
//! one that callers have.

use super::band::Band;
use super::cells::{eikonal, nodal};
use super::settings::{Energy, Variant};
use super::system::System;

/// What an energy asks of those who minimise it.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// How many steps beyond the mask its nodal curvature is needed.
    pub dilations: usize,
    /// The energies whose steady states lead to its start on the coarsest grid, one after another.
    pub start: &'static [Energy],
    /// The automatic voxel over the usual one, and how many voxels across a hole this may lead to.
    pub voxel: (f64, f64),
    /// Length of a patch's edges over that of the edges round the hole, unless it is given.
    pub edge_ratio: f64,
    /// The tolerance of the stopping test over the usual one.
    pub tolerance: f64,
    /// The metrics that its steps can have; another one counts as the first.
    pub metrics: &'static [Variant],
    /// The more robust energy that takes its place where it finds no surface.
    pub fallback: Option<Energy>,
}

/// An energy of a level set on a narrow band. Fields are values at the band's nodes, lengths are in voxels.
pub trait BandEnergy: Sized {
    /// What it asks for.
    const NEEDS: Needs;

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

impl Evaluation {
    /// That of φ on a band with the weight κ of the eikonal term; `surface` computes the energy of the surface from r and M.
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
