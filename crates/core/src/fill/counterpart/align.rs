//! Alignment of sample points of a surface with another surface: iterative closest points, point to plane, with trimming.

use glam::DVec3;
use rayon::prelude::*;

use super::motion::Motion;
use crate::cancel::Cancel;
use crate::elementary;
use crate::linalg::solve_spd;
use crate::mesh::{Mesh, area_vector, face_normal};
use crate::spatial::{Bvh, Closest};
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Lower bound of the cosine between the normals of a sample and its partner: 60°.
const PARTNER_COSINE: Tunable<f64> = tunable("fill.align.partner_cosine", 0.5);
/// Step below which an alignment has converged to rounding, dimensionless: rotation in radians plus translation in spans plus change of
/// scale.
pub(super) const SHORTEST_STEP: f64 = 1e-7;
/// Relative margin for the rounding of a distance that bounds a search.
const NEARLY: f64 = 1e-9;

/// A point of a surface and the unit normal there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
}

/// A surface that samples are aligned with.
pub(super) struct Target<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) bvh: &'a Bvh,
    /// Whether each vertex is on a boundary edge.
    pub(super) border: &'a [bool],
}

/// Parameters of an alignment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Settings {
    /// Upper bound of the iterations.
    pub(super) rounds: usize,
    /// An iteration with a shorter step is the last, as [`SHORTEST_STEP`].
    pub(super) shortest_step: f64,
    /// Fraction of the samples used: those nearest to their partners.
    pub(super) kept: f64,
    /// Whether the scale is an unknown too.
    pub(super) scale: bool,
    /// Tikhonov regularisation: the fraction of the normal matrix's trace that is added to its diagonal. Surfaces that slide on themselves,
    /// such as spheres, make the matrix singular; a larger ridge suppresses motion along poorly determined directions.
    pub(super) ridge: f64,
}

/// The result of an alignment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aligned {
    pub(super) motion: Motion,
    /// See [`distance`]; in the target's unit.
    pub(super) rms: f64,
}

/// A moved sample with its partner: the closest point of the target, and the normal there.
struct Pair {
    at: DVec3,
    partner: DVec3,
    normal: DVec3,
}

impl Target<'_> {
    /// The closest point; `None` if it is on a boundary or the normals differ too much.
    pub(super) fn partner(&self, at: DVec3, normal: DVec3) -> Option<Closest> {
        let closest = self.bvh.closest(at, f64::INFINITY)?;
        self.accepted(&closest, normal).map(|_| closest)
    }

    /// The closest point and its face's normal, unless it is on a boundary or the normals differ too much.
    fn accepted(&self, closest: &Closest, normal: DVec3) -> Option<(DVec3, DVec3)> {
        let own = face_normal(self.mesh, closest.face);
        let is_partner = own.dot(normal) > PARTNER_COSINE.get() && !self.is_on_border(closest);
        is_partner.then_some((closest.point, own))
    }

    /// Whether a closest point is at a boundary vertex, or on an edge between two boundary vertices.
    pub(super) fn is_on_border(&self, closest: &Closest) -> bool {
        let face = self.mesh.faces[closest.face as usize];
        let weights = closest.barycentric;
        let own = || (0..3).filter(|&k| weights[k] != 0.0);
        own().count() < 3 && own().all(|k| self.border[face[k] as usize])
    }

    /// The pairs of samples after a motion. `last` has the closest points of an earlier motion, none at first: their distances bound the
    /// search, and the new ones replace them.
    fn pairs(
        &self,
        samples: &[Sample],
        motion: &Motion,
        last: &mut Vec<Option<DVec3>>,
    ) -> Vec<Pair> {
        last.resize(samples.len(), None);
        let pair = |(s, last): (&Sample, &Option<DVec3>)| {
            let at = motion.at(s.point);
            let limit = last.map_or(f64::INFINITY, |p| p.distance(at) * (1.0 + NEARLY));
            let within = |limit| self.bvh.closest(at, limit);
            let closest = within(limit).or_else(|| within(f64::INFINITY))?;
            let pair = self.accepted(&closest, motion.direction(s.normal));
            let pair = pair.map(|(partner, normal)| Pair {
                at,
                partner,
                normal,
            });
            Some((closest.point, pair))
        };
        let found = samples.par_iter().zip(last.par_iter()).map(pair);
        let found: Vec<_> = found.collect_indexed();
        *last = found.iter().map(|f| f.as_ref().map(|f| f.0)).collect();
        found.into_iter().flatten().filter_map(|f| f.1).collect()
    }

    /// The nearest pairs, up to the fraction `kept` of all samples; `None` if there are fewer than half of that number or fewer than 7, the
    /// number of unknowns. `last` is as for [`Self::pairs`].
    fn nearest(
        &self,
        samples: &[Sample],
        motion: &Motion,
        kept: f64,
        last: &mut Vec<Option<DVec3>>,
    ) -> Option<Vec<Pair>> {
        let mut pairs = self.pairs(samples, motion, last);
        let most = (kept * samples.len() as f64).ceil() as usize;
        if 2 * pairs.len() < most || pairs.len() < 7 {
            return None;
        }
        let square = |p: &Pair| p.at.distance_squared(p.partner);
        pairs.sort_by(|a, b| square(a).total_cmp(&square(b)));
        pairs.truncate(most);
        Some(pairs)
    }
}

/// Aligns samples with a target by iterative closest points from an initial motion: Gauss-Newton steps on the squared point-to-plane
/// distances (Y. Chen, G. Medioni, "Object modelling by registration of multiple range images", 1992), without the farthest pairs
/// (D. Chetverikov et al., "The trimmed iterative closest point algorithm", 2002).
pub(super) fn aligned(
    samples: &[Sample],
    target: &Target,
    start: Motion,
    settings: &Settings,
    cancel: &Cancel,
) -> Aligned {
    let (mut motion, mut last) = (start, Vec::new());
    for _ in 0..settings.rounds {
        if cancel.is_cancelled() {
            break;
        }
        let Some(pairs) = target.nearest(samples, &motion, settings.kept, &mut last) else {
            break;
        };
        let Some((step, size)) = step(&pairs, settings) else {
            break;
        };
        motion = motion.then(&step);
        if size < settings.shortest_step {
            break;
        }
    }
    Aligned {
        rms: distance(samples, target, &motion, settings.kept),
        motion,
    }
}

/// Root mean square point-to-plane distance of the fraction `kept` of the samples, the nearest ones; infinite if too few have partners.
pub(super) fn distance(samples: &[Sample], target: &Target, motion: &Motion, kept: f64) -> f64 {
    match target.nearest(samples, motion, kept, &mut Vec::new()) {
        Some(pairs) if motion.is_finite() => {
            let square = |p: &Pair| (p.at - p.partner).dot(p.normal).powi(2);
            // If fewer samples have partners, each missing one counts with the distance of the farthest pair.
            let most = (kept * samples.len() as f64).ceil();
            let missing = most - pairs.len() as f64;
            let farthest = pairs
                .last()
                .map_or(0.0, |p| p.at.distance_squared(p.partner));
            ((pairs.iter().map(square).sum::<f64>() + missing * farthest) / most).sqrt()
        }
        _ => f64::INFINITY,
    }
}

/// A Gauss-Newton step, and its size as in [`SHORTEST_STEP`]. The span is the root mean square distance of the points from their centre.
fn step(pairs: &[Pair], settings: &Settings) -> Option<(Motion, f64)> {
    let count = pairs.len() as f64;
    let centre = pairs.iter().map(|p| p.at).sum::<DVec3>() / count;
    let spread = pairs
        .iter()
        .map(|p| p.at.distance_squared(centre))
        .sum::<f64>();
    let span = (spread / count).sqrt();
    if span <= 0.0 || !span.is_finite() {
        return None;
    }
    // Normal equations for the rotation vector, the translation in spans, and the change of scale.
    let n = if settings.scale { 7 } else { 6 };
    let (mut matrix, mut rhs) = (vec![0.0; n * n], vec![0.0; n]);
    for pair in pairs {
        let arm = (pair.at - centre) / span;
        let (turn, m) = (arm.cross(pair.normal), pair.normal);
        let row = [turn.x, turn.y, turn.z, m.x, m.y, m.z, arm.dot(m)];
        let residual = (pair.at - pair.partner).dot(m) / span;
        for i in 0..n {
            rhs[i] -= row[i] * residual;
            for j in 0..n {
                matrix[i * n + j] += row[i] * row[j];
            }
        }
    }
    let trace: f64 = (0..n).map(|i| matrix[i * n + i]).sum();
    (0..n).for_each(|i| matrix[i * n + i] += settings.ridge * trace);
    if !solve_spd(&mut matrix, &mut rhs) {
        return None;
    }
    // The motion about the centre; the change of scale is clamped to ±20 % for stability.
    let (turn, shift) = (DVec3::from_slice(&rhs), DVec3::from_slice(&rhs[3..6]));
    let scale = 1.0 + rhs.get(6).copied().unwrap_or(0.0).clamp(-0.2, 0.2);
    let rotation = elementary::rotation(turn) * scale;
    let step = Motion::about(rotation, centre, centre + shift * span);
    let size = turn.length() + shift.length() + (scale - 1.0).abs();
    step.is_finite().then_some((step, size))
}

/// Samples of a surface, evenly distributed by area; at most `count`.
pub(super) fn samples(mesh: &Mesh, count: usize) -> Vec<Sample> {
    let areas = (0..mesh.faces.len() as u32).map(|f| 0.5 * area_vector(mesh.corners(f)).length());
    let areas: Vec<f64> = areas.map(|a| if a.is_finite() { a } else { 0.0 }).collect();
    let total: f64 = areas.iter().sum();
    let step = total / count as f64;
    let (mut sum, mut samples) = (0.0, Vec::with_capacity(count));
    for (f, area) in areas.iter().enumerate() {
        sum += area;
        while (samples.len() as f64 + 0.5) * step < sum && samples.len() < count {
            // The R2 low-discrepancy sequence (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018), folded into
            // the triangle.
            let i = samples.len() as f64;
            let (mut u, mut v) = ((0.754_877_666 * i).fract(), (0.569_840_291 * i).fract());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let [a, b, c] = mesh.corners(f as u32);
            samples.push(Sample {
                point: a + (b - a) * u + (c - a) * v,
                normal: face_normal(mesh, f as u32),
            });
        }
    }
    samples
}
