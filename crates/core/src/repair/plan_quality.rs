//! How good the result of a plan of a repair is.

use super::faults::Faults;
use super::witness::{DOUBTFUL_DIFFERENCE, DOUBTFUL_LOSS};
use crate::tuning::{Tunable, tunable};

/// A plan is given up where it has lost as many times what the best one lost.
const RETURNED: Tunable<f64> = tunable("repair.returned", 2.0);

/// Fraction of area or of volume. A plan that loses more is taken only if all others do.
pub(super) const DESTROYED: Tunable<f64> = tunable("repair.destroyed", 0.1);

/// How good the result of a plan is; less is better, the first field that differs decides.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(super) struct PlanQuality {
    /// Whether a part of the shape is lost that nobody would miss knowingly.
    pub(super) destroys: bool,
    /// Whether it has faults, or its shape is doubtful.
    pub(super) is_wrong: bool,
    pub(super) faults: Faults,
    /// Components and handles that the cleaned mesh does not have.
    pub(super) made: usize,
    /// Fraction of the input's area cut out.
    pub(super) lost: f64,
    /// One minus the agreement with the input's solid.
    pub(super) differs: f64,
}

impl PlanQuality {
    /// Whether no faces intersect, and all edges and vertices are manifold.
    pub(super) fn is_clean(&self) -> bool {
        self.faults.intersecting_or_not_manifold() == 0
    }

    /// Whether only the area lost is doubtful.
    pub(super) fn is_tolerable(&self) -> bool {
        self.is_clean() && !self.destroys && !self.has_another_solid()
    }

    /// Fraction of the input's area. The result of a plan that has lost more after a pass is not better; none where it may be.
    pub(super) fn bound(&self) -> Option<f64> {
        let least = match (self.is_wrong, self.destroys) {
            (_, true) => DESTROYED.get(),
            (true, _) => DOUBTFUL_LOSS.get(),
            _ => 0.0,
        };
        // Later passes may bring the surface back to where faces were cut out.
        match self.faults == Faults::default() {
            true => Some(RETURNED.get() * self.lost.max(least)),
            // A plan without faults may lose more, but not as much as destroys the shape.
            false => (!self.destroys).then(|| RETURNED.get() * DESTROYED.get()),
        }
    }

    /// Whether the solid is doubtful.
    pub(super) fn has_another_solid(&self) -> bool {
        self.differs > DOUBTFUL_DIFFERENCE.get()
    }
}
