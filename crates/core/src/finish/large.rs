//! The kriged candidate of a large patch: the ring test may refuse it, and does not decide its weight.

use super::candidates::{Continuation, ModelChoice, attached, kriged_over};
use super::candidates::{FEWEST_DATA, LARGEST_SPHERE};
use super::chart::Chart;
use super::collar::Collar;
use super::params::FinishParams;
use super::patch::Patch;
use super::report::Candidate;
use crate::tuning::{Tunable, tunable};

/// Weight of the kriged surface of a large patch; the energy's minimum has the rest. On 16 defects of a skull the Dice coefficient of
/// the implant was 0.939 with the minimum alone and 0.944 with 0.6.
const LARGE_KRIGED: Tunable<f64> = tunable("finish.large_kriged", 0.6);

/// Errors of the minimum. A continuation with a larger error on the ring of known vertices is refused. On 35 rims of defects of a skull
/// it had 0.8 to 1.5 times the error of the minimum, except two; on the top of a torus 970 times, where the blend was off by 4.5
/// thousandths of the diameter instead of 0.05.
const WORST_RING: Tunable<f64> = tunable("finish.worst_ring", 1.7);

/// Diameters. Error on the ring of a continuation that cannot be made there: it is kept where the minimum has a similar error, as two rims
/// of a skull with 0.003, and refused on smooth surfaces, as the neck of a catenoid (20 thousandths of the diameter instead of 0.3).
const UNTESTED_RING: Tunable<f64> = tunable("finish.untested_ring", 2.5e-3);

/// Diameters. Width of the collar to which the sphere of a large patch is fitted.
const LARGE_CHART: Tunable<f64> = tunable("finish.large_chart", 0.15);

/// Diameters. Width of the collar from which the data of a large patch are taken. On 13 defects of a skull the
/// Dice coefficient of the kriged surface alone differed by 0.001 in the mean with 0.2.
const LARGE_COLLAR: Tunable<f64> = tunable("finish.large_collar", 0.12);

/// Least cosine between the normal of a datum of a large patch and the direction of the chart: 60°.
const LARGE_FACING: Tunable<f64> = tunable("finish.large_facing", 0.5);

/// The continuation of a large patch: kriging of heights over a sphere that fits the faces next to the rim, with the kernel of order 2, a
/// thin plate bent from this sphere. The data next to the rim often have smoother kernels as the more likely ones; across a wide hole these
/// follow slopes and curvatures at the rim too far. Only vertices that face this sphere are data: within the width of a collar, the surface
/// around a wide hole may turn back, as a skull does at its base. `None` if nothing can be kriged.
pub(super) fn continuation(
    patch: &Patch,
    minimum: &[glam::DVec3],
    params: &FinishParams,
) -> Option<Continuation> {
    let normals = patch.known_normals();
    let next_to_rim = Collar::new(patch, LARGE_CHART.get(), params.most_data);
    let vertices = &next_to_rim.vertices;
    let chart = Chart::new(patch, minimum, vertices, &normals, LARGEST_SPHERE.get())?;
    let faces_chart = |v: u32| {
        let i = v as usize;
        normals[i].dot(chart.normal(patch.points[i])) > LARGE_FACING.get()
    };
    let collar = Collar::of(patch, LARGE_COLLAR.get(), params.most_data, faces_chart);
    if patch.cancel.is_cancelled() || collar.vertices.len() < FEWEST_DATA.get() {
        return None;
    }
    let lifted = kriged_over(
        chart,
        patch,
        minimum,
        &collar,
        ModelChoice::Orders(&[2]),
        params,
    )?;
    let mut attached = attached(patch, vec![(Candidate::Sphere, lifted)]);
    // Deviations of this many vertices take too long: the expected error is predicted as for a patch without kriging.
    attached.pop().map(|c| Continuation { kriged: None, ..c })
}

/// Whether surfaces are the minimum of a large patch and its continuation, which was not refused: it alone has a chart without its kriging.
pub(super) fn is_continued(surfaces: &[Continuation]) -> bool {
    let is_kept = |c: &Continuation| c.found.weight > 0.0 && c.found.chart.is_some();
    matches!(surfaces, [_, c] if is_kept(c) && c.kriged.is_none())
}

/// Sets the weights of the minimum of a large patch and of its continuation, if there is one. The ring test tells the rim apart, not the
/// middle of a wide hole: it only refuses a continuation.
pub(super) fn share(surfaces: &mut [Continuation]) {
    if let [minimum, continuation] = surfaces {
        let (own, other) = (minimum.found.ring_error, continuation.found.ring_error);
        let is_worse = |a: f64| other.unwrap_or(UNTESTED_RING.get()) > WORST_RING.get() * a;
        let is_refused = own.is_some_and(is_worse);
        let part = if is_refused { 0.0 } else { LARGE_KRIGED.get() };
        (minimum.found.weight, continuation.found.weight) = (1.0 - part, part);
    }
}
