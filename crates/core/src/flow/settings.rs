//! Settings of a flow: energy, metric, time step, tolerances.

use serde::{Deserialize, Serialize};

use super::band::{MARGIN, WIDTH};
use crate::tuning::{Tunable, tunable};

/// Voxels across a hole. Finer grids get a κ larger than the given one. On 12 holes of scans 14 left patches 10 % farther
/// from the true surface, one of them 2.4 times as far; 28 changed less than 1 %.
const KAPPA_ACROSS: Tunable<f64> = tunable("flow.kappa_across", 20.0);

/// Radius of redistancing, in voxels: one layer beyond the residual nodes, so that the band's outermost nodes have a distance.
pub(super) const REACH: f64 = WIDTH + MARGIN + 1.0;

/// The energy that a fill minimises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Energy {
    /// `½∫ h²`: exact on spheres, minimal surfaces, Clifford tori and their Möbius images; the most robust.
    #[default]
    Willmore,
    /// `½∫ |∇h|²` along the surface: nearly exact on cylinders and cones too, much closer on ellipsoids, continuous in curvature
    /// across the rim. It is initialised with the steady state of the Willmore energy.
    CurvatureVariation,
    /// A user-defined energy, given to [`Inspection::fill_with`](crate::mend::Inspection::fill_with). It is initialised with the steady
    /// state of the Willmore energy. Reports use this name; parameters cannot select it.
    #[serde(skip_deserializing)]
    Own,
}

/// Approximation of the Hessian in a step. All have the same steady states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Variant {
    /// `L2 M⁻¹ L3`, nonsymmetric: the first scheme of Droske and Rumpf.
    I,
    /// `L3 M⁻¹ L3`: their second scheme.
    II,
    /// `L2 M⁻¹ L2`.
    #[default]
    #[serde(rename = "gauss-newton")]
    GaussNewton,
}

/// Settings of a flow.
#[derive(Clone, Copy, Debug)]
pub struct FlowSettings {
    /// The energy that the flow minimises.
    pub energy: Energy,
    /// The metric of a step of the Willmore flow; the variation of curvature supports only Gauss-Newton.
    pub variant: Variant,
    /// Time step in units of h⁴ (h⁶ for the variation of curvature); infinite to solve for the steady state directly.
    pub time_step: f64,
    /// Maximum number of steps.
    pub max_steps: usize,
    /// Converged when no node within one voxel of the surface moves by more than this, in voxels; or, on rough data, once the
    /// surface hardly moves and its energy no longer changes.
    pub tolerance: f64,
    /// On rough data, after some steps: the largest displacement may be up to this number of tolerances if the root mean square
    /// displacement is within one.
    pub largest_update_factor: f64,
    /// Relative error of the linear solves (relative residual for the variants that are not preconditioned by multigrid).
    pub solver_tolerance: f64,
    /// Initial weight κ of the eikonal term. On nested grids it holds for the finest; the next coarser has half of it, and so on,
    /// but at least 1. It should grow with the number of voxels across a hole: with 1 the surface drifts on fine grids.
    pub kappa: f64,
    /// Inconsistent data: if the initial energy is above this and the first step is long, the flow ends after that step.
    pub highest: f64,
}

impl Default for FlowSettings {
    fn default() -> Self {
        Self {
            energy: Energy::Willmore,
            variant: Variant::GaussNewton,
            time_step: f64::INFINITY,
            max_steps: 20,
            tolerance: 2e-4,
            largest_update_factor: 30.0,
            solver_tolerance: 2e-2,
            kappa: 1.0,
            highest: f64::INFINITY,
        }
    }
}

impl FlowSettings {
    /// Whether the flow proceeds in time instead of directly to the steady state.
    pub(super) fn in_time(&self) -> bool {
        self.time_step.is_finite()
    }

    /// The settings for a hole of `voxels` voxels across: the eikonal weight κ grows with their number beyond 20. With a fixed
    /// weight the surface drifts on fine grids, by a distance of the order of a voxel over κ.
    #[must_use]
    pub fn across(self, voxels: f64) -> Self {
        Self {
            kappa: self.kappa * (voxels / KAPPA_ACROSS.get()).max(1.0),
            ..self
        }
    }
}
