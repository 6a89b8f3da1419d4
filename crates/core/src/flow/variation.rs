//! Localised energy of curvature variation:
//!
//! `E(φ) = ½ Σ_c χ_c Σ_q ⅛ |∇φ| (|u|² − (n·u)²) + κ/2 Σ_cells (|∇φ| − 1)²`, `u = ∇H` at the Gauss points q,
//!
//! where `H_i = r_i` is the nodal curvature and χ_c is χ at the mean of a cell's corner values. The sum is over the cells that
//! have all corners in R and at least one corner within a step of the mask.

use rayon::prelude::*;

use super::band::{Band, Cell, corner_numbers};
use super::cells::{
    CellMatrices, Fields, Packed, chi, chi_derivative, chunked_sum, corners, gathered, norm,
    packed, stencils,
};
use super::element::{ELEMENT, dot, gauss_gradients};
use super::energy::{BandEnergy, Evaluation, Needs};
use super::settings::{Energy, Variant};
use super::system::{Factors, RowWeights, System};
use crate::threads::CollectIndexed;

/// A band with the energy of curvature variation.
pub struct VariationBand {
    band: Band,
    kappa: f64,
    /// Whether a cell contributes to the energy.
    counted: Vec<bool>,
}

impl BandEnergy for VariationBand {
    const NEEDS: Needs = Needs {
        dilations: 2,
        start: &[Energy::Willmore],
        // On smooth data this surface is so accurate that the default voxel (through the width of its band) and the default edge
        // length (through the deviation of chords) would dominate its error.
        voxel: (0.4, 128.0),
        edge_ratio: 0.45,
        // The surface converges in many small steps; the length of the last one says little about the remaining distance.
        tolerance: 0.15,
        metrics: &[Variant::GaussNewton],
        fallback: Some(Energy::Willmore),
    };

    fn band(&self) -> &Band {
        &self.band
    }

    fn evaluate(&self, phi: &[f64]) -> Evaluation {
        Evaluation::new(&self.band, phi, self.kappa, |r, _| {
            chunked_sum(&self.band.cells, |c, cell| {
                if self.counted[c] {
                    cell_energy(&corners(cell, phi), &corners(cell, r))
                } else {
                    0.0
                }
            })
        })
    }

    fn gradient(&self, phi: &[f64], at: &Evaluation) -> Vec<f64> {
        let band = &self.band;
        let variation = self.variation(phi, at);
        let force: Vec<f64> = (0..phi.len())
            .into_par_iter()
            .map(|i| gathered(band, i, |c, a| variation[c].by_curvature[a]))
            .collect_indexed();
        let fields = Fields {
            phi,
            weighted: &vec![0.0; phi.len()],
            force: &force,
            kappa: self.kappa,
        };
        let cells = band.cells.par_iter();
        let loads: Vec<[f64; 8]> = cells.map(|cell| fields.load(cell)).collect();
        let entry = |i: usize| {
            if band.unknown[i] {
                gathered(band, i, |c, a| loads[c][a] + variation[c].by_level[a])
            } else {
                0.0
            }
        };
        (0..phi.len()).into_par_iter().map(entry).collect_indexed()
    }

    /// The matrix is `BPᵀ K BP + κ L[n⊗n]` for every variant.
    fn system(&self, phi: &[f64], at: &Evaluation, _: Variant, time_step: f64) -> System {
        let band = &self.band;
        let zeros = vec![0.0; phi.len()];
        let fields = Fields {
            phi,
            weighted: &zeros,
            force: &zeros,
            kappa: self.kappa,
        };
        let make = |c: usize| {
            let matrices = CellMatrices::new(&band.cells[c], &fields, Variant::GaussNewton);
            (matrices, self.variation_of(c, phi, at).stiffness)
        };
        let mut lists = stencils(
            band,
            make,
            &[|c| &c.0.second, |c| &c.0.tangential, |c| &c.1],
        )
        .into_iter();
        let mut next = || lists.next();
        let weights = band.layout.rows.iter().map(|&i| RowWeights {
            residual: f32::from(u8::from(band.residual[i as usize])),
            inertia: if time_step.is_finite() {
                (chi(phi[i as usize]) * at.mass[i as usize] / time_step) as f32
            } else {
                0.0
            },
            unknown: band.unknown[i as usize],
        });
        let factors = Factors {
            second: next().unwrap_or_default(),
            curvature: next().unwrap_or_default(),
            middle: next(),
            inner: None,
        };
        System::new(band, factors, weights.collect())
    }
}

impl VariationBand {
    /// The energy on a band, with the weight κ of the eikonal term.
    pub fn new(band: Band, kappa: f64) -> Self {
        let counted = |cell: &Cell| {
            let corners = corner_numbers(cell);
            corners.iter().all(|&v| band.residual[v]) && corners.iter().any(|&v| band.near[v])
        };
        Self {
            counted: band.cells.iter().map(counted).collect(),
            band,
            kappa,
        }
    }

    fn variation(&self, phi: &[f64], at: &Evaluation) -> Vec<VariationCell> {
        let cells = (0..self.band.cells.len()).into_par_iter();
        cells.map(|c| self.variation_of(c, phi, at)).collect()
    }

    fn variation_of(&self, c: usize, phi: &[f64], at: &Evaluation) -> VariationCell {
        let cell = &self.band.cells[c];
        if self.counted[c] {
            VariationCell::new(&corners(cell, phi), &corners(cell, &at.r))
        } else {
            VariationCell::default()
        }
    }
}

fn mean(v: &[f64; 8]) -> f64 {
    0.125 * v.iter().sum::<f64>()
}

/// `½ χ Σ_q ⅛ |∇φ| (|u|² − (n·u)²)` from φ and the nodal curvature at the corners.
fn cell_energy(phi: &[f64; 8], curvature: &[f64; 8]) -> f64 {
    let weight = chi(mean(phi));
    if weight == 0.0 {
        return 0.0;
    }
    let mut sum = 0.0;
    for (g, u) in gauss_gradients(phi)
        .into_iter()
        .zip(gauss_gradients(curvature))
    {
        let l = norm(g);
        let along = dot(g, u) / l;
        sum += l * (dot(u, u) - along * along);
    }
    0.0625 * weight * sum
}

/// A cell's contribution to the gradient at its corners and to K.
struct VariationCell {
    /// K.
    stiffness: Packed,
    /// Derivative of the cell's energy with respect to the nodal curvature: K H.
    by_curvature: [f64; 8],
    /// Derivative with respect to φ with the nodal curvature fixed.
    by_level: [f64; 8],
}

impl Default for VariationCell {
    fn default() -> Self {
        Self {
            stiffness: [0.0; 36],
            by_curvature: [0.0; 8],
            by_level: [0.0; 8],
        }
    }
}

impl VariationCell {
    /// Derivatives of [`cell_energy`], Gauss point by Gauss point.
    fn new(phi: &[f64; 8], curvature: &[f64; 8]) -> Self {
        let level = mean(phi);
        let (weight, slope) = (chi(level), chi_derivative(level));
        let mut out = Self::default();
        let mut stiffness = [0.0f32; 64];
        let (gradients, slopes) = (gauss_gradients(phi), gauss_gradients(curvature));
        for (q, shape) in ELEMENT.gauss.iter().enumerate() {
            let (g, u) = (gradients[q], slopes[q]);
            let l = norm(g);
            let n = g.map(|x| x / l);
            let (s, uu) = (dot(n, u), dot(u, u));
            let k = 0.125 * weight * l;
            let along_normal = 0.0625 * weight * (uu + s * s);
            let along_slope = -0.125 * weight * s;
            let shift = 0.0625 * 0.125 * slope * l * (uu - s * s);
            let mut normal = [0.0f32; 8];
            for a in 0..8 {
                // s = n·u. With respect to H: χ |∇φ| (u − s n)·∇N_a. With respect to φ: ½ χ (|u|² + s²) n·∇N_a − χ s u·∇N_a, and
                // χ′/8 · ½ |∇φ| (|u|² − s²) from the weight at the cell's mean value.
                let at = [shape[0][a], shape[1][a], shape[2][a]];
                let (na, ua) = (dot(n, at), dot(u, at));
                out.by_curvature[a] += k * (ua - s * na);
                out.by_level[a] += along_normal * na + along_slope * ua + shift;
                normal[a] = na as f32;
            }
            let products = &ELEMENT.gauss_products[q];
            for a in 0..8 {
                for b in 0..8 {
                    stiffness[8 * a + b] +=
                        k as f32 * (products[8 * a + b] - normal[a] * normal[b]);
                }
            }
        }
        out.stiffness = packed(&stiffness);
        out
    }
}
