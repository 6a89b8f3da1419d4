//! Cell-wise terms of a band's energies: nodal curvature, lumped mass, weights χ, and the matrices of a step.

use std::f64::consts::PI;
use std::ops::Range;

use rayon::prelude::*;

use super::band::{Band, Cell, WIDTH, corner_numbers};
use super::element::{ELEMENT, Gradients, against_gradients, dot, gauss_gradients, gradient};
use super::settings::Variant;
use super::stencil::Stencil;
use crate::elementary::{cos, sin};
use crate::threads::CollectIndexed;

/// Items per partial sum.
const CHUNK: usize = 1024;
/// Its square is added to |∇φ|² so that the length of a gradient is never zero.
const EPSILON: f64 = 1e-6;

/// The weight χ(t) = ½ (1 + cos(πt/b)) for |t| < b, else 0.
pub fn chi(t: f64) -> f64 {
    if t.abs() < WIDTH {
        0.5 * (1.0 + cos(PI * t / WIDTH))
    } else {
        0.0
    }
}

/// The derivative χ′.
pub fn chi_derivative(t: f64) -> f64 {
    if t.abs() < WIDTH {
        -0.5 * PI / WIDTH * sin(PI * t / WIDTH)
    } else {
        0.0
    }
}

/// The values of a nodal field at a cell's corners.
#[inline]
pub fn corners(cell: &Cell, phi: &[f64]) -> [f64; 8] {
    corner_numbers(cell).map(|v| phi[v])
}

/// Length of a gradient, regularised so that it is never zero.
pub fn norm(g: [f64; 3]) -> f64 {
    (dot(g, g) + EPSILON * EPSILON).sqrt()
}

/// Sums in chunks of fixed size, so that rounding does not depend on the number of threads.
pub fn chunked_sum<T: Sync>(items: &[T], f: impl Fn(usize, &T) -> f64 + Sync) -> f64 {
    sum_of_parts(items.len().div_ceil(CHUNK), &|c| {
        let first = c * CHUNK;
        let chunk = &items[first..items.len().min(first + CHUNK)];
        chunk.iter().enumerate().map(|(i, x)| f(first + i, x)).sum()
    })
}

/// Sums `part(0)` to `part(count - 1)` in this order. The parallel loop is compiled once for all sums.
fn sum_of_parts(count: usize, part: &(dyn Fn(usize) -> f64 + Sync)) -> f64 {
    let partial = (0..count).into_par_iter().map(part).collect_indexed();
    partial.iter().sum()
}

/// r_i and M_i at each node of the band, gathered from the cells. With N_i as the test function of equation (10) of Droske and
/// Rumpf (2004), r_i is its right-hand side and M_i the lumped mass of its left-hand side, so that `w_i = r_i / M_i`.
pub fn nodal(band: &Band, phi: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let count = phi.len();
    let (mut r, mut mass) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let make = |c: usize| cell_residual(&corners(&band.cells[c], phi));
    in_slabs(
        band,
        count,
        |i| i,
        make,
        |nodes, cells| {
            let sums = nodes.into_par_iter().map(|i| {
                let (mut r, mut m) = (0.0, 0.0);
                band.each_cell(i, |c, a| {
                    let part = cells.get(c);
                    r += part.0[a];
                    m += part.1;
                });
                (r, m)
            });
            let (slab_r, slab_mass): (Vec<f64>, Vec<f64>) = sums.unzip();
            r.extend(slab_r);
            mass.extend(slab_mass);
        },
    );
    // A cancelled computation leaves the remaining slabs out.
    r.resize(count, 0.0);
    mass.resize(count, 1.0);
    (r, mass)
}

/// The eikonal term Σ ½ (|∇φ| − 1)² at the cells' centres.
pub fn eikonal(band: &Band, phi: &[f64]) -> f64 {
    chunked_sum(&band.cells, |_, cell| {
        let g = gradient(&ELEMENT.centre, &corners(cell, phi));
        0.5 * (norm(g) - 1.0).powi(2)
    })
}

/// The eight entries of `Σ_q ⅛ n·∇N_a`, and `⅛ / |∇φ|` at the centre.
fn cell_residual(v: &[f64; 8]) -> ([f64; 8], f64) {
    let normals = gauss_gradients(v).map(|g| {
        let s = 0.125 / norm(g);
        g.map(|x| s * x)
    });
    let mass = 0.125 / norm(gradient(&ELEMENT.centre, v));
    (against_gradients(&normals), mass)
}

/// Nodal fields from which a cell's matrices are assembled.
pub struct Fields<'a> {
    /// φ.
    pub phi: &'a [f64],
    /// χw².
    pub weighted: &'a [f64],
    /// χw; for other energies than Willmore's the derivative with respect to the nodal curvature.
    pub force: &'a [f64],
    /// Weight of the eikonal term.
    pub kappa: f64,
}

/// The upper triangle of a symmetric 8 × 8 matrix, by rows.
pub type Packed = [f32; 36];

/// Index in a [`Packed`] matrix of entry `8 a + b`.
const PLACE: [u8; 64] = {
    let mut table = [0; 64];
    let (mut a, mut next) = (0, 0);
    while a < 8 {
        let mut b = a;
        while b < 8 {
            table[8 * a + b] = next;
            table[8 * b + a] = next;
            next += 1;
            b += 1;
        }
        a += 1;
    }
    table
};

/// Packs the upper triangle of a symmetric matrix; its lower left quarter is not read.
pub fn packed(matrix: &[f32; 64]) -> Packed {
    let mut out = [0.0; 36];
    for a in 0..8 {
        for b in a..8 {
            out[PLACE[8 * a + b] as usize] = matrix[8 * a + b];
        }
    }
    out
}

/// A cell's contributions to the stencils.
pub struct CellMatrices {
    /// L[P/|∇φ|].
    pub tangential: Packed,
    /// L[1/|∇φ|]; only for the paper's variants.
    pub full: Packed,
    /// ½ L1 + κ L[n⊗n].
    pub second: Packed,
}

impl CellMatrices {
    /// Assembles the matrices of a cell.
    pub fn new(cell: &Cell, fields: &Fields, variant: Variant) -> Self {
        let e = &*ELEMENT;
        let v = corners(cell, fields.phi);
        let kappa = (0.125 * fields.kappa) as f32;
        let (mut tangential, mut full, mut second) = ([0.0; 64], [0.0; 64], [0.0; 64]);
        // Gauss points: L[P/|∇φ|], L[1/|∇φ|] and κ L[n⊗n].
        for (q, (shape, g)) in e.gauss.iter().zip(gauss_gradients(&v)).enumerate() {
            let l = norm(g);
            let n = g.map(|x| x / l);
            let scale = (0.125 / l) as f32;
            let normal: [f32; 8] = std::array::from_fn(|a| dot(n, at_corner(shape, a)) as f32);
            add_products(
                (&mut tangential, &mut second),
                &normal,
                &e.gauss_products[q],
                (scale, kappa),
            );
            if variant != Variant::GaussNewton {
                for (f, p) in full.iter_mut().zip(&e.gauss_products[q]) {
                    *f += scale * p;
                }
            }
        }
        // Centre: ½ L1.
        let l1 = fields.first_order(cell, norm(gradient(&e.centre, &v)));
        for (s, p) in second.iter_mut().zip(&e.centre_products) {
            *s += l1 as f32 * p;
        }
        Self {
            tangential: packed(&tangential),
            full: packed(&full),
            second: packed(&second),
        }
    }
}

impl Fields<'_> {
    /// The weight of ½ L1 in a cell; `length` is |∇φ| at its centre.
    fn first_order(&self, cell: &Cell, length: f64) -> f64 {
        let mean = 0.125 * corners(cell, self.weighted).iter().sum::<f64>();
        0.5 * mean / (length * length * length)
    }

    /// A cell's contribution to the gradient at its corners: `BPᵀ(χw) + ½ L1 φ + κ ∂Eik`. The first two terms are minus the
    /// right-hand side of equation (9) of Droske and Rumpf (2004), tested with the shape functions and weighted by χ.
    pub fn load(&self, cell: &Cell) -> [f64; 8] {
        let e = &*ELEMENT;
        let v = corners(cell, self.phi);
        let force = corners(cell, self.force);
        let (gradients, forces) = (gauss_gradients(&v), gauss_gradients(&force));
        let projected: [[f64; 3]; 8] = std::array::from_fn(|q| {
            let (g, f) = (gradients[q], forces[q]);
            let l = norm(g);
            let n = g.map(|x| x / l);
            let along = dot(f, n);
            std::array::from_fn(|d| 0.125 / l * (f[d] - along * n[d]))
        });
        let mut load = against_gradients(&projected);
        let g = gradient(&e.centre, &v);
        let l = norm(g);
        let pull = self.first_order(cell, l) + self.kappa * (1.0 - 1.0 / l);
        for (a, load) in load.iter_mut().enumerate() {
            *load += pull * dot(g, at_corner(&e.centre, a));
        }
        load
    }
}

/// The gradient of the shape function of corner `a`.
#[inline]
fn at_corner(shape: &Gradients, a: usize) -> [f64; 3] {
    [shape[0][a], shape[1][a], shape[2][a]]
}

/// Adds `scale (∇N·∇N − n·∇N n·∇N)` to the first matrix and `kappa n·∇N n·∇N` to the second; leaves their lower left quarters
/// out.
#[inline]
fn add_products(
    (tangential, second): (&mut [f32; 64], &mut [f32; 64]),
    normal: &[f32; 8],
    products: &[f32; 64],
    (scale, kappa): (f32, f32),
) {
    let mut add = |a: usize, b: usize| {
        let both = normal[a] * normal[b];
        tangential[8 * a + b] += scale * (products[8 * a + b] - both);
        second[8 * a + b] += kappa * both;
    };
    for a in 0..4 {
        for b in 0..8 {
            add(a, b);
        }
    }
    for a in 4..8 {
        for b in 4..8 {
            add(a, b);
        }
    }
}

/// Nodes per slab. Cells on the boundary of two slabs are computed twice; with slabs of this size they are few.
const SLAB: usize = 32_768;

/// Cells computed between two checks of the cancel token; their matrices take 2 to 3 ms of one thread.
const CELLS_PER_CHECK: usize = 2048;

/// The results for the cells around the nodes of a slab.
pub struct SlabCells<C> {
    first: usize,
    cells: Vec<C>,
}

impl<C> SlabCells<C> {
    /// The result for a cell.
    #[inline]
    pub fn get(&self, cell: usize) -> &C {
        &self.cells[cell - self.first]
    }
}

/// Visits `count` nodes of a band slab by slab; the i-th node is `node(i)`, in rising order. For each slab, `make` computes a
/// result for every cell around its nodes; the results are kept only while `run` processes the slab. Remaining slabs are skipped
/// once the band's token is set.
pub fn in_slabs<C: Send + Sync>(
    band: &Band,
    count: usize,
    node: impl Fn(usize) -> usize,
    make: impl Fn(usize) -> C + Sync,
    mut run: impl FnMut(Range<usize>, &SlabCells<C>),
) {
    for start in (0..count).step_by(SLAB) {
        if band.cancel.is_cancelled() {
            return;
        }
        let range = start..count.min(start + SLAB);
        // The range of cells around the slab's nodes.
        let (mut first, mut end) = (0, band.cells.len());
        if count > SLAB {
            (first, end) = (end, first);
            for i in range.clone() {
                band.each_cell(node(i), |c, _| {
                    first = first.min(c);
                    end = end.max(c + 1);
                });
            }
            first = first.min(end);
        }
        let mut cells = Vec::with_capacity(end - first);
        for from in (first..end).step_by(CELLS_PER_CHECK) {
            if band.cancel.is_cancelled() {
                return;
            }
            let part = from..end.min(from + CELLS_PER_CHECK);
            cells.par_extend(part.into_par_iter().map(&make));
        }
        run(range, &SlabCells { first, cells });
    }
}

/// The stencils of a band's rows, one list for each cell matrix in `which`; `make` computes a cell's matrices.
pub fn stencils<C: Send + Sync>(
    band: &Band,
    make: impl Fn(usize) -> C + Sync,
    which: &[fn(&C) -> &Packed],
) -> Vec<Vec<Stencil>> {
    let rows = &band.layout.rows;
    let mut lists: Vec<Vec<Stencil>> = which.iter().map(|_| Vec::new()).collect();
    lists.iter_mut().for_each(|l| l.reserve_exact(rows.len()));
    let node = |r: usize| rows[r] as usize;
    in_slabs(band, rows.len(), node, make, |slab, cells| {
        for (list, which) in lists.iter_mut().zip(which) {
            let row = |&i: &u32| {
                let mut row = [0.0; 27];
                if band.cancel.is_cancelled() {
                    return Stencil::new(&row);
                }
                band.each_cell(i as usize, |c, a| {
                    let matrix = which(cells.get(c));
                    for b in 0..8 {
                        row[ENTRY[8 * a + b] as usize] +=
                            f64::from(matrix[PLACE[8 * a + b] as usize]);
                    }
                });
                Stencil::new(&row)
            };
            list.par_extend(rows[slab.clone()].par_iter().map(row));
        }
    });
    lists
        .iter_mut()
        .for_each(|l| l.resize(rows.len(), Stencil::new(&[0.0; 27])));
    lists
}

/// Sums the contributions of the cells around a node.
#[inline]
pub fn gathered(band: &Band, node: usize, load: impl Fn(usize, usize) -> f64) -> f64 {
    let mut sum = 0.0;
    band.each_cell(node, |c, a| sum += load(c, a));
    sum
}

/// For each pair of corners, `8 a + b`, the position of `b` in the 27-point stencil of `a`.
const ENTRY: [u8; 64] = {
    let mut table = [0; 64];
    let mut i = 0;
    while i < 64 {
        table[i] = stencil_entry(i / 8, i % 8);
        i += 1;
    }
    table
};

/// Position of corner `b` in the 27-point stencil of corner `a`.
const fn stencil_entry(a: usize, b: usize) -> u8 {
    let (x, y, z) = (
        ((b >> 2) & 1) + 1 - ((a >> 2) & 1),
        ((b >> 1) & 1) + 1 - ((a >> 1) & 1),
        (b & 1) + 1 - (a & 1),
    );
    (9 * x + 3 * y + z) as u8
}
