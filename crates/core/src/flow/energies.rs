//! Dispatch from an [`Energy`] to its implementation. To add an energy, add a line here and in [`Energy`], and a file of its own.

use super::bending::{BendingBand, UserEnergy};
use super::energy::{BandEnergy, Needs};
use super::outcome::FlowOutcome;
use super::pull::Pull;
use super::settings::{Energy, FlowSettings};
use super::steady::relax_with;
use super::variation::VariationBand;
use super::willmore::WillmoreBand;
use crate::grid::SparseGrid;

impl Energy {
    /// The requirements of an energy on the solver.
    pub(crate) fn needs(self) -> &'static Needs {
        match self {
            Self::Willmore => &WillmoreBand::NEEDS,
            Self::CurvatureVariation => &VariationBand::NEEDS,
            Self::Own => &BendingBand::NEEDS,
        }
    }
}

/// Lets `phi` flow on the masked nodes to the steady state, for at most `max_steps` steps. `pull` attracts it to a given surface;
/// `own` is the energy for [`Energy::Own`]. If `keep_going` returns false the flow ends early.
///
/// A step solves `A d = −∇E`, clips `d` to one voxel at each node and is halved until the energy falls. κ is raised if steps
/// grow.
pub fn relax(
    grid: &SparseGrid,
    phi: &mut Vec<f64>,
    mask: &[bool],
    settings: &FlowSettings,
    own: Option<UserEnergy>,
    pull: Option<&Pull>,
    keep_going: &dyn Fn() -> bool,
) -> FlowOutcome {
    match (settings.energy, own) {
        (Energy::CurvatureVariation, _) => {
            let make = VariationBand::new;
            relax_with(make, grid, phi, mask, settings, pull, keep_going)
        }
        (Energy::Own, Some(own)) => {
            let make = |band, kappa| BendingBand::new(own, grid, band, kappa);
            relax_with(make, grid, phi, mask, settings, pull, keep_going)
        }
        (Energy::Willmore | Energy::Own, _) => {
            let make = WillmoreBand::new;
            relax_with(make, grid, phi, mask, settings, pull, keep_going)
        }
    }
}
