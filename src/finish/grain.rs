//! Grain: roughness for a patch, simulated with the covariance of what a smooth patch leaves out of the surroundings.
//!
//! The roughness of a known vertex is its distance from the quadric that fits the known vertices round it best. Its covariance, over
//! distance, is fitted by a sum of Gaussian kernels and noise (weights not negative); a random field with that covariance is drawn at the
//! new vertices, by random Fourier features (A. Rahimi, B. Recht, "Random features for large-scale kernel machines", 2007), with a seed
//! that is always the same. It is scaled until the patch measures as rough as the ring.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use super::geometry::vertex_normals;
use super::params::FinishParams;
use super::patch::{Located, Patch};
use super::surroundings::Surroundings;
use crate::linalg::solve_spd;

/// Diameters, and mean edges, least and most: the radius of the quadrics. What is longer than it the patch continues itself.
const RADIUS: f64 = 0.2;
const RADIUS_EDGES: [f64; 2] = [3.0, 8.0];
/// Diameters, and mean edges at least: width of the ring whose roughness is measured.
const RING: f64 = 0.45;
const RING_EDGES: f64 = 6.0;
/// Most vertices at which it is measured.
const MOST: usize = 2000;
/// Fewest vertices of a fit, and of the ring and the patch.
const FEWEST: usize = 12;
/// Lengths of the kernels in mean edges; 0 is noise.
const LENGTHS: [f64; 5] = [0.0, 0.7, 1.4, 2.8, 5.6];
/// Bins of the covariance, half a mean edge wide each, and rounds of the fit.
const BINS: usize = 16;
const ROUNDS: usize = 400;
/// Waves of each kernel.
const WAVES: usize = 192;
/// Mean edges from the rim over which the grain grows from nothing to all of its height.
const FADE: f64 = 2.0;
/// Rounds of scaling.
const SCALINGS: usize = 4;
/// Where the random numbers begin.
const SEED: u64 = 0x6973_6f6d_656e_6421;

/// Grain for the vertices of a patch.
pub(crate) struct Grain {
    /// Vertices and by what they move, in the mesh's units.
    pub(crate) shifts: Vec<(u32, DVec3)>,
    /// Root mean square roughness of the ring, and of the patch with its grain, in the mesh's units.
    pub(crate) roughness: [f64; 2],
}

/// The grain of the patch of some vertices, which must hang together; none where too little is known round them, or they are too few.
pub(crate) fn grain(around: &Surroundings<'_>, vertices: &[u32]) -> Option<Grain> {
    let vertices = super::usable(around, vertices);
    let located = super::located(around, &vertices, &FinishParams::default()).ok()?;
    let patch = &located.patch;
    let rough = Roughness::new(patch);
    let ring = rough.ring();
    let values = rough.of(&patch.points, &patch.known, &ring);
    let values: Vec<(u32, f64)> = values.into_iter().flatten().collect();
    if values.len() < FEWEST || patch.cancel.is_cancelled() {
        return None;
    }
    let target = root_mean_square(values.iter().map(|v| v.1));
    let kernels = Kernels::fitted(patch, &values);
    let field = kernels.drawn(&patch.shape(), patch.edge);
    let (heights, normals) = (faded(patch, &field), normals(patch));
    let all = vec![true; patch.points.len()];
    let inner = rough.inner();
    let at = |scale: f64| -> Vec<DVec3> {
        let heights = heights.iter().zip(&normals);
        let moved = patch.shape().into_iter().zip(heights);
        moved.map(|(p, (h, n))| p + scale * h * *n).collect()
    };
    let measured = |scale: f64| {
        let values = rough.of(&patch.placed(&at(scale)), &all, &inner);
        root_mean_square(values.into_iter().flatten().map(|v| v.1))
    };
    // Squares of roughness add up: that of the patch itself and that of the grain.
    let (own, mut scale) = (measured(0.0), 1.0);
    if own >= target || target <= 0.0 {
        return None;
    }
    if inner.len() >= FEWEST {
        for _ in 0..SCALINGS {
            let now = measured(scale).powi(2) - own.powi(2);
            if now <= 0.0 {
                break;
            }
            scale *= ((target.powi(2) - own.powi(2)) / now).sqrt();
        }
    }
    if !scale.is_finite() || patch.cancel.is_cancelled() {
        return None;
    }
    let roughness = [target, measured(scale)].map(|r| r * located.scale);
    Some(Grain {
        shifts: shifts(&located, &vertices, &at(scale)),
        roughness,
    })
}

fn shifts(located: &Located, vertices: &[u32], moved: &[DVec3]) -> Vec<(u32, DVec3)> {
    let before = located.patch.shape();
    let ways = moved.iter().zip(&before).map(|(a, b)| (*a - *b) * located.scale);
    vertices.iter().copied().zip(ways).collect()
}

/// Normals of the vertices that move.
fn normals(patch: &Patch) -> Vec<DVec3> {
    let points = patch.closure_points(&patch.shape());
    patch.closure.moved(&vertex_normals(&points, &patch.closure.faces))
}

/// The heights of a field, growing from nothing at the rim.
fn faded(patch: &Patch, field: &[f64]) -> Vec<f64> {
    let grown = |(height, depth): (&f64, f64)| {
        let part = (depth / (FADE * patch.edge)).clamp(0.0, 1.0);
        height * part * part * (3.0 - 2.0 * part)
    };
    field.iter().zip(patch.depth()).map(grown).collect()
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(s, n), v| (s + v * v, n + 1.0));
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}

/// How roughness is measured on a patch and round it.
struct Roughness<'a> {
    patch: &'a Patch,
    radius: f64,
}

impl<'a> Roughness<'a> {
    fn new(patch: &'a Patch) -> Self {
        let [least, most] = RADIUS_EDGES.map(|edges| edges * patch.edge);
        Self {
            patch,
            radius: (RADIUS * patch.diameter).clamp(least, most),
        }
    }

    /// Known vertices of the ring.
    fn ring(&self) -> Vec<u32> {
        let patch = self.patch;
        let width = (RING * patch.diameter).max(RING_EDGES * patch.edge);
        let inside = |&v: &u32| {
            let i = v as usize;
            patch.known[i] && !patch.border[i] && patch.distance[i] < width
        };
        thinned((0..patch.points.len() as u32).filter(inside).collect())
    }

    /// Vertices of the patch where the grain has all of its height.
    fn inner(&self) -> Vec<u32> {
        let closure = &self.patch.closure;
        let deep = closure.moving.iter().zip(self.patch.depth());
        let deep = deep.filter(|(_, depth)| *depth > FADE * self.patch.edge);
        thinned(deep.map(|(&v, _)| closure.vertices[v as usize]).collect())
    }

    /// For each of some vertices its number and its height over the quadric that fits the vertices round it, which are chosen by a mark; none
    /// where these are too few.
    fn of(&self, points: &[DVec3], chosen: &[bool], vertices: &[u32]) -> Vec<Option<(u32, f64)>> {
        let faces: Vec<[u32; 3]> = {
            let whole = |f: &&[u32; 3]| f.iter().all(|&v| chosen[v as usize]);
            self.patch.faces.iter().filter(whole).copied().collect()
        };
        let normals = vertex_normals(points, &faces);
        let cells = Cells::new(points, chosen, self.radius);
        let value = |&v: &u32| {
            let near = cells.near(points, points[v as usize]);
            let normal: DVec3 = near.iter().map(|&w| normals[w as usize]).sum();
            Some((v, height(points, &near, v, normal.try_normalize()?)?))
        };
        vertices.par_iter().map(value).collect()
    }
}

/// At most [`MOST`] of some vertices, evenly.
fn thinned(all: Vec<u32>) -> Vec<u32> {
    let step = all.len().div_ceil(MOST).max(1);
    all.into_iter().step_by(step).collect()
}

/// Vertices in cubic cells.
struct Cells {
    /// Cells and vertices, sorted.
    sorted: Vec<([i32; 3], u32)>,
    size: f64,
}

impl Cells {
    fn new(points: &[DVec3], chosen: &[bool], size: f64) -> Self {
        let all = (0..points.len() as u32).filter(|&v| chosen[v as usize]);
        let mut sorted: Vec<_> = all.map(|v| (Self::cell(points[v as usize], size), v)).collect();
        sorted.sort_unstable();
        Self { sorted, size }
    }

    fn cell(p: DVec3, size: f64) -> [i32; 3] {
        (p / size).floor().as_ivec3().to_array()
    }

    /// The vertices that are nearer to a point than the size of a cell, in order of cells.
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

/// Height of a vertex over the quadric over its tangent plane that fits vertices round it, itself among them, in least squares, over the
/// part of its standard deviation that such a fit leaves.
fn height(points: &[DVec3], near: &[u32], vertex: u32, normal: DVec3) -> Option<f64> {
    const TERMS: usize = 6;
    if near.len() < FEWEST {
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
    // The vertex is the origin: its height is minus the constant term, its leverage the first entry of the inverse.
    let mut leverage = [0.0; TERMS];
    leverage[0] = 1.0;
    let solved = solve_spd(&mut matrix.clone(), &mut rhs) && solve_spd(&mut matrix, &mut leverage);
    let left = (1.0 - leverage[0]).max(0.05).sqrt();
    let height = -rhs[0] * size / left;
    (solved && height.is_finite()).then_some(height)
}

/// A covariance: the variance of each kernel.
struct Kernels([f64; LENGTHS.len()]);

impl Kernels {
    /// The covariance of some values at known vertices.
    fn fitted(patch: &Patch, values: &[(u32, f64)]) -> Self {
        let width = 0.5 * patch.edge;
        // Products of pairs by distance; the first bin has the variance alone.
        let (mut sums, mut counts) = ([0.0; BINS], [0.0; BINS]);
        for (i, &(v, a)) in values.iter().enumerate() {
            sums[0] += a * a;
            counts[0] += 1.0;
            for &(w, b) in &values[..i] {
                let distance = patch.points[v as usize].distance(patch.points[w as usize]);
                let bin = 1 + (distance / width) as usize;
                if bin < BINS {
                    sums[bin] += a * b;
                    counts[bin] += 1.0;
                }
            }
        }
        let kernel = |k: usize, bin: usize| {
            let distance = if bin == 0 { 0.0 } else { 0.5 * (bin as f64 - 0.5) };
            match LENGTHS[k] {
                0.0 => f64::from(u8::from(bin == 0)),
                length => (-0.5 * (distance / length).powi(2)).exp(),
            }
        };
        // Least squares with weights that are not negative, one after the other. The variance counts as much as all other bins.
        let weight = |bin: usize| match bin {
            0 => BINS as f64,
            _ => f64::from(u8::from(counts[bin] > 0.0)),
        };
        let mut variances = [0.0; LENGTHS.len()];
        for _ in 0..ROUNDS {
            for k in 0..LENGTHS.len() {
                let (mut up, mut down) = (0.0, 0.0);
                for bin in (0..BINS).filter(|&bin| counts[bin] > 0.0) {
                    let others = (0..LENGTHS.len()).filter(|&other| other != k);
                    let others: f64 = others.map(|o| variances[o] * kernel(o, bin)).sum();
                    let own = kernel(k, bin);
                    up += weight(bin) * own * (sums[bin] / counts[bin] - others);
                    down += weight(bin) * own * own;
                }
                variances[k] = f64::max(up / down.max(f64::MIN_POSITIVE), 0.0);
            }
        }
        Self(variances)
    }

    /// A random field with this covariance at the points of some vertices.
    fn drawn(&self, points: &[DVec3], edge: f64) -> Vec<f64> {
        let mut field = vec![0.0; points.len()];
        let mut random = Random(SEED);
        for (variance, length) in self.0.iter().zip(LENGTHS) {
            if length == 0.0 {
                let deviation = variance.sqrt();
                field.iter_mut().for_each(|f| *f += deviation * random.normal());
                continue;
            }
            let height = (2.0 * variance / WAVES as f64).sqrt();
            let waves: Vec<(DVec3, f64)> = (0..WAVES).map(|_| {
                let wave = DVec3::new(random.normal(), random.normal(), random.normal());
                (wave / (length * edge), TAU * random.uniform())
            }).collect();
            let at = |p: &DVec3| waves.iter().map(|(k, phase)| (k.dot(*p) + phase).cos()).sum::<f64>();
            let values: Vec<f64> = points.par_iter().map(at).collect();
            field.iter_mut().zip(values).for_each(|(f, v)| *f += height * v);
        }
        field
    }
}

/// Numbers that look random, the same each time (G. L. Steele et al., "Fast splittable pseudorandom number generators", 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Between 0 and 1, both excluded.
    fn uniform(&mut self) -> f64 {
        ((self.next() >> 12) as f64 + 0.5) / (1u64 << 52) as f64
    }

    /// Of mean 0 and variance 1 (Box and Muller).
    fn normal(&mut self) -> f64 {
        let (u, v) = (self.uniform(), self.uniform());
        (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
    }
}
