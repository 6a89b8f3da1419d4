//! Discrete harmonic functions as initial values of a flow.

use super::grid::Stencils;
use super::plane::PlaneEnergy;
use isomend_core::linalg::{Jacobi, LinearOperator, conjugate_gradient};

struct Laplacian {
    stencils: Stencils,
    free: Vec<bool>,
    jacobi: Vec<f64>,
}

impl LinearOperator for Laplacian {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.stencils.apply(x, y);
        y.iter_mut()
            .zip(&self.free)
            .for_each(|(y, f)| *y *= f64::from(*f));
    }

    fn jacobi(&self) -> &[f64] {
        &self.jacobi
    }
}

/// Replaces φ at the free nodes by the discrete harmonic function with the values of φ at the fixed nodes.
#[doc(hidden)]
pub fn harmonic_fill(energy: &PlaneEnergy, phi: &mut [f64]) {
    let free = energy.free().to_vec();
    for (p, &free) in phi.iter_mut().zip(&free) {
        if free {
            *p = 0.0;
        }
    }
    // At a constant function, L3 is the stiffness matrix of the Laplacian divided by ε.
    let stencils = energy.linearise(&vec![0.0; phi.len()]).full;
    let mut load = vec![0.0; phi.len()];
    stencils.apply(phi, &mut load);
    let b: Vec<f64> = load
        .iter()
        .zip(&free)
        .map(|(l, &f)| if f { -l } else { 0.0 })
        .collect();
    let jacobi = (0..phi.len())
        .map(|i| {
            if free[i] {
                1.0 / stencils.entry(4, i)
            } else {
                0.0
            }
        })
        .collect();
    let laplacian = Laplacian {
        stencils,
        free,
        jacobi,
    };
    let mut x = vec![0.0; phi.len()];
    let scaling = Jacobi(laplacian.jacobi());
    conjugate_gradient(&laplacian, &scaling, &b, &mut x, 1e-12, 10_000);
    phi.iter_mut().zip(&x).for_each(|(p, x)| *p += x);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::SquareGrid;

    #[test]
    fn a_linear_function_is_filled_exactly() {
        let grid = SquareGrid::centred(10);
        let wanted = grid.field(|[x, y]| 1.0 + 2.0 * x - 3.0 * y);
        let energy = PlaneEnergy::clamped(grid, 1.0, |_, _| 0.0);
        let mut phi = wanted.clone();
        harmonic_fill(&energy, &mut phi);
        for (a, b) in phi.iter().zip(&wanted) {
            assert!((a - b).abs() < 1e-10);
        }
    }
}
