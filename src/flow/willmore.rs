//! The localised Willmore energy
//!
//! `E(φ) = ½ Σ_{i ∈ R} χ(φ_i) r_i² / M_i + κ/2 Σ_cells (|∇φ| − 1)²`
//!
//! with `r_i = Σ ⅛ n·∇N_i` (weak mean curvature: equation (10) of the paper, tested with N_i), `M_i = Σ ⅛ / |∇φ|` (lumped mass)
//! and a weight χ that follows the level, so that by the co-area formula flattening φ or leaving the band gains nothing.

use rayon::prelude::*;

use super::band::Band;
use super::cells::{
    CellMatrices, Fields, chi, chi_derivative, chunked_sum, eikonal, gathered, nodal, stencils,
};
use super::energy::{BandEnergy, Evaluation};
use super::steady::Variant;
use super::system::{Factors, RowWeights, System};

/// A band with what is computed from φ on it.
pub struct WillmoreBand {
    /// The nodes and cells.
    pub band: Band,
    /// Weight κ of the eikonal term.
    pub kappa: f64,
}

impl BandEnergy for WillmoreBand {
    const DILATIONS: usize = 1;

    fn new(band: Band, kappa: f64) -> Self {
        Self { band, kappa }
    }

    fn band(&self) -> &Band {
        &self.band
    }

    fn evaluate(&self, phi: &[f64]) -> Evaluation {
        let (r, mass) = nodal(&self.band, phi);
        let willmore = chunked_sum(&self.band.residual, |i, &inside| {
            if inside {
                0.5 * chi(phi[i]) * r[i] * r[i] / mass[i]
            } else {
                0.0
            }
        });
        Evaluation {
            energy: willmore + self.kappa * eikonal(&self.band, phi),
            surface: willmore,
            r,
            mass,
        }
    }

    fn system(&self, phi: &[f64], at: &Evaluation, variant: Variant, time_step: f64) -> System<'_> {
        let band = &self.band;
        let n = band.slots.len();
        let w: Vec<f64> = (0..n)
            .map(|i| {
                if band.residual[i] {
                    at.r[i] / at.mass[i]
                } else {
                    0.0
                }
            })
            .collect();
        let weighted: Vec<f64> = (0..n).map(|i| chi(phi[i]) * w[i] * w[i]).collect();
        let force: Vec<f64> = (0..n).map(|i| chi(phi[i]) * w[i]).collect();
        let fields = Fields {
            phi,
            weighted: &weighted,
            force: &force,
            kappa: self.kappa,
        };
        let cells: Vec<CellMatrices> = band
            .cells
            .par_iter()
            .map(|cell| CellMatrices::new(cell, &fields, variant))
            .collect();
        let tangential = || stencils(band, &cells, |c: &CellMatrices| &c.tangential);
        let full = || stencils(band, &cells, |c: &CellMatrices| &c.full);
        let (curvature, inner) = match variant {
            Variant::GaussNewton => (tangential(), None),
            Variant::I => (tangential(), Some(full())),
            Variant::II => (full(), None),
        };
        let factors = Factors {
            curvature,
            inner,
            middle: None,
            second: stencils(band, &cells, |c| &c.second),
        };
        let weights = self.weights(phi, &at.mass, time_step);
        let gradient = self.gradient(phi, &cells, &w, &at.mass);
        System::new(band, factors, weights, gradient)
    }
}

impl WillmoreBand {
    fn weights(&self, phi: &[f64], mass: &[f64], time_step: f64) -> Vec<RowWeights> {
        let band = &self.band;
        band.layout
            .rows
            .iter()
            .map(|&i| {
                let i = i as usize;
                RowWeights {
                    residual: if band.residual[i] {
                        chi(phi[i]) / mass[i]
                    } else {
                        0.0
                    },
                    inertia: if time_step.is_finite() {
                        chi(phi[i]) * mass[i] / time_step
                    } else {
                        0.0
                    },
                    unknown: band.unknown[i],
                }
            })
            .collect()
    }

    /// `BPᵀ(χw) + ½ L1 φ + ½ χ' w² M + κ Σ (1 − 1/|g|) g·∇N` on the unknowns; all but the third come from the cells.
    fn gradient(&self, phi: &[f64], cells: &[CellMatrices], w: &[f64], mass: &[f64]) -> Vec<f64> {
        let band = &self.band;
        (0..phi.len())
            .into_par_iter()
            .map(|i| {
                if !band.unknown[i] {
                    return 0.0;
                }
                let mut sum = gathered(band, i, |c, a| cells[c].load[a]);
                if band.residual[i] {
                    sum += 0.5 * chi_derivative(phi[i]) * w[i] * w[i] * mass[i];
                }
                sum
            })
            .collect()
    }
}
