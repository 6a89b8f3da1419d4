//! The kriged candidate of a large patch: the ring test does not decide its weight.

use super::candidates::{Continuation, ModelChoice, attached, kriged_over};
use super::chart::Chart;
use super::collar::Collar;
use super::params::FinishParams;
use super::patch::Patch;
use super::report::Candidate;
use crate::tuning::tuning;

/// The continuation of a large patch: kriging of heights over a sphere that fits the faces next to the rim, with the kernel of order 2, a
/// thin plate bent from this sphere. The data next to the rim often have smoother kernels as the more likely ones; across a wide hole these
/// follow slopes and curvatures at the rim too far. Only vertices that face this sphere are data: within the width of a collar, the surface
/// around a wide hole may turn back, as a skull does at its base. `None` if nothing can be kriged.
pub(super) fn continuation(
    patch: &Patch,
    minimum: &[glam::DVec3],
    params: &FinishParams,
) -> Option<Continuation> {
    let rules = &tuning().finish;
    let normals = patch.known_normals();
    let next_to_rim = Collar::new(patch, rules.large_chart, params.most_data);
    let vertices = &next_to_rim.vertices;
    let chart = Chart::new(patch, minimum, vertices, &normals, rules.largest_sphere)?;
    let faces_chart = |v: u32| {
        let i = v as usize;
        normals[i].dot(chart.normal(patch.points[i])) > rules.large_facing
    };
    let collar = Collar::of(patch, rules.large_collar, params.most_data, faces_chart);
    if patch.cancel.is_cancelled() || collar.vertices.len() < rules.fewest_data {
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

/// Whether surfaces are the minimum of a large patch and its continuation: the latter has no error on rings.
pub(super) fn is_continued(surfaces: &[Continuation]) -> bool {
    matches!(surfaces, [_, c] if c.found.weight > 0.0 && c.found.ring_error.is_none())
}

/// Sets the weights of the minimum of a large patch and of its continuation, if there is one. The ring test tells the rim apart, not the
/// middle of a wide hole, so the weights are fixed.
pub(super) fn share(surfaces: &mut [Continuation]) {
    if let [minimum, continuation] = surfaces {
        let part = tuning().finish.large_kriged;
        (minimum.found.weight, continuation.found.weight) = (1.0 - part, part);
    }
}
