//! Expected errors of patches on continued sides, from the errors with which the sides predict removed rings of faces.
//!
//! On holes cut out of man-made shapes (exact meshes, and scans with noise of 0.2 to 5 % of an edge) that error is mostly noise of the
//! rings' vertices, which the patch does not have. What the patch has is the error of the fitted sides, whose standard deviation grows with
//! the distance from the vertices to which they are fitted, and a part of what the sides miss beyond the noise.

use glam::DVec3;

use crate::elementary::hypot;
use crate::tuning::{Tunable, tunable};

/// Noise of the rings over the noise of the vertices to which the sides are fitted.
const NOISE: Tunable<f64> = tunable("fill.sides_error.noise", 1.2);
/// Upper bound of the residual over the error on the rings. A larger residual is not noise, which the rings would have too: the sides do
/// not fit.
const MOST_NOISE: Tunable<f64> = tunable("fill.sides_error.most_noise", 2.0);
/// Error of a fitted side over its standard deviation from independent noise.
const OWN: Tunable<f64> = tunable("fill.sides_error.own", 1.5);
/// Error expected in the hole over the rings' error beyond the noise.
const BEYOND_NOISE: Tunable<f64> = tunable("fill.sides_error.beyond_noise", 0.5);
/// Diameters. Lower bound of the expected error of rounded edges: the exact surfaces were known to 0.02 ‰, so smaller errors could not be
/// measured.
const LEAST_OF_ROUNDED: Tunable<f64> = tunable("fill.sides_error.least_of_rounded", 1.6e-5);
/// Standard deviation of rounding to a 32-bit float over the largest coordinate. Both the vertices round the hole and the written ones may
/// be rounded.
const ROUNDING: f64 = 0.35 / (1u64 << 24) as f64;

/// The quantities that determine the expected error of continued sides; lengths in the mesh's unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Predicted {
    /// Root mean square error with which the sides predict the rings.
    pub(super) error: f64,
    /// Root mean square residual of the vertices to which the sides are fitted.
    pub(super) residual: f64,
    /// Its part that is noise.
    pub(super) noise: f64,
}

impl Predicted {
    /// The expected error of the patch where the fitted sides have a standard deviation.
    pub(super) fn expected(&self, deviation: f64) -> f64 {
        let noise = match self.residual <= MOST_NOISE.get() * self.error {
            true => (NOISE.get() * self.noise).min(self.error),
            false => 0.0,
        };
        let beyond = (self.error.powi(2) - noise.powi(2)).max(0.0).sqrt();
        hypot(OWN.get() * deviation, BEYOND_NOISE.get() * beyond)
    }
}

/// The expected error of rounded edges, from their error on the rings and the hole's diameter.
pub(super) fn of_rounded(error: f64, diameter: f64) -> f64 {
    hypot(error, LEAST_OF_ROUNDED.get() * diameter)
}

/// An expected error at a point, increased by the rounding of its coordinates.
pub(super) fn with_rounding(error: f64, at: DVec3) -> f64 {
    hypot(error, ROUNDING * at.abs().max_element())
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXACT: Predicted = Predicted {
        error: 0.01,
        residual: 0.0,
        noise: 0.0,
    };

    #[test]
    fn noise_of_the_rings_is_no_error_of_the_sides() {
        let noisy = Predicted {
            residual: 0.01,
            noise: 0.01,
            ..EXACT
        };
        assert!(noisy.expected(0.0) < 0.5 * EXACT.expected(0.0));
        // The side's own error stays.
        assert!(noisy.expected(0.02) > 0.02);
        // A residual that neighbours share is no noise.
        let wrong = Predicted {
            noise: 0.0,
            ..noisy
        };
        assert_eq!(wrong.expected(0.0), EXACT.expected(0.0));
        // Noise is never more than the whole error.
        let rough = Predicted {
            residual: 1.0,
            noise: 1.0,
            ..EXACT
        };
        assert!(rough.expected(0.0) <= EXACT.error);
    }

    #[test]
    fn nothing_is_surer_than_its_coordinates() {
        let at = DVec3::new(-2000.0, 3.0, 1.0);
        assert!(with_rounding(0.0, at) > 1e-5);
        assert_eq!(with_rounding(0.5, DVec3::ZERO), 0.5);
        assert!(of_rounded(0.0, 2.0) > 1e-5);
    }
}
