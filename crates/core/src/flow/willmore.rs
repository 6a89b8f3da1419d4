//! Localised Willmore energy:
//!
//! `E(φ) = ½ Σ_{i ∈ R} χ(φ_i) r_i² / M_i + κ/2 Σ_cells (|∇φ| − 1)²`
//!
//! with the weak mean curvature `r_i = Σ ⅛ n·∇N_i` (equation (10) of Droske and Rumpf 2004, tested with N_i) and the lumped mass
//! `M_i = Σ ⅛ / |∇φ|`. The weight χ depends on the level, so that by the co-area formula the energy does not fall by flattening φ
//! or by moving out of the band.

use rayon::prelude::*;

use super::band::Band;
use super::cells::{
    CellMatrices, Fields, Packed, chi, chi_derivative, chunked_sum, gathered, in_slabs, stencils,
};
use super::energy::{BandEnergy, Evaluation, Needs};
use super::settings::Variant;
use super::system::{Factors, RowWeights, System};

/// A band with the Willmore energy.
pub struct WillmoreBand {
    /// The nodes and cells.
    pub band: Band,
    /// Weight κ of the eikonal term.
    pub kappa: f64,
}

impl BandEnergy for WillmoreBand {
    const NEEDS: Needs = Needs {
        dilations: 1,
        start: &[],
        voxel: (1.0, f64::INFINITY),
        // On scans, fewer and longer edges are no less accurate, and vertices cost time.
        edge_ratio: 0.8,
        tolerance: 1.0,
        metrics: &[Variant::GaussNewton, Variant::I, Variant::II],
        fallback: None,
    };

    fn band(&self) -> &Band {
        &self.band
    }

    fn evaluate(&self, phi: &[f64]) -> Evaluation {
        Evaluation::new(&self.band, phi, self.kappa, |r, mass| {
            chunked_sum(&self.band.residual, |i, &inside| {
                if inside {
                    0.5 * chi(phi[i]) * r[i] * r[i] / mass[i]
                } else {
                    0.0
                }
            })
        })
    }

    /// `BPᵀ(χw) + ½ L1 φ + ½ χ' w² M + κ Σ (1 − 1/|g|) g·∇N` on the unknowns; all terms but the third are assembled from the
    /// cells.
    fn gradient(&self, phi: &[f64], at: &Evaluation) -> Vec<f64> {
        let by_level = |i: usize| 0.5 * chi_derivative(phi[i]) * at.r[i] * at.r[i] / at.mass[i];
        self.with_fields(phi, at, |fields| gradient(&self.band, fields, by_level))
    }

    fn system(&self, phi: &[f64], at: &Evaluation, variant: Variant, time_step: f64) -> System {
        let residual = |i: usize| chi(phi[i]) / at.mass[i];
        let weights = weights(&self.band, phi, &at.mass, time_step, residual);
        self.with_fields(phi, at, |fields| {
            system(&self.band, fields, variant, weights)
        })
    }
}

impl WillmoreBand {
    /// The energy on a band, with the weight κ of the eikonal term.
    pub fn new(band: Band, kappa: f64) -> Self {
        Self { band, kappa }
    }

    /// Calls `run` with the nodal fields from which the cells' matrices are assembled.
    fn with_fields<T>(&self, phi: &[f64], at: &Evaluation, run: impl FnOnce(&Fields) -> T) -> T {
        let curvature = |i: usize| {
            if self.band.residual[i] {
                at.r[i] / at.mass[i]
            } else {
                0.0
            }
        };
        let (force, weighted): (Vec<f64>, Vec<f64>) = (0..phi.len())
            .map(|i| {
                let w = curvature(i);
                let force = chi(phi[i]) * w;
                (force, force * w)
            })
            .unzip();
        run(&Fields {
            phi,
            weighted: &weighted,
            force: &force,
            kappa: self.kappa,
        })
    }
}

/// The gradient of an energy `Σ χ e(r_i, M_i) + κ Eik` on the unknowns. `BPᵀ(χ ∂e/∂r) + ½ L1 φ + κ Σ (1 − 1/|g|) g·∇N` is
/// assembled from the cells, with the two derivatives in `fields`; `by_level` is χ′e at the nodes of R.
pub(super) fn gradient(
    band: &Band,
    fields: &Fields,
    by_level: impl Fn(usize) -> f64 + Sync,
) -> Vec<f64> {
    let count = fields.phi.len();
    let mut gradient = Vec::with_capacity(count);
    let make = |c: usize| fields.load(&band.cells[c]);
    in_slabs(
        band,
        count,
        |i| i,
        make,
        |nodes, loads| {
            let entry = |i: usize| {
                if !band.unknown[i] || band.cancel.is_cancelled() {
                    return 0.0;
                }
                let mut sum = gathered(band, i, |c, a| loads.get(c)[a]);
                if band.residual[i] {
                    sum += by_level(i);
                }
                sum
            };
            gradient.par_extend(nodes.into_par_iter().map(entry));
        },
    );
    gradient.resize(count, 0.0);
    gradient
}

/// The matrix of a step for an energy of this form.
pub(super) fn system(
    band: &Band,
    fields: &Fields,
    variant: Variant,
    weights: Vec<RowWeights>,
) -> System {
    let which: &[fn(&CellMatrices) -> &Packed] = match variant {
        Variant::GaussNewton => &[|c| &c.second, |c| &c.tangential],
        Variant::I => &[|c| &c.second, |c| &c.tangential, |c| &c.full],
        Variant::II => &[|c| &c.second, |c| &c.full],
    };
    let make = |c: usize| CellMatrices::new(&band.cells[c], fields, variant);
    let mut lists = stencils(band, make, which).into_iter();
    let mut next = || lists.next();
    let factors = Factors {
        second: next().unwrap_or_default(),
        curvature: next().unwrap_or_default(),
        inner: next(),
        middle: None,
    };
    System::new(band, factors, weights)
}

/// The weights of the rows of a step's matrix; `residual` is χ ∂²e/∂r² at a node of R.
pub(super) fn weights(
    band: &Band,
    phi: &[f64],
    mass: &[f64],
    time_step: f64,
    residual: impl Fn(usize) -> f64,
) -> Vec<RowWeights> {
    let row = |&i: &u32| {
        let i = i as usize;
        RowWeights {
            residual: if band.residual[i] {
                residual(i) as f32
            } else {
                0.0
            },
            inertia: if time_step.is_finite() {
                (chi(phi[i]) * mass[i] / time_step) as f32
            } else {
                0.0
            },
            unknown: band.unknown[i],
        }
    };
    band.layout.rows.iter().map(row).collect()
}
