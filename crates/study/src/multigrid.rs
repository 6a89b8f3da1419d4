//! Multigrid levels for the fourth-order linear systems on a square grid.
//!
//! Prolongation uses the four-point rule (−1, 9, 9, −1)/16 along each axis, whose limit function is differentiable. With bilinear
//! weights the energy of a coarse function would grow by a factor of two on each level. At the boundary the rule reflects the
//! function, which suits both clamped (φ = 0 and ∂νφ = 0 for corrections) and natural boundary conditions.

use super::plane::PlaneEnergy;
use super::system::StepSystem;
use isomend_core::linalg::{Accumulator, Csr, Multigrid, SparseMatrix};

/// Number of cells a side up to which a grid is not coarsened further.
const COARSEST: usize = 16;

/// The numbers of the unknowns of one level, by node (i, j), with `cells + 1` nodes a side; none at fixed nodes.
struct Numbering {
    cells: usize,
    numbers: Vec<Option<u32>>,
    count: usize,
}

impl Numbering {
    fn new(cells: usize, boundary: bool) -> Self {
        let mut count = 0;
        let inner = |k: usize| boundary || (k > 0 && k < cells);
        let numbers = (0..(cells + 1) * (cells + 1))
            .map(|at| {
                let (i, j) = (at % (cells + 1), at / (cells + 1));
                (inner(i) && inner(j)).then(|| {
                    count += 1;
                    count as u32 - 1
                })
            })
            .collect();
        Self {
            cells,
            numbers,
            count,
        }
    }

    fn get(&self, i: usize, j: usize) -> Option<u32> {
        self.numbers[j * (self.cells + 1) + i]
    }
}

/// Coarse nodes that interpolate fine node `k`, with their weights, along an axis of `cells` coarse cells.
fn parents(k: usize, cells: usize) -> Vec<(usize, f64)> {
    if k.is_multiple_of(2) {
        return vec![(k / 2, 1.0)];
    }
    let low = (k / 2) as isize;
    let reflected = |c: isize| {
        let c = c.unsigned_abs();
        if c > cells { 2 * cells - c } else { c }
    };
    [(-1, -1.0), (0, 9.0), (1, 9.0), (2, -1.0)]
        .into_iter()
        .map(|(step, w)| (reflected(low + step), w / 16.0))
        .collect()
}

fn add_parents(coarse: &Numbering, (i, j): (usize, usize), sink: &mut Accumulator) {
    for (b, v) in parents(j, coarse.cells) {
        for (a, u) in parents(i, coarse.cells) {
            if let Some(c) = coarse.get(a, b) {
                sink.add(c, u * v);
            }
        }
    }
}

/// The coarse levels below a system; none if the grid cannot be halved or the coarsest matrix is not positive definite.
#[doc(hidden)]
pub fn coarse_levels(energy: &PlaneEnergy, system: &StepSystem) -> Option<Multigrid> {
    let grid = &energy.grid;
    let boundary = energy.free()[grid.index(0, 0)];
    let mut levels = Vec::new();
    let mut cells = grid.cells();
    while cells > COARSEST && cells.is_multiple_of(2) {
        cells /= 2;
        levels.push(Numbering::new(cells, boundary));
    }
    let first = levels.first()?;
    let (stride, free) = (grid.stride(), energy.free());
    let finest = Csr::from_rows(grid.field_len(), first.count, |at, sink| {
        if free[at] {
            add_parents(first, (at % stride - 1, at / stride - 1), sink);
        }
    });
    let wide = SparseMatrix::from(finest.clone());
    let product = &SparseMatrix::from(system.matrix()) * &wide;
    let matrix = Csr::from(&wide.transpose_into().into_csr() * &product);
    let coarser = levels
        .windows(2)
        .map(|pair| {
            let (fine, coarse) = (&pair[0], &pair[1]);
            let side = fine.cells + 1;
            let nodes: Vec<usize> = (0..side * side)
                .filter(|&at| fine.numbers[at].is_some())
                .collect();
            Csr::from_rows(fine.count, coarse.count, |row, sink| {
                add_parents(coarse, (nodes[row] % side, nodes[row] / side), sink);
            })
        })
        .collect();
    Multigrid::new(system, finest, matrix, coarser)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::SquareGrid;
    use isomend_core::flow::Variant;
    use isomend_core::linalg::{
        Jacobi, LinearOperator, MultigridCycle, Preconditioner, conjugate_gradient,
    };

    /// Number of iterations to a residual of 1e-8 for one Gauss-Newton step at a smooth graph with a very large time step.
    fn iterations(cells: usize, multigrid: bool) -> usize {
        let grid = SquareGrid::centred(cells);
        let phi = grid.field(|[x, y]| 0.2 * (4.0 * x).sin() * (1.0 + y * y));
        let energy = PlaneEnergy::clamped(grid, 1.0, |_, _| 0.0);
        let at = energy.linearise(&phi);
        let system = StepSystem::new(&energy, &at, Variant::GaussNewton, 1e6);
        let coarse = coarse_levels(&energy, &system).expect("a grid that can be halved");
        let cycle = MultigridCycle::new(&system, &coarse);
        let scaling = Jacobi(system.jacobi());
        let preconditioner: &dyn Preconditioner = if multigrid { &cycle } else { &scaling };
        let mut x = vec![0.0; phi.len()];
        conjugate_gradient(&system, preconditioner, &at.gradient, &mut x, 1e-8, 5000).iterations
    }

    #[test]
    fn multigrid_needs_few_iterations_at_any_size() {
        let (coarse, fine) = (iterations(32, true), iterations(64, true));
        let plain = iterations(64, false);
        assert!(coarse < 40 && fine < 45, "{coarse} {fine} {plain}");
        assert!(plain > 5 * fine, "{fine} {plain}");
    }
}
