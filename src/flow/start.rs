//! The start of the flow: a biharmonic fill of the unknown nodes.

use rayon::prelude::*;

use crate::grid::{NodeIndex, SparseGrid};
use crate::linalg::{CgOutcome, Jacobi, LinearOperator, conjugate_gradient};

const CHUNK: usize = 2048;
const NEIGHBOURS: [NodeIndex; 6] = [
    [-1, 0, 0],
    [0, -1, 0],
    [0, 0, -1],
    [0, 0, 1],
    [0, 1, 0],
    [1, 0, 0],
];

/// `Kᵀ K` of the seven-point Laplacian with rows on the mask and its neighbours.
struct Bilaplacian {
    /// Six neighbours of each node; the number of nodes where there is none.
    near: Vec<[u32; 6]>,
    row: Vec<bool>,
    free: Vec<bool>,
    jacobi: Vec<f64>,
}

impl Bilaplacian {
    fn laplacian(&self, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; x.len() + 1];
        let padded = padded(x);
        out[..x.len()]
            .par_chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(c, out)| {
                for (i, o) in (c * CHUNK..).zip(out.iter_mut()) {
                    if self.row[i] {
                        *o = self.sum(i, &padded) - 6.0 * x[i];
                    }
                }
            });
        out
    }

    fn sum(&self, i: usize, x: &[f64]) -> f64 {
        self.near[i].iter().map(|&j| x[j as usize]).sum()
    }
}

fn padded(x: &[f64]) -> Vec<f64> {
    let mut p = Vec::with_capacity(x.len() + 1);
    p.extend_from_slice(x);
    p.push(0.0);
    p
}

impl LinearOperator for Bilaplacian {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let t = self.laplacian(x);
        y.par_chunks_mut(CHUNK).enumerate().for_each(|(c, out)| {
            for (i, o) in (c * CHUNK..).zip(out.iter_mut()) {
                *o = if self.free[i] {
                    self.sum(i, &t) - 6.0 * t[i]
                } else {
                    0.0
                };
            }
        });
    }

    fn jacobi(&self) -> &[f64] {
        &self.jacobi
    }
}

/// Replaces `phi` at the masked nodes by the minimiser of `∫ (Δφ)²` with φ given on the two layers of nodes round the mask.
pub fn biharmonic_fill(
    grid: &SparseGrid,
    phi: &mut [f64],
    mask: &[bool],
    tolerance: f64,
) -> CgOutcome {
    let at = |n: NodeIndex, o: NodeIndex| grid.slot([n[0] + o[0], n[1] + o[1], n[2] + o[2]]);
    let touches = |s: usize, set: &[bool]| {
        set[s]
            || NEIGHBOURS
                .iter()
                .any(|&o| at(grid.node(s), o).is_some_and(|t| set[t]))
    };
    let one: Vec<bool> = (0..grid.len()).map(|s| touches(s, mask)).collect();
    let two: Vec<bool> = (0..grid.len()).map(|s| touches(s, &one)).collect();
    let slots: Vec<usize> = (0..grid.len()).filter(|&s| two[s]).collect();
    let mut number = vec![slots.len() as u32; grid.len()];
    for (i, &s) in slots.iter().enumerate() {
        number[s] = i as u32;
    }
    let near: Vec<[u32; 6]> = slots
        .iter()
        .map(|&s| NEIGHBOURS.map(|o| at(grid.node(s), o).map_or(slots.len() as u32, |t| number[t])))
        .collect();
    let free: Vec<bool> = slots.iter().map(|&s| mask[s]).collect();
    let operator = Bilaplacian {
        row: slots
            .iter()
            .zip(&near)
            .map(|(&s, near)| one[s] && near.iter().all(|&j| (j as usize) < slots.len()))
            .collect(),
        jacobi: free.iter().map(|&f| f64::from(u8::from(f))).collect(),
        near,
        free,
    };
    let known: Vec<f64> = slots.iter().map(|&s| phi[s]).collect();
    let mut b = vec![0.0; slots.len()];
    operator.apply(&known, &mut b);
    b.iter_mut().for_each(|v| *v = -*v);
    let mut x = vec![0.0; slots.len()];
    let outcome = conjugate_gradient(
        &operator,
        &Jacobi(&operator.jacobi),
        &b,
        &mut x,
        tolerance,
        2000,
    );
    for (i, &s) in slots.iter().enumerate() {
        phi[s] += x[i];
    }
    outcome
}
