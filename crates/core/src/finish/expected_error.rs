//! The expected error of a patch: how far the true surface may be from it.
//!
//! The kriging deviation depends on the positions of the data and on the kernel. It predicts where in a hole, and in which holes,
//! the error is large. On 80 holes cut out of eleven real meshes that were kriged, the logarithms of a hole's true error and of
//! its deviation correlated by 0.82; with the error on the ring by 0.72, with the spread of the candidates by 0.74, and neither
//! added to the deviation. Where nothing could be kriged (48 holes) the best predictor is the error on the ring over the length
//! of an edge, an error of slope. In both cases patches that bend more have larger errors than these predict. The exponents are
//! from regressions over these holes, rounded; the factors are such that 0.70 of all vertices of a mean hole are within σ of the
//! truth and 0.92 within 2 σ. Where the candidates of the blend differ, their spread is added: on few holes they are farther apart than
//! these predict.

use glam::DVec3;
use rayon::prelude::*;

use super::candidates::{Continuation, Kriged};
use super::geometry::corners;
use super::large;
use super::patch::Patch;
use crate::elementary::{hypot, powf};
use crate::mesh::area_vector;
use crate::tuning::tuning;

/// The expected error of each moving vertex, in the patch's units. Whether the shape is the blend of the surfaces: else it is the
/// minimum, and the others were refused.
pub(super) fn expected_error(
    patch: &Patch,
    shape: &[DVec3],
    surfaces: &[Continuation],
    is_blend: bool,
) -> Vec<f64> {
    let rules = &tuning().finish;
    let bend = bend(patch, shape);
    let best = surfaces
        .iter()
        .filter(|s| s.found.weight > 0.0)
        .filter_map(|s| s.kriged.as_ref().map(|k| (s.found.weight, k)))
        .reduce(|a, b| if b.0 > a.0 { b } else { a });
    let by_kriging = best.and_then(|(_, kriged)| by_kriging(patch, shape, kriged));
    let (factor, values) = match by_kriging {
        Some(values) => (
            rules.kriged_error * powf(bend, rules.kriged_error_bend),
            values,
        ),
        None => {
            let error = surfaces.first().and_then(|s| s.found.ring_error);
            let slope = error.map_or(tuning().finish.median_slope, |e| e / patch.edge);
            let factor = rules.ring_error
                * powf(bend, rules.ring_error_bend)
                * powf(slope, rules.ring_error_slope);
            let part = match is_blend && large::is_continued(surfaces) {
                true => rules.large_error,
                false => 1.0,
            };
            (part * factor, by_depth(patch))
        }
    };
    let unit = factor * patch.diameter;
    let deviation = match is_blend {
        true => candidate_deviation(shape, surfaces),
        false => vec![0.0; shape.len()],
    };
    values
        .iter()
        .zip(deviation)
        .map(|(v, s)| hypot(unit * v, s))
        .collect()
}

/// Weighted standard deviation of the candidate surfaces from the final shape, at each moving vertex.
fn candidate_deviation(shape: &[DVec3], surfaces: &[Continuation]) -> Vec<f64> {
    let mut squares = vec![0.0; shape.len()];
    for surface in surfaces.iter().filter(|s| s.found.weight > 0.0) {
        for ((sum, own), p) in squares.iter_mut().zip(&surface.shape).zip(shape) {
            *sum += surface.found.weight * own.distance_squared(*p);
        }
    }
    squares.into_iter().map(f64::sqrt).collect()
}

/// Shape of the error over the vertices from kriging: `d̄ᵖ √((d/d̄)² + f²)` with deviations d and their root mean square d̄.
/// `None` if the deviations are not finite, as after a cancellation.
fn by_kriging(patch: &Patch, shape: &[DVec3], kriged: &Kriged) -> Option<Vec<f64>> {
    let deviation = |p: &DVec3| match patch.cancel.is_cancelled() {
        true => f64::NAN,
        false => kriged.kriging.deviation(kriged.chart.coordinates(*p).0),
    };
    let deviations: Vec<f64> = shape.par_iter().map(deviation).collect();
    let squares: f64 = deviations.iter().map(|d| d * d).sum();
    let mean = (squares / deviations.len() as f64).sqrt();
    if mean == 0.0 {
        return Some(deviations);
    }
    let scale = powf(mean, tuning().finish.kriged_error_deviation);
    let value = |d: &f64| scale * hypot(d / mean, tuning().finish.kriged_error_floor);
    mean.is_finite()
        .then(|| deviations.iter().map(value).collect())
}

/// Shape of the error over the vertices without kriging: it grows with the distance from the rim.
fn by_depth(patch: &Patch) -> Vec<f64> {
    let depth = patch.depth();
    let finite = depth.iter().copied().filter(|d| d.is_finite());
    let deepest = finite.fold(f64::MIN_POSITIVE, f64::max);
    depth
        .iter()
        .map(|d| hypot((d / deepest).min(1.0), tuning().finish.ring_error_floor))
        .collect()
}

/// How much a patch bends: 1 − |Σ A n| / Σ A over its faces; 0 for a flat patch.
fn bend(patch: &Patch, shape: &[DVec3]) -> f64 {
    let points = patch.closure_points(shape);
    let (mut sum, mut area) = (DVec3::ZERO, 0.0);
    for &face in &patch.closure.patch_faces {
        let vector = area_vector(corners(&points, face));
        sum += vector;
        area += vector.length();
    }
    (1.0 - sum.length() / area).clamp(0.0, 1.0)
}
