//! The localised Willmore energy
//!
//! `E(φ) = ½ Σ_{i ∈ R} χ(φ_i) r_i² / M_i + κ/2 Σ_cells (|∇φ| − 1)²`
//!
//! with `r_i = Σ ⅛ n·∇N_i` (weak mean curvature: equation (10) of the paper, tested with N_i), `M_i = Σ ⅛ / |∇φ|` (lumped mass)
//! and a weight χ that follows the level, so that by the co-area formula flattening φ or leaving the band gains nothing.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::band::{Band, NONE, WIDTH, chunked_sum};
use super::element::{ELEMENT, dot, gradient};
use super::pull::BandPull;
use super::system::{RowWeights, Stencil, System};

/// Keeps |∇φ| from zero.
const EPSILON: f64 = 1e-6;

/// The metric of a step: which matrix stands for the Hessian.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// `L2 M⁻¹ L2`: Gauss-Newton.
    GaussNewton,
    /// `L2 M⁻¹ L3`, nonsymmetric: variant I of the paper.
    VariantOne,
    /// `L3 M⁻¹ L3`: variant II of the paper.
    VariantTwo,
}

/// A band with what is computed from φ on it.
pub struct WillmoreBand {
    /// The nodes and cells.
    pub band: Band,
    /// Weight κ of the eikonal term.
    pub kappa: f64,
    /// The pull to a given surface.
    pub(super) pull: BandPull,
}

/// Energy and the nodal quantities it is made of.
pub struct Evaluation {
    /// The whole energy.
    pub energy: f64,
    /// Its Willmore part, ½ Σ χ r²/M.
    pub willmore: f64,
    r: Vec<f64>,
    mass: Vec<f64>,
}

/// χ(t) = ½ (1 + cos(πt/b)) inside |t| < b.
pub(super) fn chi(t: f64) -> f64 {
    if t.abs() < WIDTH {
        0.5 * (1.0 + (PI * t / WIDTH).cos())
    } else {
        0.0
    }
}

fn chi_derivative(t: f64) -> f64 {
    if t.abs() < WIDTH {
        -0.5 * PI / WIDTH * (PI * t / WIDTH).sin()
    } else {
        0.0
    }
}

fn corners(cell: &[u32; 8], phi: &[f64]) -> [f64; 8] {
    cell.map(|v| phi[v as usize])
}

fn norm(g: [f64; 3]) -> f64 {
    (dot(g, g) + EPSILON * EPSILON).sqrt()
}

impl WillmoreBand {
    /// r_i and M_i, gathered from the cells.
    fn nodal(&self, phi: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let parts: Vec<([f64; 8], f64)> = self
            .band
            .cells
            .par_iter()
            .map(|cell| cell_residual(&corners(cell, phi)))
            .collect();
        self.band
            .node_cells
            .par_iter()
            .map(|cells| {
                let (mut r, mut m) = (0.0, 0.0);
                for (a, &c) in cells.iter().enumerate() {
                    if c != NONE {
                        let part = &parts[c as usize];
                        r += part.0[a];
                        m += part.1;
                    }
                }
                (r, m)
            })
            .unzip()
    }

    /// The energy of `phi` (values at the band's nodes).
    pub fn evaluate(&self, phi: &[f64]) -> Evaluation {
        let (r, mass) = self.nodal(phi);
        let willmore = chunked_sum(&self.band.residual, |i, &inside| {
            if inside {
                0.5 * chi(phi[i]) * r[i] * r[i] / mass[i]
            } else {
                0.0
            }
        });
        let eikonal = chunked_sum(&self.band.cells, |_, cell| {
            let g = gradient(&ELEMENT.centre, &corners(cell, phi));
            0.5 * (norm(g) - 1.0).powi(2)
        });
        Evaluation {
            energy: willmore + self.kappa * eikonal + self.pull.energy(phi),
            willmore,
            r,
            mass,
        }
    }

    /// Gradient and matrix at `phi`; `time_step` is infinite for the steady state.
    pub fn system(
        &self,
        phi: &[f64],
        at: &Evaluation,
        metric: Metric,
        time_step: f64,
    ) -> System<'_> {
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
            .map(|cell| CellMatrices::new(cell, &fields, metric))
            .collect();
        let stencils = |which: Choose| -> Vec<Stencil> {
            band.layout
                .rows
                .par_iter()
                .map(|&i| assemble_row(&band.node_cells[i as usize], &cells, which))
                .collect()
        };
        let tangential: Choose = |c| &c.tangential;
        let full: Choose = |c| &c.full;
        let (curvature, inner) = match metric {
            Metric::GaussNewton => (stencils(tangential), None),
            Metric::VariantOne => (stencils(tangential), Some(stencils(full))),
            Metric::VariantTwo => (stencils(full), None),
        };
        let second = stencils(|c| &c.second);
        let weights = self.weights(phi, &at.mass, time_step);
        let gradient = self.gradient(phi, &cells, &w, &at.mass);
        System::new(band, [curvature, second], inner, weights, gradient)
    }

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
                        mass[i] / time_step
                    } else {
                        0.0
                    } + self.pull.diagonal(i),
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
                let mut sum = self.pull.gradient(i, phi);
                for (a, &c) in band.node_cells[i].iter().enumerate() {
                    if c != NONE {
                        sum += cells[c as usize].load[a];
                    }
                }
                if band.residual[i] {
                    sum += 0.5 * chi_derivative(phi[i]) * w[i] * w[i] * mass[i];
                }
                sum
            })
            .collect()
    }
}

/// The eight entries of `Σ_q ⅛ n·∇N_a` and `⅛ / |∇φ|` at the centre.
fn cell_residual(v: &[f64; 8]) -> ([f64; 8], f64) {
    let e = &*ELEMENT;
    let mut r = [0.0; 8];
    for shape in &e.gauss {
        let g = gradient(shape, v);
        let s = 0.125 / norm(g);
        for a in 0..8 {
            r[a] += s * (g[0] * shape[0][a] + g[1] * shape[1][a] + g[2] * shape[2][a]);
        }
    }
    (r, 0.125 / norm(gradient(&e.centre, v)))
}

/// What a cell's matrices are made of, at the band's nodes.
struct Fields<'a> {
    phi: &'a [f64],
    /// χw².
    weighted: &'a [f64],
    /// χw.
    force: &'a [f64],
    kappa: f64,
}

/// The upper triangle of a symmetric 8 × 8 matrix, by rows.
type Packed = [f32; 36];

/// Place in a [`Packed`] matrix of entry `8 a + b`.
const PLACE: [u8; 64] = {
    let mut table = [0; 64];
    let (mut a, mut next) = (0, 0);
    while a < 8 {
        let mut b = a;
        while b < 8 {
            table[8 * a + b] = next;
            table[8 * b + a] = next;
            next += 1;
            b += 1;
        }
        a += 1;
    }
    table
};

fn packed(matrix: &[f32; 64]) -> Packed {
    let mut out = [0.0; 36];
    for (i, &v) in matrix.iter().enumerate() {
        out[PLACE[i] as usize] = v;
    }
    out
}

/// One of a cell's matrices.
type Choose = fn(&CellMatrices) -> &Packed;

/// What a cell adds to the stencils and to the gradient at its corners.
struct CellMatrices {
    /// L[P/|∇φ|].
    tangential: Packed,
    /// L[1/|∇φ|]; only for the paper's variants.
    full: Packed,
    /// ½ L1 + κ L[n⊗n].
    second: Packed,
    /// `BPᵀ(χw) + ½ L1 φ + κ ∂Eik`.
    load: [f64; 8],
}

impl CellMatrices {
    fn new(cell: &[u32; 8], fields: &Fields, metric: Metric) -> Self {
        let e = &*ELEMENT;
        let v = corners(cell, fields.phi);
        let force = corners(cell, fields.force);
        let kappa = (0.125 * fields.kappa) as f32;
        let (mut tangential, mut full, mut second) = ([0.0; 64], [0.0; 64], [0.0; 64]);
        let mut load = [0.0; 8];
        for (q, shape) in e.gauss.iter().enumerate() {
            let g = gradient(shape, &v);
            let l = norm(g);
            let n = g.map(|x| x / l);
            let scale = 0.125 / l;
            let f = gradient(shape, &force);
            let along = dot(f, n);
            let p: [f64; 3] = std::array::from_fn(|d| scale * (f[d] - along * n[d]));
            let mut normal = [0.0f32; 8];
            for a in 0..8 {
                load[a] += p[0] * shape[0][a] + p[1] * shape[1][a] + p[2] * shape[2][a];
                normal[a] = (n[0] * shape[0][a] + n[1] * shape[1][a] + n[2] * shape[2][a]) as f32;
            }
            add_products(
                (&mut tangential, &mut second),
                &normal,
                &e.gauss_products[q],
                (scale as f32, kappa),
            );
            if metric != Metric::GaussNewton {
                for (f, p) in full.iter_mut().zip(&e.gauss_products[q]) {
                    *f += scale as f32 * p;
                }
            }
        }
        let g = gradient(&e.centre, &v);
        let l = norm(g);
        let mean = 0.125 * corners(cell, fields.weighted).iter().sum::<f64>();
        let l1 = 0.5 * mean / (l * l * l);
        let pull = l1 + fields.kappa * (1.0 - 1.0 / l);
        for a in 0..8 {
            let shape = &e.centre;
            load[a] += pull * (g[0] * shape[0][a] + g[1] * shape[1][a] + g[2] * shape[2][a]);
        }
        for (s, p) in second.iter_mut().zip(&e.centre_products) {
            *s += l1 as f32 * p;
        }
        Self {
            tangential: packed(&tangential),
            full: packed(&full),
            second: packed(&second),
            load,
        }
    }
}

/// Adds `scale (∇N·∇N − n·∇N n·∇N)` to the first matrix and `kappa n·∇N n·∇N` to the second.
#[inline]
fn add_products(
    (tangential, second): (&mut [f32; 64], &mut [f32; 64]),
    normal: &[f32; 8],
    products: &[f32; 64],
    (scale, kappa): (f32, f32),
) {
    for a in 0..8 {
        for b in 0..8 {
            let both = normal[a] * normal[b];
            tangential[8 * a + b] += scale * (products[8 * a + b] - both);
            second[8 * a + b] += kappa * both;
        }
    }
}

/// The stencil of one node from the cells that touch it.
fn assemble_row(touching: &[u32; 8], cells: &[CellMatrices], which: Choose) -> Stencil {
    let mut row = [0.0; 27];
    for (a, &c) in touching.iter().enumerate() {
        if c == NONE {
            continue;
        }
        let matrix = which(&cells[c as usize]);
        for b in 0..8 {
            row[ENTRY[8 * a + b] as usize] += f64::from(matrix[PLACE[8 * a + b] as usize]);
        }
    }
    Stencil::new(&row)
}

/// For each pair of corners, `8 a + b`, the place of `b` in the stencil of `a`.
const ENTRY: [u8; 64] = {
    let mut table = [0; 64];
    let mut i = 0;
    while i < 64 {
        table[i] = stencil_entry(i / 8, i % 8);
        i += 1;
    }
    table
};

/// Position in the 27-point stencil of corner `b` seen from corner `a`.
const fn stencil_entry(a: usize, b: usize) -> u8 {
    let (x, y, z) = (
        ((b >> 2) & 1) + 1 - ((a >> 2) & 1),
        ((b >> 1) & 1) + 1 - ((a >> 1) & 1),
        (b & 1) + 1 - (a & 1),
    );
    (9 * x + 3 * y + z) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::SparseGrid;
    use crate::linalg::LinearOperator;

    fn sphere_band() -> (WillmoreBand, Vec<f64>) {
        let grid = SparseGrid::new([24, 24, 24], |_| true);
        let (mut phi, mut mask) = (vec![], vec![]);
        for s in 0..grid.len() {
            let n = grid.node(s).map(|i| f64::from(i) - 11.3);
            let r = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
            let bump = 0.2 * (0.9 * n[0]).sin() * (0.7 * n[1] + 0.3).cos();
            phi.push(r - 7.0 + bump);
            mask.push(n[2] > 2.0);
        }
        let band = Band::new(&grid, &phi, &mask);
        let values = band.gather(&phi);
        (
            WillmoreBand {
                band,
                kappa: 1.0,
                pull: BandPull::default(),
            },
            values,
        )
    }

    #[test]
    fn the_gradient_is_that_of_the_energy() {
        let (w, phi) = sphere_band();
        let at = w.evaluate(&phi);
        let g = w
            .system(&phi, &at, Metric::GaussNewton, f64::INFINITY)
            .gradient;
        let direction: Vec<f64> = (0..phi.len())
            .map(|i| {
                if w.band.unknown[i] {
                    (i as f64 * 1.7).sin()
                } else {
                    0.0
                }
            })
            .collect();
        let shifted =
            |s: f64| -> Vec<f64> { phi.iter().zip(&direction).map(|(p, d)| p + s * d).collect() };
        let e = 1e-5;
        let numeric =
            (w.evaluate(&shifted(e)).energy - w.evaluate(&shifted(-e)).energy) / (2.0 * e);
        let exact: f64 = g.iter().zip(&direction).map(|(a, b)| a * b).sum();
        assert!(
            (numeric - exact).abs() < 1e-6 * exact.abs().max(1.0),
            "{numeric} {exact}"
        );
    }

    #[test]
    fn the_operator_is_symmetric_and_its_diagonal_is_the_jacobi_factor() {
        let (w, phi) = sphere_band();
        let at = w.evaluate(&phi);
        let system = w.system(&phi, &at, Metric::GaussNewton, f64::INFINITY);
        let layout = system.layout();
        let n = layout.len;
        let vector = |f: f64| -> Vec<f64> {
            let values: Vec<f64> = (0..phi.len())
                .map(|i| {
                    if w.band.unknown[i] {
                        (i as f64 * f).sin()
                    } else {
                        0.0
                    }
                })
                .collect();
            layout.spread(&values)
        };
        let (x, y) = (vector(0.7), vector(1.3));
        let (mut ax, mut ay) = (vec![0.0; n], vec![0.0; n]);
        system.apply(&x, &mut ax);
        system.apply(&y, &mut ay);
        let (a, b): (f64, f64) = (
            y.iter().zip(&ax).map(|(p, q)| p * q).sum(),
            x.iter().zip(&ay).map(|(p, q)| p * q).sum(),
        );
        assert!((a - b).abs() < 1e-6 * a.abs().max(1.0));
        let i = (0..phi.len())
            .find(|&i| w.band.unknown[i] && w.band.residual[i])
            .map(|i| layout.position[i] as usize)
            .unwrap();
        let mut unit = vec![0.0; n];
        unit[i] = 1.0;
        system.apply(&unit, &mut ax);
        assert!((ax[i] * system.jacobi()[i] - 1.0).abs() < 1e-12);
    }
}
