//! Sums of angles without an arctangent for each.

use std::f64::consts::PI;

use crate::elementary::atan2;

/// A sum of angles in (−π, π], as the product of complex numbers with these arguments and the number of turns: one arctangent for all.
pub(super) struct Angles {
    real: f64,
    imaginary: f64,
    turns: f64,
}

impl Angles {
    pub(super) fn new() -> Self {
        Self {
            real: 1.0,
            imaginary: 0.0,
            turns: 0.0,
        }
    }

    /// Adds the angle of which these are the multiples of sine and cosine.
    #[inline]
    pub(super) fn add(&mut self, sine: f64, cosine: f64) {
        let scale = 1.0 / (sine.abs() + cosine.abs());
        // A point in a corner or on an edge sees no angle.
        if !scale.is_normal() {
            return;
        }
        let (x, y) = (cosine * scale, sine * scale);
        let real = self.real * x - self.imaginary * y;
        let imaginary = self.real * y + self.imaginary * x;
        let [before, with, after] =
            [self.imaginary, y, imaginary].map(|part| part.is_sign_negative());
        if before == with && after != with {
            self.turns += if after { 1.0 } else { -1.0 };
        }
        // Each factor is between 0.7 and 1.
        let size = real.abs() + imaginary.abs();
        let rescale = if size < 1e-100 { 1e100 } else { 1.0 };
        (self.real, self.imaginary) = (real * rescale, imaginary * rescale);
    }

    pub(super) fn sum(&self) -> f64 {
        atan2(self.imaginary, self.real) + 2.0 * PI * self.turns
    }
}
