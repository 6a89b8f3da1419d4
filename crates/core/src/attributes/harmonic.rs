//! Harmonic interpolation on patches: Laplace's equation with given values at the rim.
//!
//! Cotangent weights ½(cot α + cot β) (Pinkall and Polthier 1993), bounded below by a positive number, so that no value
//! leaves the range of the rim's values.

use std::collections::VecDeque;

use glam::DVec3;
use sprs::{CompressedStorage, CsVecViewI, TriMatI};

use crate::linalg::{Csr, Jacobi, LinearOperator, SparseMatrix, conjugate_gradient};
use crate::mesh::attributes::NONE;

/// Least and largest weight of an edge, dimensionless: 1 is the weight of an edge whose opposite angles are both 45°.
const WEIGHTS: [f64; 2] = [0.02, 50.0];
/// Relative residual |r| / |b| at which the conjugate gradients stop.
const TOLERANCE: f64 = 1e-9;
const MOST_ITERATIONS: usize = 5000;

/// The weights of the edges of patches.
pub struct Laplacian {
    /// Symmetric, without a diagonal.
    weights: SparseMatrix,
}

/// The equations of the free points.
struct System {
    matrix: Csr,
    inverse_diagonal: Vec<f64>,
}

impl LinearOperator for System {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.matrix.apply(x, y);
    }

    fn jacobi(&self) -> &[f64] {
        &self.inverse_diagonal
    }
}

impl Laplacian {
    /// For the faces between the points.
    pub fn new(points: &[DVec3], faces: &[[u32; 3]]) -> Self {
        let count = points.len();
        let mut entries = TriMatI::with_capacity((count, count), 6 * faces.len());
        // Half the cotangent of the angle at corner c belongs to the opposite edge ab: cot = p·q / |p × q|.
        for face in faces {
            for k in 0..3 {
                let [c, a, b] = [face[k], face[(k + 1) % 3], face[(k + 2) % 3]].map(|v| v as usize);
                let [p, q] = [a, b].map(|v| points[v] - points[c]);
                let twice_area = p.cross(q).length().max(f64::MIN_POSITIVE);
                let weight = 0.5 * (p.dot(q) / twice_area).clamp(-WEIGHTS[1], WEIGHTS[1]);
                entries.add_triplet(a, b, weight);
                entries.add_triplet(b, a, weight);
            }
        }
        let mut weights: SparseMatrix = entries.to_csr();
        weights.map_inplace(|w| w.clamp(WEIGHTS[0], WEIGHTS[1]));
        Self { weights }
    }

    /// The neighbours of a point in ascending order, with their weights.
    fn of(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.weights.indptr().outer_inds_sz(i);
        let columns = &self.weights.indices()[range.clone()];
        let values = &self.weights.data()[range];
        columns
            .iter()
            .map(|j| *j as usize)
            .zip(values.iter().copied())
    }

    /// For each point, the fixed point that is the fewest edges away; `u32::MAX` if it is connected with none.
    pub(super) fn nearest(&self, fixed: &[bool]) -> Vec<u32> {
        let mut nearest = vec![NONE; fixed.len()];
        let mut queue = VecDeque::new();
        for i in (0..fixed.len()).filter(|&i| fixed[i]) {
            nearest[i] = i as u32;
            queue.push_back(i);
        }
        while let Some(i) = queue.pop_front() {
            for (j, _) in self.of(i) {
                if nearest[j] == NONE {
                    nearest[j] = nearest[i];
                    queue.push_back(j);
                }
            }
        }
        nearest
    }

    /// Computes the values of all points that are connected with a fixed point. `values` has `components` numbers per point.
    pub fn solve(&self, fixed: &[bool], components: usize, values: &mut [f64]) {
        let nearest = self.nearest(fixed);
        let mut unknown = vec![NONE; fixed.len()];
        let free: Vec<usize> = (0..fixed.len())
            .filter(|&i| !fixed[i] && nearest[i] != NONE)
            .collect();
        // Number the free points; each starts with the value of the nearest fixed point.
        for (row, &i) in free.iter().enumerate() {
            unknown[i] = row as u32;
        }
        let system = self.system(&free, &unknown);
        for component in 0..components {
            let value = |i: usize| i * components + component;
            let mut x: Vec<f64> = free
                .iter()
                .map(|&i| values[value(nearest[i] as usize)])
                .collect();
            let b: Vec<f64> = free
                .iter()
                .map(|&i| {
                    let fixed = self.of(i).filter(|(j, _)| fixed[*j]);
                    fixed.map(|(j, w)| w * values[value(j)]).sum()
                })
                .collect();
            conjugate_gradient(
                &system,
                &Jacobi(system.jacobi()),
                &b,
                &mut x,
                TOLERANCE,
                MOST_ITERATIONS,
            );
            for (&i, x) in free.iter().zip(x) {
                values[value(i)] = x;
            }
        }
    }

    /// The equations of the free points, which `unknown` numbers in ascending order: Σ w (xᵢ − xⱼ) = 0.
    fn system(&self, free: &[usize], unknown: &[u32]) -> System {
        let count = free.len();
        let mut matrix = SparseMatrix::empty(CompressedStorage::CSR, count);
        matrix.reserve_outer_dim(count);
        matrix.reserve_nnz(count + self.weights.nnz());
        let mut inverse_diagonal = Vec::with_capacity(count);
        for (row, &i) in free.iter().enumerate() {
            let mut diagonal = 0.0;
            let (mut columns, mut values) = (Vec::new(), Vec::new());
            for (j, w) in self.of(i) {
                diagonal += w;
                if j == i {
                    // An edge from a point to itself, of a face that uses the point twice.
                    diagonal -= w;
                } else if unknown[j] != NONE {
                    columns.push(unknown[j]);
                    values.push(-w);
                }
            }
            let at = columns.partition_point(|c| (*c as usize) < row);
            columns.insert(at, row as u32);
            values.insert(at, diagonal);
            let entries = CsVecViewI::new(count, &columns, &values);
            matrix = matrix.append_outer_csvec(entries);
            inverse_diagonal.push(1.0 / diagonal);
        }
        System {
            matrix: matrix.into(),
            inverse_diagonal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of `n` by `n` points with fixed values on its boundary.
    fn square(n: u32) -> (Vec<DVec3>, Vec<[u32; 3]>, Vec<bool>) {
        let (mut points, mut faces, mut fixed) = (Vec::new(), Vec::new(), Vec::new());
        for j in 0..n {
            for i in 0..n {
                points.push(DVec3::new(f64::from(i), f64::from(j), 0.0));
                fixed.push(i == 0 || j == 0 || i + 1 == n || j + 1 == n);
                if i + 1 < n && j + 1 < n {
                    let at = j * n + i;
                    faces.extend([[at, at + 1, at + n], [at + 1, at + n + 1, at + n]]);
                }
            }
        }
        (points, faces, fixed)
    }

    #[test]
    fn linear_functions_are_reproduced() {
        let (points, faces, fixed) = square(12);
        let wanted: Vec<f64> = points
            .iter()
            .flat_map(|p| [2.0 * p.x - p.y, 5.0 - p.x])
            .collect();
        let mut values = wanted.clone();
        for i in (0..fixed.len()).filter(|&i| !fixed[i]) {
            values[2 * i..2 * i + 2].fill(f64::NAN);
        }
        Laplacian::new(&points, &faces).solve(&fixed, 2, &mut values);
        // A weight below the least one is raised, which changes the function slightly.
        for (value, wanted) in values.iter().zip(wanted) {
            assert!((value - wanted).abs() < 0.02, "{value} {wanted}");
        }
    }

    #[test]
    fn a_face_that_uses_a_point_twice_changes_nothing() {
        let (points, mut faces, fixed) = square(5);
        let mut solved = |more: &[[u32; 3]]| {
            faces.extend(more);
            let mut values: Vec<f64> = points.iter().map(|p| p.x).collect();
            Laplacian::new(&points, &faces).solve(&fixed, 1, &mut values);
            values
        };
        let (plain, with) = (solved(&[]), solved(&[[12, 12, 12]]));
        let apart = plain.iter().zip(with).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-6);
    }

    #[test]
    fn values_stay_between_those_of_the_rim() {
        let (mut points, faces, fixed) = square(9);
        for (i, p) in points.iter_mut().enumerate().filter(|(i, _)| !fixed[*i]) {
            *p += DVec3::new((i as f64).sin(), (i as f64 * 1.7).cos(), 0.3) * 0.45;
        }
        let mut values: Vec<f64> = (0..81).map(|i| f64::from(i % 2)).collect();
        Laplacian::new(&points, &faces).solve(&fixed, 1, &mut values);
        let inner = (0..81).filter(|&i| !fixed[i]);
        for i in inner {
            assert!(values[i] > 0.05 && values[i] < 0.95, "{}", values[i]);
        }
    }
}
