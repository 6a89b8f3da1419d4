//! The finish of a patch on its own triangles.
//!
//! The level set finds the surface and its topology; here its vertices, and nothing else, are moved to the minimum of the same
//! energy under the exact rim, and then towards what the surroundings foretell, as far as that proves itself next to the hole:
//!
//! 1. Gauss-Newton for the discrete Willmore energy `½ Σ m h²`, from the patch as it is and, where that is slow or folds, from
//!    the biharmonic fill of the same triangles; of a large patch a strip along the rim is filled so first.
//! 2. Other continuations: universal kriging of heights over a sphere or plane fitted to the surroundings, kernel and noise by
//!    restricted likelihood; the triharmonic fill; where the patch bends little, the biharmonic one.
//! 3. A ring test: rings of known vertices are deleted and refilled; the error there tells what each continuation is worth.
//! 4. The blend of all by the inverse fourth powers of these errors.
//! 5. Safeguards: what has more folded faces, a higher energy, or moved too far, is refused, and the step before kept.
//!
//! Everything is computed relative to the rim's middle and diameter, so that neither unit nor place matter, and in an order
//! that depends on the mesh alone. The work depends on the size of the patch and its surroundings, not on that of the mesh.

use crate::tuning::tuning;

mod biharmonic;
mod blend;
mod candidates;
mod chart;
mod collar;
mod expected_error;
mod geometry;
mod grain;
mod kriging;
mod offset_field;
mod params;
mod patch;
mod report;
mod surroundings;
#[cfg(test)]
mod tests;
mod willmore;

use glam::DVec3;

pub(crate) use grain::grain;
pub(crate) use offset_field::{OffsetDatum, OffsetField};
pub use params::{FinishMethod, FinishParams};
pub use report::{
    Candidate, CandidateFound, ChartKind, FinishFound, FinishResult, Finished, Refusal, Restart,
};
pub use surroundings::Surroundings;

use patch::{Located, Patch};
use willmore::Second;

/// Finishes the patch of some vertices (in any order), which must hang together (see [`Surroundings::pieces`]). Whatever cannot
/// be finished keeps its positions, to the bit, and [`FinishFound`] says why; so it is where the token of the surroundings is
/// set.
pub fn finish(around: &Surroundings<'_>, vertices: &[u32], params: &FinishParams) -> Finished {
    let vertices = usable(around, vertices);
    let mut finished = Finished {
        positions: vertices.iter().map(|&v| around.position(v)).collect(),
        minimum: Vec::new(),
        expected_error: vec![f64::NAN; vertices.len()],
        found: FinishFound {
            vertices: vertices.len(),
            ..FinishFound::default()
        },
        vertices,
    };
    match located(around, &finished.vertices, params) {
        Ok(located) => run(&located, params, &mut finished),
        Err(refusal) => finished.found.willmore_refused = Some(refusal),
    }
    finished
}

/// `½ ∫ h²` of the patch of some vertices, `h` being the sum of the principal curvatures; it does not depend on the unit.
///
/// # Errors
/// When no face uses the vertices, there are too many, or nothing that stays, or no finite shape, is round them.
pub fn willmore_energy(around: &Surroundings<'_>, vertices: &[u32]) -> Result<f64, Refusal> {
    let located = located(around, &usable(around, vertices), &FinishParams::default())?;
    Ok(willmore::energy(&located.patch, &located.patch.shape()))
}

/// The number of faces of the patch of some vertices that are folded over: that look against the normals at all three of their
/// vertices.
///
/// # Errors
/// As [`willmore_energy`].
pub fn folds(around: &Surroundings<'_>, vertices: &[u32]) -> Result<usize, Refusal> {
    let located = located(around, &usable(around, vertices), &FinishParams::default())?;
    Ok(willmore::folds(&located.patch, &located.patch.shape()))
}

/// The biharmonic fill of the patch of some vertices, given (rising) with their new positions: it takes the triangles alone, not
/// their shape, and continues position and slope of the rim. The second start for what cannot be found by a level set. One pair of vertex
/// and position in units of the mesh for each vertex that a face uses (Botsch and Kobbelt 2004).
///
/// # Errors
/// As [`willmore_energy`], and when the system cannot be solved or the token is set ([`Refusal::Singular`]).
pub fn biharmonic(
    around: &Surroundings<'_>,
    vertices: &[u32],
) -> Result<Vec<(u32, DVec3)>, Refusal> {
    linear(around, vertices, biharmonic::biharmonic)
}

/// The surface of least area with the rim and the triangles of the patch of some vertices, which are given (rising) with their new
/// positions: a tight, nearly flat cap (Pinkall and Polthier 1993).
///
/// # Errors
/// As [`biharmonic()`].
pub fn minimal_surface(
    around: &Surroundings<'_>,
    vertices: &[u32],
) -> Result<Vec<(u32, DVec3)>, Refusal> {
    linear(around, vertices, biharmonic::minimal)
}

fn linear(
    around: &Surroundings<'_>,
    vertices: &[u32],
    fill: impl Fn(&Patch, &[DVec3]) -> Option<Vec<DVec3>>,
) -> Result<Vec<(u32, DVec3)>, Refusal> {
    let vertices = usable(around, vertices);
    let located = located(around, &vertices, &FinishParams::default())?;
    let shape = fill(&located.patch, &located.patch.shape()).ok_or(Refusal::Singular)?;
    let outward = shape.iter().map(|p| located.outward(*p));
    Ok(vertices.into_iter().zip(outward).collect())
}

/// The vertices that faces use, rising, each once.
fn usable(around: &Surroundings<'_>, vertices: &[u32]) -> Vec<u32> {
    let used = vertices.iter().copied().filter(|&v| around.is_used(v));
    let mut used: Vec<u32> = used.collect();
    used.sort_unstable();
    used.dedup();
    used
}

fn located(
    around: &Surroundings<'_>,
    vertices: &[u32],
    params: &FinishParams,
) -> Result<Located, Refusal> {
    if vertices.is_empty() {
        return Err(Refusal::NoVertices);
    }
    if vertices.len() > params.most_vertices {
        return Err(Refusal::TooLarge);
    }
    Located::new(around, vertices)
}

fn run(located: &Located, params: &FinishParams, finished: &mut Finished) {
    let patch = &located.patch;
    let start = patch.shape();
    let found = &mut finished.found;
    found.diameter = located.scale;
    found.edge = patch.edge * located.scale;
    found.folds_before = willmore::folds(patch, &start);
    found.folds_after = found.folds_before;
    let mut shape = minimum(patch, &start, params, found);
    if patch.cancel.is_cancelled() {
        finished.set_stopped();
        return;
    }
    let (surfaces, blended) = blend::blend(patch, &shape, params);
    if patch.cancel.is_cancelled() {
        finished.set_stopped();
        return;
    }
    let checked = blended.and_then(|b| match flaw(patch, &b, &shape, params.farthest) {
        Some(refusal) => Err(refusal),
        None => Ok(b),
    });
    match checked {
        Ok(blended) => {
            if found.result == FinishResult::Willmore {
                finished.minimum = shape.iter().map(|p| located.outward(*p)).collect();
            }
            shape = blended;
            found.result = FinishResult::Blend;
        }
        Err(refusal) => found.blend_refused = Some(refusal),
    }
    for surface in &surfaces {
        let mut one = surface.found.clone();
        one.ring_error = one.ring_error.map(|e| e * located.scale);
        found.candidates.push(one);
    }
    let expected_error = expected_error::expected_error(patch, &shape, &surfaces);
    if patch.cancel.is_cancelled() {
        finished.set_stopped();
        return;
    }
    finished.expected_error = expected_error.iter().map(|s| s * located.scale).collect();
    let mean = finished.expected_error.iter().sum::<f64>() / finished.expected_error.len() as f64;
    found.mean_expected_error = mean.is_finite().then_some(mean);
    let largest = finished.expected_error.iter().copied().fold(0.0, f64::max);
    found.largest_expected_error = found.mean_expected_error.map(|_| largest);
    if found.result == FinishResult::Unchanged {
        return;
    }
    found.folds_after = willmore::folds(patch, &shape);
    let ways = shape.iter().zip(&start).map(|(a, b)| a.distance(*b));
    found.largest_move = ways.fold(0.0, f64::max) * located.scale;
    finished.positions = shape.iter().map(|p| located.outward(*p)).collect();
}

/// The minimum of the energy, or the start where that is refused.
fn minimum(
    patch: &Patch,
    start: &[DVec3],
    params: &FinishParams,
    found: &mut FinishFound,
) -> Vec<DVec3> {
    let (mut minimum, second) = willmore::lowest(patch, params);
    if willmore::folds(patch, &minimum.shape) > found.folds_before
        && let Some(shape) = willmore::unfolded(patch, &minimum.shape, found.folds_before)
    {
        minimum.energy = willmore::energy(patch, &shape);
        minimum.shape = shape;
    }
    found.steps = minimum.steps;
    found.converged = minimum.last <= params.tolerance;
    found.energy_before = minimum.energy_before;
    found.energy_after = minimum.energy_before;
    found.restart = match second {
        Second::NotNeeded => Restart::NotNeeded,
        Second::Worse => Restart::Tried,
        Second::Better => Restart::Taken,
    };
    let rose = minimum.energy > minimum.energy_before * tuning().finish.energy_rise;
    found.willmore_refused = if !minimum.energy_before.is_finite() {
        Some(Refusal::NotFinite)
    } else {
        let is_much_lower =
            found.converged && minimum.energy < tuning().finish.much_lower * minimum.energy_before;
        let farthest = if is_much_lower {
            f64::INFINITY
        } else {
            params.farthest
        };
        let flaw = flaw(patch, &minimum.shape, start, farthest);
        flaw.or(rose.then_some(Refusal::EnergyRose))
    };
    if found.willmore_refused.is_some() {
        return start.to_vec();
    }
    found.energy_after = minimum.energy;
    found.result = FinishResult::Willmore;
    minimum.shape
}

/// Why a shape is refused in favour of the one before; `farthest` bounds the displacement of a vertex, in diameters.
fn flaw(patch: &Patch, shape: &[DVec3], before: &[DVec3], farthest: f64) -> Option<Refusal> {
    if !shape.iter().all(|p| p.is_finite()) {
        return Some(Refusal::NotFinite);
    }
    let ways = shape.iter().zip(before).map(|(a, b)| a.distance(*b));
    if ways.fold(0.0, f64::max) > farthest * patch.diameter {
        return Some(Refusal::MovedTooFar);
    }
    (willmore::folds(patch, shape) > willmore::folds(patch, before)).then_some(Refusal::Folded)
}
