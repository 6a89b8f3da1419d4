//! User-defined bending energies: the integral of a density of mean curvature and position, discretised on a band.
//!
//! `E(φ) = v² Σ_{i ∈ R} χ(φ_i) f(x_i, h_i) / M_i + κ/2 Σ_cells (|∇φ| − 1)²`, `h_i = −r_i / v`
//!
//! where v is the voxel size, and r_i and M_i are as in the Willmore energy ([`super::willmore`]). 1/M_i is the lumped |∇φ|, so
//! by the co-area formula the sum is ∫f dA averaged over the levels in the band. For f = ½h² this is the Willmore energy.

use glam::DVec3;
use rayon::prelude::*;

use super::band::Band;
use super::cells::{Fields, chi, chi_derivative, chunked_sum};
use super::energy::{BandEnergy, Evaluation, Needs};
use super::settings::{Energy, Variant};
use super::system::System;
use super::willmore::{gradient, system, weights};
use crate::grid::{Lattice, SparseGrid, as_point};
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Least second derivative of an energy density in the matrix of a step, relative to the second derivative of ½h². With 0
/// the matrix is singular where a density is linear in h or concave.
const LEAST_SECOND: Tunable<f64> = tunable("flow.least_second", 1e-2);

/// A user-defined energy `∫ f(x, h) dA` of a surface, for [`Inspection::fill_with`](crate::mend::Inspection::fill_with).
///
/// h is the mean curvature as the sum of the principal curvatures, in 1/length, positive where the surface bends away from the
/// side that its normals point to: with outward normals 2/r on a sphere and 1/r on a cylinder of radius r. x is the position, in
/// the mesh's units. Along the rim a patch takes position and normal from its surroundings; under that condition it is a steady
/// state of the energy.
///
/// The energy of Helfrich ("Elastic properties of lipid bilayers: theory and possible experiments", 1973, equation 12) has a
/// spontaneous curvature h₀. Its Gaussian term is omitted because it is constant here:
///
/// ```
/// use isomend::glam::DVec3;
/// use isomend::{BendingEnergy, Density};
///
/// /// `½∫(h − h₀)² dA`.
/// struct Helfrich {
///     /// h₀ in 1/length.
///     spontaneous: f64,
/// }
///
/// impl BendingEnergy for Helfrich {
///     fn density(&self, _: DVec3, h: f64) -> Density {
///         let excess = h - self.spontaneous;
///         Density::new(0.5 * excess * excess, excess, 1.0)
///     }
/// }
/// ```
///
/// The energy is computed on a level set, with the weak mean curvature of Droske and Rumpf ("A level set formulation for Willmore
/// flow", 2004, equation 10) at the nodes of a band five voxels wide. A density cannot depend on derivatives of h or on the
/// Gaussian curvature. Steps are of Gauss-Newton type: few are needed if ∂f/∂h is small at the minimum, more if it is not.
///
/// `examples/own_energy.rs` fills a hole in the wall of a tube with it.
pub trait BendingEnergy: Sync {
    /// f and its derivatives with respect to h at a position. Called for each node of a band in each step, from several threads:
    /// it should be a pure function that takes about 10 ns. A value that is not finite ends the flow, and the hole is closed by
    /// another method.
    fn density(&self, place: DVec3, h: f64) -> Density;
}

/// The density of a [`BendingEnergy`] for one h at one place.
///
/// Its scale matters relative to the term that keeps φ a distance: f″ should be of the order of 1, as for ½h².
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Density {
    /// f, in 1/length². Negative values are allowed but shorten the steps.
    pub value: f64,
    /// ∂f/∂h, in 1/length.
    pub slope: f64,
    /// ∂²f/∂h²; the matrix of a step uses at least 0.01.
    pub second: f64,
}

impl Density {
    /// From f, ∂f/∂h and ∂²f/∂h².
    pub fn new(value: f64, slope: f64, second: f64) -> Self {
        Self {
            value,
            slope,
            second,
        }
    }
}

/// A user-defined energy and the lattice it is evaluated on.
#[derive(Clone, Copy)]
pub struct UserEnergy<'a> {
    /// The energy.
    pub energy: &'a dyn BendingEnergy,
    /// Maps nodes to positions in the mesh's units.
    pub lattice: Lattice,
}

/// A band with a user-defined energy.
pub struct BendingBand<'a> {
    band: Band,
    kappa: f64,
    own: UserEnergy<'a>,
    /// Positions of the band's nodes, in the mesh's units.
    places: Vec<DVec3>,
}

impl<'a> BendingBand<'a> {
    /// The energy on a band of a grid, with the weight κ of the eikonal term.
    pub fn new(own: UserEnergy<'a>, grid: &SparseGrid, band: Band, kappa: f64) -> Self {
        let place = |&slot: &u32| own.lattice.to_world(as_point(grid.node(slot as usize)));
        Self {
            places: band.slots.iter().map(place).collect(),
            band,
            kappa,
            own,
        }
    }

    /// v² f and its first two derivatives with respect to r at a node of R, where h = −r/v.
    fn density(&self, i: usize, r: f64) -> Density {
        let voxel = self.own.lattice.voxel;
        let density = self.own.energy.density(self.places[i], -r / voxel);
        Density {
            value: voxel * voxel * density.value,
            slope: -voxel * density.slope,
            second: density.second.max(LEAST_SECOND.get()),
        }
    }

    /// The densities at the band's nodes; zero outside R.
    fn densities(&self, at: &Evaluation) -> Vec<Density> {
        let of = |i: usize| match self.band.residual[i] {
            true => self.density(i, at.r[i]),
            false => Density::new(0.0, 0.0, 0.0),
        };
        (0..at.r.len()).into_par_iter().map(of).collect_indexed()
    }
}

impl BandEnergy for BendingBand<'_> {
    const NEEDS: Needs = Needs {
        dilations: 1,
        start: &[Energy::Willmore],
        voxel: (1.0, f64::INFINITY),
        edge_ratio: 0.8,
        tolerance: 1.0,
        metrics: &[Variant::GaussNewton],
        fallback: Some(Energy::Willmore),
    };

    fn band(&self) -> &Band {
        &self.band
    }

    fn evaluate(&self, phi: &[f64]) -> Evaluation {
        Evaluation::new(&self.band, phi, self.kappa, |r, mass| {
            chunked_sum(&self.band.residual, |i, &inside| {
                let weight = chi(phi[i]);
                if inside && weight > 0.0 {
                    weight * self.density(i, r[i]).value / mass[i]
                } else {
                    0.0
                }
            })
        })
    }

    fn gradient(&self, phi: &[f64], at: &Evaluation) -> Vec<f64> {
        let densities = self.densities(at);
        // χ ∂(f/M)/∂r and −2 χ ∂(f/M)/∂M; for the Willmore energy these are χw and χw².
        let (force, weighted): (Vec<f64>, Vec<f64>) = (0..phi.len())
            .map(|i| {
                let (weight, mass) = (chi(phi[i]), at.mass[i]);
                let force = weight * densities[i].slope / mass;
                (force, 2.0 * weight * densities[i].value / (mass * mass))
            })
            .unzip();
        let fields = Fields {
            phi,
            weighted: &weighted,
            force: &force,
            kappa: self.kappa,
        };
        gradient(&self.band, &fields, |i| {
            chi_derivative(phi[i]) * densities[i].value / at.mass[i]
        })
    }

    /// The matrix is `BPᵀ diag(χf″/M) BP + ½ L1 + κ L[n⊗n]` for every variant; L1 uses only nodes where f is positive.
    fn system(&self, phi: &[f64], at: &Evaluation, _: Variant, time_step: f64) -> System {
        let densities = self.densities(at);
        let weighted = |i: usize| {
            let value = densities[i].value.max(0.0);
            2.0 * chi(phi[i]) * value / (at.mass[i] * at.mass[i])
        };
        let weighted: Vec<f64> = (0..phi.len()).map(weighted).collect();
        let fields = Fields {
            phi,
            weighted: &weighted,
            force: &[],
            kappa: self.kappa,
        };
        let residual = |i: usize| chi(phi[i]) * densities[i].second / at.mass[i];
        let weights = weights(&self.band, phi, &at.mass, time_step, residual);
        system(&self.band, &fields, Variant::GaussNewton, weights)
    }
}
