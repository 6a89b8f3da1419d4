//! Finishing: moves the vertices of a patch to the minimum of the Willmore energy and blends it with kriging.
//!
//! The level set finds the surface and its topology. Here only the vertices of the patch move, without new triangles: first to
//! the minimum of the same energy under the exact rim, then towards a continuation of the surroundings, as far as a test next to
//! the hole supports it:
//!
//! 1. Gauss-Newton for the discrete Willmore energy `½ Σ m h²`, from the patch as it is and, if that is slow or folds, from the
//!    biharmonic fill of the same triangles; for a large patch, a strip along the rim gets a biharmonic fill first.
//! 2. Other candidates: universal kriging of heights over a sphere or plane fitted to the surroundings, with kernel and noise by
//!    restricted likelihood; the triharmonic fill; where the patch bends little, the biharmonic fill.
//! 3. A ring test: rings of known vertices are deleted and refilled; the error there measures each candidate.
//! 4. The blend of all candidates, weighted by the inverse fourth powers of these errors. A large patch has the minimum and one kriged
//!    continuation, with fixed weights, unless the rings refuse it.
//! 5. Safeguards: a result with more folded faces, a higher energy, or too large displacements is refused, and the one before kept.
//!
//! All lengths are relative to the rim's middle and diameter, so results depend neither on the unit nor on the position of the
//! mesh, and the order of computation depends only on the mesh. The work depends on the size of the patch and its surroundings,
//! not of the whole mesh.

mod biharmonic;
mod blend;
mod candidates;
mod chart;
mod collar;
mod expected_error;
mod folds;
mod geometry;
mod grain;
mod kriging;
mod large;
mod normal_matrix;
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
    Candidate, CandidateRecord, ChartKind, FinishRecord, FinishResult, Finished, Refusal,
    SecondInitialisation,
};
pub use surroundings::Surroundings;

use patch::{Located, Patch};

use crate::tuning::{Tunable, tunable};

/// Upper bound of E_minimum / E_before: a minimum with a higher energy is refused.
const ENERGY_RISE: Tunable<f64> = tunable("finish.energy_rise", 1.02);

/// Ratio of energies. A converged minimum below this fraction of the energy before it is taken however far it moved.
/// Where the biharmonic fill is below this fraction of a minimum's energy, it is the second initialisation. The level set
/// bulges over holes in walls thinner than 0.35 diameters: two of 300 holes of scans and models were of this kind; their
/// error fell from 165 to 2.6 ‰ of the diameter.
const MUCH_LOWER: Tunable<f64> = tunable("finish.much_lower", 0.5);

/// Diameters. Width of the collar from which data are taken. On 12 holes of scans 0.32 made patches 4 % worse, 0.63
/// changed less than 1 %.
const COLLAR: Tunable<f64> = tunable("finish.collar", 0.45);

/// Finishes the patch of some vertices (in any order), which must be connected (see [`Surroundings::patches`]). A patch that
/// cannot be finished keeps its positions bit for bit, and [`FinishRecord`] has the reason; the same holds if the token of the
/// surroundings is set.
pub fn finish(around: &Surroundings<'_>, vertices: &[u32], params: &FinishParams) -> Finished {
    let vertices = usable(around, vertices);
    let mut finished = Finished {
        positions: vertices.iter().map(|&v| around.position(v)).collect(),
        minimum: Vec::new(),
        expected_error: vec![f64::NAN; vertices.len()],
        found: FinishRecord {
            vertices: vertices.len(),
            ..FinishRecord::default()
        },
        vertices,
    };
    match located(around, &finished.vertices, params) {
        Ok(located) => run(&located, params, &mut finished),
        Err(refusal) => finished.found.willmore_refused = Some(refusal),
    }
    finished
}

/// `½ ∫ h²` of the patch of some vertices, where `h` is the sum of the principal curvatures; independent of the unit.
///
/// # Errors
/// If no face uses the vertices, there are too many, the surroundings have no fixed vertices, or the shape is not finite.
pub fn willmore_energy(around: &Surroundings<'_>, vertices: &[u32]) -> Result<f64, Refusal> {
    let located = located(around, &usable(around, vertices), &FinishParams::default())?;
    Ok(willmore::energy(&located.patch, &located.patch.shape()))
}

/// The number of folded faces in the patch of some vertices: faces that point against the normals at all three of their vertices.
///
/// # Errors
/// As [`willmore_energy`].
pub fn folds(around: &Surroundings<'_>, vertices: &[u32]) -> Result<usize, Refusal> {
    let located = located(around, &usable(around, vertices), &FinishParams::default())?;
    Ok(folds::folds(&located.patch, &located.patch.shape()))
}

/// The biharmonic fill of the patch of some vertices, which are given in rising order and returned with their new positions. It
/// uses only the triangulation, not the shape, and continues position and slope at the rim. It is the alternative initialisation
/// for holes that the level set cannot fill. One pair of vertex and position (in units of the mesh) for each vertex that a face
/// uses (Botsch and Kobbelt 2004).
///
/// # Errors
/// As [`willmore_energy`], and [`Refusal::Singular`] if the system cannot be solved or the token is set.
pub fn biharmonic(
    around: &Surroundings<'_>,
    vertices: &[u32],
) -> Result<Vec<(u32, DVec3)>, Refusal> {
    linear(around, vertices, biharmonic::biharmonic)
}

/// The surface of least area with the rim and the triangulation of the patch of some vertices, which are given in rising order
/// and returned with their new positions: a tight, nearly flat cap (Pinkall and Polthier 1993).
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

/// The vertices that faces use, in rising order, without repetitions.
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

/// Finishes a patch: energy minimum, blend, expected error. Writes everything to `finished`.
fn run(located: &Located, params: &FinishParams, finished: &mut Finished) {
    let patch = &located.patch;
    let start = patch.shape();
    let found = &mut finished.found;
    found.diameter = located.scale;
    found.edge = patch.edge * located.scale;
    found.folds_before = folds::folds(patch, &start);
    found.folds_after = found.folds_before;
    if patch.cancel.is_cancelled() {
        finished.set_stopped();
        return;
    }
    // The minimum of the energy.
    let mut shape = minimum(patch, &start, params, found);
    if patch.cancel.is_cancelled() {
        finished.set_stopped();
        return;
    }
    // The blend replaces the minimum if it has no flaw.
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
    // Report and expected error, in units of the mesh.
    for surface in &surfaces {
        let mut one = surface.found.clone();
        one.ring_error = one.ring_error.map(|e| e * located.scale);
        found.candidates.push(one);
    }
    let is_blend = found.result == FinishResult::Blend;
    let expected_error = expected_error::expected_error(patch, &shape, &surfaces, is_blend);
    if patch.cancel.is_cancelled() {
        finished.set_stopped();
        return;
    }
    finished.expected_error = expected_error.iter().map(|s| s * located.scale).collect();
    found.set_expected_errors(&finished.expected_error);
    if found.result == FinishResult::Unchanged {
        return;
    }
    // The final positions.
    found.folds_after = folds::folds(patch, &shape);
    let ways = shape.iter().zip(&start).map(|(a, b)| a.distance(*b));
    found.largest_move = ways.fold(0.0, f64::max) * located.scale;
    finished.positions = shape.iter().map(|p| located.outward(*p)).collect();
}

/// The minimum of the energy, or the initial shape if the minimum is refused.
fn minimum(
    patch: &Patch,
    start: &[DVec3],
    params: &FinishParams,
    found: &mut FinishRecord,
) -> Vec<DVec3> {
    // Minimise, and unfold the result if it has more folded faces than the initial shape.
    let (mut minimum, second) = willmore::lowest(patch, params);
    if folds::folds(patch, &minimum.shape) > found.folds_before
        && let Some(shape) = folds::unfolded(patch, &minimum.shape, found.folds_before)
    {
        minimum.energy = willmore::energy(patch, &shape);
        minimum.shape = shape;
    }
    found.steps = minimum.steps;
    found.converged = minimum.last <= params.tolerance;
    found.energy_before = minimum.energy_before;
    found.energy_after = minimum.energy_before;
    found.second_initialisation = second;
    // Refuse a minimum with a flaw. A converged minimum of much lower energy may move vertices any distance.
    let rose = minimum.energy > minimum.energy_before * ENERGY_RISE.get();
    found.willmore_refused = if !minimum.energy_before.is_finite() {
        Some(Refusal::NotFinite)
    } else {
        let is_much_lower =
            found.converged && minimum.energy < MUCH_LOWER.get() * minimum.energy_before;
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

/// Why a shape is refused in favour of the one before, if it is; `farthest` bounds the displacement of a vertex, in diameters.
fn flaw(patch: &Patch, shape: &[DVec3], before: &[DVec3], farthest: f64) -> Option<Refusal> {
    if !shape.iter().all(|p| p.is_finite()) {
        return Some(Refusal::NotFinite);
    }
    let ways = shape.iter().zip(before).map(|(a, b)| a.distance(*b));
    if ways.fold(0.0, f64::max) > farthest * patch.diameter {
        return Some(Refusal::MovedTooFar);
    }
    (folds::folds(patch, shape) > folds::folds(patch, before)).then_some(Refusal::Folded)
}
