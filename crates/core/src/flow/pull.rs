//! Attraction to a given surface: `½ Σ λ_i χ_i (φ_i − φ⁰_i)²` on the unknowns, added to the bending energy.

use super::band::Band;
use super::cells::{chi, chunked_sum};

/// The target of the attraction: for each node of the grid the wanted value and the weight λ.
///
/// The weight is (h/ℓ)⁴ for a length ℓ: features narrower than about 2πℓ vanish, wider ones stay.
#[derive(Clone, Debug)]
pub struct Pull {
    /// φ⁰ in voxels, for each slot of the grid.
    pub target: Vec<f64>,
    /// λ for each slot of the grid; 0 without attraction.
    pub weight: Vec<f64>,
}

/// The attraction at the nodes of a band.
pub(super) struct BandPull {
    target: Vec<f64>,
    /// λχ at the values from which the band was made; 0 except at the unknowns.
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
