//! Kriging of residuals: corrects a side's plane or quadric by simple kriging of its vertices' distances.
//!
//! Signed distances of the vertices from the sheet are modelled as a random field with a Matérn covariance of order 5/2 (M. L.
//! Stein, "Interpolation of Spatial Data", 1999, section 2.7) and white noise. Range and noise maximise the likelihood, and the
//! field is used only if it is clearly more likely than noise alone. Far from the vertices the field is zero and the sheet is
//! unchanged.

use glam::DVec3;

use crate::elementary::{exp, ln};
use crate::linalg::Cholesky;
use crate::tuning::{Tunable, tunable};

/// Maximum number of vertices for the prediction: the cost of each likelihood grows with its cube.
const MOST: Tunable<usize> = tunable("creases.residuals.most", 150);
/// Minimum number of vertices.
const FEWEST: Tunable<usize> = tunable("creases.residuals.fewest", 20);
/// Residuals below this fraction of an edge are rounding errors.
const ROUNDING: f64 = 1e-4;
/// Candidate ranges of the covariance, in diameters of the hole.
const RANGES: [f64; 3] = [0.4, 0.8, 1.6];
/// Candidate noise variances, as fractions of the field's variance.
const NOISES: [f64; 4] = [1e-6, 1e-3, 3e-2, 0.3];
/// Minimum gain in log-likelihood over noise alone.
const GAIN: Tunable<f64> = tunable("creases.residuals.gain", 10.0);

/// A random field of signed distances.
#[derive(Clone, Debug)]
pub(super) struct Residuals {
    points: Vec<DVec3>,
    weights: Vec<f64>,
    range: f64,
}

impl Residuals {
    /// Fits a field to the distances of some points, which are sorted from the hole outwards; `None` if they are noise. Lengths
    /// are in the mesh's units.
    pub(super) fn fit(
        points: &[DVec3],
        distances: &[f64],
        diameter: f64,
        edge: f64,
    ) -> Option<Self> {
        let count = points.len();
        let square = distances.iter().map(|d| d * d).sum::<f64>() / count.max(1) as f64;
        if count < FEWEST.get() || square.sqrt() < ROUNDING * edge {
            return None;
        }
        // Half of the points from next to the hole, the others evenly from the rest.
        let near = count.min(MOST.get() / 2);
        let step = (count - near).div_ceil(MOST.get() - near).max(1);
        let chosen = (0..near).chain((near..count).step_by(step));
        let chosen: Vec<usize> = chosen.collect();
        let points: Vec<DVec3> = chosen.iter().map(|&i| points[i]).collect();
        let values: Vec<f64> = chosen.iter().map(|&i| distances[i]).collect();
        let n = points.len() as f64;
        // The log-likelihood of noise alone, then of each range and noise.
        let square = values.iter().map(|d| d * d).sum::<f64>() / n;
        let alone = -0.5 * n * ln(square);
        let mut best: Option<(f64, Self)> = None;
        for range in RANGES.map(|r| r * diameter) {
            for noise in NOISES {
                let Some((likelihood, weights)) = solve(&points, &values, range, noise) else {
                    continue;
                };
                if best.as_ref().is_none_or(|b| likelihood > b.0) {
                    let field = Self {
                        points: points.clone(),
                        weights,
                        range,
                    };
                    best = Some((likelihood, field));
                }
            }
        }
        let (likelihood, field) = best?;
        (likelihood - alone > GAIN.get()).then_some(field)
    }

    /// The predicted signed distance between the side and its sheet at a point.
    pub(super) fn at(&self, point: DVec3) -> f64 {
        let of = |(p, w): (&DVec3, &f64)| w * covariance(p.distance(point) / self.range);
        self.points.iter().zip(&self.weights).map(of).sum()
    }

    /// The gradient of the predicted distance.
    pub(super) fn gradient(&self, point: DVec3) -> DVec3 {
        let of = |(p, w): (&DVec3, &f64)| {
            let apart = point - *p;
            *w * slope(apart.length() / self.range) / (self.range * self.range) * apart
        };
        self.points.iter().zip(&self.weights).map(of).sum()
    }
}

/// The log-likelihood (up to a constant) of values of a field with a given range and relative noise and the most likely variance;
/// and the weights of simple kriging.
fn solve(points: &[DVec3], values: &[f64], range: f64, noise: f64) -> Option<(f64, Vec<f64>)> {
    let n = points.len();
    let mut matrix = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..i {
            matrix[i * n + j] = covariance(points[i].distance(points[j]) / range);
        }
        matrix[i * n + i] = 1.0 + noise;
    }
    let factor = Cholesky::new(&matrix, n)?;
    let mut weights = values.to_vec();
    factor.solve(&mut weights);
    let square = weights.iter().zip(values).map(|(w, v)| w * v).sum::<f64>() / n as f64;
    let likelihood = -0.5 * n as f64 * ln(square) - 0.5 * factor.log_determinant();
    likelihood.is_finite().then_some((likelihood, weights))
}

/// The Matérn covariance of order 5/2 for a distance in ranges.
fn covariance(distance: f64) -> f64 {
    let d = 5f64.sqrt() * distance;
    (1.0 + d + d * d / 3.0) * exp(-d)
}

/// The derivative of the covariance with respect to the distance, divided by the distance.
fn slope(distance: f64) -> f64 {
    let d = 5f64.sqrt() * distance;
    -5.0 / 3.0 * (1.0 + d) * exp(-d)
}
