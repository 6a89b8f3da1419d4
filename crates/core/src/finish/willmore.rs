//! Minimisation of the Willmore energy on a patch's own triangles, by Gauss-Newton.

use glam::DVec3;

use super::MUCH_LOWER;
use super::biharmonic::biharmonic;
use super::folds::{FoldWatch, folds};
use super::geometry::{CurvatureTerms, Stiffness, gauss_curvature, quantile, vertex_normals};
use super::normal_matrix::NormalMatrix;
use super::params::FinishParams;
use super::patch::{Patch, PatchSupport};
use super::report::SecondInitialisation;
use crate::tuning::{Tunable, tunable};

/// Mean edges. Upper bound of the displacement of a vertex in one step.
const LONGEST_STEP: Tunable<f64> = tunable("finish.longest_step", 2.0);

/// Diameters. After a step longer than this, vertices are spread along the surface.
const SPREAD_ABOVE: Tunable<f64> = tunable("finish.spread_above", 5e-3);

/// Fraction of the way to the mean of its neighbours by which a vertex is spread.
const SPREAD: Tunable<f64> = tunable("finish.spread", 0.3);

/// Halvings of a step, at most.
const HALVINGS: Tunable<usize> = tunable("finish.halvings", 5);

/// Cosine. Steps are extrapolated where the angle between two successive steps has a larger cosine.
const ALIKE_COSINE: Tunable<f64> = tunable("finish.alike_cosine", 0.98);

/// Vertices. For larger patches the roughness that enters the system is bounded. On 143 holes of scans the bound made the
/// errors of smaller patches larger by 0.3 %.
const MANY_VERTICES: Tunable<usize> = tunable("finish.many_vertices", 1200);

/// Diameters. Width of the strip along the rim of a large patch that is filled biharmonically before the first step.
const STRIP: Tunable<f64> = tunable("finish.strip", 0.1);

/// Fraction of the Hessian's diagonal that is added to it.
const WILLMORE_RIDGE: Tunable<f64> = tunable("finish.willmore_ridge", 1e-10);

/// ½∫h². Minima below this get no second initialisation: a hemisphere has 4π, and below that every initialisation led to
/// a minimum.
const SECOND_START_BENT: Tunable<f64> = tunable("finish.second_start_bent", 8.0);

/// Diameters. A step shorter than this and than `ALWAYS_BELOW_EDGES` is taken even if the energy rises, as it may
/// by rounding or by the spreading of vertices.
const ALWAYS_BELOW: Tunable<f64> = tunable("finish.always_below", 2e-3);

/// Mean edges. See `ALWAYS_BELOW`.
const ALWAYS_BELOW_EDGES: Tunable<f64> = tunable("finish.always_below_edges", 0.04);

/// Least ratio of a step to the one before for an extrapolation.
const SHRINKING_LEAST: Tunable<f64> = tunable("finish.shrinking_least", 0.5);

/// Largest ratio of a step to the one before for an extrapolation.
const SHRINKING_MOST: Tunable<f64> = tunable("finish.shrinking_most", 0.96);

/// The result of a minimisation, converged or not.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    /// Positions of the moving vertices.
    pub(super) shape: Vec<DVec3>,
    pub(super) steps: usize,
    /// The largest displacement of the last step, in diameters.
    pub(super) last: f64,
    pub(super) energy_before: f64,
    pub(super) energy: f64,
}

/// Discrete curvature and energy of a surface.
struct State {
    half_cotangents: Vec<[f64; 3]>,
    normals: Vec<DVec3>,
    masses: Vec<f64>,
    /// Sum of the principal curvatures.
    curvature: Vec<f64>,
    energy: f64,
}

impl State {
    /// `h = n · S x / m` (mean curvature normal, Meyer et al. 2003, equation (8)) and `E = ½ Σ m h²` over moving and rim
    /// vertices.
    fn new(closure: &PatchSupport, points: &[DVec3]) -> Self {
        let CurvatureTerms {
            half_cotangents,
            normals,
            masses,
            pulls,
        } = CurvatureTerms::new(points, &closure.faces);
        let curvature: Vec<f64> = (0..points.len())
            .map(|i| normals[i].dot(pulls[i]) / masses[i])
            .collect();
        let acting = closure.acting.iter().map(|&i| i as usize);
        let energy = 0.5
            * acting
                .map(|i| masses[i] * curvature[i].powi(2))
                .sum::<f64>();
        Self {
            half_cotangents,
            normals,
            masses,
            curvature,
            energy,
        }
    }
}

/// `½ ∫ h²` of a patch with its rim; it does not depend on the unit of length.
pub(super) fn energy(patch: &Patch, shape: &[DVec3]) -> f64 {
    State::new(&patch.closure, &patch.closure_points(shape)).energy
}

/// State of the Gauss-Newton iteration that is shared by its steps.
struct Solver<'a> {
    patch: &'a Patch,
    closure: &'a PatchSupport,
    stiffness: Stiffness,
    /// The unknown of each vertex of the closure, if it moves.
    unknown: Vec<Option<usize>>,
    /// The matrix `Jᵀ M J`: `J` has a row for each acting vertex and a column for each moving one.
    normal: NormalMatrix,
    /// The entry of the stiffness matrix from which each entry of `J` is computed.
    entries: Vec<usize>,
    /// Factor on the diagonal (Levenberg-Marquardt).
    damping: f64,
}

impl<'a> Solver<'a> {
    fn new(patch: &'a Patch) -> Self {
        let closure = &patch.closure;
        let mut unknown = vec![None; closure.vertices.len()];
        for (k, &v) in closure.moving.iter().enumerate() {
            unknown[v as usize] = Some(k);
        }
        let stiffness = Stiffness::new(closure.vertices.len(), &closure.faces);
        let matrix = &stiffness.matrix;
        let mut entries = Vec::new();
        let mut row = |&i: &u32| {
            let own = matrix.indptr().outer_inds_sz(i as usize);
            let ends = own.map(|entry| Some((entry, unknown[matrix.indices()[entry]]?)));
            let (own, columns): (Vec<usize>, Vec<usize>) = ends.flatten().unzip();
            entries.extend(own);
            columns
        };
        let rows: Vec<Vec<usize>> = closure.acting.iter().map(&mut row).collect();
        Self {
            normal: NormalMatrix::new(&rows, closure.moving.len()),
            patch,
            closure,
            stiffness,
            unknown,
            entries,
            damping: 0.0,
        }
    }

    /// The linearised problem: with `J = ∂h/∂d = M⁻¹ S − diag(h² − 2 K)` for displacements `d` along the normals,
    /// `(Jᵀ M J) d = −(Jᵀ M h + ½ M h³)`, a Gauss-Newton step (J. Nocedal, S. J. Wright, "Numerical Optimization", 2006, section
    /// 10.3). `J` has a row for each moving vertex and each rim vertex, whose curvature also depends on the patch.
    ///
    /// In a patch with many vertices, `h² − 2 K` in the matrix is bounded by its third quartile. On a finely meshed rough rim,
    /// noise makes the Hessian nearly singular; steps along its near-null space do not lower the energy.
    ///
    /// Returns the values of `J`, row by row, and the right-hand side.
    fn linearised(&mut self, points: &[DVec3], state: &State) -> (Vec<f64>, Vec<f64>) {
        let closure = self.closure;
        self.stiffness.set(&closure.faces, &state.half_cotangents);
        // h² − 2 K is the sum of the squared principal curvatures. Curvatures above π/2 per edge are not resolved and are
        // clamped; K is at most h²/4, as for real principal curvatures.
        let gauss = gauss_curvature(points, &closure.faces, &state.masses);
        let most = std::f64::consts::PI / (2.0 * self.patch.edge);
        let squares = |i: usize| {
            let bounded = state.curvature[i].powi(2).min(most * most);
            let k = gauss[i].max(-most * most).min(0.25 * bounded);
            (bounded - 2.0 * k).max(0.0).min(most * most)
        };
        let acting = || closure.acting.iter().map(|&i| i as usize);
        let squares: Vec<f64> = acting().map(squares).collect();
        let upper = match closure.moving.len() > MANY_VERTICES.get() {
            true => quantile(squares.iter().copied(), 0.75),
            false => f64::INFINITY,
        };
        // The quartile does not bound h² − 2 K in the right-hand side.
        let mut values = Vec::with_capacity(self.entries.len());
        let mut rhs = vec![0.0; closure.moving.len()];
        let stiffness = self.stiffness.matrix.data();
        for (row, (i, squares)) in acting().zip(squares).enumerate() {
            let (m, h) = (state.masses[i], state.curvature[i]);
            for (place, u) in self.normal.row(row) {
                let s = stiffness[self.entries[place]];
                let is_own = self.unknown[i] == Some(u);
                let entry = |squares: f64| s / m - if is_own { squares } else { 0.0 };
                values.push(entry(squares.min(upper)));
                rhs[u] -= entry(squares) * m * h;
            }
            if let Some(u) = self.unknown[i] {
                rhs[u] -= 0.5 * m * h.powi(3);
            }
        }
        (values, rhs)
    }

    /// Solves for the displacements along the normals, clamps them, and returns them with the largest; `None` if there is no
    /// finite solution.
    fn displacements(&mut self, points: &[DVec3], state: &State) -> Option<(Vec<f64>, f64)> {
        let (values, mut d) = self.linearised(points, state);
        let masses = self
            .closure
            .acting
            .iter()
            .map(|&i| state.masses[i as usize]);
        let matrix = self.normal.set(&values, &masses.collect::<Vec<_>>());
        self.patch
            .pattern(2, matrix)
            .factorise(matrix, WILLMORE_RIDGE.get() + self.damping)?
            .solve(&mut d);
        if !d.iter().all(|d| d.is_finite()) {
            return None;
        }
        let longest = LONGEST_STEP.get() * self.patch.edge;
        d.iter_mut().for_each(|d| *d = d.clamp(-longest, longest));
        let largest = d.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        Some((d, largest))
    }

    /// The points after the fraction `part` of a step.
    fn moved(&self, points: &[DVec3], normals: &[DVec3], d: &[f64], part: f64) -> Vec<DVec3> {
        let mut moved = points.to_vec();
        for (&v, d) in self.closure.moving.iter().zip(d) {
            moved[v as usize] += part * d * normals[v as usize];
        }
        moved
    }

    /// Moves vertices tangentially towards the mean of their neighbours.
    fn spread(&self, points: &mut [DVec3]) {
        let normals = vertex_normals(points, &self.closure.faces);
        let mut goals = Vec::with_capacity(self.closure.moving.len());
        for &v in &self.closure.moving {
            let i = v as usize;
            let row = self.stiffness.matrix.outer_view(i);
            let neighbours = row.iter().flat_map(|row| row.indices());
            let (mut sum, mut count) = (DVec3::ZERO, 0.0);
            for &j in neighbours.filter(|&&j| j != i) {
                sum += points[j];
                count += 1.0;
            }
            let way = sum / f64::max(count, 1.0) - points[i];
            goals.push(way - way.dot(normals[i]) * normals[i]);
        }
        for (&v, way) in self.closure.moving.iter().zip(goals) {
            points[v as usize] += SPREAD.get() * way;
        }
    }

    /// Takes a step from the given state, halving it until the energy falls; `None` if it does not. A step that is short enough
    /// is taken even if the energy does not fall.
    fn step(
        &self,
        points: &[DVec3],
        state: &State,
        d: &[f64],
        largest: f64,
    ) -> Option<(Vec<DVec3>, State)> {
        let Patch { diameter, edge, .. } = self.patch;
        let always_below = (ALWAYS_BELOW.get() * diameter).min(ALWAYS_BELOW_EDGES.get() * edge);
        let mut part = 1.0;
        for _ in 0..HALVINGS.get() {
            let mut moved = self.moved(points, &state.normals, d, part);
            if largest > SPREAD_ABOVE.get() * diameter {
                self.spread(&mut moved);
            }
            let next = State::new(self.closure, &moved);
            let falls = next.energy < state.energy * (1.0 + 1e-9);
            if falls || largest * part < always_below && next.energy.is_finite() {
                return Some((moved, next));
            }
            part *= 0.5;
        }
        None
    }
}

/// Factor by which to lengthen a step, from the step before. The energy is invariant under inversions, which leaves nearly flat
/// valleys on patches wider than their rims. There steps have the same direction and shrink by a constant factor; the factor
/// extends a step to the sum of the geometric series (A. C. Aitken, 1926).
fn stretch(before: &[f64], now: &[f64]) -> f64 {
    if before.len() != now.len() {
        return 1.0;
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (both, first, second) = (dot(before, now), dot(before, before), dot(now, now));
    let factor = both / first;
    let is_alike = both > ALIKE_COSINE.get() * (first * second).sqrt();
    if is_alike && factor > SHRINKING_LEAST.get() && factor < SHRINKING_MOST.get() {
        1.0 / (1.0 - factor)
    } else {
        1.0
    }
}

/// Gauss-Newton iteration from a shape.
pub(super) fn minimise(patch: &Patch, shape: &[DVec3], params: &FinishParams) -> Minimum {
    let mut solver = Solver::new(patch);
    let mut points = patch.closure_points(shape);
    let mut state = State::new(&patch.closure, &points);
    let energy_before = state.energy;
    let (mut steps, mut last) = (0, f64::INFINITY);
    // For large patches only: watches for folds.
    let mut before: Vec<f64> = Vec::new();
    let mut watch = (shape.len() > params.most_blended).then(|| FoldWatch {
        patch,
        allowed: folds(patch, shape),
        in_a_row: 0,
        best: (points.clone(), energy_before),
    });
    while steps < params.most_steps && state.energy.is_finite() && !patch.cancel.is_cancelled() {
        steps += 1;
        // The displacements of a step; `last` is the largest, in diameters, before the step is lengthened.
        let Some((mut d, mut largest)) = solver.displacements(&points, &state) else {
            break;
        };
        last = largest / patch.diameter;
        let stretch = stretch(&before, &d);
        before = d.clone();
        d.iter_mut().for_each(|d| *d *= stretch);
        largest *= stretch;
        // A step that lowers the energy reduces the damping; otherwise the damping is raised (Levenberg and Marquardt).
        if let Some((moved, next)) = solver.step(&points, &state, &d, largest) {
            (points, state) = (moved, next);
            solver.damping *= 0.1;
            let goes_on = |w: &mut FoldWatch| w.goes_on(&points, state.energy);
            if last < params.tolerance || !watch.as_mut().is_none_or(goes_on) {
                break;
            }
        } else {
            solver.damping = (10.0 * solver.damping).max(1e-3);
            if solver.damping > 1e2 {
                break;
            }
        }
    }
    // If folds remain, the last shape without them is the result, not converged.
    let (points, energy) = match watch {
        Some(watch) if watch.in_a_row > 0 => {
            last = f64::INFINITY;
            watch.best
        }
        _ => (points, state.energy),
    };
    Minimum {
        shape: patch.closure.moved(&points),
        steps,
        last,
        energy_before,
        energy,
    }
}

/// The shape with a strip along its rim filled biharmonically; `None` if that fails. A patch with small faces meets the rim only
/// with the accuracy of its voxels, which are many faces wide: it is crumpled there, and no Gauss-Newton step would be short
/// enough.
fn smoothed(patch: &Patch, shape: &[DVec3]) -> Option<Vec<DVec3>> {
    let strip = patch.enlarged(&[], shape, STRIP.get() * patch.diameter);
    let points = strip.placed(&biharmonic(&strip, &strip.shape())?);
    let place = |&v: &u32| points[patch.closure.vertices[v as usize] as usize];
    Some(patch.closure.moving.iter().map(place).collect())
}

/// The minimum with the fewest folds, then the lowest energy, from up to two initial shapes. The first is the patch's own shape;
/// for a large patch, with a strip along the rim filled biharmonically. The second is the biharmonic fill of all its triangles,
/// which has no folds. It is used if the first did not converge or has folds (smaller patches only), or if the fill itself has
/// much less energy than the minimum from the first.
pub(super) fn lowest(patch: &Patch, params: &FinishParams) -> (Minimum, SecondInitialisation) {
    let shape = patch.shape();
    let is_large = shape.len() > params.most_blended;
    let mut params = params.clone();
    let (mut start, mut second) = (shape, SecondInitialisation::NotNeeded);
    let energy_before = energy(patch, &start);
    // For a large patch, smooth a strip along the rim first if that lowers the energy.
    if is_large {
        params.most_steps = params.most_steps_of_large;
        second = SecondInitialisation::Worse;
        if let Some(other) = smoothed(patch, &start)
            && energy(patch, &other) < energy_before
        {
            (start, second) = (other, SecondInitialisation::Better);
        }
    }
    // The first initial shape. A converged minimum of low energy without folds needs no second.
    let first = Minimum {
        energy_before,
        ..minimise(patch, &start, &params)
    };
    let first_folds = folds(patch, &first.shape);
    let is_sound = first.last <= params.tolerance && first_folds == 0;
    if is_sound && first.energy < SECOND_START_BENT.get() || patch.cancel.is_cancelled() {
        return (first, second);
    }
    // The second initial shape: used if the first failed or the fill has much less energy than its minimum.
    let Some(filled) = biharmonic(patch, &start) else {
        return (first, second);
    };
    if (is_sound || is_large) && energy(patch, &filled) > MUCH_LOWER.get() * first.energy {
        return (first, second);
    }
    let other = minimise(patch, &filled, &params);
    let other_folds = folds(patch, &other.shape);
    let is_better =
        other_folds < first_folds || other_folds == first_folds && other.energy < first.energy;
    if is_better && other.shape.iter().all(|p| p.is_finite()) {
        let both = Minimum {
            steps: first.steps + other.steps,
            energy_before,
            ..other
        };
        return (both, SecondInitialisation::Better);
    }
    (
        first,
        if is_large {
            second
        } else {
            SecondInitialisation::Worse
        },
    )
}
