//! Harmonic interpolation on patches: Laplace's equation with the values at the rim given.
//!
//! Cotangent weights (Pinkall and Polthier 1993), kept positive, so that no value leaves the range of those at the rim.

use std::collections::VecDeque;

use glam::DVec3;

use crate::linalg::{Csr, Jacobi, LinearOperator, conjugate_gradient};
use crate::mesh::attributes::NONE;

/// The least and the largest weight of an edge, in units of the cotangent of 45°.
const WEIGHTS: [f64; 2] = [0.02, 50.0];
const TOLERANCE: f64 = 1e-9;
const MOST_ITERATIONS: usize = 5000;

/// The graph Laplacian of the patches.
pub(super) struct Laplacian {
    offsets: Vec<usize>,
    neighbours: Vec<(u32, f64)>,
}

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
    pub(super) fn new(points: &[DVec3], faces: &[[u32; 3]]) -> Self {
        let mut entries: Vec<(u32, u32, f64)> = Vec::with_capacity(6 * faces.len());
        for face in faces {
            for k in 0..3 {
                let [c, a, b] = [face[k], face[(k + 1) % 3], face[(k + 2) % 3]];
                let [p, q] = [a, b].map(|v| points[v as usize] - points[c as usize]);
                let twice_area = p.cross(q).length().max(f64::MIN_POSITIVE);
                let weight = 0.5 * (p.dot(q) / twice_area).clamp(-WEIGHTS[1], WEIGHTS[1]);
                entries.extend([(a, b, weight), (b, a, weight)]);
            }
        }
        entries.sort_by_key(|e| (e.0, e.1));
        let mut offsets = vec![0; points.len() + 1];
        let mut neighbours: Vec<(u32, f64)> = Vec::new();
        let mut last = None;
        for (from, to, weight) in entries {
            if last == Some((from, to)) {
                if let Some(sum) = neighbours.last_mut() {
                    sum.1 += weight;
                }
            } else {
                neighbours.push((to, weight));
                offsets[from as usize + 1] += 1;
                last = Some((from, to));
            }
        }
        for i in 0..points.len() {
            offsets[i + 1] += offsets[i];
        }
        for neighbour in &mut neighbours {
            neighbour.1 = neighbour.1.clamp(WEIGHTS[0], WEIGHTS[1]);
        }
        Self {
            offsets,
            neighbours,
        }
    }

    fn of(&self, i: usize) -> &[(u32, f64)] {
        &self.neighbours[self.offsets[i]..self.offsets[i + 1]]
    }

    /// For each point the fixed one that is fewest edges away, or [`NONE`] where there is none.
    pub(super) fn nearest(&self, fixed: &[bool]) -> Vec<u32> {
        let mut nearest = vec![NONE; fixed.len()];
        let mut queue = VecDeque::new();
        for i in (0..fixed.len()).filter(|&i| fixed[i]) {
            nearest[i] = i as u32;
            queue.push_back(i);
        }
        while let Some(i) = queue.pop_front() {
            for &(j, _) in self.of(i) {
                if nearest[j as usize] == NONE {
                    nearest[j as usize] = nearest[i];
                    queue.push_back(j as usize);
                }
            }
        }
        nearest
    }

    /// Fills in the values, of so many components, of all points that are connected with a fixed one.
    pub(super) fn solve(&self, fixed: &[bool], components: usize, values: &mut [f64]) {
        let nearest = self.nearest(fixed);
        let mut unknown = vec![NONE; fixed.len()];
        let free: Vec<usize> = (0..fixed.len())
            .filter(|&i| !fixed[i] && nearest[i] != NONE)
            .collect();
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
                    let fixed = self.of(i).iter().filter(|(j, _)| fixed[*j as usize]);
                    fixed.map(|(j, w)| w * values[value(*j as usize)]).sum()
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

    fn system(&self, free: &[usize], unknown: &[u32]) -> System {
        let matrix = Csr::from_rows(free.len(), free.len(), |row, sink| {
            for &(j, w) in self.of(free[row]) {
                sink.add(row as u32, w);
                if unknown[j as usize] != NONE {
                    sink.add(unknown[j as usize], -w);
                }
            }
        });
        let inverse_diagonal = matrix.diagonal().iter().map(|d| 1.0 / d).collect();
        System {
            matrix,
            inverse_diagonal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of `n` by `n` points, its rim fixed.
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
        // A weight below the least is raised, which bends the function a little.
        for (value, wanted) in values.iter().zip(wanted) {
            assert!((value - wanted).abs() < 0.02, "{value} {wanted}");
        }
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
