//! Discrete geometry of triangle meshes: normals, areas, cotangent weights, curvatures.
//!
//! M. Meyer, M. Desbrun, P. Schröder, A. H. Barr, "Discrete differential-geometry operators for triangulated 2-manifolds",
//! Visualization and Mathematics III, 2003.

use std::f64::consts::PI;

use crate::elementary::atan2;
use crate::mesh::{area_vector, half_cotangents};
use crate::tuning::{Tunable, tunable};
use glam::DVec3;
use sprs::CsMat;

/// Lower bound of a face's area over the largest face's area where it is a divisor.
const LEAST_FACE: Tunable<f64> = tunable("finish.least_face", 1e-12);

/// Lower bound of a vertex's area over the median vertex area.
const LEAST_VERTEX: Tunable<f64> = tunable("finish.least_vertex", 1e-3);

/// Lower bound of a corner's cotangent: larger angles (153°) would make the systems ill-conditioned.
const LEAST_COTANGENT: Tunable<f64> = tunable("finish.least_cotangent", -2.0);

/// Upper bound of a corner's cotangent: 7°.
const LARGEST_COTANGENT: Tunable<f64> = tunable("finish.largest_cotangent", 8.0);

/// Faces as triples of local vertex numbers.
pub(super) type Faces = [[u32; 3]];

/// The corners of a face.
pub(super) fn corners(points: &[DVec3], face: [u32; 3]) -> [DVec3; 3] {
    face.map(|v| points[v as usize])
}

/// Unit normals of vertices, with faces weighted by area; zero without area.
pub(super) fn vertex_normals(points: &[DVec3], faces: &Faces) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; points.len()];
    for &face in faces {
        let area = area_vector(corners(points, face));
        face.iter().for_each(|&v| sums[v as usize] += area);
    }
    sums.into_iter().map(DVec3::normalize_or_zero).collect()
}

/// The median, the lower of the two middle values if their number is even; zero without values.
pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    if values.is_empty() {
        return 0.0;
    }
    let middle = (values.len() - 1) / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Raises small areas to a fraction of the median.
fn raised(mut areas: Vec<f64>) -> Vec<f64> {
    let least = LEAST_VERTEX.get() * median(areas.iter().copied());
    areas.iter_mut().for_each(|a| *a = a.max(least));
    areas
}

/// Half the cotangents at the corners of each face, clamped, and twice its area.
pub(super) fn clamped_cotangents(points: &[DVec3], faces: &Faces) -> (Vec<[f64; 3]>, Vec<f64>) {
    let area = |&f: &[u32; 3]| area_vector(corners(points, f)).length();
    let mut areas: Vec<f64> = faces.iter().map(area).collect();
    let least = least_area(&areas);
    areas.iter_mut().for_each(|a| *a = a.max(least));
    let at = |(&face, area): (&[u32; 3], &f64)| clamped(corners(points, face), *area);
    (faces.iter().zip(&areas).map(at).collect(), areas)
}

/// Half the cotangents at the corners of a face, clamped.
fn clamped(p: [DVec3; 3], twice_area: f64) -> [f64; 3] {
    let (low, high) = (0.5 * LEAST_COTANGENT.get(), 0.5 * LARGEST_COTANGENT.get());
    half_cotangents(p, twice_area).map(|half| half.clamp(low, high))
}

/// Lower bound of an area as a divisor.
fn least_area(areas: &[f64]) -> f64 {
    LEAST_FACE.get() * areas.iter().copied().fold(0.0, f64::max)
}

/// Barycentric areas of vertices from twice the areas of faces.
pub(super) fn barycentric(count: usize, faces: &Faces, twice: &[f64]) -> Vec<f64> {
    let mut areas = vec![0.0; count];
    for (face, area) in faces.iter().zip(twice) {
        face.iter().for_each(|&v| areas[v as usize] += area / 6.0);
    }
    raised(areas)
}

/// What the mean curvature of a surface is computed from.
pub(super) struct CurvatureTerms {
    /// Half the cotangents at the corners of each face, as [`clamped_cotangents`].
    pub(super) half_cotangents: Vec<[f64; 3]>,
    /// As [`vertex_normals`].
    pub(super) normals: Vec<DVec3>,
    /// Mixed Voronoi areas of vertices (Meyer et al., figure 4): an obtuse face gives half of its area to the obtuse corner and a
    /// quarter to each other.
    pub(super) masses: Vec<f64>,
    /// `S x` for each vertex without assembling the matrix. Divided by the mixed area it is the mean curvature normal (Meyer et al.,
    /// equation (8)), whose length is the sum of the principal curvatures.
    pub(super) pulls: Vec<DVec3>,
}

impl CurvatureTerms {
    pub(super) fn new(points: &[DVec3], faces: &Faces) -> Self {
        let mut normals = vec![DVec3::ZERO; points.len()];
        let area = |&face: &[u32; 3]| {
            let area = area_vector(corners(points, face));
            face.iter().for_each(|&v| normals[v as usize] += area);
            area.length()
        };
        let areas: Vec<f64> = faces.iter().map(area).collect();
        let least = least_area(&areas);
        let mut masses = vec![0.0; points.len()];
        let mut pulls = vec![DVec3::ZERO; points.len()];
        let weigh = |(&face, &twice): (&[u32; 3], &f64)| {
            let p = corners(points, face);
            let weights = clamped(p, twice.max(least));
            let shares = voronoi_shares(p, twice);
            for k in 0..3 {
                let [i, j] = [(k + 1) % 3, (k + 2) % 3];
                let pull = weights[k] * (p[i] - p[j]);
                pulls[face[i] as usize] += pull;
                pulls[face[j] as usize] -= pull;
                masses[face[k] as usize] += shares[k];
            }
            weights
        };
        Self {
            half_cotangents: faces.iter().zip(&areas).map(weigh).collect(),
            normals: normals.into_iter().map(DVec3::normalize_or_zero).collect(),
            masses: raised(masses),
            pulls,
        }
    }
}

/// The parts of a face's area that its corners get, from twice the area.
fn voronoi_shares(p: [DVec3; 3], twice: f64) -> [f64; 3] {
    let dots = [0, 1, 2].map(|k| (p[(k + 1) % 3] - p[k]).dot(p[(k + 2) % 3] - p[k]));
    let obtuse = dots.iter().position(|&d| d < 0.0);
    [0, 1, 2].map(|k| match obtuse {
        Some(o) if o == k => 0.25 * twice,
        Some(_) => 0.125 * twice,
        None => {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let sum = p[i].distance_squared(p[k]) * dots[j] + p[j].distance_squared(p[k]) * dots[i];
            sum / (8.0 * twice.max(f64::MIN_POSITIVE))
        }
    })
}

/// Gaussian curvature at vertices: the angle defect over the area (Meyer et al., equation (9)).
pub(super) fn gauss_curvature(points: &[DVec3], faces: &Faces, areas: &[f64]) -> Vec<f64> {
    let mut lack = vec![2.0 * PI; points.len()];
    for &face in faces {
        let p = corners(points, face);
        for k in 0..3 {
            let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            lack[face[k] as usize] -= atan2(u.cross(v).length(), u.dot(v));
        }
    }
    lack.iter().zip(areas).map(|(l, a)| l / a).collect()
}

/// The stiffness matrix `S` of the cotangent weights, `(S u)_i = Σ_j w_ij (u_i − u_j)`. Its pattern depends only on the faces and
/// is reused for all positions of the vertices.
#[derive(Clone)]
pub(super) struct Stiffness {
    /// The matrix by rows.
    pub(super) matrix: CsMat<f64>,
    /// For each corner of each face, the two entries of the edge opposite to it.
    slots: Vec<[[usize; 2]; 3]>,
    /// The diagonal entry of each vertex.
    diagonal: Vec<usize>,
}

impl Stiffness {
    /// The pattern, with all entries zero.
    pub(super) fn new(count: usize, faces: &Faces) -> Self {
        // Neighbours of each vertex: every edge of a face adds each end to the row of the other; a row also holds its own vertex.
        let mut ends = vec![1usize; count];
        faces.iter().flatten().for_each(|&v| ends[v as usize] += 2);
        let mut sum = 0;
        for end in &mut ends {
            let start = sum;
            sum += *end;
            *end = start;
        }
        let first = ends.clone();
        let mut neighbours = vec![0u32; sum];
        let mut add = |i: u32, j: u32| {
            neighbours[ends[i as usize]] = j;
            ends[i as usize] += 1;
        };
        (0..count as u32).for_each(|i| add(i, i));
        for face in faces {
            for k in 0..3 {
                let (i, j) = (face[k], face[(k + 1) % 3]);
                add(i, j);
                add(j, i);
            }
        }
        // Sorts each row and removes repetitions.
        let (mut starts, mut indices) = (vec![0], Vec::with_capacity(sum));
        for (&from, &to) in first.iter().zip(&ends) {
            let row = &mut neighbours[from..to];
            row.sort_unstable();
            let own = indices.len();
            for &j in &*row {
                if indices.len() == own || indices[indices.len() - 1] != j as usize {
                    indices.push(j as usize);
                }
            }
            starts.push(indices.len());
        }
        // The index of each edge's two entries.
        let slot = |i: u32, j: u32| {
            let own = starts[i as usize];
            own + indices[own..starts[i as usize + 1]].partition_point(|&c| c < j as usize)
        };
        let opposite = |face: &[u32; 3]| {
            [0, 1, 2].map(|k| {
                let (i, j) = (face[(k + 1) % 3], face[(k + 2) % 3]);
                [slot(i, j), slot(j, i)]
            })
        };
        let slots = faces.iter().map(opposite).collect();
        let diagonal = (0..count as u32).map(|i| slot(i, i)).collect();
        let zeros = vec![0.0; indices.len()];
        Self {
            matrix: CsMat::new((count, count), starts, indices, zeros),
            slots,
            diagonal,
        }
    }

    /// Sets the entries from half the cotangents at the corners of the faces.
    pub(super) fn set(&mut self, faces: &Faces, half_cotangents: &[[f64; 3]]) {
        let data = self.matrix.data_mut();
        data.fill(0.0);
        for ((face, slots), weights) in faces.iter().zip(&self.slots).zip(half_cotangents) {
            for k in 0..3 {
                let weight = weights[k];
                slots[k].iter().for_each(|&s| data[s] -= weight);
                data[self.diagonal[face[(k + 1) % 3] as usize]] += weight;
                data[self.diagonal[face[(k + 2) % 3] as usize]] += weight;
            }
        }
    }
}

/// A quantile by linear interpolation between the sorted values; infinite without values.
pub(super) fn quantile(values: impl Iterator<Item = f64>, part: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_unstable_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else {
        return f64::INFINITY;
    };
    let at = part * last as f64;
    let low = (at as usize).min(last);
    let high = (low + 1).min(last);
    values[low] + (at - low as f64) * (values[high] - values[low])
}
