//! What the surroundings foretell, weighted by how well it foretold rings of what is known.

use glam::DVec3;
use rayon::prelude::*;

use super::candidates::{Continuation, Models, candidates, models};
use super::params::{FinishMethod, FinishParams};
use super::patch::{Patch, rings_tried};
use super::report::{Candidate, Refusal};
use super::willmore::minimise;
use crate::tuning::tuning;

/// The blend of the energy's minimum with what else the patch may be, `Σ w e⁻⁴ x / Σ w e⁻⁴` with their errors `e` on rings of known
/// vertices that are deleted and refilled; and the surfaces that it is made of.
pub(super) fn blend(
    patch: &Patch,
    minimum: &[DVec3],
    params: &FinishParams,
) -> (Vec<Continuation>, Result<Vec<DVec3>, Refusal>) {
    // Why there is no blend, if there is none: not asked for, or too many vertices to krige.
    let is_large = minimum.len() > params.most_blended;
    let reason = if params.method == FinishMethod::Willmore {
        Some(Refusal::NotAsked)
    } else if is_large {
        Some(Refusal::TooLarge)
    } else {
        None
    };
    let others = reason.is_none();
    // Without other surfaces the error only says how sure the patch is, for which one ring is enough.
    let rings = &rings_tried()[if others { 0 } else { 1 }..];
    // Deletes a ring of known vertices and minimises the energy on the wider hole.
    let refill = |&reach: &(f64, f64)| {
        let ring = Ring::new(patch, reach, minimum, is_large)?;
        if patch.cancel.is_cancelled() {
            return None;
        }
        let wider = &ring.wider;
        let shape = minimise(wider, &wider.shape(), params).shape;
        Some((ring, shape))
    };
    let (mut surfaces, refilled) = rayon::join(
        || candidates(patch, minimum, others, &Models::new(), params),
        || rings.par_iter().filter_map(refill).collect::<Vec<_>>(),
    );
    if patch.cancel.is_cancelled() {
        return (surfaces, Err(Refusal::Stopped));
    }
    // The wider holes get the same candidates, kriged with the models estimated for the hole itself. The error of each is
    // its distance from the deleted vertices along their normals, in diameters.
    let given = models(&surfaces);
    let tries = refilled.par_iter().map(|(ring, shape)| {
        let tried = candidates(&ring.wider, shape, others, &given, params);
        ring.errors(patch, &tried)
    });
    let tries: Vec<Errors> = tries.collect();
    if patch.cancel.is_cancelled() {
        return (surfaces, Err(Refusal::Stopped));
    }
    if tries.is_empty() {
        return (surfaces, Err(reason.unwrap_or(Refusal::NoRing)));
    }
    // Errors become weights, and the surfaces are averaged if there is more than the minimum.
    weigh(&mut surfaces, &tries);
    let blended = match reason {
        Some(reason) => Err(reason),
        None if surfaces.len() == 1 => Err(Refusal::NoChart),
        None => Ok(combined(patch, minimum, &surfaces, params)),
    };
    (surfaces, blended)
}

/// Sets the error of each surface, the geometric mean of its errors on the rings, and its weight, from these errors without the noise of
/// the rings. A surface that has no error on one of the rings gets no weight.
fn weigh(surfaces: &mut [Continuation], tries: &[Errors]) {
    let noise = noise_deviation(surfaces);
    let mut sum = 0.0;
    for Continuation { found, kriged, .. } in surfaces.iter_mut() {
        let on = |errors: &Errors| {
            let own = errors.iter().find(|e| e.0 == found.candidate);
            own.map(|e| e.1)
        };
        let errors: Option<Vec<f64>> = tries.iter().map(on).collect();
        let mean = |of: &dyn Fn(f64) -> f64| {
            let errors = errors.as_ref()?;
            let product: f64 = errors
                .iter()
                .map(|e| of(*e).max(tuning().finish.least_ring_error))
                .product();
            Some(product.powf(1.0 / errors.len() as f64))
        };
        found.ring_error = mean(&|e| e);
        let is_one_of_alike = kriged.is_some() || found.chart.is_some();
        let prior = if is_one_of_alike {
            tuning().finish.alike_weight
        } else {
            1.0
        };
        let error = mean(&|e| without_noise(e, noise));
        found.weight = error.map_or(0.0, |e| prior * e.powi(-tuning().finish.sharpness));
        sum += found.weight;
    }
    surfaces.iter_mut().for_each(|s| s.found.weight /= sum);
}

/// The standard deviation of the noise of the known vertices: the least that a kriging estimates. 0 where none is kriged.
fn noise_deviation(surfaces: &[Continuation]) -> f64 {
    let kriged = surfaces.iter().filter_map(|s| s.kriged.as_ref());
    let deviations = kriged.map(|k| k.kriging.noise_deviation());
    deviations
        .filter(|n| n.is_finite())
        .reduce(f64::min)
        .unwrap_or(0.0)
}

/// The error of a continuation from its error on a ring whose own vertices are noisy. That noise is the same for all surfaces, and would
/// make their weights alike.
fn without_noise(error: f64, noise: f64) -> f64 {
    let squared = error.powi(2) - noise.powi(2);
    squared
        .max((tuning().finish.least_own_error * error).powi(2))
        .sqrt()
}

/// The weighted mean of the surfaces, not farther from the energy's minimum than is allowed.
fn combined(
    patch: &Patch,
    minimum: &[DVec3],
    surfaces: &[Continuation],
    params: &FinishParams,
) -> Vec<DVec3> {
    let mut shift = vec![DVec3::ZERO; minimum.len()];
    for surface in surfaces {
        for ((s, x), m) in shift.iter_mut().zip(&surface.shape).zip(minimum) {
            *s += surface.found.weight * (*x - *m);
        }
    }
    let farthest = shift.iter().map(|s| s.length()).fold(0.0, f64::max);
    let most = params.farthest_blended * patch.diameter;
    let part = if farthest > most {
        most / farthest
    } else {
        1.0
    };
    minimum
        .iter()
        .zip(&shift)
        .map(|(m, s)| *m + part * *s)
        .collect()
}

/// The error of each surface on a ring, in diameters.
type Errors = Vec<(Candidate, f64)>;

/// Known vertices next to a hole, and the hole without them.
struct Ring {
    vertices: Vec<u32>,
    wider: Patch,
}

impl Ring {
    /// The known vertices nearer to the hole than `reach`, in diameters and in mean edges, but none on a border; none where there
    /// are none, or nothing is left round them. Of a large patch what is beside the rim is refilled with them.
    fn new(patch: &Patch, reach: (f64, f64), minimum: &[DVec3], is_large: bool) -> Option<Self> {
        let reach = (reach.0 * patch.diameter).max(reach.1 * patch.edge);
        let widest = if is_large {
            tuning().finish.widest_ring * patch.edge
        } else {
            f64::INFINITY
        };
        let reach = reach.min(widest);
        let inside = |&v: &u32| {
            let i = v as usize;
            patch.known[i] && !patch.border[i] && patch.distance[i] < reach
        };
        let vertices: Vec<u32> = (0..patch.points.len() as u32).filter(inside).collect();
        let wider = patch.enlarged(&vertices, minimum, tuning().finish.blend_depth * widest);
        let is_one = !vertices.is_empty() && !wider.rim.is_empty();
        is_one.then_some(Self { vertices, wider })
    }

    /// Root mean square of the distance along the normal between the ring and what surfaces have in its place.
    fn errors(&self, patch: &Patch, tried: &[Continuation]) -> Errors {
        let normals = super::geometry::vertex_normals(&patch.points, &patch.faces);
        let moving = &self.wider.closure;
        let place = |v: u32| {
            let own = |m: &u32| moving.vertices[*m as usize] < v;
            moving.moving.partition_point(own)
        };
        let error = |surface: &Continuation| {
            let square = |&v: &u32| {
                let i = v as usize;
                let way = surface.shape[place(v)] - patch.points[i];
                way.dot(normals[i]).powi(2)
            };
            (self.vertices.iter().map(square).sum::<f64>() / self.vertices.len() as f64).sqrt()
        };
        tried
            .iter()
            .map(|s| (s.found.candidate, error(s)))
            .collect()
    }
}
