//! A pull to a given surface: `½ Σ λ_i χ_i (φ_i − φ⁰_i)²` on the unknowns, beside the bending energy.

use super::band::Band;
use super::cells::{chi, chunked_sum};

/// What the flow is pulled to: for each node of the grid the value wanted there and the weight λ of the pull.
///
/// The weight is (h/ℓ)⁴ for a length ℓ: what is narrower than about 2πℓ goes, what is wider stays.
#[derive(Clone, Debug)]
pub struct Pull {
    /// φ⁰ in voxels, for each slot of the grid.
    pub target: Vec<f64>,
    /// λ for each slot of the grid; 0 where there is no pull.
    pub weight: Vec<f64>,
}

/// The pull at the nodes of a band.
pub(super) struct BandPull {
    target: Vec<f64>,
    /// λχ at the values with which the band was made; 0 off the unknowns.
    weight: Vec<f64>,
}

impl BandPull {
    pub(super) fn new(pull: &Pull, band: &Band, values: &[f64]) -> Self {
        let weights = band.gather(&pull.weight).into_iter().enumerate();
        Self {
            target: band.gather(&pull.target),
            weight: weights
                .map(|(i, w)| {
                    if band.unknown[i] {
                        w * chi(values[i])
                    } else {
                        0.0
                    }
                })
                .collect(),
        }
    }

    pub(super) fn energy(&self, phi: &[f64]) -> f64 {
        chunked_sum(&self.weight, |i, w| {
            0.5 * w * (phi[i] - self.target[i]).powi(2)
        })
    }

    pub(super) fn gradient(&self, i: usize, phi: &[f64]) -> f64 {
        self.weight[i] * (phi[i] - self.target[i])
    }

    pub(super) fn diagonal(&self, i: usize) -> f64 {
        self.weight[i]
    }
}
