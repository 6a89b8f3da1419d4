//! Parameterisation of a disk over the unit circle by mean value coordinates, with the border fixed on the circle.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use sprs::TriMatI;

use super::disk::Disk;
use isomend_core::cancel::Cancel;
use isomend_core::elementary::{at_angle, cos, sin};
use isomend_core::linalg::{Csr, Jacobi, LinearOperator, SparseMatrix, bicgstab};
use isomend_core::mesh::attributes::NONE;

/// Relative residual |r| / |b| of the linear systems: close to rounding, since triangles of deep patches are tiny in the circle and must
/// not flip. None of 10,384 triangles in 342 patches of a bunny flipped; other values were not measured.
const TOLERANCE: f64 = 1e-13;
const MOST_ITERATIONS: usize = 20_000;
/// Bounds of tan(α/2) in a weight; they change only the weights of slivers.
const TANGENTS: [f64; 2] = [1e-3, 1e3];
/// Lower bound of a border edge over the mean border edge, so that its ends differ on the circle; and upper bound over the whole length, so
/// that an edge does not pass the centre.
const BORDER_EDGES: [f64; 2] = [1e-3, 0.4];

/// Weights of the edges of a disk. All are positive and the border is convex, so no triangle flips (Tutte 1963, Floater 2003).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Weights {
    /// Mean value coordinates (M. S. Floater, "Mean value coordinates", 2003, equation 2.1): low distortion of angles.
    MeanValue,
    /// All equal (W. T. Tutte, "How to draw a graph", 1963): if mean value coordinates flip thin triangles by rounding.
    Equal,
}

/// The border of a chart: a convex polygon with vertices on the unit circle, at arcs proportional to the edges' lengths in space.
pub(super) struct Border {
    /// The vertices of the disk, in order.
    pub(super) vertices: Vec<u32>,
    /// Their angles in radians, rising from 0.
    angles: Vec<f64>,
    /// The length of the border in space.
    pub(super) length: f64,
}

impl Border {
    pub(super) fn new(disk: &Disk, points: &[DVec3]) -> Self {
        let count = disk.border.len();
        let at = |i: usize| points[disk.border[i % count] as usize];
        let lengths: Vec<f64> = (0..count).map(|i| at(i).distance(at(i + 1))).collect();
        let length: f64 = lengths.iter().sum();
        let least = (BORDER_EDGES[0] * length / count as f64).max(f64::MIN_POSITIVE);
        let largest = (BORDER_EDGES[1] * length).max(least);
        let lengths: Vec<f64> = lengths.iter().map(|l| l.clamp(least, largest)).collect();
        let total: f64 = lengths.iter().sum();
        let mut sum = 0.0;
        let angle = |l: &f64| {
            let angle = TAU * sum / total;
            sum += l;
            angle
        };
        Self {
            vertices: disk.border.clone(),
            angles: lengths.iter().map(angle).collect(),
            length,
        }
    }

    /// Number of edges.
    pub(super) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// The vertices of the disk at the ends of an edge.
    pub(super) fn ends(&self, edge: usize) -> [u32; 2] {
        [edge, (edge + 1) % self.len()].map(|i| self.vertices[i])
    }

    /// Where the ray from the centre at an angle leaves the polygon: the edge, the fraction of the edge before that point, and the point's
    /// distance from the centre.
    pub(super) fn at_angle(&self, angle: f64) -> (usize, f64, f64) {
        let angle = angle.rem_euclid(TAU);
        let edge = self.angles.partition_point(|a| *a <= angle).max(1) - 1;
        let start = self.angles[edge];
        let end = self.angles.get(edge + 1).copied().unwrap_or(TAU);
        let (before, behind) = (sin(angle - start), sin(end - angle));
        let part = before / (before + behind).max(f64::MIN_POSITIVE);
        let distance = cos(0.5 * (end - start)) / cos(angle - 0.5 * (start + end));
        (edge, part.clamp(0.0, 1.0), distance)
    }
}

/// The positions of the vertices of a disk in the unit circle; meaningless if cancelled.
///
/// Solves x_i = Σ_j λ_ij x_j with λ_ij = w_ij / Σ_k w_ik for the inner vertices, one coordinate after the other.
pub(super) fn layout(
    disk: &Disk,
    points: &[DVec3],
    border: &Border,
    weights: Weights,
    cancel: &Cancel,
) -> Vec<DVec2> {
    let mut places = vec![DVec2::ZERO; points.len()];
    let mut row = vec![0; points.len()];
    for (&vertex, angle) in border.vertices.iter().zip(&border.angles) {
        places[vertex as usize] = at_angle(*angle);
        row[vertex as usize] = NONE;
    }
    let mut count = 0;
    for row in row.iter_mut().filter(|row| **row != NONE) {
        *row = count;
        count += 1;
    }
    if count > 0 {
        let mut system = System::new(disk, points, &row, count as usize, weights);
        system.cancel = cancel.clone();
        let mut x = vec![0.0; count as usize];
        for axis in 0..2 {
            let mut b = vec![0.0; count as usize];
            for &(row, vertex, weight) in &system.fixed {
                b[row as usize] += weight * places[vertex as usize][axis];
            }
            let jacobi = Jacobi(system.jacobi());
            bicgstab(&system, &jacobi, &b, &mut x, TOLERANCE, MOST_ITERATIONS);
            for (place, row) in places.iter_mut().zip(&row).filter(|(_, row)| **row != NONE) {
                place[axis] = x[*row as usize];
            }
        }
    }
    places
}

/// The equations of the inner vertices: each is the weighted mean of its neighbours.
struct System {
    matrix: Csr,
    inverse_diagonal: Vec<f64>,
    /// Row, neighbour on the border and normalised weight, for the right-hand side.
    fixed: Vec<(u32, u32, f64)>,
    cancel: Cancel,
}

impl LinearOperator for System {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.matrix.apply(x, y);
    }

    fn jacobi(&self) -> &[f64] {
        &self.inverse_diagonal
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }
}

impl System {
    fn new(disk: &Disk, points: &[DVec3], row: &[u32], count: usize, weights: Weights) -> Self {
        let mut pairs = Vec::with_capacity(6 * disk.faces.len());
        let mut sums = vec![0.0; count];
        for face in &disk.faces {
            for k in 0..3 {
                let [i, j, l] = [face[k], face[(k + 1) % 3], face[(k + 2) % 3]];
                let own = row[i as usize];
                if own == NONE {
                    continue;
                }
                for (neighbour, weight) in [j, l].into_iter().zip(weights.of(points, [i, j, l])) {
                    pairs.push((own, neighbour, weight));
                    sums[own as usize] += weight;
                }
            }
        }
        let mut entries = TriMatI::with_capacity((count, count), pairs.len() + count);
        let mut fixed = Vec::new();
        for (own, neighbour, weight) in pairs {
            let part = weight / sums[own as usize];
            match row[neighbour as usize] {
                NONE => fixed.push((own, neighbour, part)),
                other => entries.add_triplet(own as usize, other as usize, -part),
            }
        }
        (0..count).for_each(|i| entries.add_triplet(i, i, 1.0));
        let matrix: SparseMatrix = entries.to_csr();
        Self {
            matrix: matrix.into(),
            inverse_diagonal: vec![1.0; count],
            fixed,
            cancel: Cancel::new(),
        }
    }
}

impl Weights {
    /// The contribution of a face's corner at its first vertex to the weights of the edges from there to the other two.
    fn of(self, points: &[DVec3], [i, j, l]: [u32; 3]) -> [f64; 2] {
        if self == Self::Equal {
            return [1.0; 2];
        }
        let [a, b] = [j, l].map(|v| points[v as usize] - points[i as usize]);
        let [long, other] = [a, b].map(|e| e.length().max(f64::MIN_POSITIVE));
        // tan(α/2) = sin α / (1 + cos α).
        let tangent = a.cross(b).length() / (long * other + a.dot(b)).max(f64::MIN_POSITIVE);
        let tangent = tangent.clamp(TANGENTS[0], TANGENTS[1]);
        [tangent / long, tangent / other]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cap of the unit sphere down to a polar angle in radians, with `rings` rings of vertices.
    pub(in super::super) fn cap(rings: u32, angle: f64) -> (Vec<[u32; 3]>, Vec<DVec3>) {
        let around = 4 * rings;
        let mut points = vec![DVec3::Z];
        let mut faces = Vec::new();
        for ring in 1..=rings {
            let (sin, cos) = (angle * f64::from(ring) / f64::from(rings)).sin_cos();
            for i in 0..around {
                let (y, x) = (TAU * f64::from(i) / f64::from(around)).sin_cos();
                points.push(DVec3::new(sin * x, sin * y, cos));
            }
        }
        let at = |ring: u32, i: u32| 1 + (ring - 1) * around + i % around;
        for i in 0..around {
            faces.push([0, at(1, i), at(1, i + 1)]);
            for ring in 1..rings {
                let [a, b] = [at(ring, i), at(ring, i + 1)];
                let [c, d] = [at(ring + 1, i), at(ring + 1, i + 1)];
                faces.extend([[a, c, b], [b, c, d]]);
            }
        }
        (faces, points)
    }

    fn areas(disk: &Disk, places: &[DVec2]) -> Vec<f64> {
        let area = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| places[v as usize]);
            0.5 * (b - a).perp_dot(c - a)
        };
        disk.faces.iter().map(area).collect()
    }

    #[test]
    fn no_triangle_flips_over_and_a_flat_one_keeps_its_shape() {
        for (rings, angle) in [(1, 0.5), (8, 1.5), (20, 3.0)] {
            let (faces, points) = cap(rings, angle);
            let disk = Disk::cut(&faces).unwrap();
            let own: Vec<DVec3> = disk.slots.iter().map(|s| points[*s as usize]).collect();
            let border = Border::new(&disk, &own);
            for weights in [Weights::MeanValue, Weights::Equal] {
                let places = layout(&disk, &own, &border, weights, &Cancel::new());
                assert!(areas(&disk, &places).into_iter().all(|a| a > 0.0));
            }
            let flat: Vec<DVec3> = own.iter().map(|p| p.truncate().extend(0.0)).collect();
            if angle < 1.6 {
                let radius = angle.sin();
                let places = layout(
                    &disk,
                    &flat,
                    &Border::new(&disk, &flat),
                    Weights::MeanValue,
                    &Cancel::new(),
                );
                let first =
                    DVec2::from_angle(-flat[border.vertices[0] as usize].truncate().to_angle());
                for (place, point) in places.iter().zip(&flat) {
                    let wanted = first.rotate(point.truncate()) / radius;
                    assert!(place.distance(wanted) < 1e-9, "{place} {wanted}");
                }
            }
        }
    }

    #[test]
    fn a_ray_leaves_the_polygon_on_its_edge() {
        let disk = Disk::cut(&[[0, 1, 2], [0, 2, 3]]).unwrap();
        let points = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 2.0, 0.0), DVec3::Y];
        let border = Border::new(&disk, &points);
        let places = layout(&disk, &points, &border, Weights::MeanValue, &Cancel::new());
        for i in 0..100 {
            let angle = 0.0628 * f64::from(i) + 0.01;
            let (edge, part, distance) = border.at_angle(angle);
            let [a, b] = border.ends(edge).map(|v| places[v as usize]);
            assert!(
                a.lerp(b, part)
                    .distance(distance * DVec2::from_angle(angle))
                    < 1e-12
            );
        }
    }
}
