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
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Factor of the expected error of a large patch that has a continuation: on 32 rims of 16 defects of a skull 0.74 of the vertices of
/// a patch were nearer to the bone than 0.6 of the expected error without it, 0.95 than twice this.
const LARGE_ERROR: Tunable<f64> = tunable("finish.large_error", 0.6);

/// Slope error on the ring of a median patch; used where no ring could be tested.
const MEDIAN_SLOPE: Tunable<f64> = tunable("finish.median_slope", 0.25);

/// Factor `a` of the expected error `a bᵏ d̄ᵖ √((d/d̄)² + f²)`, where `d` is the kriging standard deviation, `d̄` its
/// mean and `b` the bend: a regression over 80 holes of eleven meshes, fitted so that in the mean hole 0.70 of the
/// vertices are closer to the true surface than the expected error.
const KRIGED_ERROR: Tunable<f64> = tunable("finish.kriged_error", 0.25);

/// Exponent `k` in the same formula.
const KRIGED_ERROR_BEND: Tunable<f64> = tunable("finish.kriged_error_bend", 0.15);

/// Exponent `p` in the same formula.
const KRIGED_ERROR_DEVIATION: Tunable<f64> = tunable("finish.kriged_error_deviation", 0.65);

/// Floor `f` in the same formula.
const KRIGED_ERROR_FLOOR: Tunable<f64> = tunable("finish.kriged_error_floor", 0.33);

/// Factor `a` of the expected error `a bᵏ sᵖ √(u² + f²)`, where `s` is the slope error on the ring and `u` the depth;
/// used where nothing could be kriged: a regression over 48 holes.
const RING_ERROR: Tunable<f64> = tunable("finish.ring_error", 0.13);

/// Exponent `k` in that formula.
const RING_ERROR_BEND: Tunable<f64> = tunable("finish.ring_error_bend", 0.2);

/// Exponent `p` in that formula.
const RING_ERROR_SLOPE: Tunable<f64> = tunable("finish.ring_error_slope", 0.45);

/// Floor `f` in that formula.
const RING_ERROR_FLOOR: Tunable<f64> = tunable("finish.ring_error_floor", 0.15);

/// The expected error of each moving vertex, in the patch's units. Whether the shape is the blend of the surfaces: else it is the
/// minimum, and the others were refused.
pub(super) fn expected_error(
    patch: &Patch,
    shape: &[DVec3],
    surfaces: &[Continuation],
    is_blend: bool,
) -> Vec<f64> {
    let bend = bend(patch, shape);
    let best = surfaces
        .iter()
        .filter(|s| s.found.weight > 0.0)
        .filter_map(|s| s.kriged.as_ref().map(|k| (s.found.weight, k)))
        .reduce(|a, b| if b.0 > a.0 { b } else { a });
    let by_kriging = best.and_then(|(_, kriged)| by_kriging(patch, shape, kriged));
    let (factor, values) = match by_kriging {
        Some(values) => (
            KRIGED_ERROR.get() * powf(bend, KRIGED_ERROR_BEND.get()),
            values,
        ),
        None => {
            let error = surfaces.first().and_then(|s| s.found.ring_error);
            let slope = error.map_or(MEDIAN_SLOPE.get(), |e| e / patch.edge);
            let factor = RING_ERROR.get()
                * powf(bend, RING_ERROR_BEND.get())
                * powf(slope, RING_ERROR_SLOPE.get());
            let part = match is_blend && large::is_continued(surfaces) {
                true => LARGE_ERROR.get(),
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
    let deviations: Vec<f64> = shape.par_iter().map(deviation).collect_indexed();
    let squares: f64 = deviations.iter().map(|d| d * d).sum();
    let mean = (squares / deviations.len() as f64).sqrt();
    if mean == 0.0 {
        return Some(deviations);
    }
    let scale = powf(mean, KRIGED_ERROR_DEVIATION.get());
    let value = |d: &f64| scale * hypot(d / mean, KRIGED_ERROR_FLOOR.get());
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
        .map(|d| hypot((d / deepest).min(1.0), RING_ERROR_FLOOR.get()))
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
