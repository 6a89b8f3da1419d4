//! Square domains with mirror symmetry in x and y, computed on a quarter.

use super::grid::SquareGrid;

/// The centred unit square, for functions that are even in x and in y.
///
/// With an even number of cells a side, the axes are lines of nodes, and the functions have no normal derivative there. The elements
/// of the quarter `x, y ≥ 0` with natural boundary conditions then give the equations of the whole square, at a fourth of the cost.
#[derive(Clone, Debug)]
pub struct Mirrored {
    /// The whole square.
    pub whole: SquareGrid,
    /// The computed domain: the quarter, or the whole square if the number of cells a side is odd and no node is on the axes.
    pub part: SquareGrid,
    /// Index in the whole of the part's first node, along both axes.
    first: usize,
}

impl Mirrored {
    /// The unit square with `cells` cells a side.
    pub fn new(cells: usize) -> Self {
        let whole = SquareGrid::centred(cells);
        if cells % 2 == 1 {
            return Self {
                part: whole.clone(),
                whole,
                first: 0,
            };
        }
        Self {
            whole,
            part: SquareGrid::new(cells / 2, [0.0; 2], 0.5),
            first: cells / 2,
        }
    }

    /// The nodes of the part, by their indices in the whole.
    pub fn nodes(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let first = self.first;
        self.part.nodes().map(move |(i, j)| (first + i, first + j))
    }

    /// Restricts a field on the whole square to the part.
    pub fn fold(&self, field: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.part.field_len()];
        for ((i, j), (a, b)) in self.part.nodes().zip(self.nodes()) {
            out[self.part.index(i, j)] = field[self.whole.index(a, b)];
        }
        out
    }

    /// Extends a field on the part to the whole square by symmetry.
    pub fn unfold(&self, part: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.whole.field_len()];
        let seen = |k: usize| k.abs_diff(self.first);
        for (i, j) in self.whole.nodes() {
            out[self.whole.index(i, j)] = part[self.part.index(seen(i), seen(j))];
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::PlaneEnergy;
    use crate::step::{PlaneFlow, Tolerance};
    use isomend_core::flow::Variant;

    #[test]
    fn the_quarter_moves_as_the_whole_does() {
        for cells in [16, 15] {
            let square = Mirrored::new(cells);
            let h = square.whole.h();
            let start = square
                .whole
                .field(|[x, y]| (x * x + 1.3 * y * y).sqrt() - 0.3);
            let end = |grid: &SquareGrid, mut phi: Vec<f64>| {
                let energy = PlaneEnergy::natural(grid.clone(), h * h);
                let tolerance = Tolerance::OfState(1e-10);
                let mut flow = PlaneFlow::new(energy, Variant::I, 10.0 * h.powi(4), tolerance);
                let moved: f64 = (0..10).map(|_| flow.step(&mut phi).update).sum();
                (phi, moved)
            };
            let (whole, moved) = end(&square.whole, start.clone());
            let (part, _) = end(&square.part, square.fold(&start));
            let part = square.unfold(&part);
            let apart = whole.iter().zip(&part).map(|(a, b)| (a - b).abs());
            let apart = apart.fold(0.0, f64::max);
            assert!(moved > 1e-2 && apart < 1e-7, "{cells} {moved} {apart:e}");
        }
    }
}
