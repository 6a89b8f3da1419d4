//! The localised Willmore energy
//!
//! `E(φ) = ½ Σ_{i ∈ R} χ(φ_i) r_i² / M_i + κ/2 Σ_cells (|∇φ| − 1)²`
//!
//! with `r_i = Σ ⅛ n·∇N_i` (weak mean curvature: equation (10) of the paper, tested with N_i), `M_i = Σ ⅛ / |∇φ|` (lumped mass)
//! and a weight χ that follows the level, so that by the co-area formula flattening φ or leaving the band gains nothing.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::band::{Band, NONE, WIDTH};
use super::element::{ELEMENT, dot, gradient};
use super::system::System;

const CHUNK: usize = 1024;
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
fn chi(t: f64) -> f64 {
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

/// Sums in chunks of fixed size, so that rounding does not depend on the threads.
fn chunked_sum<T: Sync>(items: &[T], f: impl Fn(usize, &T) -> f64 + Sync) -> f64 {
    let partial: Vec<f64> = items
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(c, chunk)| {
            let first = c * CHUNK;
            chunk.iter().enumerate().map(|(i, x)| f(first + i, x)).sum()
        })
        .collect();
    partial.iter().sum()
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
            energy: willmore + self.kappa * eikonal,
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
        let cells: Vec<CellFrame> = band
            .cells
            .par_iter()
            .map(|cell| CellFrame::new(cell, phi, &weighted))
            .collect();
        let rows: Vec<Row> = band
            .node_cells
            .par_iter()
            .enumerate()
            .map(|(i, touching)| {
                if !band.residual[i] && !band.unknown[i] {
                    return Row::ZERO;
                }
                assemble_row(touching, &cells, self.kappa, metric)
            })
            .collect();
        let weight: Vec<f64> = (0..n)
            .map(|i| {
                if band.residual[i] {
                    chi(phi[i]) / at.mass[i]
                } else {
                    0.0
                }
            })
            .collect();
        let force: Vec<f64> = (0..n).map(|i| chi(phi[i]) * w[i]).collect();
        let gradient = self.gradient(phi, &rows, &w, &force, &at.mass);
        let second: Vec<[f64; 27]> = rows.iter().map(|r| r.second).collect();
        let tangential_rows = || rows.iter().map(|r| r.curvature).collect();
        let full_rows = || rows.iter().map(|r| r.full).collect();
        let (curvature, inner) = match metric {
            Metric::GaussNewton => (tangential_rows(), None),
            Metric::VariantOne => (tangential_rows(), Some(full_rows())),
            Metric::VariantTwo => (full_rows(), None),
        };
        let diagonal = (0..n)
            .map(|i| {
                if time_step.is_finite() {
                    at.mass[i] / time_step
                } else {
                    0.0
                }
            })
            .collect();
        System::new(band, curvature, second, weight, diagonal, gradient).with_inner(inner)
    }

    /// `BPᵀ(χw) + ½ L1 φ + ½ χ' w² M + κ Σ (1 − 1/|g|) g·∇N` on the unknowns; the parts from L1 and κ come with the rows.
    fn gradient(
        &self,
        phi: &[f64],
        rows: &[Row],
        w: &[f64],
        force: &[f64],
        mass: &[f64],
    ) -> Vec<f64> {
        let band = &self.band;
        (0..phi.len())
            .into_par_iter()
            .map(|i| {
                if !band.unknown[i] {
                    return 0.0;
                }
                let mut sum = rows[i].force;
                for (k, &j) in band.neighbours[i].iter().enumerate() {
                    if let Some(f) = force.get(j as usize) {
                        sum += rows[i].curvature[k] * f;
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

/// What the cells round a node add to its stencils and its entry of the gradient.
struct Row {
    /// L[P/|∇φ|].
    curvature: [f64; 27],
    /// L[1/|∇φ|]; only for the paper's variants.
    full: [f64; 27],
    /// ½ L1 + κ L[n⊗n].
    second: [f64; 27],
    /// `½ L1 φ + κ ∂Eik`.
    force: f64,
}

impl Row {
    const ZERO: Self = Self {
        curvature: [0.0; 27],
        full: [0.0; 27],
        second: [0.0; 27],
        force: 0.0,
    };
}

/// What a cell hands to the rows of its corners.
struct CellFrame {
    normals: [[f64; 3]; 8],
    /// ⅛ / |∇φ| at the Gauss points.
    scale: [f64; 8],
    /// ∇φ at the centre.
    centre: [f64; 3],
    /// ½ (mean of χw²) / |∇φ|³ at the centre.
    l1: f64,
    /// 1 − 1/|∇φ| at the centre.
    eikonal: f64,
}

impl CellFrame {
    fn new(cell: &[u32; 8], phi: &[f64], weighted: &[f64]) -> Self {
        let e = &*ELEMENT;
        let v = corners(cell, phi);
        let mut frame = Self {
            normals: [[0.0; 3]; 8],
            scale: [0.0; 8],
            centre: gradient(&e.centre, &v),
            l1: 0.0,
            eikonal: 0.0,
        };
        for (q, shape) in e.gauss.iter().enumerate() {
            let g = gradient(shape, &v);
            let l = norm(g);
            frame.normals[q] = g.map(|x| x / l);
            frame.scale[q] = 0.125 / l;
        }
        let l = norm(frame.centre);
        let mean = 0.125 * cell.iter().map(|&c| weighted[c as usize]).sum::<f64>();
        frame.l1 = 0.5 * mean / (l * l * l);
        frame.eikonal = 1.0 - 1.0 / l;
        frame
    }
}

/// The row of one node from the cells that touch it.
fn assemble_row(touching: &[u32; 8], cells: &[CellFrame], kappa: f64, metric: Metric) -> Row {
    let e = &*ELEMENT;
    let mut row = Row::ZERO;
    for (a, &c) in touching.iter().enumerate() {
        if c == NONE {
            continue;
        }
        let frame = &cells[c as usize];
        let (mut row_p, mut row_full, mut row_s) = ([0.0; 8], [0.0; 8], [0.0; 8]);
        for (q, shape) in e.gauss.iter().enumerate() {
            let n = frame.normals[q];
            let da = [shape[0][a], shape[1][a], shape[2][a]];
            let along = dot(n, da);
            let t = frame.scale[q];
            let vp: [f64; 3] = std::array::from_fn(|d| t * (da[d] - along * n[d]));
            let vn: [f64; 3] = std::array::from_fn(|d| 0.125 * kappa * along * n[d]);
            for b in 0..8 {
                row_p[b] += vp[0] * shape[0][b] + vp[1] * shape[1][b] + vp[2] * shape[2][b];
                row_s[b] += vn[0] * shape[0][b] + vn[1] * shape[1][b] + vn[2] * shape[2][b];
            }
            if metric != Metric::GaussNewton {
                for b in 0..8 {
                    row_full[b] +=
                        t * (da[0] * shape[0][b] + da[1] * shape[1][b] + da[2] * shape[2][b]);
                }
            }
        }
        let shape = &e.centre;
        let da = [shape[0][a], shape[1][a], shape[2][a]];
        for b in 0..8 {
            row_s[b] +=
                frame.l1 * (da[0] * shape[0][b] + da[1] * shape[1][b] + da[2] * shape[2][b]);
            let k = stencil_entry(a, b);
            row.curvature[k] += row_p[b];
            row.full[k] += row_full[b];
            row.second[k] += row_s[b];
        }
        row.force += (frame.l1 + kappa * frame.eikonal) * dot(frame.centre, da);
    }
    row
}

/// Position in the 27-point stencil of corner `b` seen from corner `a`.
fn stencil_entry(a: usize, b: usize) -> usize {
    let step = |shift: usize| ((b >> shift) & 1) + 1 - ((a >> shift) & 1);
    9 * step(2) + 3 * step(1) + step(0)
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
        (WillmoreBand { band, kappa: 1.0 }, values)
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
        let n = phi.len();
        let vector = |f: f64| -> Vec<f64> {
            (0..n)
                .map(|i| {
                    if w.band.unknown[i] {
                        (i as f64 * f).sin()
                    } else {
                        0.0
                    }
                })
                .collect()
        };
        let (x, y) = (vector(0.7), vector(1.3));
        let (mut ax, mut ay) = (vec![0.0; n], vec![0.0; n]);
        system.apply(&x, &mut ax);
        system.apply(&y, &mut ay);
        let (a, b): (f64, f64) = (
            y.iter().zip(&ax).map(|(p, q)| p * q).sum(),
            x.iter().zip(&ay).map(|(p, q)| p * q).sum(),
        );
        assert!((a - b).abs() < 1e-9 * a.abs().max(1.0));
        let i = (0..n)
            .find(|&i| w.band.unknown[i] && w.band.residual[i])
            .unwrap();
        let mut unit = vec![0.0; n];
        unit[i] = 1.0;
        system.apply(&unit, &mut ax);
        assert!((ax[i] * system.jacobi()[i] - 1.0).abs() < 1e-12);
    }
}
