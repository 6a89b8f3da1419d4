//! The discrete Willmore energy of all level lines of a function on a square, or of the graph of the function, and its gradient.
//!
//! With `|v|_ε = √(|v|² + ε²)`, lumped mass `M`, and the matrices `L3 = L[1/|∇φ|_ε]`, `L2 = L[P/|∇φ|_ε]`,
//! `L1 = L[w²/|∇φ|_ε³]` (Droske and Rumpf, Section 5),
//!
//! `E(φ) = ½ Σ m_i w_i²`, `w = M⁻¹ (L3 φ − b)` (10), `g = ½ L1 φ + L2 w` (9).
//!
//! With ε = 1, `(∇φ, −ε)` is the normal of the graph (Section 6). For level lines, ε is of the order of h or less.

use super::element::{ELEMENT, Shape};
use super::grid::{SquareGrid, Stencils};

/// The quadrature of `w²` in L1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum Quadrature {
    /// `w²` at the Gauss points, as in the paper.
    Gauss,
    /// The mean of the corners' `w²` at the cell's centre. `g` is then exactly the gradient of the discrete energy.
    Midpoint,
}

/// The energy on a grid, with its regularisation and boundary conditions.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct PlaneEnergy {
    /// The grid.
    pub grid: SquareGrid,
    /// ε of `|v|_ε`, in units of |∇φ|.
    pub epsilon: f64,
    /// The quadrature of L1.
    pub quadrature: Quadrature,
    load: Vec<f64>,
    free: Vec<bool>,
}

/// The energy, its gradient and the matrices of a step at one φ.
#[doc(hidden)]
pub struct Linearisation {
    /// The energy.
    pub energy: f64,
    /// `g = ½ L1 φ + L2 w`, minus the right-hand side of (9); zero off the free nodes.
    pub gradient: Vec<f64>,
    /// Lumped mass, zero in the halo.
    pub mass: Vec<f64>,
    /// Inverse of the lumped mass, zero in the halo.
    pub inverse_mass: Vec<f64>,
    /// L3.
    pub full: Stencils,
    /// L2.
    pub tangential: Stencils,
    /// L1.
    pub weighted: Stencils,
}

impl PlaneEnergy {
    /// Natural boundary conditions: every node is free, γ = 0.
    pub fn natural(grid: SquareGrid, epsilon: f64) -> Self {
        let load = vec![0.0; grid.field_len()];
        let free = grid.node_mask(true);
        Self {
            grid,
            epsilon,
            quadrature: Quadrature::Gauss,
            load,
            free,
        }
    }

    /// Clamped boundary conditions: φ is held on the boundary, and so is the normal, through `γ = ∂νφ/|∇φ|_ε` as a function of
    /// position and outer normal (12), (13).
    pub fn clamped(
        grid: SquareGrid,
        epsilon: f64,
        gamma: impl Fn([f64; 2], [f64; 2]) -> f64,
    ) -> Self {
        let load = grid.boundary_load(gamma);
        let free = grid.node_mask(false);
        Self {
            grid,
            epsilon,
            quadrature: Quadrature::Gauss,
            load,
            free,
        }
    }

    /// Whether each node is free.
    pub fn free(&self) -> &[bool] {
        &self.free
    }

    /// The energy of φ.
    pub fn energy(&self, phi: &[f64]) -> f64 {
        self.curvature(phi).energy()
    }

    /// The energy, its gradient and the matrices of a step at φ.
    pub fn linearise(&self, phi: &[f64]) -> Linearisation {
        let curvature = self.curvature(phi);
        let weighted = self.weighted(phi, &curvature);
        let mut gradient = vec![0.0; phi.len()];
        let mut bent = vec![0.0; phi.len()];
        weighted.apply(phi, &mut gradient);
        curvature.tangential.apply(&curvature.w, &mut bent);
        for (i, g) in gradient.iter_mut().enumerate() {
            *g = if self.free[i] {
                0.5 * *g + bent[i]
            } else {
                0.0
            };
        }
        Linearisation {
            energy: curvature.energy(),
            gradient,
            mass: curvature.mass,
            inverse_mass: curvature.inverse_mass,
            full: curvature.full,
            tangential: curvature.tangential,
            weighted,
        }
    }

    fn norm(&self, g: [f64; 2]) -> f64 {
        (g[0] * g[0] + g[1] * g[1] + self.epsilon * self.epsilon).sqrt()
    }

    fn gradient_at(&self, shape: &Shape, v: &[f64; 4]) -> [f64; 2] {
        let per_cell = 1.0 / self.grid.h();
        shape.gradient_of(v).map(|x| x * per_cell)
    }

    fn curvature(&self, phi: &[f64]) -> Curvature {
        let grid = &self.grid;
        let (mut full, mut tangential) = (Stencils::zero(grid), Stencils::zero(grid));
        let mut mass = vec![0.0; phi.len()];
        let mut inverse_norms = Vec::with_capacity(grid.cells() * grid.cells());
        let quarter = 0.25 * grid.h() * grid.h();
        let shapes = &*ELEMENT;
        // Assemble L3, L2 by the four Gauss points of each cell, and the lumped mass of 1/|∇φ|_ε by its centre (Section 5).
        for j in 0..grid.cells() {
            for i in 0..grid.cells() {
                let corners = grid.corners(i, j);
                let v = corners.map(|k| phi[k]);
                let lumped = quarter / self.norm(self.gradient_at(&shapes.centre, &v));
                corners.iter().for_each(|&k| mass[k] += lumped);
                let (mut e3, mut e2) = ([0.0; 10], [0.0; 10]);
                let gradients = [0, 1, 2, 3].map(|q| self.gradient_at(&shapes.gauss[q], &v));
                let inverse = gradients.map(|g| 1.0 / self.norm(g));
                inverse_norms.push(inverse);
                for q in 0..4 {
                    let (shape, n) = (&shapes.gauss[q], gradients[q].map(|g| g * inverse[q]));
                    // The factors h² of the cell and 1/h² of the two gradients cancel.
                    add_laplacian(&mut e3, shape, 0.25 * inverse[q]);
                    add_projected(&mut e2, shape, 0.25 * inverse[q], n);
                }
                full.add(&corners, &e3);
                tangential.add(&corners, &e2);
            }
        }
        // The mass is zero in the halo only.
        let inverse_mass: Vec<f64> = mass
            .iter()
            .map(|&m| if m > 0.0 { 1.0 / m } else { 0.0 })
            .collect();
        // w = M⁻¹ (L3 φ − b): equation (10).
        let mut w = vec![0.0; phi.len()];
        full.apply(phi, &mut w);
        for (i, w) in w.iter_mut().enumerate() {
            *w = (*w - self.load[i]) * inverse_mass[i];
        }
        Curvature {
            w,
            mass,
            inverse_mass,
            full,
            tangential,
            inverse_norms,
        }
    }

    /// L1.
    fn weighted(&self, phi: &[f64], curvature: &Curvature) -> Stencils {
        let grid = &self.grid;
        let mut weighted = Stencils::zero(grid);
        let shapes = &*ELEMENT;
        for j in 0..grid.cells() {
            for i in 0..grid.cells() {
                let corners = grid.corners(i, j);
                let u = corners.map(|k| curvature.w[k]);
                let mut e = [0.0; 10];
                match self.quadrature {
                    Quadrature::Gauss => {
                        let inverse = &curvature.inverse_norms[j * grid.cells() + i];
                        for (shape, n) in shapes.gauss.iter().zip(inverse) {
                            let at = shape.value_of(&u);
                            add_laplacian(&mut e, shape, 0.25 * at * at * (n * n * n));
                        }
                    }
                    Quadrature::Midpoint => {
                        let v = corners.map(|k| phi[k]);
                        let norm = self.norm(self.gradient_at(&shapes.centre, &v));
                        let mean = 0.25 * u.iter().map(|x| x * x).sum::<f64>();
                        add_laplacian(&mut e, &shapes.centre, mean / norm.powi(3));
                    }
                }
                weighted.add(&corners, &e);
            }
        }
        weighted
    }
}

/// The weak curvature of φ, with the matrices that it is computed from.
struct Curvature {
    /// `w = M⁻¹ (L3 φ − b)` at all nodes, the boundary included: equation (10).
    w: Vec<f64>,
    mass: Vec<f64>,
    inverse_mass: Vec<f64>,
    /// L3.
    full: Stencils,
    /// L2.
    tangential: Stencils,
    /// `1/|∇φ|_ε` at the four Gauss points of each cell, row by row.
    inverse_norms: Vec<[f64; 4]>,
}

impl Curvature {
    fn energy(&self) -> f64 {
        let parts = self.w.iter().zip(&self.mass);
        0.5 * parts.map(|(w, m)| m * w * w).sum::<f64>()
    }
}

/// Adds `c ∇ψa·∇ψb`.
#[inline]
fn add_laplacian(e: &mut [f64; 10], shape: &Shape, c: f64) {
    for (e, product) in e.iter_mut().zip(&shape.products) {
        *e += c * product;
    }
}

/// Adds `c ∇ψa·P∇ψb`, `P = I − n⊗n`.
#[inline]
fn add_projected(e: &mut [f64; 10], shape: &Shape, c: f64, n: [f64; 2]) {
    let [gx, gy] = &shape.gradient;
    let along: [f64; 4] = std::array::from_fn(|a| n[0] * gx[a] + n[1] * gy[a]);
    let mut k = 0;
    for a in 0..4 {
        for b in a..4 {
            e[k] += c * (shape.products[k] - along[a] * along[b]);
            k += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wavy(epsilon: f64) -> (PlaneEnergy, Vec<f64>) {
        let grid = SquareGrid::centred(12);
        let phi = grid.field(|[x, y]| (3.0 * x).sin() + (2.0 * x * y + 1.3 * y).cos());
        (
            PlaneEnergy::clamped(grid, epsilon, |x, n| 0.2 * x[0] * n[0] - 0.1 * n[1]),
            phi,
        )
    }

    #[test]
    fn by_midpoints_the_gradient_is_that_of_the_energy() {
        for epsilon in [1.0, 0.1] {
            let (mut energy, phi) = wavy(epsilon);
            let direction: Vec<f64> = (0..phi.len())
                .map(|i| f64::from(energy.free()[i]) * (1.7 * i as f64).sin())
                .collect();
            let shifted = |s: f64| -> Vec<f64> {
                phi.iter().zip(&direction).map(|(p, d)| p + s * d).collect()
            };
            let e = 1e-6;
            let numeric = (energy.energy(&shifted(e)) - energy.energy(&shifted(-e))) / (2.0 * e);
            let slope = |energy: &PlaneEnergy| -> f64 {
                let g = energy.linearise(&phi).gradient;
                g.iter().zip(&direction).map(|(a, b)| a * b).sum()
            };
            let paper = slope(&energy);
            energy.quadrature = Quadrature::Midpoint;
            let exact = slope(&energy);
            let size = numeric.abs();
            assert!((numeric - exact).abs() < 1e-6 * size, "{numeric} {exact}");
            assert!((numeric - paper).abs() > 1e-5 * size, "{numeric} {paper}");
        }
    }

    #[test]
    fn a_sloping_plane_has_no_curvature() {
        let grid = SquareGrid::centred(8);
        let phi = grid.field(|[x, y]| 2.0 * x - y);
        let norm = 6f64.sqrt();
        let energy = PlaneEnergy::clamped(grid, 1.0, |_, n| (2.0 * n[0] - n[1]) / norm);
        let at = energy.linearise(&phi);
        assert!(at.energy < 1e-20, "{}", at.energy);
        assert!(at.gradient.iter().all(|g| g.abs() < 1e-10));
    }
}
