//! How a flow is run.

use serde::{Deserialize, Serialize};

use super::band::{MARGIN, WIDTH};
use crate::tuning::tuning;

/// How far out redistancing goes, in voxels: one layer more, so that the band's outermost nodes have their distance.
pub(super) const REACH: f64 = WIDTH + MARGIN + 1.0;

/// The energy whose steady state a fill is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Energy {
    /// `½∫ h²`: exact on spheres, minimal surfaces, Clifford tori and their Möbius images, and the most robust.
    #[default]
    Willmore,
    /// `½∫ |∇h|²` along the surface: nearly exact on cylinders and cones too, much closer on ellipsoids, continuous in
    /// curvature across the rim. It starts from the steady state of the Willmore energy.
    CurvatureVariation,
    /// One of the caller's, by [`Inspection::fill_with`](crate::Inspection::fill_with). It starts from the steady state of the Willmore
    /// energy. Reports name it so; no parameters can ask for it.
    #[serde(skip_deserializing)]
    Own,
}

/// Which approximation of the Hessian a step uses. All share their steady states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Variant {
    /// `L2 M⁻¹ L3`, nonsymmetric: the paper's first scheme.
    I,
    /// `L3 M⁻¹ L3`: the paper's second scheme.
    II,
    /// `L2 M⁻¹ L2`.
    #[default]
    #[serde(rename = "gauss-newton")]
    GaussNewton,
}

/// How the flow is run.
#[derive(Clone, Copy, Debug)]
pub struct FlowSettings {
    /// The energy that the flow minimises.
    pub energy: Energy,
    /// The metric of a step of the Willmore flow; the variation of curvature knows Gauss-Newton alone.
    pub variant: Variant,
    /// Time step in units of h⁴ (h⁶ with the variation of curvature); infinite for the steady state at once.
    pub time_step: f64,
    /// Most steps to take.
    pub max_steps: usize,
    /// Converged when no node within one voxel of the surface moves by more than this, in voxels; or, on rough data, once
    /// the surface hardly moves and its energy has settled.
    pub tolerance: f64,
    /// On rough data, after some steps, no node may move by more than so many tolerances, while their root mean square is within
    /// one.
    pub rough: f64,
    /// Relative error of the linear solves (relative residual, for the variants that are not preconditioned by multigrid).
    pub solver_tolerance: f64,
    /// Weight κ of the eikonal term to begin with; on nested grids that of the finest, half of it on the next, but at
    /// least 1. It should grow with the number of voxels across: with 1 the surface drifts on fine grids.
    pub kappa: f64,
    /// Where the energy at the start is more than this, and the first step long, the flow is over after it: the data contradict
    /// each other.
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
            rough: 30.0,
            solver_tolerance: 2e-2,
            kappa: 1.0,
            highest: f64::INFINITY,
        }
    }
}

impl FlowSettings {
    /// Whether the flow goes through time instead of to the steady state.
    pub(super) fn in_time(&self) -> bool {
        self.time_step.is_finite()
    }

    /// The same for a hole of so many voxels across: the eikonal weight κ grows with their number beyond 20. At a fixed
    /// weight the surface drifts on fine grids, by a distance of the order of a voxel over κ.
    #[must_use]
    pub fn across(self, voxels: f64) -> Self {
        Self {
            kappa: self.kappa * (voxels / tuning().flow.kappa_across).max(1.0),
            ..self
        }
    }
}
