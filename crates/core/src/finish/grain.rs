//! Grain: synthesises random roughness for a patch that matches the roughness of the surroundings at several wavelengths.
//!
//! The roughness of a vertex at a radius is its distance from the least-squares quadric of the vertices within that radius. Random fields
//! with Gaussian covariances of several lengths, and noise, are drawn at the new vertices by random Fourier features (A. Rahimi, B. Recht,
//! "Random features for large-scale kernel machines", 2007), with a fixed seed. Non-negative least squares determines their variances such
//! that the patch is as rough at each radius as the known vertices round it.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use super::geometry::vertex_normals;
use super::params::FinishParams;
use super::patch::{Located, Patch};
use super::surroundings::Surroundings;
use crate::elementary::{cos, ln, root_mean_square};
use crate::linalg::solve_spd;
use crate::threads::{CollectFiltered, CollectIndexed};
use crate::tuning::{Tunable, tunable};

/// Mean edges. Radii of the quadrics. Shape of longer wavelengths is continued by the patch itself.
const RADII: [f64; 4] = [2.2, 4.0, 7.0, 11.0];
/// Index of the radius whose roughness is reported.
const REPORTED: usize = 2;
/// Width of the ring whose roughness is measured: diameters, and its lower bound in mean edges.
const RING: Tunable<f64> = tunable("finish.grain.ring", 0.45);
const RING_EDGES: Tunable<f64> = tunable("finish.grain.ring_edges", 6.0);
/// Upper bound of the number of vertices at which roughness is measured.
const MOST: Tunable<usize> = tunable("finish.grain.most", 1000);
/// Lower bound of the number of vertices of a quadric fit, of the ring, and of the patch.
const FEWEST: Tunable<usize> = tunable("finish.grain.fewest", 12);
/// Mean edges. Lengths ℓ of the covariances exp(−r² / 2ℓ²); 0 is white noise.
const LENGTHS: [f64; 5] = [0.0, 0.7, 1.4, 2.8, 5.6];
/// Sweeps of coordinate descent in the fit of the variances.
const ROUNDS: Tunable<usize> = tunable("finish.grain.rounds", 400);
/// Upper bound of the factor that corrects the height of the summed fields, which is 1 for independent fields.
const MOST_SCALED: Tunable<f64> = tunable("finish.grain.most_scaled", 3.0);
/// Number of draws. On six surfaces with one draw the roughness at the radii 2.2, 4 and 11 was 0.6 to 1.6 times the ring's.
const DRAWS: usize = 8;
/// Weight of the height beyond the ring's roughness in the choice of a draw.
const HEIGHT: Tunable<f64> = tunable("finish.grain.height", 8.0);
/// Number of waves of each random field.
const WAVES: usize = 192;
/// Mean edges. Distance from the rim over which the grain grows from zero to its whole height.
const FADE: Tunable<f64> = tunable("finish.grain.fade", 2.0);
/// Seed of the random numbers.
const SEED: u64 = 0x6973_6f6d_656e_6421;

/// Grain for the vertices of a patch, in the mesh's unit.
pub(crate) struct Grain {
    /// Vertices and their displacements.
    pub(crate) shifts: Vec<(u32, DVec3)>,
    /// Root mean square roughness of the ring, and of the patch with its grain.
    pub(crate) roughness: [f64; 2],
}

/// The grain of a connected patch with the given vertices; `None` if the ring or the patch has too few vertices, or the patch is already as
/// rough as the ring.
pub(crate) fn grain(around: &Surroundings<'_>, vertices: &[u32]) -> Option<Grain> {
    let vertices = super::usable(around, vertices);
    let located = super::located(around, &vertices, &FinishParams::default()).ok()?;
    let patch = &located.patch;
    let (ring, inner) = (ring(patch), inner(patch));
    if ring.len() < FEWEST.get() || inner.len() < FEWEST.get() {
        return None;
    }
    // The roughness of the ring at each radius.
    let target = RADII.map(|r| roughness(patch, &patch.points, &patch.known, &ring, r));
    let (shape, normals) = (patch.shape(), normals(patch));
    let all = vec![true; patch.points.len()];
    let moved = |heights: &[f64]| -> Vec<DVec3> {
        let ways = normals.iter().zip(heights).map(|(n, h)| *n * *h);
        shape.iter().zip(ways).map(|(p, way)| *p + way).collect()
    };
    let measured = |heights: &[f64]| {
        let points = patch.placed(&moved(heights));
        RADII.map(|r| roughness(patch, &points, &all, &inner, r))
    };
    // Squares of roughness of the patch and of independent fields add up.
    let own = measured(&vec![0.0; shape.len()]);
    let missing: Vec<f64> = own.iter().zip(target).map(|(o, t)| t * t - o * o).collect();
    if patch.cancel.is_cancelled() || missing[REPORTED] <= 0.0 {
        return None;
    }
    // Of several draws the one whose roughness is nearest to the ring's at all radii, and that is no higher than the ring is rough: quadrics
    // hide long waves.
    let task = Task {
        patch,
        shape: &shape,
        target,
        own,
        missing,
    };
    let draws: Vec<_> = (0..DRAWS)
        .into_par_iter()
        .filter_map(|number| task.draw(number, &measured))
        .collect_filtered();
    let score = |draw: &([f64; RADII.len()], Vec<f64>)| -> f64 {
        let (roughness, heights) = draw;
        let ratios = roughness.iter().zip(target);
        let unlike: f64 = ratios.map(|(m, t)| ln(m / t).powi(2)).sum();
        let squares: f64 = heights.iter().map(|h| h * h).sum();
        let height = (squares / heights.len() as f64).sqrt();
        let most = target.iter().copied().fold(0.0, f64::max);
        unlike + HEIGHT.get() * ln(height / most).max(0.0).powi(2)
    };
    let best = draws
        .into_iter()
        .min_by(|a, b| score(a).total_cmp(&score(b)));
    let (roughness, heights) = best.filter(|_| !patch.cancel.is_cancelled())?;
    let reported = [target[REPORTED], roughness[REPORTED]];
    Some(Grain {
        shifts: shifts(&located, &vertices, &moved(&heights)),
        roughness: reported.map(|r| r * located.scale),
    })
}

/// The data from which grain is drawn: the patch, its positions, and at each radius the ring's roughness, the patch's own and the missing
/// square.
struct Task<'a> {
    patch: &'a Patch,
    shape: &'a [DVec3],
    target: [f64; RADII.len()],
    own: [f64; RADII.len()],
    missing: Vec<f64>,
}

impl Task<'_> {
    /// Random heights of the vertices, with the roughness of the patch with them; `None` if the roughness cannot be reached.
    fn draw(
        &self,
        number: usize,
        measured: &(dyn Fn(&[f64]) -> [f64; RADII.len()] + Sync),
    ) -> Option<([f64; RADII.len()], Vec<f64>)> {
        let (patch, own) = (self.patch, self.own);
        // The square that each field, scaled to the missing height, adds at each radius.
        let height = self.missing[REPORTED].sqrt();
        let field = |(k, length): (usize, &f64)| {
            let seed = SEED.wrapping_add((number * LENGTHS.len() + k) as u64);
            let drawn = drawn(self.shape, length * patch.edge, seed);
            let heights: Vec<f64> = faded(patch, &drawn).iter().map(|h| h * height).collect();
            let with = measured(&heights);
            let added = with.iter().zip(own).map(|(m, o)| m * m - o * o).collect();
            (heights, added)
        };
        let fields: Vec<(Vec<f64>, Vec<f64>)> = LENGTHS.iter().enumerate().map(field).collect();
        let mut heights = sum(&fields, &self.missing, &self.target);
        // The fields are not quite independent: scale their sum once to the reported roughness.
        let now = measured(&heights)[REPORTED].powi(2) - own[REPORTED].powi(2);
        let scale = (self.missing[REPORTED] / now).sqrt();
        if !scale.is_finite() || scale > MOST_SCALED.get() || patch.cancel.is_cancelled() {
            return None;
        }
        heights.iter_mut().for_each(|h| *h *= scale);
        Some((measured(&heights), heights))
    }
}

/// The weighted sum of fields that adds the missing squares of roughness. Each field comes with the squares that it adds at the radii.
fn sum(fields: &[(Vec<f64>, Vec<f64>)], missing: &[f64], target: &[f64]) -> Vec<f64> {
    let added: Vec<&[f64]> = fields.iter().map(|f| &f.1[..]).collect();
    let mut heights = vec![0.0; fields[0].0.len()];
    for ((field, _), variance) in fields.iter().zip(variances(&added, missing, target)) {
        let part = variance.sqrt();
        heights
            .iter_mut()
            .zip(field)
            .for_each(|(h, f)| *h += part * f);
    }
    heights
}

/// Non-negative factors f of the fields' variances that minimise Σ_r ((Σ_k f_k added_kr − missing_r) / target_r²)², by coordinate
/// descent.
fn variances(added: &[&[f64]], missing: &[f64], target: &[f64]) -> Vec<f64> {
    let mut factors = vec![0.0; added.len()];
    for _ in 0..ROUNDS.get() {
        for k in 0..added.len() {
            let (mut up, mut down) = (0.0, 0.0);
            for r in (0..missing.len()).filter(|&r| target[r] > 0.0) {
                let all: f64 = factors.iter().zip(added).map(|(f, a)| f * a[r]).sum();
                let weight = target[r].powi(-4);
                let residual = missing[r] - all + factors[k] * added[k][r];
                up += weight * added[k][r] * residual;
                down += weight * added[k][r].powi(2);
            }
            factors[k] = if down > 0.0 {
                (up / down).max(0.0)
            } else {
                0.0
            };
        }
    }
    factors
}

/// The displacements of the vertices, in the mesh's unit.
fn shifts(located: &Located, vertices: &[u32], moved: &[DVec3]) -> Vec<(u32, DVec3)> {
    let before = located.patch.shape();
    let ways = moved
        .iter()
        .zip(&before)
        .map(|(a, b)| (*a - *b) * located.scale);
    vertices.iter().copied().zip(ways).collect()
}

/// Normals at the moving vertices.
fn normals(patch: &Patch) -> Vec<DVec3> {
    let points = patch.closure_points(&patch.shape());
    patch
        .closure
        .moved(&vertex_normals(&points, &patch.closure.faces))
}

/// The heights of a field times a smooth step that grows from 0 at the rim to 1.
fn faded(patch: &Patch, field: &[f64]) -> Vec<f64> {
    let grown = |(height, depth): (&f64, f64)| {
        let part = (depth / (FADE.get() * patch.edge)).clamp(0.0, 1.0);
        height * part * part * (3.0 - 2.0 * part)
    };
    field.iter().zip(patch.depth()).map(grown).collect()
}

/// Vertices of the ring: known ones near the rim, off the mesh's boundary.
fn ring(patch: &Patch) -> Vec<u32> {
    let width = (RING.get() * patch.diameter).max(RING_EDGES.get() * patch.edge);
    let inside = |&v: &u32| {
        let i = v as usize;
        patch.known[i] && !patch.border[i] && patch.distance[i] < width
    };
    thinned((0..patch.points.len() as u32).filter(inside).collect())
}

/// Vertices of the patch where the grain has its whole height.
fn inner(patch: &Patch) -> Vec<u32> {
    let deep = patch.closure.moving.iter().zip(patch.depth());
    let deep = deep.filter(|(_, depth)| *depth > FADE.get() * patch.edge);
    thinned(
        deep.map(|(&v, _)| patch.closure.vertices[v as usize])
            .collect(),
    )
}

/// Root mean square distance of vertices from the quadrics of their neighbourhoods: the vertices marked in `chosen` within a radius in mean
/// edges.
fn roughness(
    patch: &Patch,
    points: &[DVec3],
    chosen: &[bool],
    vertices: &[u32],
    radius: f64,
) -> f64 {
    let whole = |f: &&[u32; 3]| f.iter().all(|&v| chosen[v as usize]);
    let faces: Vec<[u32; 3]> = patch.faces.iter().filter(whole).copied().collect();
    let normals = vertex_normals(points, &faces);
    let cells = Cells::new(points, chosen, radius * patch.edge);
    let value = |&v: &u32| {
        let near = cells.near(points, points[v as usize]);
        let normal: DVec3 = near.iter().map(|&w| normals[w as usize]).sum();
        height(points, &near, v, normal.try_normalize()?)
    };
    let values: Vec<Option<f64>> = vertices.par_iter().map(value).collect_indexed();
    root_mean_square(values.into_iter().flatten())
}

/// At most [`MOST`] of the vertices, at regular intervals.
fn thinned(all: Vec<u32>) -> Vec<u32> {
    let step = all.len().div_ceil(MOST.get()).max(1);
    all.into_iter().step_by(step).collect()
}

/// A grid of cubic cells for searches within a fixed radius.
struct Cells {
    /// Pairs of cell and vertex, sorted.
    sorted: Vec<([i32; 3], u32)>,
    /// Edge of a cell, which is the radius.
    size: f64,
}

impl Cells {
    fn new(points: &[DVec3], chosen: &[bool], size: f64) -> Self {
        let all = (0..points.len() as u32).filter(|&v| chosen[v as usize]);
        let mut sorted: Vec<_> = all
            .map(|v| (Self::cell(points[v as usize], size), v))
            .collect();
        sorted.sort_unstable();
        Self { sorted, size }
    }

    fn cell(p: DVec3, size: f64) -> [i32; 3] {
        (p / size).floor().as_ivec3().to_array()
    }

    /// The vertices within the radius of a point, in the order of cells.
    fn near(&self, points: &[DVec3], p: DVec3) -> Vec<u32> {
        let [x, y, z] = Self::cell(p, self.size);
        let mut near = Vec::new();
        for i in x - 1..=x + 1 {
            for j in y - 1..=y + 1 {
                let row = [i, j, z - 1];
                let first = self.sorted.partition_point(|(cell, _)| *cell < row);
                let row = self.sorted[first..].iter();
                let row = row.take_while(|(cell, _)| *cell <= [i, j, z + 1]);
                let is_near = |v: &u32| points[*v as usize].distance_squared(p) < self.size.powi(2);
                near.extend(row.map(|r| r.1).filter(is_near));
            }
        }
        near
    }
}

/// Height of a vertex over the least-squares quadric of its neighbourhood, itself included, as a graph over its tangent plane. Divided by
/// √(1 − leverage), as a studentised residual: the fit follows the vertex by its leverage.
fn height(points: &[DVec3], near: &[u32], vertex: u32, normal: DVec3) -> Option<f64> {
    const TERMS: usize = 6;
    if near.len() < FEWEST.get() {
        return None;
    }
    let origin = points[vertex as usize];
    let (first, second) = normal.any_orthonormal_pair();
    let size = near.iter().map(|&w| points[w as usize].distance(origin));
    let size = size.fold(0.0, f64::max);
    let (mut matrix, mut rhs) = ([0.0; TERMS * TERMS], [0.0; TERMS]);
    for &w in near {
        let arm = (points[w as usize] - origin) / size;
        let (x, y, z) = (arm.dot(first), arm.dot(second), arm.dot(normal));
        let terms = [1.0, x, y, x * x, x * y, y * y];
        for i in 0..TERMS {
            rhs[i] += terms[i] * z;
            (0..TERMS).for_each(|j| matrix[i * TERMS + j] += terms[i] * terms[j]);
        }
    }
    (0..TERMS).for_each(|i| matrix[i * TERMS + i] += 1e-9 * near.len() as f64);
    // The vertex is the origin: its height is minus the constant term, and its leverage the first entry of the inverse.
    let mut leverage = [0.0; TERMS];
    leverage[0] = 1.0;
    let solved = solve_spd(&mut matrix.clone(), &mut rhs) && solve_spd(&mut matrix, &mut leverage);
    let left = (1.0 - leverage[0]).max(0.05).sqrt();
    let height = -rhs[0] * size / left;
    (solved && height.is_finite()).then_some(height)
}

/// A random field of variance 1 at points: Gaussian covariance of the given length, or white noise if that is 0.
fn drawn(points: &[DVec3], length: f64, seed: u64) -> Vec<f64> {
    let mut random = Random(seed);
    if length == 0.0 {
        return points.iter().map(|_| random.normal()).collect();
    }
    let wave = |_| {
        let wave = DVec3::new(random.normal(), random.normal(), random.normal());
        (wave / length, TAU * random.uniform())
    };
    let waves: Vec<(DVec3, f64)> = (0..WAVES).map(wave).collect();
    let height = (2.0 / WAVES as f64).sqrt();
    let at = |p: &DVec3| {
        let all = waves.iter().map(|(k, phase)| cos(k.dot(*p) + phase));
        height * all.sum::<f64>()
    };
    points.par_iter().map(at).collect_indexed()
}

/// The pseudorandom number generator SplitMix64 (G. L. Steele et al., "Fast splittable pseudorandom number generators", 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform between 0 and 1, both excluded.
    fn uniform(&mut self) -> f64 {
        ((self.next() >> 12) as f64 + 0.5) / (1u64 << 52) as f64
    }

    /// Normal with mean 0 and variance 1 (G. E. P. Box, M. E. Muller, 1958).
    fn normal(&mut self) -> f64 {
        let (u, v) = (self.uniform(), self.uniform());
        (-2.0 * ln(u)).sqrt() * cos(TAU * v)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{surroundings, with_patch};
    use super::*;
    use crate::mesh::shapes::icosphere;

    #[test]
    fn a_patch_gets_as_rough_as_its_ring_and_keeps_its_rim() {
        let mut random = Random(7);
        let mut sphere = icosphere(5);
        let is_missing = |p: DVec3| p.z > 0.85;
        // Noise on the known vertices alone.
        for p in sphere.positions.iter_mut().filter(|p| !is_missing(**p)) {
            *p *= 1.0 + 0.004 * random.normal();
        }
        let (mesh, patch) = with_patch(sphere, is_missing, |_, _| DVec3::ZERO);
        let around = surroundings(&mesh, &patch);
        let grain = grain(&around, &patch).expect("grain");
        let [ring, own] = grain.roughness;
        assert!((own / ring - 1.0).abs() < 0.1, "{ring} {own}");
        assert!((ring / 0.004 - 1.0).abs() < 0.2, "{ring}");
        assert_eq!(grain.shifts.len(), patch.len());
        let largest = grain
            .shifts
            .iter()
            .map(|s| s.1.length())
            .fold(0.0, f64::max);
        assert!(largest > 0.004 && largest < 0.04, "{largest}");
    }

    #[test]
    fn a_smooth_ring_gives_no_grain_to_speak_of() {
        let (mesh, patch) = with_patch(icosphere(5), |p| p.z > 0.85, |_, _| DVec3::ZERO);
        let grain = grain(&surroundings(&mesh, &patch), &patch);
        let largest = grain.map_or(0.0, |g| {
            g.shifts.iter().map(|s| s.1.length()).fold(0.0, f64::max)
        });
        assert!(largest < 1e-3, "{largest}");
    }

    #[test]
    fn variances_add_up_to_what_is_missing() {
        let fields: [&[f64]; 2] = [&[1.0, 1.0, 1.0], &[0.1, 0.5, 1.0]];
        let missing = [2.2, 3.0, 4.0];
        let found = variances(&fields, &missing, &[1.0; 3]);
        assert!(
            (found[0] - 2.0).abs() < 1e-3 && (found[1] - 2.0).abs() < 1e-3,
            "{found:?}"
        );
        // Factors stay non-negative even if one field alone adds too much.
        let found = variances(&fields, &[1.0, 0.5, 0.0], &[1.0; 3]);
        assert!(found.iter().all(|f| *f >= 0.0));
    }
}
