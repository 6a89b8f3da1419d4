//! Expected errors of patches on continued sides, from the errors with which the sides predict rings that were taken out.
//!
//! On 109 patches of holes cut out of man-made shapes (exact meshes, and scans with noise of 0.2 to 5 % of an edge) that error is mostly the
//! noise of the rings' own vertices, which the sides do not have. The rest are the sides' own errors: errors of fits to a number
//! of vertices that grows as the edges get shorter.

use glam::DVec3;

/// Residuals of the sides that count as noise of the rings.
const NOISE: f64 = 1.2;
/// Errors on the rings. A larger residual is no noise, which the rings would have too, but where the sides do not fit.
const MOST_NOISE: f64 = 2.0;
/// Part of that noise that a fitted side has itself, over the root of the edge's length in diameters: a single plane, and several sides.
const OWN_OF_PLANE: f64 = 0.35;
const OWN: f64 = 0.9;
/// Part of the error beyond the noise that is expected in the hole.
const BEYOND_NOISE: f64 = 0.8;
/// Diameters. Least expected error of rounded edges: errors below could not be measured, since the exact surfaces were known to 0.02 ‰.
const LEAST_OF_ROUNDED: f64 = 1.6e-5;
/// Error of a coordinate of 32 bits, over the largest coordinate: the vertices round the hole are rounded to that, and so is what is written.
const ROUNDING: f64 = 0.35 / (1u64 << 24) as f64;

/// What the expected error of continued sides depends on; lengths in the mesh's units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Predicted {
    /// Root mean square error with which the sides predict the rings.
    pub(super) error: f64,
    /// Root mean square residual of the vertices that the sides are fitted to.
    pub(super) residual: f64,
    /// Mean length of the rim's edges over the hole's diameter.
    pub(super) edge: f64,
    /// Whether there is one side, and that is a plane.
    pub(super) is_flat: bool,
}

impl Predicted {
    /// The expected error of the patch.
    pub(super) fn expected(&self) -> f64 {
        let noise = match self.residual <= MOST_NOISE * self.error {
            true => (NOISE * self.residual).min(self.error),
            false => 0.0,
        };
        let beyond = (self.error.powi(2) - noise.powi(2)).max(0.0).sqrt();
        let own = if self.is_flat { OWN_OF_PLANE } else { OWN };
        let own = noise * (own * self.edge.sqrt()).min(1.0);
        own.hypot(BEYOND_NOISE * beyond)
    }
}

/// The expected error of rounded edges in a hole of a diameter, from their error on the rings.
pub(super) fn of_rounded(error: f64, diameter: f64) -> f64 {
    error.hypot(LEAST_OF_ROUNDED * diameter)
}

/// The expected error at a point, from the expected errors of its coordinates.
pub(super) fn with_rounding(error: f64, at: DVec3) -> f64 {
    error.hypot(ROUNDING * at.abs().max_element())
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXACT: Predicted = Predicted {
        error: 0.01,
        residual: 0.0,
        edge: 0.1,
        is_flat: false,
    };

    #[test]
    fn noise_of_the_rings_is_no_error_of_the_sides() {
        let noisy = Predicted {
            residual: 0.01,
            ..EXACT
        };
        assert!(noisy.expected() < 0.5 * EXACT.expected());
        let flat = Predicted {
            is_flat: true,
            ..noisy
        };
        assert!(flat.expected() < noisy.expected());
        let fine = Predicted {
            edge: 0.02,
            ..noisy
        };
        assert!(fine.expected() < noisy.expected());
        // Noise is never more than the whole error.
        let rough = Predicted {
            residual: 1.0,
            ..EXACT
        };
        assert!(rough.expected() <= EXACT.error);
    }

    #[test]
    fn nothing_is_surer_than_its_coordinates() {
        let at = DVec3::new(-2000.0, 3.0, 1.0);
        assert!(with_rounding(0.0, at) > 1e-5);
        assert_eq!(with_rounding(0.5, DVec3::ZERO), 0.5);
        assert!(of_rounded(0.0, 2.0) > 1e-5);
    }
}
