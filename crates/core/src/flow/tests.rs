//! Tests that hold for every energy: its gradient is the derivative, its matrix is symmetric, and the Jacobi factor is the
//! diagonal's inverse.

use glam::DVec3;

use super::{
    Band, BandEnergy, BendingBand, BendingEnergy, Density, System, UserEnergy, Variant,
    VariationBand, WillmoreBand,
};
use crate::grid::{Lattice, SparseGrid};
use crate::linalg::LinearOperator;

/// A bumpy ball, free on one side.
fn ball<E: BandEnergy>(make: impl Fn(&SparseGrid, Band) -> E) -> (E, Vec<f64>) {
    let grid = SparseGrid::new([24, 24, 24], |_| true);
    let (mut phi, mut mask) = (vec![], vec![]);
    for s in 0..grid.len() {
        let n = grid.node(s).map(|i| f64::from(i) - 11.3);
        let r = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        let bump = 0.2 * (0.9 * n[0]).sin() * (0.7 * n[1] + 0.3).cos();
        phi.push(r - 7.0 + bump);
        mask.push(n[2] > 2.0);
    }
    let band = Band::new(&grid, &phi, &mask, E::NEEDS.dilations);
    let values = band.gather(&phi);
    (make(&grid, band), values)
}

/// A test direction: a sine wave on the unknowns.
fn waves(band: &Band, frequency: f64) -> Vec<f64> {
    let wave = |i: usize| {
        if band.unknown[i] {
            (i as f64 * frequency).sin()
        } else {
            0.0
        }
    };
    (0..band.slots.len()).map(wave).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn system<E: BandEnergy>(energy: &E, phi: &[f64]) -> System {
    let at = energy.evaluate(phi);
    energy.system(phi, &at, Variant::GaussNewton, f64::INFINITY)
}

fn gradient_is_derivative<E: BandEnergy>(make: impl Fn(&SparseGrid, Band) -> E) {
    let (energy, phi) = ball(make);
    let gradient = energy.gradient(&phi, &energy.evaluate(&phi));
    for frequency in [1.7, 0.03] {
        let direction = waves(energy.band(), frequency);
        let value = |s: f64| {
            let shifted: Vec<f64> = phi.iter().zip(&direction).map(|(p, d)| p + s * d).collect();
            energy.evaluate(&shifted).energy
        };
        let e = 1e-5;
        let numeric = (value(e) - value(-e)) / (2.0 * e);
        let exact = dot(&gradient, &direction);
        assert!(
            (numeric - exact).abs() < 1e-6 * exact.abs().max(1.0),
            "{numeric} {exact}"
        );
    }
}

fn operator_is_symmetric_with_its_diagonal<E: BandEnergy>(make: impl Fn(&SparseGrid, Band) -> E) {
    let (energy, phi) = ball(make);
    let band = energy.band();
    let system = system(&energy, &phi);
    let layout = system.layout();
    let product = |values: &[f64]| {
        let mut out = vec![0.0; layout.len];
        system.apply(&layout.spread(values), &mut out);
        layout.gathered(&out)
    };
    let (x, y) = (waves(band, 0.7), waves(band, 1.3));
    let (a, b) = (dot(&y, &product(&x)), dot(&x, &product(&y)));
    assert!((a - b).abs() < 1e-6 * a.abs().max(1.0), "{a} {b}");
    assert!(dot(&x, &product(&x)) > 0.0);
    let inside: Vec<usize> = (0..phi.len())
        .filter(|&i| band.unknown[i] && band.residual[i])
        .collect();
    for &i in inside.iter().step_by(inside.len() / 7) {
        let mut unit = vec![0.0; phi.len()];
        unit[i] = 1.0;
        let factor = system.jacobi()[layout.position[i] as usize];
        let diagonal = product(&unit)[i];
        assert!(
            (diagonal * factor - 1.0).abs() < 1e-6,
            "{diagonal} {factor}"
        );
    }
}

#[test]
fn the_willmore_gradient_is_that_of_the_energy() {
    gradient_is_derivative(|_, band| WillmoreBand::new(band, 1.0));
}

#[test]
fn the_gradient_of_the_variation_is_that_of_the_energy() {
    gradient_is_derivative(|_, band| VariationBand::new(band, 1.0));
}

#[test]
fn the_willmore_operator_is_symmetric_and_its_diagonal_is_the_jacobi_factor() {
    operator_is_symmetric_with_its_diagonal(|_, band| WillmoreBand::new(band, 1.0));
}

#[test]
fn the_operator_of_the_variation_is_symmetric_and_its_diagonal_is_the_jacobi_factor() {
    operator_is_symmetric_with_its_diagonal(|_, band| VariationBand::new(band, 1.0));
}

/// `½∫(h − h₀)²` with an h₀ that grows along x.
struct Target {
    at_origin: f64,
    growth: f64,
}

impl BendingEnergy for Target {
    fn density(&self, place: DVec3, h: f64) -> Density {
        let excess = h - self.at_origin - self.growth * place.x;
        Density::new(0.5 * excess * excess, excess, 1.0)
    }
}

/// A bending energy on the lattice of a ball of radius 0.7 units around the origin.
fn own<'a>(energy: &'a Target) -> impl Fn(&SparseGrid, Band) -> BendingBand<'a> {
    let lattice = Lattice {
        origin: DVec3::splat(-1.13),
        voxel: 0.1,
    };
    move |grid, band| BendingBand::new(UserEnergy { energy, lattice }, grid, band, 1.0)
}

const GROWING: Target = Target {
    at_origin: 1.5,
    growth: 2.0,
};

#[test]
fn the_gradient_of_an_own_energy_is_that_of_the_energy() {
    gradient_is_derivative(own(&GROWING));
}

#[test]
fn the_operator_of_an_own_energy_is_symmetric_and_its_diagonal_is_the_jacobi_factor() {
    operator_is_symmetric_with_its_diagonal(own(&GROWING));
}

#[test]
fn half_h_squared_is_the_willmore_energy_whatever_the_voxel() {
    let plain = Target {
        at_origin: 0.0,
        growth: 0.0,
    };
    let (own, phi) = ball(own(&plain));
    let (willmore, _) = ball(|_, band| WillmoreBand::new(band, 1.0));
    let [a, b] = [own.evaluate(&phi).energy, willmore.evaluate(&phi).energy];
    assert!((a - b).abs() < 1e-12 * b, "{a} {b}");
}

#[test]
fn a_ball_with_its_own_curvature_as_the_target_has_next_to_no_energy() {
    let smooth = |h0: f64| {
        let target = Target {
            at_origin: h0,
            growth: 0.0,
        };
        let (energy, mut phi) = ball(own(&target));
        let grid = SparseGrid::new([24, 24, 24], |_| true);
        for (value, &slot) in phi.iter_mut().zip(&energy.band().slots) {
            let x = DVec3::from_array(grid.node(slot as usize).map(|i| f64::from(i) - 11.3));
            *value = x.length() - 7.0;
        }
        energy.evaluate(&phi).surface
    };
    // Outward normals: 2/r is positive.
    assert!(smooth(2.0 / 0.7) < 0.02 * smooth(0.0));
    assert!(smooth(-2.0 / 0.7) > 3.0 * smooth(0.0));
}
