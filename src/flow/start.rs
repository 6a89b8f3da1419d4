//! The start of the flow: a biharmonic fill of the unknown nodes.

use std::sync::Mutex;

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

/// `Kᵀ K` of the seven-point Laplacian with rows on the mask and its neighbours. The last entry of its vectors is zero; it
/// stands for the nodes that are not there.
struct Bilaplacian {
    /// Six neighbours of each node.
    near: Vec<[u32; 6]>,
    row: Vec<bool>,
    free: Vec<bool>,
    jacobi: Vec<f64>,
    /// The Laplacian, kept from one product to the next.
    laplacian: Mutex<Vec<f64>>,
}

impl Bilaplacian {
    /// The Laplacian of `x` at the nodes that `wanted` marks, zero elsewhere.
    fn laplacian(&self, x: &[f64], wanted: &[bool], y: &mut [f64]) {
        y.par_chunks_mut(CHUNK).enumerate().for_each(|(c, out)| {
            for (i, o) in (c * CHUNK..).zip(out.iter_mut()) {
                *o = if wanted[i] {
                    let sum: f64 = self.near[i].iter().map(|&j| x[j as usize]).sum();
                    sum - 6.0 * x[i]
                } else {
                    0.0
                };
            }
        });
    }
}

impl LinearOperator for Bilaplacian {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let kept = self.laplacian.lock();
        let mut t = kept.map_or_else(|_| Vec::new(), |mut kept| std::mem::take(&mut *kept));
        t.resize(x.len(), 0.0);
        self.laplacian(x, &self.row, &mut t);
        self.laplacian(&t, &self.free, y);
        if let Ok(mut kept) = self.laplacian.lock() {
            *kept = t;
        }
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
    let nowhere = slots.len() as u32;
    let near_of =
        |&s: &usize| NEIGHBOURS.map(|o| at(grid.node(s), o).map_or(nowhere, |t| number[t]));
    let near: Vec<[u32; 6]> = slots.iter().map(near_of).chain([[nowhere; 6]]).collect();
    let free: Vec<bool> = slots.iter().map(|&s| mask[s]).chain([false]).collect();
    let has_row = |(&s, near): (&usize, &[u32; 6])| one[s] && near.iter().all(|&j| j < nowhere);
    let operator = Bilaplacian {
        row: slots
            .iter()
            .zip(&near)
            .map(has_row)
            .chain([false])
            .collect(),
        jacobi: free.iter().map(|&f| f64::from(u8::from(f))).collect(),
        near,
        free,
        laplacian: Mutex::default(),
    };
    let known: Vec<f64> = slots.iter().map(|&s| phi[s]).chain([0.0]).collect();
    let mut b = vec![0.0; known.len()];
    operator.apply(&known, &mut b);
    b.iter_mut().for_each(|v| *v = -*v);
    let mut x = vec![0.0; known.len()];
    let outcome = conjugate_gradient(
        &operator,
        &Jacobi(&operator.jacobi),
        &b,
        &mut x,
        tolerance,
        2000,
    );
    for (&s, x) in slots.iter().zip(&x) {
        phi[s] += x;
    }
    outcome
}
