//! The blend of candidate surfaces, weighted by their errors on rings of known vertices (ring test).

use glam::DVec3;
use rayon::prelude::*;

use super::candidates::{Continuation, Models, candidates, models};
use super::large;
use super::params::{FinishMethod, FinishParams};
use super::patch::{Patch, test_rings};
use super::report::{Candidate, Refusal};
use super::willmore::minimise;
use crate::elementary::powf;
use crate::threads::CollectFiltered;
use crate::tuning::{Tunable, tunable};

/// Diameters. Lower bound of an error on the rings.
const LEAST_RING_ERROR: Tunable<f64> = tunable("finish.least_ring_error", 1e-6);

/// Fraction of a continuation's error on a ring. After the noise of the ring's vertices is subtracted, at least this
/// fraction remains.
const LEAST_OWN_ERROR: Tunable<f64> = tunable("finish.least_own_error", 0.3);

/// Exponent: weights are the inverse of this power of the error on the rings. Inverse squares would have the least
/// variance if errors were uncorrelated, but errors on the ring and in the hole are correlated: on 143 holes of scans the
/// error was 0.7 % lower than with 2; 6 differed by 0.1 %.
const SHARPNESS: Tunable<i32> = tunable("finish.sharpness", 4);

/// Prior weight of a kriged surface in the blend: there are up to two, and they are nearly alike.
const ALIKE_WEIGHT: Tunable<f64> = tunable("finish.alike_weight", 0.5);

/// Mean edges. Upper bound of the width of the ring around a large patch.
const WIDEST_RING: Tunable<f64> = tunable("finish.widest_ring", 4.0);

/// Widths of that ring. Vertices deeper in a large patch than this stay at the energy's minimum.
const BLEND_DEPTH: Tunable<f64> = tunable("finish.blend_depth", 2.0);

/// The candidate surfaces and their blend `Σ w e⁻⁴ x / Σ w e⁻⁴`. The errors `e` are measured on rings of known vertices around
/// the hole that are deleted and refilled.
pub(super) fn blend(
    patch: &Patch,
    minimum: &[DVec3],
    params: &FinishParams,
) -> (Vec<Continuation>, Result<Vec<DVec3>, Refusal>) {
    // Why there is no blend by the ring test, if there is none: not requested, or too many vertices.
    let is_large = minimum.len() > params.most_blended;
    let reason = match (params.method, is_large) {
        (FinishMethod::Willmore, _) => Some(Refusal::NotRequested),
        (FinishMethod::Auto, true) => Some(Refusal::TooLarge),
        (FinishMethod::Auto, false) => None,
    };
    let others = reason.is_none();
    let is_continued = reason == Some(Refusal::TooLarge);
    // Without other surfaces the ring test serves the expected error of the patch, and refuses the continuation of a large one: one
    // ring is enough.
    let rings = &test_rings()[if others { 0 } else { 1 }..];
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
    let surfaces_of = |patch: &Patch, minimum: &[DVec3], given: &Models| {
        let mut all = candidates(patch, minimum, others, given, params);
        let continuation = is_continued.then(|| large::continuation(patch, minimum, params));
        all.extend(continuation.flatten());
        all
    };
    let own = || surfaces_of(patch, minimum, &Models::new());
    let (mut surfaces, refilled) = rayon::join(own, || {
        rings.par_iter().filter_map(refill).collect_filtered()
    });
    if patch.cancel.is_cancelled() {
        return (surfaces, Err(Refusal::Stopped));
    }
    // The wider holes get the same candidates, kriged with the models estimated for the hole itself. The error of a candidate is
    // its distance from the deleted vertices along their normals, in diameters.
    let given = models(&surfaces);
    let ring_errors = refilled
        .par_iter()
        .map(|(ring, shape)| ring.errors(patch, &surfaces_of(&ring.wider, shape, &given)));
    let ring_errors: Vec<Errors> = ring_errors.collect();
    if patch.cancel.is_cancelled() {
        return (surfaces, Err(Refusal::Stopped));
    }
    if ring_errors.is_empty() && !is_continued {
        return (surfaces, Err(reason.unwrap_or(Refusal::NoRing)));
    }
    // Converts errors to weights, and averages the surfaces if there are others than the minimum.
    if !ring_errors.is_empty() {
        weigh(&mut surfaces, &ring_errors);
    }
    if is_continued {
        large::share(&mut surfaces);
    }
    let blended = match reason {
        Some(Refusal::TooLarge) if large::is_continued(&surfaces) => {
            Ok(combined(patch, minimum, &surfaces, params))
        }
        Some(reason) => Err(reason),
        None if surfaces.len() == 1 => Err(Refusal::NoChart),
        None => Ok(combined(patch, minimum, &surfaces, params)),
    };
    (surfaces, blended)
}

/// Sets the error of each surface (the geometric mean of its errors on the rings) and its weight (from these errors without the
/// noise of the rings). A surface that has no error on one of the rings gets no weight.
fn weigh(surfaces: &mut [Continuation], ring_errors: &[Errors]) {
    let noise = noise_deviation(surfaces);
    let mut sum = 0.0;
    for Continuation { found, kriged, .. } in surfaces.iter_mut() {
        let on = |errors: &Errors| {
            let own = errors.iter().find(|e| e.0 == found.candidate);
            own.map(|e| e.1)
        };
        let errors: Option<Vec<f64>> = ring_errors.iter().map(on).collect();
        let mean = |of: &dyn Fn(f64) -> f64| {
            let errors = errors.as_ref()?;
            let product: f64 = errors
                .iter()
                .map(|e| of(*e).max(LEAST_RING_ERROR.get()))
                .product();
            Some(powf(product, 1.0 / errors.len() as f64))
        };
        found.ring_error = mean(&|e| e);
        let is_one_of_alike = kriged.is_some() || found.chart.is_some();
        let prior = if is_one_of_alike {
            ALIKE_WEIGHT.get()
        } else {
            1.0
        };
        let error = mean(&|e| without_noise(e, noise));
        found.weight = error.map_or(0.0, |e| prior * e.powi(-SHARPNESS.get()));
        sum += found.weight;
    }
    surfaces.iter_mut().for_each(|s| s.found.weight /= sum);
}

/// The standard deviation of the noise of the known vertices: the smallest estimate of the krigings, 0 if there are none.
fn noise_deviation(surfaces: &[Continuation]) -> f64 {
    let kriged = surfaces.iter().filter_map(|s| s.kriged.as_ref());
    let deviations = kriged.map(|k| k.kriging.noise_deviation());
    deviations
        .filter(|n| n.is_finite())
        .reduce(f64::min)
        .unwrap_or(0.0)
}

/// Removes the noise of the ring's own vertices from an error on that ring. The noise is the same for all surfaces and would
/// level their weights.
fn without_noise(error: f64, noise: f64) -> f64 {
    let squared = error.powi(2) - noise.powi(2);
    squared.max((LEAST_OWN_ERROR.get() * error).powi(2)).sqrt()
}

/// The weighted mean of the surfaces; displacements from the energy's minimum are scaled down to the allowed maximum.
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

/// Faces. A vertex with more is a hub: its curvature depends on all vertices around it, so that the energy's matrix is dense there.
/// Refilling 10,000 vertices around one took 40 s. Poles of spheres have up to 64.
const MOST_FACES_OF_VERTEX: u32 = 100;

/// Marks the hubs of a patch and the vertices next to them.
fn at_hubs(patch: &Patch) -> Vec<bool> {
    let mut count = vec![0u32; patch.points.len()];
    let corners = patch.faces.iter().flatten();
    corners.for_each(|&v| count[v as usize] += 1);
    let is_hub = |v: &u32| count[*v as usize] > MOST_FACES_OF_VERTEX;
    let mut at_hub = vec![false; count.len()];
    for face in patch.faces.iter().filter(|f| f.iter().any(is_hub)) {
        face.iter().for_each(|&v| at_hub[v as usize] = true);
    }
    at_hub
}

/// The error of each surface on a ring, in diameters of the hole.
type Errors = Vec<(Candidate, f64)>;

/// A ring of known vertices around a hole, and the wider hole without them.
struct Ring {
    vertices: Vec<u32>,
    wider: Patch,
}

impl Ring {
    /// The known vertices closer to the hole than `reach` (in diameters and in mean edges, whichever is longer), except those on
    /// an open border and those at a hub. In a large patch only a strip along the rim is refilled with them. `None` if there are no
    /// such vertices or nothing remains around them.
    fn new(patch: &Patch, reach: (f64, f64), minimum: &[DVec3], is_large: bool) -> Option<Self> {
        let reach = (reach.0 * patch.diameter).max(reach.1 * patch.edge);
        let widest = if is_large {
            WIDEST_RING.get() * patch.edge
        } else {
            f64::INFINITY
        };
        let reach = reach.min(widest);
        let at_hub = at_hubs(patch);
        let inside = |&v: &u32| {
            let i = v as usize;
            patch.known[i] && !patch.border[i] && !at_hub[i] && patch.distance[i] < reach
        };
        let vertices: Vec<u32> = (0..patch.points.len() as u32).filter(inside).collect();
        let wider = patch.enlarged(&vertices, minimum, BLEND_DEPTH.get() * widest);
        let is_one = !vertices.is_empty() && !wider.rim.is_empty();
        is_one.then_some(Self { vertices, wider })
    }

    /// Root mean square distance along the normals between the ring's vertices and each refill.
    fn errors(&self, patch: &Patch, refills: &[Continuation]) -> Errors {
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
        refills
            .iter()
            .map(|s| (s.found.candidate, error(s)))
            .collect()
    }
}
