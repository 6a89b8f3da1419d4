//! Initial surface of the flow: a biharmonic fill of the unknown nodes.

use std::sync::Mutex;

use rayon::prelude::*;

use crate::cancel::Cancel;
use crate::grid::{NodeIndex, SparseGrid, as_point, linear, value_and_gradient};
use crate::linalg::{CgOutcome, Jacobi, LinearOperator, conjugate_gradient};
use crate::threads::{CollectIndexed, for_each_chunk};
use crate::tuning::{Tunable, tunable};

/// Free nodes. A lattice with fewer is not coarsened further: its solve starts from the values that it has.
const FEW_START_UNKNOWNS: Tunable<usize> = tunable("flow.few_start_unknowns", 400);

/// Nodes per unit of work of a thread.
const CHUNK: usize = 2048;
/// Offsets to the six neighbours of a node.
const NEIGHBOURS: [NodeIndex; 6] = [
    [-1, 0, 0],
    [0, -1, 0],
    [0, 0, -1],
    [0, 0, 1],
    [0, 1, 0],
    [1, 0, 0],
];

/// `Kᵀ K`, where K is the seven-point Laplacian with rows on the mask and its neighbours. Vectors have one extra entry at the
/// end, always zero, which stands for missing nodes.
struct Bilaplacian {
    /// Six neighbours of each node.
    near: Vec<[u32; 6]>,
    /// Whether K has a row at a node.
    row: Vec<bool>,
    /// Whether a node is an unknown.
    free: Vec<bool>,
    jacobi: Vec<f64>,
    /// Buffer for the Laplacian, reused from one product to the next.
    laplacian: Mutex<Vec<f64>>,
    cancel: Cancel,
}

impl Bilaplacian {
    /// The Laplacian of `x` at the nodes marked in `wanted`, zero elsewhere.
    fn laplacian(&self, x: &[f64], wanted: &[bool], y: &mut [f64]) {
        for_each_chunk(y, CHUNK, &|c, out| {
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

    fn is_cancelled(&self) -> bool {
        self.cancel.is_cancelled()
    }
}

/// Replaces `phi` at the masked nodes by the minimiser of `∫ (Δφ)²`, with φ given on the two layers of nodes around the mask. The
/// solution on every other node initialises the solve on all nodes. `phi` and `mask` have one entry for each slot of the grid.
/// `tolerance` bounds the residual relative to the right-hand side, which is the residual with zero at all masked nodes.
pub fn biharmonic_fill(
    grid: &SparseGrid,
    phi: &mut [f64],
    mask: &[bool],
    tolerance: f64,
) -> CgOutcome {
    fill(grid, phi, mask, &vec![true; grid.len()], tolerance)
}

/// The nodes of a fill: the masked ones and two layers around them.
struct Nodes {
    /// For each slot of the grid, whether it is masked or in the first layer.
    one: Vec<bool>,
    /// The slots of the nodes.
    slots: Vec<usize>,
    /// The numbers of the six neighbours of each node; missing ones have the number after the last node, which has an entry of
    /// its own.
    near: Vec<[u32; 6]>,
}

impl Nodes {
    fn new(grid: &SparseGrid, mask: &[bool], there: &[bool]) -> Self {
        let at = |n: NodeIndex, o: NodeIndex| {
            let slot = grid.slot([n[0] + o[0], n[1] + o[1], n[2] + o[2]])?;
            there[slot].then_some(slot)
        };
        let touches = |s: usize, set: &[bool]| {
            set[s]
                || NEIGHBOURS
                    .iter()
                    .any(|&o| at(grid.node(s), o).is_some_and(|t| set[t]))
        };
        let grown = |set: &[bool]| -> Vec<bool> {
            let slots = (0..grid.len()).into_par_iter();
            slots
                .map(|s| !grid.is_cancelled() && there[s] && touches(s, set))
                .collect()
        };
        let one = grown(mask);
        let two = grown(&one);
        let slots: Vec<usize> = (0..grid.len())
            .filter(|&s| two[s] && !grid.is_cancelled())
            .collect();
        let mut number = vec![slots.len() as u32; grid.len()];
        for (i, &s) in slots.iter().enumerate() {
            number[s] = i as u32;
        }
        let nowhere = slots.len() as u32;
        let near_of =
            |&s: &usize| NEIGHBOURS.map(|o| at(grid.node(s), o).map_or(nowhere, |t| number[t]));
        let near: Vec<[u32; 6]> = slots.iter().map(near_of).chain([[nowhere; 6]]).collect();
        Self { one, slots, near }
    }
}

/// Fills the masked nodes of the (possibly coarser) grid that consists of the nodes marked in `there`.
fn fill(
    grid: &SparseGrid,
    phi: &mut [f64],
    mask: &[bool],
    there: &[bool],
    tolerance: f64,
) -> CgOutcome {
    // Initial guess of conjugate gradients: the solution on every other node, prolonged.
    let guess = from_every_other(grid, phi, mask, there, tolerance);
    let Nodes { one, slots, near } = Nodes::new(grid, mask, there);
    let nowhere = slots.len() as u32;
    let free: Vec<bool> = slots.iter().map(|&s| mask[s]).chain([false]).collect();
    // K has a row at each node within one step of the mask that has all six neighbours: (K φ)_i is the Laplacian there.
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
        cancel: grid.cancel().clone(),
    };
    let spread = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
        slots.iter().map(|&s| of(s)).chain([0.0]).collect()
    };
    // The minimiser of |K φ|² over the free nodes solves Kᵀ K x = −Kᵀ K φ₀, where φ₀ holds the given values and 0 at free nodes.
    let known = spread(&|s| if mask[s] { 0.0 } else { phi[s] });
    let mut b = vec![0.0; known.len()];
    operator.apply(&known, &mut b);
    b.iter_mut().for_each(|v| *v = -*v);
    let start = guess.as_deref().unwrap_or(phi);
    let mut x = spread(&|s| if mask[s] { start[s] } else { 0.0 });
    let outcome = conjugate_gradient(
        &operator,
        &Jacobi(&operator.jacobi),
        &b,
        &mut x,
        tolerance,
        2000,
    );
    // Only free nodes change.
    for (&s, x) in slots.iter().zip(&x) {
        if mask[s] {
            phi[s] = *x;
        }
    }
    outcome
}

/// Solves the fill on every other node and prolongs it to the masked nodes. `None` if there are too few masked nodes.
fn from_every_other(
    grid: &SparseGrid,
    phi: &[f64],
    mask: &[bool],
    there: &[bool],
    tolerance: f64,
) -> Option<Vec<f64>> {
    if mask.iter().filter(|&&m| m).count() < FEW_START_UNKNOWNS.get() {
        return None;
    }
    let half = SparseGrid::new(grid.dims().map(|d| d / 2), |_| true).stopped_by(grid.cancel());
    let source: Vec<Option<usize>> = (0..half.len())
        .map(|s| {
            let slot = grid.slot(half.node(s).map(|i| 2 * i))?;
            there[slot].then_some(slot)
        })
        .collect();
    let mut values: Vec<f64> = source.iter().map(|s| s.map_or(0.0, |s| phi[s])).collect();
    let free: Vec<bool> = source.iter().map(|s| s.is_some_and(|s| mask[s])).collect();
    let there: Vec<bool> = source.iter().map(Option::is_some).collect();
    fill(&half, &mut values, &free, &there, tolerance);
    let prolonged = |s: usize| {
        let p = 0.5 * as_point(grid.node(s));
        let smooth = value_and_gradient(&half, &values, p).map(|v| v.0);
        smooth.or_else(|| linear(&half, &values, p)).unwrap_or(0.0)
    };
    let guess = |s: usize| {
        if mask[s] && !grid.is_cancelled() {
            prolonged(s)
        } else {
            0.0
        }
    };
    Some((0..grid.len()).into_par_iter().map(guess).collect_indexed())
}
