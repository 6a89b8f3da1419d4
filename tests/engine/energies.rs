//! Fills with a bending energy that the caller defines (`fill_with`).

use glam::DVec3;
use isomend::{BendingEnergy, Control, Density, Energy, FillParams, fill, inspect};

use crate::shapes::{cut, polar, sphere, topology};

/// An energy whose density is not a number.
struct Broken;

impl BendingEnergy for Broken {
    fn density(&self, _: DVec3, _: f64) -> Density {
        Density::new(f64::NAN, f64::INFINITY, f64::NAN)
    }
}

/// `½∫(h − h₀)²`.
struct Target(f64);

impl BendingEnergy for Target {
    fn density(&self, _: DVec3, h: f64) -> Density {
        let excess = h - self.0;
        Density::new(0.5 * excess * excess, excess, 1.0)
    }
}

/// The mean distance from the origin of the vertices that close the top of a sphere, by `½∫(h − h₀)²`.
fn mean_radius(target: f64) -> f64 {
    let mesh = cut(&sphere(16), |p| polar(p) < 40.0);
    let found = inspect(&mesh).unwrap();
    let filled = found
        .fill_with(&FillParams::new(), &Target(target), &Control::new())
        .unwrap();
    let region = &filled.report.regions[0];
    assert!(region.converged && !region.other_energy);
    assert_eq!(region.levels.last().unwrap().flow.energy, Energy::Own);
    assert_eq!(topology(&filled.mesh), (0, 2));
    let patch = &filled.mesh.positions[mesh.positions.len()..];
    patch.iter().map(|p| p.length()).sum::<f64>() / patch.len() as f64
}

/// At the unit sphere, where h = 2, the first variation of ½∫(h − h₀)² is `∫ c (c − 2) v` with c = 2 − h₀, for a displacement v outward.
/// The sphere is a steady state for the targets 0 and 2; targets between them make the patch bulge more, all others less.
#[test]
fn a_patch_leaves_the_sphere_to_the_side_that_the_first_variation_predicts() {
    let [same, willmore] = [2.0, 0.0].map(mean_radius);
    assert!((same - 1.0).abs() < 5e-4, "{same}");
    assert!((willmore - 1.0).abs() < 5e-4, "{willmore}");
    let [low, between, high] = [-4.0, 1.0, 8.0].map(mean_radius);
    assert!(low < same - 0.01 && high < same - 0.02, "{low} {high}");
    assert!(
        between > same.max(willmore) + 1e-4,
        "{between} {same} {willmore}"
    );
}

#[test]
fn the_willmore_energy_replaces_an_energy_that_is_not_a_number() {
    let mesh = cut(&sphere(10), |p| polar(p) < 40.0);
    let found = inspect(&mesh).unwrap();
    let filled = found
        .fill_with(&FillParams::new(), &Broken, &Control::new())
        .unwrap();
    assert!(!filled.report.incomplete());
    assert_eq!(topology(&filled.mesh), (0, 2));
}

#[test]
fn parameters_cannot_select_an_own_energy_without_its_definition() {
    let mesh = cut(&sphere(10), |p| polar(p) < 40.0);
    let error = fill(&mesh, &FillParams::new().with_energy(Energy::Own)).unwrap_err();
    assert!(error.to_string().contains("fill_with"), "{error}");
}
